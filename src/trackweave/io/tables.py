"""A file or a table of another library becomes a table of raw columns."""

import gzip
import os
import zlib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from io import BytesIO
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any, Literal, TypeAlias

import numpy as np
import polars as pl

from trackweave.arrays import IntArray
from trackweave.domain.facts import Facts, Skips
from trackweave.domain.reports import BadRow
from trackweave.errors import DataFormatError
from trackweave.summaries import counted

__all__ = [
    "ENDINGS",
    "OnBadRow",
    "RawTable",
    "TableSource",
    "file_ending",
    "is_table_file",
    "load_table",
    "opened",
    "read_bytes",
    "table_in",
    "with_names",
    "with_our_names",
    "within_calendars",
]

OnBadRow: TypeAlias = Literal["fail", "skip"]
if TYPE_CHECKING:
    from narwhals.typing import IntoDataFrame

    TableSource: TypeAlias = str | os.PathLike[str] | IntoDataFrame
else:
    # Narwhals is imported when a table of another library comes.
    TableSource = str | os.PathLike[str] | Any

_PER_DAY = {None: 1.0, "ms": 86_400e3, "us": 86_400e6, "ns": 86_400e9}
# The years 1 to 9999, in days from 1970, and as long a duration as Python has.
_YEARS, _DURATION = (-719_162, 2_932_895), (-999_999_999, 999_999_999)
ENDINGS = (".csv", ".csv.gz", ".parquet")
# As many rows of titles and units as may follow a header, and how no cell of them begins.
_MOST_HEADERS, _BEGINS_A_NUMBER = 4, r"^\s*[+-]?\.?\d"
KNOWN_AS = {
    "time": ("t", "timestamp", "datetime", "time_s", "t_s", "position_t", "frame"),
    "lat": ("latitude", "lat_deg"),
    "lon": ("longitude", "lng", "lon_deg"),
    "x": ("position_x", "x_m", "easting"),
    "y": ("position_y", "y_m", "northing"),
    "z": ("position_z", "z_m"),
}
"""What others call our columns, in small letters; the first that is there counts."""
OURS = frozenset(
    {
        "time", "sensor", "x", "y", "z", "lat", "lon", "alt_m", "range_m", "azimuth_deg",
        "elevation_deg", "range_rate_mps", "bearing_deg", "height_m", "sensor_x", "sensor_y",
        "sensor_z", "sensor_vx", "sensor_vy", "sensor_vz", "sensor_lat", "sensor_lon",
        "sensor_heading_deg", "sigma_x", "sigma_y", "sigma_z", "sigma_range_m",
        "sigma_azimuth_deg", "sigma_elevation_deg", "sigma_range_rate_mps", "sigma_bearing_deg",
        "identity", "strength", "scan", "target", "report", "track", "status", "vx", "vy", "vz",
    }
)  # fmt: skip
"""What we call columns, which are understood in large letters too."""


@dataclass(frozen=True, slots=True)
class RawTable:
    """Columns as they came: text from CSV, typed from Parquet and from other libraries."""

    name: str  # What messages call the source
    columns: pl.DataFrame  # The columns; null where a cell is empty
    row: IntArray  # Number of each row's data record, 1 for the first after the header
    # Rows that have too few or too many cells to be placed in columns, or a day that no calendar
    # has; ``columns`` is without them.
    skipped: tuple[BadRow, ...] = field(default=())
    # Library that the table came from: "polars" (also for files), "pandas" or "pyarrow".
    kind: str = "polars"
    # What the table itself calls columns that were renamed to ours.
    own_names: Mapping[str, str] = field(default_factory=dict)
    is_text: bool = False  # Whether cells are text because the file knows nothing else
    facts: Facts = field(default_factory=Facts)  # What the recording tells beside its reports
    # Records of a binary file or a stream that could not be decoded.
    undecoded: Skips = field(default_factory=Skips)
    # Of several files together, what each is called, and how many rows come before its own.
    files: tuple[tuple[str, int], ...] = ()

    def __len__(self) -> int:
        return len(self.row)

    def message_of(self, bad: BadRow) -> str:
        """Return the sentence that tells of a bad row, with its own file and number."""
        return self.in_its_file(bad).message(self.name)

    def in_its_file(self, bad: BadRow) -> BadRow:
        """Return a bad row with its number in its own file, and that where there are several."""
        name, before = "", 0
        for each, count in self.files:
            if count < bad.row:
                name, before = each, count
        return replace(bad, row=bad.row - before, file=name)

    @property
    def notes_on_names(self) -> list[str]:
        """Sentences on columns that the table calls otherwise than we do."""
        return [
            f"column {own}: taken for {name}, for there is no column {name}"
            for name, own in self.own_names.items()
        ]

    @property
    def notes(self) -> tuple[str, ...]:
        """Sentences on what a user should know of how the columns were understood."""
        notes = self.facts.sentences()
        for name, place in self.facts.places.items():
            where = f"{place.latitude_deg:.5f}, {place.longitude_deg:.5f}"
            notes.append(f"sensor {name}: the recording tells where it stands, {where}")
        notes += self.notes_on_names
        if self.undecoded.count:
            first = self.undecoded.listed[0]
            notes.append(
                f"{self.undecoded.count:,} records could not be decoded and were left out; the "
                f"first at byte {first.offset}: {first.what}"
            )
        return tuple(notes)


def load_table(source: TableSource, *, may_be_empty: bool = False) -> RawTable:
    """Return the raw columns of a .csv, .csv.gz or .parquet file, or of a table in memory."""
    if isinstance(source, RawTable):
        return source
    if isinstance(source, str | os.PathLike):
        path = Path(source)
        table = table_in(read_bytes(path), str(path), file_ending(path))
    else:
        from trackweave.io.frames_in import from_native

        table = from_native(source)
    return within_calendars(table, may_be_empty=may_be_empty)


def within_calendars(table: RawTable, *, may_be_empty: bool = False) -> RawTable:
    """Return a table without rows whose days no calendar has; refuse one without any rows."""
    for column in table.columns.get_columns():
        table = _within_calendar(table, column.name)
    if len(table) == 0 and not table.skipped and not may_be_empty:
        raise DataFormatError(f"{table.name}: no data rows; expected at least one")
    return table


def with_names(table: RawTable, own_names: Mapping[str, str]) -> RawTable:
    """Return a table of which a user tells what some of our columns are called there."""
    names = table.columns.columns
    for ours, own in own_names.items():
        if own not in names:
            raise DataFormatError(
                f"{table.name}, column {own}: missing; expected it as {ours} ({', '.join(names)})"
            )
        if ours != own and ours in names and ours not in own_names.values():
            raise DataFormatError(
                f"{table.name}, columns {ours} and {own}: both would be {ours}; expected one"
            )
    renamed = table.columns.rename({own: ours for ours, own in own_names.items()})
    return replace(table, columns=renamed, own_names={**table.own_names, **own_names})


def with_our_names(table: RawTable) -> RawTable:
    """Return a table whose columns that others call otherwise are called as ours."""
    names = table.columns.columns
    own = _in_other_letters(table)
    for ours, others in KNOWN_AS.items():
        if ours in own:
            continue
        found = [name for other in others for name in names if name.lower() == other]
        if ours not in names and found:
            own[ours] = found[0]
    renamed = table.columns.rename({theirs: ours for ours, theirs in own.items()})
    table = replace(table, columns=renamed, own_names={**table.own_names, **own})
    return _without_more_headers(table) if table.is_text and "time" in renamed.columns else table


def _without_more_headers(table: RawTable) -> RawTable:
    """Return a table without rows of titles and units that follow its header."""
    # Such as the three of TrackMate's tables: no cell begins as a number or a time does.
    first = table.columns.head(_MOST_HEADERS + 1)
    says = pl.any_horizontal(pl.all().str.contains(_BEGINS_A_NUMBER).fill_null(value=False))
    count = next((k for k, says_any in enumerate(first.select(says).to_series()) if says_any), 0)
    if not count:
        return table
    note = f"{counted(count, 'more row')} of headers under the first left out"
    facts = replace(table.facts, notes=[*table.facts.notes, note])
    return replace(table, columns=table.columns[count:], row=table.row[count:], facts=facts)


def _in_other_letters(table: RawTable) -> dict[str, str]:
    """Return our names that a table has in large letters alone, and how it writes them."""
    names, found = table.columns.columns, dict[str, str]()
    for name in names:
        ours = name.strip().lower()
        if name in OURS or ours not in OURS or ours in names:
            continue
        if ours in found:
            raise DataFormatError(
                f"{table.name}, columns {found[ours]} and {name}: both are {ours}; expected one "
                f"of that name, or one that is written {ours}"
            )
        found[ours] = name
    return found


def file_ending(path: Path) -> str:
    """Return how a file is written, one of ``ENDINGS`` in whatever case, or refuse it."""
    name = path.name.lower()
    for ending in ENDINGS:
        if name.endswith(ending):
            return ending
    raise DataFormatError(f"{path}: unknown file ending; expected {', '.join(ENDINGS)}")


def is_table_file(path: Path) -> bool:
    """Tell by its name whether a file is a table, which has a header."""
    return path.name.lower().endswith(ENDINGS)


def read_bytes(path: Path) -> bytes:
    """Return a file's content, or say why it cannot be had."""
    with opened(path):
        return path.read_bytes()


@contextmanager
def opened(path: Path) -> Iterator[IO[bytes]]:
    """Open a file, or say why it cannot be read."""
    if "\0" in str(path):
        raise DataFormatError(f"{str(path)!r}: not a file name")
    try:
        if path.is_file():
            with path.open("rb") as file:
                yield file
            return
        # Opening a pipe would wait for ever.
        if path.is_dir():
            raise DataFormatError(f"{path}: a directory; expected a file")
        pipe = "not a regular file; expected a file, or - for standard input"
        found = pipe if path.exists() else "no such file"
        raise DataFormatError(f"{path}: {found}")
    except PermissionError as err:
        raise DataFormatError(f"{path}: no permission to read the file") from err
    except OSError as err:
        raise DataFormatError(f"{path}: cannot be read ({err.strerror or err})") from err


def table_in(data: bytes, name: str, ending: str) -> RawTable:
    """Return the columns of a file's content, as one with such an ending is written."""
    if ending == ".parquet":
        return _parse_parquet(data, name)
    if ending == ".csv.gz":
        data = _unzip(data, name)
    elif data.startswith(b"\x1f\x8b"):
        raise DataFormatError(f"{name}: gzip data; expected text, or a name that ends in .csv.gz")
    from trackweave.io.csv_text import parse_csv

    return parse_csv(data, name)


def _unzip(data: bytes, name: str) -> bytes:
    try:
        return gzip.decompress(data)
    except EOFError as err:
        raise DataFormatError(f"{name}: gzip data end too early; expected a whole file") from err
    except (OSError, zlib.error) as err:
        raise DataFormatError(f"{name}: damaged or no gzip data; expected a whole file") from err


def _parse_parquet(data: bytes, name: str) -> RawTable:
    # Polars prints to standard error when it panics on a damaged file, so look first.
    if len(data) < 12 or data[:4] != b"PAR1" or data[-4:] != b"PAR1":
        raise DataFormatError(f"{name}: damaged or no Parquet data; expected a whole file")
    try:
        frame = pl.read_parquet(BytesIO(data), use_statistics=False)
    except Exception as err:
        raise DataFormatError(f"{name}: damaged Parquet data ({_first_line(err)})") from err
    except BaseException as err:
        # A panic of polars derives from BaseException only.
        if type(err).__name__ != "PanicException":
            raise
        raise DataFormatError(f"{name}: damaged Parquet data") from err
    if frame.width == 0:
        raise DataFormatError(f"{name}: no columns; expected a table of reports")
    return RawTable(name, frame, np.arange(1, frame.height + 1))


def _within_calendar(table: RawTable, name: str) -> RawTable:
    """Return a table without rows whose days no calendar has: what shows them panics later."""
    column = table.columns[name]
    days, bad, expected = _strange_days(table.name, name, column)
    if bad.size == 0:
        return table
    skipped = [
        BadRow(int(table.row[place]), name, f"{days[int(place)]:.15g} days", expected)
        for place in bad
    ]
    keep = np.ones(len(table), dtype=np.bool_)
    keep[bad] = False
    return replace(
        table,
        columns=table.columns.filter(keep),
        row=table.row[keep],
        skipped=tuple(sorted((*table.skipped, *skipped), key=lambda bad_row: bad_row.row)),
    )


def _strange_days(source: str, name: str, column: pl.Series) -> tuple[pl.Series, IntArray, str]:
    """Return days, where no calendar has them, and what has; refuse such days inside of lists."""
    kind = column.dtype
    inner: list[pl.Series] = []
    if isinstance(kind, pl.List | pl.Array):
        inner = [column.explode().drop_nulls()]
    elif isinstance(kind, pl.Struct):
        inner = [column.struct.field(part) for part in column.struct.fields]
    for part in inner:
        days, bad, expected = _strange_days(source, name, part)
        if bad.size:
            found = f"{days[int(bad[0])]:.15g} days"
            raise DataFormatError(f"{source}, column {name}: {found}; expected {expected}")
    if not isinstance(kind, pl.Date | pl.Datetime | pl.Duration):
        return column, np.empty(0, dtype=np.int64), ""
    days = column.to_physical().cast(pl.Float64) / _PER_DAY[getattr(kind, "time_unit", None)]
    first, last = _DURATION if isinstance(kind, pl.Duration) else _YEARS
    bad = np.flatnonzero(((days < first) | (days > last)).fill_null(value=False).to_numpy())
    words = "a duration" if isinstance(kind, pl.Duration) else "a day from 1970"
    return days, bad, f"{words} of {first} to {last} days"


def _first_line(err: Exception) -> str:
    return (str(err).splitlines() or [type(err).__name__])[0][:120]
