"""Cells become numbers, text and times, and times become ISO 8601 again."""

from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any, TypeAlias

import numpy as np
import polars as pl
from numpy.typing import NDArray

from trackweave.arrays import FloatArray, IntArray

__all__ = [
    "BoolArray",
    "Numbers",
    "Times",
    "cell_text",
    "datetime_column",
    "empty_cells",
    "iso_text",
    "numbered",
    "over_midnight",
    "read_numbers",
    "read_text",
    "read_times",
    "text_array",
    "times_of_day",
    "typed_column",
    "with_common_times",
]

BoolArray: TypeAlias = NDArray[np.bool_]

_LONGEST_CELL = 60


@dataclass(frozen=True, slots=True)
class Numbers:
    """A column read as numbers."""

    values: FloatArray  # The numbers; NaN where there is none
    missing: BoolArray  # Where the cell is empty
    unreadable: BoolArray  # Where the cell holds something else than a number


def read_numbers(column: pl.Series) -> Numbers:
    """Return a column's numbers, NaN and infinities too; blanks around them are allowed."""
    if column.dtype == pl.Float64 and not column.null_count():
        # Of small tables, polars' own operations take longer than all the rest.
        nowhere = np.zeros(len(column), dtype=np.bool_)
        return Numbers(column.to_numpy(), nowhere, nowhere)
    if column.dtype == pl.String:
        numbers = column.cast(pl.Float64, strict=False)
        if numbers.null_count() > column.null_count():
            column = column.str.strip_chars()
            numbers = column.cast(pl.Float64, strict=False)
        missing = column.is_null() | (column == "").fill_null(value=False)
    elif column.dtype.is_numeric() or column.dtype == pl.Null:
        numbers, missing = column.cast(pl.Float64, strict=False), column.is_null()
    else:
        numbers, missing = pl.Series([None] * len(column), dtype=pl.Float64), column.is_null()
    unreadable = numbers.is_null() & ~missing
    values = numbers.fill_null(float("nan")).to_numpy()
    return Numbers(values, missing.to_numpy(), unreadable.to_numpy())


def empty_cells(column: pl.Series) -> BoolArray:
    """Return where a column has empty or blank cells."""
    if column.dtype != pl.String and not column.null_count():
        return np.zeros(len(column), dtype=np.bool_)
    missing = column.is_null()
    if column.dtype == pl.String:
        missing = missing | (column.str.strip_chars() == "").fill_null(value=False)
    return missing.to_numpy()


def read_text(column: pl.Series) -> pl.Series:
    """Return a column as text without blanks around it, null where empty; 3.0 becomes "3"."""
    if column.dtype.is_float():
        column = column.fill_nan(None)
        whole = column.is_null() | ((column == column.floor()) & (column.abs() < 2.0**53))
        column = column.cast(pl.Int64 if whole.all() else pl.String)
    if column.dtype != pl.String:
        try:
            column = column.cast(pl.String)
        except pl.exceptions.PolarsError:  # lists, structures, objects
            texts = [None if value is None else str(value) for value in column.to_list()]
            column = pl.Series(column.name, texts, dtype=pl.String)
    column = column.str.strip_chars()
    return column.set(column == "", None) if (column == "").any() else column


def text_array(column: pl.Series) -> np.ndarray[Any, Any]:
    """Return text as an array of Python strings, empty where the cell is null."""
    return column.fill_null("").to_numpy().astype(object, copy=False)


def typed_column(column: pl.Series) -> pl.Series:
    """Return text as numbers where all cells are; with leading zeros they are names."""
    if column.dtype != pl.String or column.null_count() == len(column):
        return column
    whole = column.cast(pl.Int64, strict=False)
    if whole.null_count() == column.null_count() and (whole.cast(pl.String) == column).all():
        return whole
    numbers = column.cast(pl.Float64, strict=False)
    is_name = column.str.contains(r"^[+-]?0[0-9]").any()
    return column if is_name or numbers.null_count() > column.null_count() else numbers


def numbered(names: pl.Series) -> tuple[tuple[str, ...], IntArray]:
    """Return the different names, numbers first and by size, and each row's place among them."""
    different = sorted(names.unique().to_list(), key=_natural_order)
    places = pl.Series(range(len(different)), dtype=pl.Int64)
    code = names.replace_strict(pl.Series(different), places, return_dtype=pl.Int64)
    return tuple(different), code.to_numpy()


def _natural_order(name: str) -> tuple[bool, float, str]:
    try:
        number = float(name)
    except ValueError:
        number = np.nan
    return (True, 0.0, name) if np.isnan(number) else (False, number, name)


def cell_text(column: pl.Series, place: int) -> str:
    """Return a cell as a message shows it: short, on one line, "(empty)" for nothing."""
    value = column[place]
    text = "(empty)" if value is None else str(value)
    if text.strip() == "":
        text = "(blank)" if text else "(empty)"
    if not text.isprintable():
        text = repr(text)
    return text if len(text) <= _LONGEST_CELL else text[: _LONGEST_CELL - 1] + "…"


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

    numbers: Numbers  # Seconds; counted from 1970 UTC where the times came as ISO 8601
    iso: bool  # Whether they came so
    expected: str  # What a message asks for where there is no time


def read_times(column: pl.Series) -> Times:
    """Return a column's times; its first cell decides between seconds and ISO 8601."""
    # An ISO 8601 time without a zone is UTC. Fractions finer than a microsecond are cut off.
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


_OF_DAY = r"^\s*(\d{1,2}):(\d{2})(?::(\d{2}(?:\.\d+)?))?\s*$"
_DAY_S, _NEARLY_A_DAY_S, _OUT_OF_ORDER_S = 86_400.0, 82_800.0, 60.0


def times_of_day(column: pl.Series) -> Times | None:
    """Return times such as 23:59:58.5 in seconds from the first row's midnight, or None."""
    # A time nearly a day before that of the row above it is of the day after, and the other way.
    text = column.drop_nulls().filter(column.drop_nulls().str.strip_chars() != "")
    if text.is_empty() or not text[:1].str.contains(_OF_DAY)[0]:
        return None
    parts = column.str.extract_groups(_OF_DAY).struct.unnest().cast(pl.Float64)
    hour, minute, second = (parts.to_series(place).fill_null(0.0).to_numpy() for place in range(3))
    missing = column.fill_null("").str.strip_chars() == ""
    is_read = column.str.contains(_OF_DAY).fill_null(value=False).to_numpy()
    is_read &= (hour <= 23) & (minute <= 59) & (second < 61)
    values = np.where(is_read, 3600.0 * hour + 60.0 * minute + second, np.nan)
    step = np.diff(values[is_read], prepend=values[is_read][:1])
    day = np.cumsum((step < -_NEARLY_A_DAY_S).astype(int) - (step > _NEARLY_A_DAY_S))
    values[is_read] += _DAY_S * day
    numbers = Numbers(values, missing.to_numpy(), ~is_read & ~missing.to_numpy())
    return Times(numbers, iso=False, expected="a time of the day, as in the first row")


def over_midnight(seconds: FloatArray) -> FloatArray | None:
    """Return seconds of the day that go on after midnight, None where they never fall back so."""
    # In the order of the file, and only where nothing else falls back far.
    known = seconds[np.isfinite(seconds)]
    if known.size == 0 or known.min() < 0.0 or known.max() >= _DAY_S:
        return None
    back = -np.diff(known)
    falls = back > _NEARLY_A_DAY_S
    if not falls.any() or np.any(back[~falls] > _OUT_OF_ORDER_S):
        return None
    moved = seconds.copy()
    moved[np.isfinite(seconds)] += _DAY_S * np.r_[0, np.cumsum(falls)]
    # One sensor after the other, of a whole day each, falls back as well.
    return moved if np.nanmax(moved) - np.nanmin(moved) < _DAY_S else None


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
