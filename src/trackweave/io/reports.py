"""Tables of reports, from files and from other libraries."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple, get_args

import numpy as np
import polars as pl

from trackweave.arrays import FloatArray, IntArray
from trackweave.domain.facts import Place
from trackweave.domain.foreign_kind import ForeignKind, kind_of
from trackweave.domain.frames import LocalFrame, Projection
from trackweave.domain.measurements import MeasurementKind
from trackweave.domain.reports import ReportTable
from trackweave.errors import InvalidInputError
from trackweave.fields import checked_choice
from trackweave.io.checks import FLIGHT_LEVEL, LEVEL_M, Range, RowChecks, ask_back, questions
from trackweave.io.columns import (
    numbered,
    read_numbers,
    read_text,
    text_array,
    typed_column,
    with_common_times,
)
from trackweave.io.counters import unwrapped
from trackweave.io.measured import Measured, read_all_measured
from trackweave.io.polar import read_platforms
from trackweave.io.positions import choose_frame, frame_about, require_origin
from trackweave.io.tables import OnBadRow, RawTable, with_our_names
from trackweave.io.time_axes import note_on_falls
from trackweave.summaries import counted

__all__ = ["ONLY_SENSOR", "reports_in", "with_heeded_scans"]

# The name of the sensor of a table without a column for it, as in [sensors.default].
ONLY_SENSOR = "default"
# Of so many moments of one sensor a column of scans has to tell several.
MOMENTS_OF_SCANS = 3

_SCAN = Range(-(2.0**53), 2.0**53, expected="a whole number")
_HEIGHT = Range(-1e5, 1e8)
_STRENGTH = Range(-1e300, 1e300)

MEANT = {
    "sensor": (("sensor_id", "sensor_name", "radar", "radar_id"), "which sensor reports"),
    "identity": (("mmsi", "icao24", "icao", "mode_s"), "whose report it is"),
}
"""Columns that are often called so, in small letters, and what they may be meant to tell."""


def reports_in(  # noqa: PLR0913 each says another thing of the same table
    table: RawTable,
    *,
    frame_origin: tuple[float, float] | None = None,
    frame_projection: Projection = "tangent",
    on_bad_row: OnBadRow = "fail",
    kinds: Mapping[str, Any] | None = None,
    places: Mapping[str, Place] | None = None,
    anywhere: bool = False,  # Not only about one plane: for whoever only passes rows on
) -> ReportTable:
    """Return the reports that raw columns hold; the rest as ``trackweave.read_reports``."""
    checked_choice(frame_projection, "frame_projection", get_args(Projection))
    checked_choice(on_bad_row, "on_bad_row", get_args(OnBadRow))
    table, frame = with_our_names(table), None
    if frame_origin is not None:
        frame = require_origin(frame_origin, frame_projection)
    checks = RowChecks(table, anywhere=anywhere)
    has_plane = {"x", "y"} <= set(checks.names)
    if frame is None and not has_plane and "lat" not in checks.names:
        known = {**table.facts.places, **(places or {})}
        frame = _frame_of_places([*known.values()], frame_projection)
    if frame is None and frame_projection != "tangent" and not has_plane:
        frame = frame_about(checks, frame_projection)
    checks.require(
        "time", "seconds or ISO 8601 times; --from 'csv?time=NAME' tells what it is called"
    )
    ask_back(checks)
    time, iso_time = checks.times("time")
    sensor_names = _sensor_names(checks)
    measured = read_all_measured(checks, sensor_names, frame, _checked_kinds(kinds))
    on_plane = measured.frame is None and {"x", "y"} <= set(measured.columns)
    read = _Read(
        sensor_names,
        measured,
        *read_platforms(checks, measured.frame or frame, on_plane=on_plane),
        _optional(checks, "strength", _STRENGTH),
        _height(checks),
        checks.whole_numbers("scan", _SCAN) if "scan" in checks.names else None,
        _identifiers(checks, table),
    )
    skipped = checks.finish(on_bad_row, may_skip=True)

    usable, aside = np.flatnonzero(checks.good), np.flatnonzero(checks.aside)
    moment, moved = with_common_times(time[usable])
    falls = note_on_falls(time[usable], table.row[usable], sensor_names.gather(usable))
    unavailable = None
    if aside.size:
        unavailable = _reports_of(checks, table, read, (aside, time[aside]))
        nothing = np.full_like(unavailable.measurement, np.nan)
        unavailable = replace(unavailable, measurement=nothing, iso_time=iso_time)
    return replace(
        _reports_of(checks, table, read, (usable, moment)),
        iso_time=iso_time,
        skipped=skipped,
        notes=(
            *table.notes,
            *checks.notes,
            *_notes_on_meant(checks.names),
            *measured.notes,
            *_note_on_two_places(checks, measured),
            *moved,
            *falls,
            *_note_on_unavailable(checks),
            *_note_on_levels(checks),
            *questions(checks),
        ),
        unavailable=unavailable,
        facts=table.facts,
        undecoded=table.undecoded,
    )


def with_heeded_scans(reports: ReportTable) -> ReportTable:
    """Return reports whose column of scans tells of each time, if at all, with notes."""
    # For all reports there are: of a stream, a part may well be one scan.
    scan = reports.scan
    if scan is None or scan.size == 0:
        return reports
    scan, notes = scan.copy(), list(reports.notes)
    is_same = bool(np.all(scan == scan[0]))
    for sensor, name in enumerate(reports.sensors):
        rows = np.flatnonzero(reports.sensor == sensor)
        if is_same and np.unique(reports.time[rows]).size >= MOMENTS_OF_SCANS:
            note = (
                f"column scan: {scan[0]} in every row, though reports of a sensor come at "
                f"{MOMENTS_OF_SCANS} times or more; not used"
            )
            return replace(reports, scan=None, notes=(*notes, note))
        scan[rows], count = unwrapped(scan[rows])
        if count:
            notes.append(
                f"column scan: numbers of sensor {name} begin anew {counted(count, 'time')}; "
                "those before and after are other scans"
            )
    return replace(reports, scan=scan, notes=tuple(notes))


def _frame_of_places(places: Sequence[Place], projection: Projection) -> LocalFrame | None:
    """Return a plane about where sensors are known to stand, None where that is not known."""
    if not places:
        return None
    latitude, longitude = (
        np.array([getattr(place, name) for place in places])
        for name in ("latitude_deg", "longitude_deg")
    )
    return replace(choose_frame(latitude, longitude), projection=projection)


class _Read(NamedTuple):
    """What was read of each row."""

    sensors: pl.Series
    measured: Measured
    platform: FloatArray | None
    frame: LocalFrame | None
    strength: FloatArray | None
    height: FloatArray | None
    scan: FloatArray | None
    identifiers: pl.Series


def _reports_of(
    checks: RowChecks, table: RawTable, read: _Read, some: tuple[IntArray, FloatArray]
) -> ReportTable:
    """Return some rows, of which the times are given, as reports in their order."""
    rows, moment = some
    sensors, code = numbered(read.sensors.gather(rows))
    order = np.lexsort((code, moment))
    rows, code = rows[order], code[order]
    identity, identities = _identities(checks, rows)
    measured, scan, platform = read.measured, read.scan, read.platform
    return ReportTable(
        time=moment[order],
        sensor=code,
        sensors=sensors,
        measurement=measured.values[rows],
        sigma=measured.sigma[rows],
        report=text_array(read.identifiers.gather(rows)),
        scan=None if scan is None else scan[rows].astype(np.int64),
        carried=_carried(checks, table, measured, rows),
        frame=measured.frame or read.frame,
        kind=table.kind,
        kinds=_kinds(measured, rows, code, sensors),
        space=0 if measured.kind is None else measured.space,
        platform=None if platform is None else platform[rows],
        identity=identity,
        identities=identities,
        strength=None if read.strength is None else read.strength[rows],
        height=None if read.height is None else read.height[rows],
        row=table.row[rows],
        report_type=_type_of_identifiers(table),
        context=None if measured.context is None else measured.context[rows],
    )


def _notes_on_meant(names: Collection[str]) -> list[str]:
    """Return a sentence for each column that seems to tell what no column of ours does."""
    named = {name.lower(): name for name in names}
    tracks = (
        "columns track and status: this looks like a file of tracks, whose rows are taken for "
        "reports; expected what sensors reported"
    )
    return [tracks] * ({"track", "status"} <= set(names)) + [
        f"column {named[other]}: carried along and not read; if it tells {what}, call it {ours}"
        for ours, (others, what) in MEANT.items()
        for other in others
        if ours not in names and other in named
    ]


def _note_on_unavailable(checks: RowChecks) -> list[str]:
    """Return a sentence on rows that hold codes for "not available", if any do."""
    count = int(checks.aside.sum())
    return [
        f'lat, lon: {count:,} of {len(checks):,} rows hold the codes for "not available" '
        "(latitude 91, longitude 181, or 0, 0 far from all others); they are of no track"
    ] * (count > 0)


def _note_on_two_places(checks: RowChecks, measured: Measured) -> list[str]:
    """Return a sentence on which columns are the position, where there are two such pairs."""
    pairs = ("x", "y"), ("lat", "lon")
    if not all(checks.filled(name) for pair in pairs for name in pair):
        return []
    of_plane = {"x", "y"} <= set(measured.columns)
    used, other = pairs if of_plane else pairs[::-1]
    how = "[frame] origin takes lat, lon" if of_plane else "without [frame] origin x, y are used"
    return [
        f"{', '.join(used)}: used as positions, and {', '.join(other)} beside them are not; {how}"
    ]


def _takes_levels(checks: RowChecks) -> bool:
    """Tell whether heights are those of flight levels: of ranges, where nothing else tells any."""
    return {"range_m", FLIGHT_LEVEL} <= set(checks.names) and "height_m" not in checks.names


def _height(checks: RowChecks) -> FloatArray | None:
    """Return heights [m], NaN where a row tells none."""
    if not _takes_levels(checks):
        return _optional(checks, "height_m", _HEIGHT)
    # Nobody said that they are heights: what is none refuses no row.
    height = read_numbers(checks.column(FLIGHT_LEVEL)).values * LEVEL_M
    height[~((height >= _HEIGHT.low) & (height <= _HEIGHT.high))] = np.nan
    return None if np.isnan(height).all() else height


def _note_on_levels(checks: RowChecks) -> list[str]:
    """Return a sentence on flight levels that are taken for heights, if any are."""
    return [
        f"column {FLIGHT_LEVEL}: taken for height_m, in hundreds of feet, for there is no column "
        "height_m; it is the pressure's height, up to some hundred metres from the true one"
    ] * _takes_levels(checks)


def _sensor_names(checks: RowChecks) -> pl.Series:
    if "sensor" in checks.names:
        return checks.text("sensor", "the name or number of a sensor")
    return pl.Series("sensor", [ONLY_SENSOR]).new_from_index(0, len(checks))


def _checked_kinds(kinds: Mapping[str, Any] | None) -> dict[str, ForeignKind | None]:
    """Return kinds from outside by the names of their sensors."""
    if kinds is None:
        return {}
    expected = "kinds of measurement of your own by the names of their sensors"
    if not isinstance(kinds, Mapping):
        raise InvalidInputError(f"kinds: {kinds!r:.80}; expected {expected}")
    found = {str(name): kind_of(kind) for name, kind in kinds.items()}
    for name, kind in found.items():
        if not isinstance(kind, ForeignKind | None):
            raise InvalidInputError(f"kinds: {name}: {kind!r:.80}; expected {expected}")
    return found


def _kinds(
    measured: Measured, rows: IntArray, code: IntArray, sensors: tuple[str, ...]
) -> tuple[MeasurementKind | ForeignKind, ...]:
    """Return what each sensor measures, none where all measure positions."""
    if measured.kind is None:
        return ()
    _, first = np.unique(code, return_index=True)
    numbers = measured.kind[rows[first]]
    return tuple(
        measured.foreign.get(name) or MeasurementKind(number)
        for name, number in zip(sensors, numbers, strict=True)
    )


def _optional(checks: RowChecks, name: str, within: Range) -> FloatArray | None:
    """Return the numbers of a column that may be missing or have empty cells."""
    return checks.numbers(name, within, optional=True) if checks.filled(name) else None


def _identities(checks: RowChecks, rows: IntArray) -> tuple[IntArray | None, tuple[str, ...]]:
    """Return whom each report says it is of, and the names; None where no report says."""
    if not checks.filled("identity"):
        return None, ()
    names = checks.text("identity").gather(rows)
    different = sorted(names.drop_nulls().unique().to_list())
    places = pl.Series(range(len(different)), dtype=pl.Int64)
    code = names.replace_strict(
        pl.Series(different, dtype=pl.String), places, default=None, return_dtype=pl.Int64
    )
    return code.fill_null(-1).to_numpy(), tuple(different)


def _identifiers(checks: RowChecks, table: RawTable) -> pl.Series:
    """Return each report's identifier; one that an earlier right row has is a fault."""
    if "report" not in checks.names:
        return pl.Series("report", table.row).cast(pl.String)
    identifiers = checks.text("report", "an identifier")
    right = np.flatnonzero(checks.good | checks.aside)
    again = np.zeros(len(checks), dtype=bool)
    again[right] = ~identifiers.gather(right).is_first_distinct().to_numpy()
    checks.refuse("report", again, "an identifier that no row before has")
    return identifiers


def _type_of_identifiers(table: RawTable) -> Any:
    """Return the type of whole numbers that identifiers are, None where they are text."""
    if "report" not in table.columns.columns:
        return pl.Int64()
    column = table.columns["report"]
    if table.is_text or column.dtype.is_float():
        # As text whole floats have no decimal point, so that files and tables agree.
        column = typed_column(read_text(column))
    is_known = column.dtype.is_integer() and column.dtype != pl.Int128
    return column.dtype if is_known else None


def _carried(
    checks: RowChecks, table: RawTable, measured: Measured, rows: IntArray
) -> Mapping[str, Any]:
    """Return the columns that are not measurements, and the targets as text."""
    read = {"time", "sensor", "report", "scan", *measured.columns}
    carried: dict[str, Any] = {}
    for name in checks.names:
        if name == "target":
            carried[name] = text_array(checks.text(name).gather(rows))
        elif name not in read:
            carried[name] = table.columns[name].gather(rows)
    return carried
