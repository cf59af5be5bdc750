"""Times of several tables on one axis: dates beside seconds that count from 1970."""

from collections.abc import Sequence

import numpy as np
import polars as pl

from trackweave.arrays import FloatArray, IntArray
from trackweave.errors import DataFormatError
from trackweave.io.columns import datetime_column, iso_text, read_times

__all__ = ["EARLIEST_S", "note_on_falls", "on_one_axis"]

EARLIEST_S = 1e8
"""Seconds from 1970 are no fewer (1973) where dates are told beside them."""
# A clock is set back by so much and more, and by so many usual steps, so often at most: rows that
# are in no order fall back oftener.
SET_BACK_S, STEPS_BACK, MOST_FALLS = 60.0, 30.0, 3


def on_one_axis(
    tables: Sequence[pl.DataFrame], names: Sequence[str] | None = None
) -> list[pl.DataFrame]:
    """Return tables that all tell dates where some do and others tell seconds from 1970.

    Parameters
    ----------
    tables
        Tables, those with a column ``time`` concerned.
    names
        Where they come from. None to leave out times that are neither, instead of refusing them.

    Returns
    -------
    The tables, unchanged where all tell dates or none does.

    Raises
    ------
    DataFormatError
        If seconds beside dates cannot be from 1970.
    """
    read = [read_times(each["time"]) if "time" in each.columns else None for each in tables]
    dated = [place for place, times in enumerate(read) if times is not None and times.iso]
    if not dated or all(times is None or times.iso for times in read):
        return list(tables)
    found = list(tables)
    # Cells of text stay text.
    are_text = all(each["time"].dtype == pl.String for each in tables if "time" in each.columns)
    for place, times in enumerate(read):
        if times is None:
            continue
        values = times.numbers.values
        is_bad = ~np.isfinite(values) | ((values < EARLIEST_S) & (not times.iso))
        told = values[np.isfinite(values)]
        if names is not None and not times.iso and told.size and told.min() < EARLIEST_S:
            raise DataFormatError(
                f"{names[place]}, column time: {told.min():.15g}, but {names[dated[0]]} tells "
                "dates; expected dates in both, or seconds from 1970 UTC beside them"
            )
        dates = datetime_column("time", np.where(is_bad, 0.0, values))
        nothing = pl.Series([None], dtype=dates.dtype)
        column = dates.zip_with(pl.Series(~is_bad), nothing)
        column = iso_text(column) if are_text else column
        found[place] = tables[place].with_columns(column.alias("time"))
    return found


def note_on_falls(time: FloatArray, row: IntArray, sensors: pl.Series) -> list[str]:
    """Return a sentence where the times of a sensor fall back far, once or a few times."""
    # Times [s], numbers and sensors of rows are in the order of the file.
    code = sensors.rank("dense").to_numpy()
    order = np.lexsort((row, code))
    steps, same = np.diff(time[order]), np.diff(code[order]) == 0
    ahead = steps[same & (steps > 0.0)]
    if not ahead.size:
        return []
    far = max(SET_BACK_S, STEPS_BACK * float(np.median(ahead)))
    falls = np.flatnonzero(same & (steps < -far)) + 1
    if not 0 < falls.size <= MOST_FALLS:
        return []
    first = falls[0]
    return [
        f"time: row {row[order[first]]} is {-steps[first - 1]:.6g} s before the row above it of "
        "its sensor; rows are taken by their times, so that two parts of the file lie over each "
        "other where a clock was set back or two recordings are in one"
    ]
