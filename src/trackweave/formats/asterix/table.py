"""Reports of several categories as one table."""

from typing import Any

import numpy as np
import polars as pl
from numpy.typing import NDArray

from trackweave.formats.asterix.category import Part
from trackweave.formats.asterix.clock import DayClock

__all__ = ["table_of"]

_FLAGS = (
    "mode_a_garbled", "mode_a_unvalidated", "height_garbled", "height_unvalidated",
    "simulated", "field_monitor",
)  # fmt: skip
_TEXTS = ("sensor", "identity", "callsign", "mode_a", "status", "detection")
_ORDER = (
    "time", "sensor", "range_m", "azimuth_deg", "range_rate_mps", "lat", "lon", "x", "y",
    "height_m", "strength", "identity", "callsign", "mode_a", "track_number", "status", "vx", "vy",
    "detection", *_FLAGS, "category",
)  # fmt: skip
_PAIRS = (("range_m", "azimuth_deg"), ("lat", "lon"), ("x", "y"))


def table_of(parts: list[Part], days: DayClock, counts: dict[str, int]) -> pl.DataFrame | None:
    """Return the rows that report something, in the order in which they came.

    Parameters
    ----------
    parts
        Reports, category by category.
    days
        Adds days to times of the day.
    counts
        Takes how many rows report nothing, by why.

    Returns
    -------
    The table without columns that say nothing; None where no row is left.
    """
    clock = np.concatenate([part.clock for part in parts])
    names = {name for part in parts for name in part.columns}
    columns = {name: _merged(name, parts) for name in names}
    columns["category"] = np.concatenate([np.full(p.begin.size, p.category) for p in parts])
    rows = np.argsort(np.concatenate([part.begin for part in parts]))
    for what, right in _conditions(columns).items():
        kept = rows[right[rows]]
        if kept.size < rows.size:
            counts[what] = counts.get(what, 0) + rows.size - kept.size
        rows = kept
    if rows.size == 0:
        return None
    series = [days.times(columns.pop("time")[rows], clock[rows])]
    for name in _ORDER:
        if name in columns and (each := _series(name, columns[name][rows])) is not None:
            series.append(each)
    return pl.DataFrame(series)


def _merged(name: str, parts: list[Part]) -> NDArray[Any]:
    """Return a column of all parts, filled up where a part has none."""
    nothing: Any = None if name in _TEXTS else False if name in _FLAGS else np.nan
    return np.concatenate(
        [part.columns.get(name, np.full(part.begin.size, nothing)) for part in parts]
    )


def _conditions(columns: dict[str, NDArray[Any]]) -> dict[str, NDArray[np.bool_]]:
    """Return which rows have what a report needs, by what to say of the others."""
    time = columns["time"]
    placed = np.zeros(time.size, dtype=np.bool_)
    for first, second in _PAIRS:
        if first in columns:
            placed |= ~(np.isnan(columns[first]) | np.isnan(columns[second]))
    return {
        "records without a position, which report nothing": placed,
        "tracks of a radar that it did not detect, which report nothing": columns.get(
            "detection", np.full(time.size, None)
        )
        != "none",
    }


def _series(name: str, values: NDArray[Any]) -> pl.Series | None:
    """Return a column, None where it says nothing."""
    if name in _FLAGS:
        # What is not raised is null, so that tables without the column fit those with it.
        return (
            pl.Series(name, [each or None for each in values.tolist()], dtype=pl.Boolean)
            if values.any()
            else None
        )
    if name in _TEXTS:
        texts = pl.Series(name, values.tolist(), dtype=pl.String)
        return None if texts.null_count() == len(texts) else texts
    if values.dtype == np.float64 and np.isnan(values).all():
        return None
    series = pl.Series(name, values, nan_to_null=True)
    return series.cast(pl.Int64) if name == "track_number" else series
