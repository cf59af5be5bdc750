"""Times of several tables on one axis: dates beside seconds that count from 1970."""

from collections.abc import Sequence

import numpy as np
import polars as pl

from trackweave.errors import DataFormatError
from trackweave.io.columns import datetime_column, iso_text, read_times

__all__ = ["EARLIEST_S", "on_one_axis"]

EARLIEST_S = 1e8
"""Seconds from 1970 are no fewer (1973) where dates are told beside them."""


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
