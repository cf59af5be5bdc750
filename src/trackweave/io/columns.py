"""Cells become numbers and text."""

from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
import polars as pl
from numpy.typing import NDArray

from trackweave.arrays import FloatArray, IntArray

__all__ = [
    "BoolArray",
    "Numbers",
    "cell_text",
    "empty_cells",
    "numbered",
    "read_numbers",
    "read_text",
    "text_array",
    "typed_column",
]

BoolArray: TypeAlias = NDArray[np.bool_]

_LONGEST_CELL = 60


@dataclass(frozen=True, slots=True)
class Numbers:
    """A column read as numbers."""

    values: FloatArray
    """The numbers; NaN where there is none."""
    missing: BoolArray
    """Where the cell is empty."""
    unreadable: BoolArray
    """Where the cell holds something else than a number."""


def read_numbers(column: pl.Series) -> Numbers:
    """Return a column's numbers, NaN and infinities too; blanks around them are allowed."""
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
    values = numbers.to_numpy() if numbers.null_count() == 0 else _with_nan(numbers)
    return Numbers(values, missing.to_numpy(), unreadable.to_numpy())


def empty_cells(column: pl.Series) -> BoolArray:
    """Return where a column has empty or blank cells."""
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


def _with_nan(numbers: pl.Series) -> FloatArray:
    return numbers.fill_null(float("nan")).to_numpy()
