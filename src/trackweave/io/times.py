"""Cells become times, and times become ISO 8601 again."""

from dataclasses import dataclass
from datetime import UTC, datetime

import numpy as np
import polars as pl

from trackweave.arrays import FloatArray
from trackweave.io.columns import BoolArray, Numbers, read_numbers

__all__ = ["Times", "datetime_column", "iso_text", "read_times", "with_common_times"]

_UNITS_PER_SECOND = {"ns": 1e9, "us": 1e6, "ms": 1e3}
# Times this near are one where no others are nearer than so many times that: what is between
# them is rounding. Seconds since 1970 are told to a quarter of a microsecond.
_ONE_MOMENT_S, _CLEARLY_APART = 2e-6, 1e5


def with_common_times(time: FloatArray) -> tuple[FloatArray, list[str]]:
    """Return times [s] in which those apart by rounding alone are equal, and notes on them."""
    moments = np.unique(time)
    gaps = np.sort(np.diff(moments))
    if gaps.size < 2 or gaps[0] > _ONE_MOMENT_S:
        return time, []
    # Logarithms: of gaps as small as numbers get a ratio overflows.
    largest = int(np.argmax(np.diff(np.log(gaps))))
    nearest, apart = gaps[largest], gaps[largest + 1]
    begin = np.flatnonzero(np.r_[True, np.diff(moments) > nearest])
    last = moments[np.r_[begin[1:], moments.size] - 1]
    widest = float(np.max(last - moments[begin]))
    if widest > _ONE_MOMENT_S or widest * _CLEARLY_APART > apart:
        return time, []
    group = np.searchsorted(moments[begin], time, side="right") - 1
    return last[group], [
        f"time: moments up to {widest:.2g} s apart count as one; the next are {apart:.3g} s away"
    ]


@dataclass(frozen=True, slots=True)
class Times:
    """A column read as times."""

    numbers: Numbers
    """Seconds; counted from 1970 UTC where the times came as ISO 8601."""
    iso: bool
    """Whether they came so."""
    expected: str
    """What a message asks for where there is no time."""


def read_times(column: pl.Series) -> Times:
    """Return a column's times; its first cell decides between seconds and ISO 8601.

    An ISO 8601 time without a zone is UTC. Fractions finer than a microsecond are cut off.

    Parameters
    ----------
    column
        Text, numbers of seconds, or a type of dates and times.

    Returns
    -------
    The times and how they came.
    """
    if isinstance(column.dtype, pl.Datetime | pl.Date):
        return _typed_times(column)
    numbers = read_numbers(column)
    if column.dtype == pl.String:
        filled = np.flatnonzero(~numbers.missing)
        if filled.size and numbers.unreadable[filled[0]]:
            first = column[int(filled[0])]
            if _parse_iso(first) is not None:
                return _iso_times(column, numbers.missing)
            return Times(numbers, iso=False, expected="seconds or an ISO 8601 time")
    return Times(numbers, iso=False, expected="a finite number of seconds")


def datetime_column(name: str, seconds: FloatArray) -> pl.Series:
    """Return finite seconds from 1970 UTC as dates and times, to the microsecond."""
    microseconds = np.rint(seconds * 1e6).astype(np.int64)
    return pl.Series(name, microseconds).cast(pl.Datetime("us", "UTC"))


def iso_text(column: pl.Series) -> pl.Series:
    """Return dates and times as ISO 8601 text with as many decimals as the finest needs."""
    microseconds = column.to_physical()
    decimals = "%.6f"
    if (microseconds % 1_000_000 == 0).all():
        decimals = ""
    elif (microseconds % 1_000 == 0).all():
        decimals = "%.3f"
    return column.dt.strftime(f"%Y-%m-%dT%H:%M:%S{decimals}Z")


def _typed_times(column: pl.Series) -> Times:
    missing = column.is_null()
    if isinstance(column.dtype, pl.Datetime):
        per_second = _UNITS_PER_SECOND[column.dtype.time_unit]
        seconds = column.to_physical().cast(pl.Float64) / per_second
    else:
        seconds = column.to_physical().cast(pl.Float64) * 86_400.0
    values = seconds.fill_null(float("nan")).to_numpy()
    numbers = Numbers(values, missing.to_numpy(), np.zeros(len(column), dtype=bool))
    return Times(numbers, iso=True, expected="a time")


def _iso_times(column: pl.Series, missing: BoolArray) -> Times:
    # Reports of one scan share their time, so each different text is parsed once.
    texts = column.unique()
    parsed = pl.Series([_parse_iso(text) for text in texts.to_list()], dtype=pl.Float64)
    seconds = column.replace_strict(texts, parsed, return_dtype=pl.Float64)
    unreadable = seconds.is_null().to_numpy() & ~missing
    values = seconds.fill_null(float("nan")).to_numpy()
    expected = "an ISO 8601 time, as in the first row, such as 2024-05-01T12:00:00Z"
    return Times(Numbers(values, missing, unreadable), iso=True, expected=expected)


def _parse_iso(text: str | None) -> float | None:
    """Return seconds from 1970 UTC, None where the text is no ISO 8601 time."""
    if text is None:
        return None
    text = text.strip()
    if text.isdigit():  # 20240501 may be a date, but among times it is a slip
        return None
    try:
        moment = datetime.fromisoformat(text.replace("z", "Z"))
        if moment.tzinfo is None:
            moment = moment.replace(tzinfo=UTC)
        return moment.timestamp()
    except (ValueError, OverflowError):
        return None
