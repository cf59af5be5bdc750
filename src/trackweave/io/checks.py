"""Which rows of a table are bad, and why."""

from dataclasses import dataclass

import numpy as np
import polars as pl

from trackweave.arrays import FloatArray, IntArray
from trackweave.domain.reports import BadRow
from trackweave.errors import DataFormatError
from trackweave.io.columns import (
    BoolArray,
    Numbers,
    cell_text,
    empty_cells,
    read_numbers,
    read_text,
)
from trackweave.io.tables import OnBadRow, RawTable
from trackweave.io.times import Times, read_times

__all__ = ["LONGEST_NAME", "Range", "RowChecks"]

# As many bad rows are named; all are counted.
_MOST_NAMED = 5
_SKIPPING = '--on-bad-row skip (in Python on_bad_row="skip")'

# 3,000 years: beyond it are mistakes of the unit (milliseconds or microseconds from 1970).
_LATEST_S = 1e11
_OTHER_UNITS = ("km", "nm", "nmi", "mi", "ft", "rad", "ms", "us", "ns", "min", "h")
LONGEST_NAME = 256
"""Bytes of a name, which arrays hold as often as it is used; what is longer is no name."""


@dataclass(frozen=True, slots=True)
class Range:
    """What a number may be."""

    low: float
    """The smallest value."""
    high: float
    """The largest value."""
    expected: str = "a finite number"
    """What a message asks for where there is no number, or a negative one where a positive is
    wanted."""
    positive: bool = False
    """Whether zero and less count as no number at all."""

    @property
    def limits(self) -> str:
        """What a message asks for where a number is too small or too large."""
        return f"{'a positive number' if self.positive else 'a number'} " + (
            f"from {self.low:g} to {self.high:g}"
        )


class RowChecks:
    """Reads the columns of a table and keeps the first complaint about each row.

    Parameters
    ----------
    table
        The raw columns.
    """

    def __init__(self, table: RawTable) -> None:
        self._table = table
        self._reasons: list[tuple[str, str]] = []
        self._complaint = np.full(len(table), -1, dtype=np.int64)
        self._aside = np.zeros(len(table), dtype=np.bool_)

    @property
    def name(self) -> str:
        """What messages call the table."""
        return self._table.name

    @property
    def names(self) -> list[str]:
        """Names of the columns."""
        return self._table.columns.columns

    @property
    def listed_columns(self) -> str:
        """The columns' names as messages show them."""
        names = [self.own_name(name) for name in self.names]
        listed = ", ".join(repr(name)[1:-1] or "(without a name)" for name in names)
        return f"the columns are {listed:.200}"

    @property
    def good(self) -> BoolArray:
        """Rows that can be used as far as is known."""
        return (self._complaint < 0) & ~self._aside

    @property
    def aside(self) -> BoolArray:
        """Rows set aside that are without a complaint so far."""
        return (self._complaint < 0) & self._aside

    def __len__(self) -> int:
        return len(self._table)

    def column(self, name: str) -> pl.Series:
        """Return a raw column."""
        return self._table.columns[name]

    def filled(self, name: str) -> bool:
        """Return whether the table has the column and any cell of it is filled."""
        return name in self.names and not empty_cells(self.column(name)).all()

    def require(self, name: str, expected: str) -> None:
        """Refuse a table without a column, saying what was expected and what there is."""
        if name in self.names:
            return
        same = [found for found in self.names if found.lower() == name]
        found = f"only {same[0]}" if same else "missing"
        # Such as range_km where range_m is expected.
        stem = name.removesuffix("_m").removesuffix("_deg")
        units = {f"{stem}_{unit}" for unit in _OTHER_UNITS} | ({stem} - {name})
        alike = [other for other in self.names if other.lower() in units]
        if alike and not same:
            found = f"only {alike[0]}, which may be of another unit"
        raise DataFormatError(
            f"{self.name}, column {name}: {found}; expected {expected} ({self.listed_columns})"
        )

    def refuse(self, column: str, where: BoolArray, expected: str) -> None:
        """Complain about a column's cells where rows are bad, saying what should be there."""
        fresh = where & (self._complaint < 0)
        if fresh.any():
            self._complaint[fresh] = len(self._reasons)
            self._reasons.append((column, expected))

    def set_aside(self, where: BoolArray) -> None:
        """Take rows for right that say nothing, and cannot be used."""
        self._aside |= where

    def numbers(
        self, name: str, within: Range, *, optional: bool = False, among: BoolArray | None = None
    ) -> FloatArray:
        """Return a column's numbers, complaining of every cell that is not as it should be.

        Parameters
        ----------
        name
            The column's name.
        within
            What a number may be.
        optional
            Whether a cell may be empty.
        among
            The rows to look at; None for all.

        Returns
        -------
        The numbers; NaN in empty cells, in bad rows and in those passed over.
        """
        numbers = read_numbers(self.column(name))
        if among is None:
            return self._checked(name, numbers, within, optional=optional)
        looked_at = Numbers(
            np.where(among, numbers.values, np.nan),
            numbers.missing | ~among,
            numbers.unreadable & among,
        )
        values = self._checked(name, looked_at, within, optional=True)
        if not optional:
            self.refuse(name, among & np.isnan(values), within.expected)
        return values

    def optional_numbers(
        self, name: str, within: Range, among: BoolArray | None = None
    ) -> FloatArray:
        """Return the numbers of a column that may be missing, NaN where there is none."""
        if name not in self.names:
            return np.full(len(self), np.nan)
        return self.numbers(name, within, optional=True, among=among)

    def filled_cells(self, name: str) -> BoolArray:
        """Return in which rows a column holds anything; nowhere where there is no such column."""
        if name not in self.names:
            return np.zeros(len(self), dtype=np.bool_)
        return ~empty_cells(self.column(name))

    def whole_numbers(self, name: str, within: Range) -> FloatArray:
        """Return a column's whole numbers; other parameters as ``numbers``."""
        values = self.numbers(name, within)
        self.refuse(name, self.good & (values != np.floor(values)), within.expected)
        return values

    def times(self, name: str, *, optional: bool = False) -> tuple[FloatArray, bool]:
        """Return times [s], NaN in bad rows, and whether they are ISO 8601, from 1970 UTC."""
        times: Times = read_times(self.column(name))
        within = Range(-_LATEST_S, _LATEST_S, times.expected)
        return self._checked(name, times.numbers, within, optional=optional), times.iso

    def text(self, name: str, expected: str | None = None) -> pl.Series:
        """Return a column as text, null where empty: a fault where something is expected there."""
        column = read_text(self.column(name))
        too_long = (column.str.len_bytes() > LONGEST_NAME).fill_null(value=False)
        self.refuse(name, too_long.to_numpy(), f"at most {LONGEST_NAME} bytes of text")
        if expected is not None:
            self.refuse(name, column.is_null().to_numpy(), expected)
        return column

    def finish(self, on_bad_row: OnBadRow, *, may_skip: bool = False) -> tuple[BadRow, ...]:
        """Return the rows that are left out, or refuse the table.

        Parameters
        ----------
        on_bad_row
            Whether a bad row is an error or is left out.
        may_skip
            Whether a user could have chosen, which a refusal then says.

        Returns
        -------
        The bad rows in the table's order, none where a bad row is an error.

        Raises
        ------
        DataFormatError
            If a row is bad while bad rows are errors, or no row is good.
        """
        bad = np.flatnonzero(self._complaint >= 0)
        none_left = not self.good.any()
        if on_bad_row == "fail" and (bad.size or self._table.skipped):
            raise DataFormatError(self._refusal(bad, may_skip, none_left))
        skipped = (*self._table.skipped, *(self._bad_row(int(place)) for place in bad))
        in_order = tuple(sorted(skipped, key=lambda bad_row: bad_row.row))
        if none_left and in_order:
            first = self._table.message_of(in_order[0])
            raise DataFormatError(f"{first} (and none of the other rows is usable)")
        if none_left and self._aside.any():
            raise DataFormatError(
                f'{self.name}: all rows hold codes for "not available"; expected a position'
            )
        return tuple(map(self._table.in_its_file, in_order))

    def _refusal(self, bad: IntArray, may_skip: bool, none_left: bool) -> str:
        """Return what is said of the first bad row, and of how many there are."""
        some = (*self._table.skipped, *(self._bad_row(int(place)) for place in bad[:_MOST_NAMED]))
        firsts = sorted(some, key=lambda bad_row: bad_row.row)[:_MOST_NAMED]
        count = len(self._table.skipped) + bad.size
        parts = [self._table.message_of(firsts[0])]
        if count > 1:
            places = map(self._table.in_its_file, firsts)
            named = ", ".join(f"{each.file} {each.row}".strip() for each in places)
            more = ", …" if count > _MOST_NAMED else ""
            parts.append(f"{count:,} rows are bad in all ({named}{more})")
        if may_skip:
            does = "would leave no row" if none_left else "leaves out what is bad"
            parts.append(f"{_SKIPPING} {does}")
        return "; ".join(parts)

    def _checked(
        self, name: str, numbers: Numbers, within: Range, *, optional: bool
    ) -> FloatArray:
        values = numbers.values
        nothing = np.isnan(values) & ~numbers.missing if optional else np.isnan(values)
        if within.positive:
            nothing = nothing | (values <= 0)
        self.refuse(name, nothing, within.expected)
        self.refuse(name, (values < within.low) | (values > within.high), within.limits)
        return values

    def _bad_row(self, place: int) -> BadRow:
        column, expected = self._reasons[self._complaint[place]]
        found = cell_text(self.column(column), place)
        return BadRow(int(self._table.row[place]), self.own_name(column), found, expected)

    def own_name(self, column: str) -> str:
        """Return what the table itself calls a column."""
        return self._table.own_names.get(column, column)
