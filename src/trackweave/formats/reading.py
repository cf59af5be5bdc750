"""Files of any format become tables of raw columns."""

import gzip
import os
import sys
import zlib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, nullcontext
from dataclasses import replace
from io import BufferedReader
from itertools import chain
from pathlib import Path
from typing import IO, Any
from urllib.parse import parse_qsl

import numpy as np
import polars as pl

from trackweave.arrays import IntArray
from trackweave.domain.facts import Facts, Place, Skips
from trackweave.domain.frames import Projection
from trackweave.domain.reports import BadRow, ReportTable
from trackweave.errors import DataFormatError, InvalidInputError
from trackweave.formats.format import HEAD_BYTES, Format, Option
from trackweave.formats.registry import format_named, formats, recognised
from trackweave.io.reports import reports_in, with_heeded_scans
from trackweave.io.tables import (
    OURS,
    OnBadRow,
    RawTable,
    load_table,
    opened,
    table_in,
    with_names,
    with_our_names,
    within_calendars,
)
from trackweave.io.time_axes import on_one_axis
from trackweave.plugin_faults import told_as_theirs

__all__ = ["STANDARD_INPUT", "chosen", "is_recording", "load", "read_reports"]

STANDARD_INPUT = "-"
_CHUNK = 1 << 20
_GZIP = b"\x1f\x8b"


def is_recording(source: Any) -> bool:
    """Tell whether a source is a path, or several."""
    if isinstance(source, list | tuple):
        return bool(source) and all(isinstance(each, str | os.PathLike) for each in source)
    return isinstance(source, str | os.PathLike)


def load(source: Any, told: str | None = None) -> RawTable:
    """Return the raw columns of a recording of any format, or of a table in memory.

    Parameters
    ----------
    source
        A path, "-" for standard input, several paths (one network of sensors; without a column
        ``sensor`` a file's sensor is called after it), or a table of another library.
    told
        The format's name and what its reader is told, such as "mot?frame_rate=30"; None to find
        it by the content.

    Returns
    -------
    The columns of reports.

    Raises
    ------
    InvalidInputError
        If there is no such format; a DataFormatError if a file cannot be read, or is of none that
        is known.
    """
    if told is not None and not isinstance(told, str):
        raise InvalidInputError(f"told: {told!r:.80}; expected the name of a format")
    if not is_recording(source):
        return load_table(source)
    if isinstance(source, list | tuple):
        if len(source) > 1:
            return _network(source, told)
        source = source[0]
    return within_calendars(_load_one(Path(source), told))


def read_reports(  # noqa: PLR0913 each says another thing of the same file
    source: Any,
    *,
    told: str | None = None,
    frame_origin: tuple[float, float] | None = None,
    frame_projection: Projection = "tangent",
    on_bad_row: OnBadRow = "fail",
    kinds: Mapping[str, Any] | None = None,
    places: Mapping[str, Place] | None = None,
) -> ReportTable:
    """Read reports and check every value.

    Columns: ``time`` (seconds, or ISO 8601; ``t`` or ``frame`` where there is none); a
    measurement, ``x,y[,z]`` [m] or ``lat,lon[,alt_m]`` [degrees, m] or
    ``range_m,azimuth_deg[,elevation_deg][,range_rate_mps]`` or ``bearing_deg``, of one kind per
    sensor; optionally ``sensor``, the report's own noise ``sigma_x,sigma_y[,sigma_z]`` [m] or
    ``sigma_range_m,sigma_azimuth_deg,…`` (empty cells leave it to the sensor, but x and y go
    together), where the sensor was, ``sensor_x,sensor_y,…``, ``identity``, ``strength``,
    ``height_m``, ``report`` (an identifier, else the row's number), ``scan`` (a whole number)
    and ``target``. All columns but the measurement, also unknown ones, are carried along. Where
    a table has both ``x,y`` and ``lat,lon``, ``lat,lon`` are the position when ``frame_origin``
    is given and ``x,y`` when not; a row with a position is one, whatever else it holds.

    Rows whose latitude is 91 or whose longitude is 181, which AIS sends for "not available", are
    in ``unavailable`` of the result.

    Latitudes and longitudes are laid on the plane that touches the ellipsoid at ``frame_origin``.
    Tracking is in three dimensions only where every report has an altitude. The altitude itself
    is then z, and the horizontal position is that of the point below on the ellipsoid, so that it
    does not depend on altitude.

    Parameters
    ----------
    source
        A path of a file of any format that ``trackweave formats`` lists, "-" for standard input,
        several paths (one network of sensors), or a pandas, polars or Arrow table.
    told
        The format's name and what its reader is told, such as "mot?frame_rate=30"; None to find
        it by the content.
    frame_origin
        Latitude and longitude [degrees] of the plane's origin; None to take the median position,
        rounded to 1e-4 degrees.
    frame_projection
        "tangent" for the plane that touches the Earth, "stereographic" for wide areas.
    on_bad_row
        "fail" to refuse a table with a bad row; "skip" to leave bad rows out and list them in
        ``skipped`` of the result.
    kinds
        Kinds of measurement from outside the package by the names of their sensors, "default" for
        all others, None for one of ours; their rows are read by the columns that the kinds name.
    places
        Where sensors stand on the Earth, by their names; before what the recording tells. The
        plane of ranges is laid there where no origin is given.

    Returns
    -------
    The reports, sorted by time, then sensor, then row.

    Raises
    ------
    InvalidInputError
        If the source is no table, or the origin no position.
    DataFormatError
        If the table is not one of reports, or has a bad row; the message names file, row and
        column, what was there and what was expected.

    Examples
    --------
    >>> import polars as pl
    >>> import trackweave as tw
    >>> reports = tw.read_reports(pl.DataFrame({"time": [2.0, 1.0], "x": [7, 5], "y": [1, 1]}))
    >>> reports.time, reports.row  # sorted by time, and where each row came from
    (array([1., 2.]), array([2, 1]))
    """
    return with_heeded_scans(
        reports_in(
            load(source, told),
            frame_origin=frame_origin,
            frame_projection=frame_projection,
            on_bad_row=on_bad_row,
            kinds=kinds,
            places=places,
        )
    )


def chosen(told: str, *, of_file: bool = False) -> tuple[Format, dict[str, Any]]:
    """Return the format that a user names, and what its reader is told by that, checked."""
    # Of a file that is a table: what columns are called there, by our names.
    name, _, query = told.partition("?")
    found = format_named(name)
    settings: dict[str, Any] = {}
    options = {option.name: option for option in found.options}
    for key, value in parse_qsl(query, keep_blank_values=True):
        if of_file and found.is_table and key in OURS and value:
            settings[key] = value
            continue
        if key not in options:
            expected = ", ".join(options) or "no option"
            if of_file and found.is_table:
                expected = "a column of ours and its name in the file, such as x=easting"
            raise InvalidInputError(f"format {told!r:.80}: {key!r}; expected {expected}")
        settings[key] = _value(options[key], value, told)
    return found, settings


def _value(option: Option, value: str, told: str) -> float | str:
    if option.choices and value not in option.choices:
        expected = ", ".join(option.choices)
    elif isinstance(option.default, str):
        return value
    else:
        expected = "a number > 0"
        try:
            number = float(value)
        except ValueError:
            number = 0.0
        if 0.0 < number < 1e12:
            return number
    raise InvalidInputError(
        f"format {told!r:.80}: {option.name} {value!r:.40}; expected {expected}"
    )


def _network(paths: Sequence[str | os.PathLike[str]], told: str | None) -> RawTable:
    """Return several recordings as that of one network of sensors."""
    names = _short_names([Path(path) for path in paths])
    tables = [load(path, told) for path in paths]
    are_text = all(table.is_text for table in tables)
    facts, skips, frames, files = Facts(), Skips(), list[pl.DataFrame](), []
    row, skipped, before = list[IntArray](), list[BadRow](), 0
    for name, table in zip(names, tables, strict=True):
        table = with_our_names(table)
        files.append((table.name, before))
        row.append(before + table.row)
        skipped += [replace(bad, row=before + bad.row) for bad in table.skipped]
        before += max([0, *table.row[-1:].tolist(), *(bad.row for bad in table.skipped)])
        frames.append(_of_network(table, name, as_text=are_text))
        facts.places |= table.facts.places
        facts.scan_periods |= table.facts.scan_periods
        facts.notes += [
            f"{name}: {note}" for note in (*table.facts.sentences(), *table.notes_on_names)
        ]
        skips.take(table.undecoded, name)
    _require_alike(frames, [name for name, _ in files])
    columns = pl.concat(on_one_axis(frames, [name for name, _ in files]), how="diagonal_relaxed")
    return RawTable(
        f"{len(tables)} files", columns, np.concatenate(row), tuple(skipped), is_text=are_text,
        facts=facts, undecoded=skips, files=tuple(files),
    )  # fmt: skip


def _require_alike(frames: Sequence[pl.DataFrame], names: Sequence[str]) -> None:
    """Refuse positions on a plane in one file and of the Earth in another."""
    plane, earth = (
        [name for name, each in zip(names, frames, strict=True)
         if {first, second} <= set(each.columns) and other not in each.columns]
        for first, second, other in (("x", "y", "lat"), ("lat", "lon", "x"))
    )  # fmt: skip
    if plane and earth:
        raise DataFormatError(
            f"{plane[0]} tells x, y and {earth[0]} lat, lon; expected one of both in all files: "
            "give x, y their latitudes and longitudes, or track them apart and fuse the tracks"
        )


def _of_network(table: RawTable, name: str, *, as_text: bool) -> pl.DataFrame:
    """Return a table with its sensor's name, and identifiers that no other file has."""
    from trackweave.io.columns import read_text, typed_column

    columns = table.columns
    if table.is_text and not as_text:
        columns = pl.DataFrame([typed_column(each) for each in columns.get_columns()])
    if "sensor" not in columns.columns:
        columns = columns.with_columns(sensor=pl.lit(name))
    if "report" in columns.columns:
        own = read_text(columns["report"])
    else:
        own = pl.Series("report", table.row).cast(pl.String)
    return columns.with_columns(sensor=read_text(columns["sensor"]), report=name + ":" + own)


def _short_names(paths: list[Path]) -> list[str]:
    """Return what each file's sensor is called: its name without ending, where no other has it."""
    names = [path.name.partition(".")[0] or str(path) for path in paths]
    for candidates in ([path.name for path in paths], [str(path) for path in paths]):
        names = [
            name if names.count(name) == 1 else longer
            for name, longer in zip(names, candidates, strict=True)
        ]
    if len(set(names)) < len(names):
        twice = next(name for name in names if names.count(name) > 1)
        raise InvalidInputError(f"{twice}: given twice; expected each file once")
    return names


def _load_one(path: Path, told: str | None) -> RawTable:
    if path.is_dir():
        return _load_folder(path, told)
    with _opened(path) as (file, name):
        head = file.read(HEAD_BYTES)
        if not head and told is None and not path.suffix:
            raise DataFormatError(f"{name}: empty; expected a recording of reports")
        found, settings = _format_of(head, name, told)
        if found.is_table:
            return with_names(table_in(head + file.read(), name, found.endings[0]), settings)
        if found.decoder is None:
            raise DataFormatError(
                f"{name}: a file; expected a directory of the format {found.name}"
            )
        with told_as_theirs(found.decoder, "readers", "decoder", found.name):
            decoder = found.decoder(**settings)
        pieces = chain([head], iter(lambda: file.read(_CHUNK), b""))
        try:
            frames = [decoder.feed(piece) for piece in pieces]
            frames.append(decoder.finish())
        except DataFormatError as err:  # of the document as a whole
            raise DataFormatError(f"{name}: {err}") from err
        except Exception as err:
            if type(decoder).__module__.startswith("trackweave."):
                raise
            raise DataFormatError(
                f"{name}: format {found.name}, a plug-in, failed ({type(err).__name__}: {err}); "
                "expected reports, or skips.add for what cannot be decoded"
            ) from err
    return _table_of([f for f in frames if f is not None], name, (decoder.facts, decoder.skips))


def _load_folder(path: Path, told: str | None) -> RawTable:
    found = chosen(told)[0] if told else recognised(b"", str(path))
    if found is None or found.folder is None:
        known = [each.name for each in formats().values() if each.folder is not None]
        raise DataFormatError(
            f"{path}: a directory that is no recording; expected a file, several files, or a "
            f"directory of the format {' or '.join(known)} (`trackweave formats`)"
        )
    with told_as_theirs(found.folder, "readers", "folder", found.name):
        frame, facts = found.folder(path)
    return _table_of([frame], str(path), (facts, Skips()))


def _format_of(head: bytes, name: str, told: str | None) -> tuple[Format, dict[str, Any]]:
    if told is not None:
        return chosen(told, of_file=True)
    found = recognised(head, name)
    if found is None or not found.can_read:
        if (written := _written_only(name)) is not None:
            raise DataFormatError(
                f"{name}: {written.title}, which is written and not read; expected reports, or of "
                "a run its directory or its tracks.csv, which become any other format"
            )
        known = ", ".join(each.name for each in formats().values() if each.can_read)
        raise DataFormatError(
            f"{name}: of no format that is known by its content or ending; expected one of "
            f"{known}; --from says which"
        )
    return found, {}


def _written_only(name: str) -> Format | None:
    """Return the format that a name's ending tells where it is one that is not read."""
    fits = [each for each in formats().values() if name.lower().endswith(each.endings)]
    return fits[0] if fits and not any(each.can_read for each in fits) else None


def _table_of(frames: list[pl.DataFrame], name: str, told: tuple[Facts, Skips]) -> RawTable:
    """Return what a decoder made of a file, without reports whose time nothing tells."""
    facts, skips = told
    columns = pl.concat(frames, how="diagonal_relaxed") if frames else pl.DataFrame()
    untimed = columns["time"].null_count() if "time" in columns.columns else 0
    if untimed:
        columns = columns.filter(pl.col("time").is_not_null())
        facts.notes.append(f"{untimed:,} reports say no time and were left out")
    if columns.is_empty():
        why = facts.sentences()
        if skips.count:
            first = skips.listed[0]
            why.append(
                f"{skips.count:,} records skipped, the first at byte {first.offset}: {first.what}"
            )
        what = "; ".join(why) or "what it holds tells of no object"
        raise DataFormatError(f"{name}: no reports in it ({what})")
    row = np.arange(1, columns.height + 1)
    return RawTable(name, columns, row, facts=facts, undecoded=skips)


@contextmanager
def _opened(path: Path) -> Iterator[tuple[IO[bytes], str]]:
    """Open a file or standard input, unpacked where it is gzip data, with what it is called."""
    is_standard = str(path) == STANDARD_INPUT
    name = "standard input" if is_standard else str(path)
    with nullcontext(sys.stdin.buffer) if is_standard else opened(path) as file:
        try:
            source: Any = BufferedReader(file)
            is_packed = path.name.lower().endswith(".gz") or source.peek(2)[:2] == _GZIP
            unpacked: Any = gzip.GzipFile(fileobj=source) if is_packed else source
            yield unpacked, name
        except EOFError as err:
            raise DataFormatError(
                f"{name}: gzip data end too early; expected a whole file"
            ) from err
        except (gzip.BadGzipFile, zlib.error) as err:
            raise DataFormatError(
                f"{name}: damaged or no gzip data; expected a whole file"
            ) from err
