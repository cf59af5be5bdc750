"""Which rows of a table are bad, and why."""

import re
from dataclasses import dataclass, replace

import numpy as np
import polars as pl

from trackweave.arrays import FloatArray, IntArray
from trackweave.domain.reports import BadRow
from trackweave.errors import DataFormatError
from trackweave.io.columns import (
    BoolArray,
    Numbers,
    Times,
    cell_text,
    empty_cells,
    over_midnight,
    read_numbers,
    read_text,
    read_times,
    times_of_day,
)
from trackweave.io.tables import OnBadRow, RawTable, TableSource, load_table, with_our_names

__all__ = [
    "FLIGHT_LEVEL", "LEVEL_M", "LONGEST_NAME", "Range", "RowChecks", "ask_back", "checks_of",
    "questions",
]  # fmt: skip

# As many bad rows are named; all are counted.
_MOST_NAMED = 5
_SKIPPING = '--on-bad-row skip (in Python on_bad_row="skip")'

# 3,000 years: beyond it are mistakes of the unit (milliseconds or microseconds from 1970).
_LATEST_S = 1e11
_WORDS = re.compile(r"[^a-z0-9_]+")
_OTHER_UNITS = ("km", "nm", "nmi", "mi", "ft", "rad", "ms", "us", "ns", "min", "h")
LONGEST_NAME = 256
"""Bytes of a name, which arrays hold as often as it is used; what is longer is no name."""


@dataclass(frozen=True, slots=True)
class Range:
    """What a number may be."""

    low: float  # The smallest value
    high: float  # The largest value
    # What a message asks for where there is no number, or a negative one where a positive is
    # wanted.
    expected: str = "a finite number"
    positive: bool = False  # Whether zero and less count as no number at all

    @property
    def limits(self) -> str:
        """What a message asks for where a number is too small or too large."""
        return f"{'a positive number' if self.positive else 'a number'} " + (
            f"from {self.low:g} to {self.high:g}"
        )


class RowChecks:
    """Reads the columns of a table and keeps the first complaint about each row.

    With ``anywhere`` a position may be anywhere on the Earth, not only about one plane.
    """

    def __init__(self, table: RawTable, *, anywhere: bool = False) -> None:
        self._table, self.anywhere = table, anywhere
        self.notes: list[str] = []
        self._reasons: list[tuple[str, str]] = []
        self._complaint = np.full(len(table), -1, dtype=np.int64)
        self._aside = np.zeros(len(table), dtype=np.bool_)

    @property
    def name(self) -> str:
        """What messages call the table."""
        return self._table.name

    @property
    def kind(self) -> str:
        """Library that the table came from: "polars" (also for files), "pandas" or "pyarrow"."""
        return self._table.kind

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
        apart = [other for other in self.names if name in _WORDS.split(other.lower())]
        if alike and not same:
            found = f"only {alike[0]}, which may be of another unit"
        elif apart and not same:
            found = (
                f"only {apart[0]!r}; columns are separated by commas, semicolons or tabs, and a "
                "name holds no unit"
            )
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
        """Return a column's numbers, complaining of every cell that is not as it should be."""
        # They are NaN in empty cells, in bad rows and in those not ``among`` the rows to look at.
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
        column = self.column(name)
        of_day = times_of_day(column) if column.dtype == pl.String else None
        times: Times = of_day or read_times(column)
        if of_day is not None:
            self.notes.append(f"{name}: times of the day, read as seconds from midnight")
        elif not times.iso and (moved := over_midnight(times.numbers.values)) is not None:
            times = replace(times, numbers=replace(times.numbers, values=moved))
            self.notes.append(f"{name}: seconds of the day, which go on after midnight")
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
        """Return the bad rows that are left out, in order; refuse the table where none may be."""
        # It is refused, too, where no row is good. Whether a user could have chosen to skip bad
        # rows, ``may_skip``, a refusal then says.
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


def checks_of(source: TableSource, *, may_be_empty: bool = False) -> RowChecks:
    """Return the checks of a table whose columns are called as ours."""
    return RowChecks(with_our_names(load_table(source, may_be_empty=may_be_empty)))


FLIGHT_LEVEL, LEVEL_M = "flight_level", 30.48
"""A column of heights in hundreds of feet, and one of them [m]."""
# Beyond these no time in seconds lies, and moments of our day in finer units do.
_FINER = ((1e17, "nanoseconds"), (1e14, "microseconds"), (1e11, "milliseconds"))
_LATITUDE, _RIGHT_ANGLE = 90.0, np.pi / 2
FEWEST_ROWS = 20
"""So many numbers that are all small are no chance."""
FEWEST_ANGLES, LEAST_SPAN = 60, 1.0
"""So many directions that lie within a full turn in radians, and are that far apart."""


def ask_back(checks: RowChecks) -> None:
    """Refuse a whole column that cannot be what its name says; say what it seems to be."""
    time = _filled(checks, "time")
    if time.size:
        least = float(np.min(np.abs(time)))
        unit = next((unit for beyond, unit in _FINER if least > beyond), None)
        if unit is not None:
            _refuse(checks, "time", f"seconds; these look like {unit} from 1970")
    latitude, longitude = _filled(checks, "lat"), _filled(checks, "lon")
    if latitude.size and longitude.size:
        beyond = np.abs(latitude) > _LATITUDE
        # 91 is AIS's code for "not available".
        if np.mean(beyond & (latitude != 91.0)) > 0.5 and np.all(np.abs(longitude) <= _LATITUDE):
            _refuse(checks, "lat", "latitudes from -90 to 90; lat and lon look swapped")


def questions(checks: RowChecks) -> list[str]:
    """Return a question for each column whose numbers may be another unit, but need not."""
    asked = []
    latitude, longitude = _filled(checks, "lat"), _filled(checks, "lon")
    if (
        min(latitude.size, longitude.size) >= FEWEST_ROWS
        and np.all(np.abs(latitude) <= _RIGHT_ANGLE)
        and np.all(np.abs(longitude) <= 2 * _RIGHT_ANGLE)
    ):
        asked.append(
            "lat, lon: all within 1.571 and 3.142; are they radians? They are taken for degrees"
        )
    return [*_of_zones(checks), *asked, *_of_directions(checks), *_of_ranges(checks)]


def _of_zones(checks: RowChecks) -> list[str]:
    """Return a question where some times tell their zone and others do not."""
    if "time" not in checks.names or checks.column("time").dtype != pl.String:
        return []
    text = checks.column("time").drop_nulls().str.strip_chars()
    dated = text.filter(text.str.contains(r"^\d{4}-?\d\d-?\d\d[T ]"))
    zoned = int(dated.str.contains(r"(?i)(z|[+-]\d\d:?\d\d)$").sum())
    if zoned in (0, dated.len()):
        return []
    return [
        f"{checks.own_name('time')}: {dated.len() - zoned} of {dated.len()} tell no zone; they "
        "are taken for UTC"
    ]


def _of_directions(checks: RowChecks) -> list[str]:
    """Return a question for each column of directions that begins and ends as radians do."""
    asked = []
    for name in ("azimuth_deg", "bearing_deg"):
        angle = _filled(checks, name)
        if angle.size < FEWEST_ANGLES or np.max(np.abs(angle)) > 2 * np.pi:
            continue
        # A beam so narrow that is pointed due north is rarer than a column in radians.
        if np.ptp(angle) > LEAST_SPAN:
            asked.append(
                f"{checks.own_name(name)}: all from {angle.min():.4g} to {angle.max():.4g}; are "
                "they radians? They are taken for degrees"
            )
    return asked


def _of_ranges(checks: RowChecks) -> list[str]:
    """Return a question where ranges are too short beside what else is told of them."""
    for other, unit, words in (
        ("height_m", 1.0, "shorter than height_m"),
        (FLIGHT_LEVEL, LEVEL_M, "shorter than flight_level, in hundreds of feet,"),
        ("sigma_range_m", 1.0, "shorter than their own sigma_range_m"),
        ("range_rate_mps", 1.0, "so short that range_rate_mps crosses them within a second"),
        ("speed_mps", 1.0, "so short that speed_mps crosses them within a second"),
    ):
        if not {"range_m", other} <= set(checks.names):
            continue
        far, beside = (read_numbers(checks.column(name)).values for name in ("range_m", other))
        both = np.isfinite(far) & np.isfinite(beside)
        if both.sum() >= FEWEST_ROWS and np.mean(far[both] < unit * np.abs(beside[both])) > 0.5:
            return [
                f"range_m: {words} in most rows; are they kilometres? They are taken for metres"
            ]
    return []


def _filled(checks: RowChecks, name: str) -> FloatArray:
    """Return the numbers of a column, none where there is no such column."""
    if name not in checks.names:
        return np.empty(0)
    numbers = read_numbers(checks.column(name))
    return numbers.values[np.isfinite(numbers.values)]


def _refuse(checks: RowChecks, name: str, expected: str) -> None:
    column = checks.column(name)
    found = cell_text(column, int(np.flatnonzero(~column.is_null().to_numpy())[0]))
    place = f"{checks.name}, column {checks.own_name(name)}"
    raise DataFormatError(f"{place}: {found}; expected {expected}")
