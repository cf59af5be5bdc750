"""Results become data frames with the columns that files have."""

from collections.abc import Collection, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import polars as pl

from trackweave.arrays import FloatArray, IntArray
from trackweave.domain.foreign_kind import ForeignKind
from trackweave.domain.frames import LocalFrame
from trackweave.domain.reports import ReportTable
from trackweave.domain.tracks import STATUSES, TrackTable
from trackweave.domain.truth import TruthTable
from trackweave.io.columns import datetime_column
from trackweave.io.positions import NO_LATITUDE, NO_LONGITUDE
from trackweave.io.tracks_in import covariance_names, state_names

if TYPE_CHECKING:
    # Runs that fuse nothing need not wait for the import.
    from trackweave.fusion.pairings import Pairing

__all__ = [
    "assignments_frame",
    "associations_frame",
    "reports_frame",
    "tracks_frame",
    "truth_frame",
    "ways_out",
    "with_parents",
]


_DIGITS = 6
"""To so many decimals probabilities are written: nothing that one decides hangs on more."""
_AXES = ("x", "y", "z")
_PLATFORM = tuple(f"sensor_{name}" for name in ("x", "y", "z", "vx", "vy", "vz"))
_PLATFORM_ON_EARTH = ("sensor_lat", "sensor_lon", "sensor_alt_m", *_PLATFORM[3:])


def tracks_frame(
    tracks: TrackTable, frame: LocalFrame | None = None, *, iso_time: bool = False
) -> pl.DataFrame:
    """Return tracks or a history as a data frame, its rows in their order."""
    # ``time,track,status,x,y[,z][,lat,lon[,alt_m]],vx,vy[,vz],p_x_x,…[,ax,ay[,az]],score,hits,
    # last_update[,existence,visible]``: places on the Earth where a plane is given, accelerations
    # where the motion knows them.
    dim, n = tracks.dim, 2 * tracks.dim
    names = state_names(dim)
    status = pl.Series("status", list(STATUSES)).gather(tracks.status)
    upper = np.triu_indices(n)
    covariance = tracks.covariance[:, upper[0], upper[1]]
    return pl.DataFrame(
        [
            _time_column("time", tracks.time, iso_time=iso_time),
            pl.Series("track", tracks.track, dtype=pl.Int64),
            status,
            *_number_columns(names[:dim], tracks.mean[:, :dim]),
            *_geodetic_columns(tracks.mean[:, :dim], frame),
            *_number_columns(names[dim:], tracks.mean[:, dim:]),
            *_number_columns(covariance_names(dim), covariance),
            *_number_columns(
                ("ax", "ay", "az")[: tracks.acceleration.shape[1]], tracks.acceleration
            ),
            pl.Series("score", tracks.score, dtype=pl.Float64),
            pl.Series("hits", tracks.hits, dtype=pl.Int64),
            _time_column("last_update", tracks.last_update, iso_time=iso_time),
            *_chance_columns(tracks),
        ]
    )


def with_parents(frame: pl.DataFrame, parent: Mapping[int, int]) -> pl.DataFrame:
    """Return tracks with the track that each came of by division, null for none, in ``parent``."""
    column = pl.col("track").replace_strict(parent, default=None, return_dtype=pl.Int64)
    return frame.with_columns(column.alias("parent"))


def _chance_columns(tracks: TrackTable) -> list[pl.Series]:
    """Return what is told of whether objects are there and in sight, if anything is."""
    chances = {"existence": tracks.existence, "visible": tracks.visible}
    return [
        pl.Series(name, values.round(_DIGITS), dtype=pl.Float64, nan_to_null=True)
        for name, values in chances.items()
        if not np.isnan(values).all()
    ]


def assignments_frame(
    reports: ReportTable,
    track: Mapping[int, int] | IntArray,
    probability: FloatArray | None = None,
    *,
    shared: Mapping[int, int] | None = None,
) -> pl.DataFrame:
    """Return which report belongs to which track, in the order in which the reports came."""
    # ``report,time,sensor,track,probability``, with ``shared`` also ``shared_with``, and the
    # carried columns: one whose name is taken by a column here gets the prefix ``reports_``. Null
    # = none. Tracks come by row number (absent = false alarm) or as an array (negative = false
    # alarm). Reports that are not available have a row too.
    found = _assigned_rows(reports, track, probability, shared)
    if reports.unavailable is not None:
        none = None if shared is None else dict[int, int]()
        found = pl.concat([found, _assigned_rows(reports.unavailable, {}, None, none)])
    return _as_they_came(found, reports)


def _assigned_rows(
    reports: ReportTable,
    track: Mapping[int, int] | IntArray,
    probability: FloatArray | None,
    shared: Mapping[int, int] | None,
) -> pl.DataFrame:
    chances = np.full(len(reports), np.nan) if probability is None else probability
    came = reports.time if reports.stamp is None else reports.stamp
    columns = [
        _identifier_column(reports),
        _time_column("time", came, iso_time=reports.iso_time),
        _sensor_column(reports),
        _named_tracks("track", track, len(reports)),
        pl.Series("probability", chances, dtype=pl.Float64, nan_to_null=True),
    ]
    if shared is not None:
        columns.append(_named_tracks("shared_with", shared, len(reports)))
    return _frame([*columns, *_carried_columns(reports, columns)])


def _named_tracks(name: str, track: Mapping[int, int] | IntArray, count: int) -> pl.Series:
    """Return the track of each row, null for none."""
    numbers = np.full(count, -1, dtype=np.int64)
    if isinstance(track, Mapping):
        numbers[np.fromiter(track.keys(), np.int64, len(track))] = np.fromiter(
            track.values(), np.int64, len(track)
        )
    else:
        numbers[:] = track
    return pl.Series(name, numbers).set(pl.Series(numbers < 0), None)


def reports_frame(reports: ReportTable) -> pl.DataFrame:
    """Return reports as a data frame that ``read_reports`` reads back, in the order they came."""
    # ``report,time,sensor,x,y[,z]`` or ``lat,lon[,alt_m]`` or what else is measured, then
    # ``sigma_x,…``, where the sensor was, and ``scan`` where there are any, and the carried
    # columns. Positions that are not available are written as AIS does.
    found = _report_rows(reports)
    if reports.unavailable is not None:
        unknown = _report_rows(reports.unavailable).with_columns(
            lat=pl.lit(NO_LATITUDE), lon=pl.lit(NO_LONGITUDE)
        )
        found = pl.concat([found, unknown], how="diagonal").select(found.columns)
    return _as_they_came(found, reports)


def _report_rows(reports: ReportTable) -> pl.DataFrame:
    columns = [
        _identifier_column(reports),
        _time_column("time", reports.time, iso_time=reports.iso_time),
        _sensor_column(reports),
        *_measured_columns(reports),
    ]
    if reports.scan is not None:
        columns.append(pl.Series("scan", reports.scan, dtype=pl.Int64))
    return _frame([*columns, *_carried_columns(reports, columns)])


def truth_frame(truth: TruthTable) -> pl.DataFrame:
    """Return true positions: ``time,target,x,y[,z][,vx,vy[,vz]]``."""
    dim = truth.dim
    names = state_names(dim)
    velocity = [] if truth.velocity is None else _number_columns(names[dim:], truth.velocity)
    return pl.DataFrame(
        [
            pl.Series("time", truth.time, dtype=pl.Float64),
            _text_column("target", truth.target),
            *_number_columns(names[:dim], truth.position),
            *velocity,
        ]
    )


def associations_frame(pairings: Sequence["Pairing"], *, iso_time: bool = False) -> pl.DataFrame:
    """Return ``object,sensor,track,from,to,reason``, no reason where it lasted to the end."""
    begin = np.array([one.begin for one in pairings], dtype=np.float64)
    end = np.array([one.end for one in pairings], dtype=np.float64)
    return pl.DataFrame(
        [
            pl.Series("object", [one.object for one in pairings], dtype=pl.Int64),
            pl.Series("sensor", [one.sensor for one in pairings], dtype=pl.String),
            pl.Series("track", [one.track for one in pairings], dtype=pl.Int64),
            _time_column("from", begin, iso_time=iso_time),
            _time_column("to", end, iso_time=iso_time),
            pl.Series("reason", [one.reason or None for one in pairings], dtype=pl.String),
        ]
    )


def _frame(columns: list[pl.Series]) -> pl.DataFrame:
    # By name, because polars gives a name to a column without one when it comes in a list.
    return pl.DataFrame({column.name: column for column in columns})


def _as_they_came(frame: pl.DataFrame, reports: ReportTable) -> pl.DataFrame:
    row = reports.rows_told()
    if row is None or np.all(np.diff(row) > 0):
        return frame
    return frame[np.argsort(row)]


def _identifier_column(reports: ReportTable) -> pl.Series:
    column = _text_column("report", reports.report)
    return column if reports.report_type is None else column.cast(reports.report_type)


def _time_column(name: str, seconds: FloatArray, *, iso_time: bool) -> pl.Series:
    """Return times [s] as a column of seconds, or of dates and times."""
    if iso_time:
        return datetime_column(name, seconds)
    return pl.Series(name, seconds, dtype=pl.Float64)


def _text_column(name: str, texts: np.ndarray[Any, Any]) -> pl.Series:
    return pl.Series(name, np.asarray(texts).astype(object), dtype=pl.String)


def _sensor_column(reports: ReportTable) -> pl.Series:
    return pl.Series("sensor", list(reports.sensors), dtype=pl.String).gather(reports.sensor)


def _carried_columns(reports: ReportTable, taken: list[pl.Series]) -> list[pl.Series]:
    ways = ways_out({column.name for column in taken}, reports.carried)
    columns = []
    for name, values in reports.carried.items():
        free = ways.get(name, name)
        if isinstance(values, pl.Series):
            columns.append(values.rename(free))
        else:
            column = _text_column(free, np.asarray(values))
            columns.append(column.set(column == "", None))
    return columns


def ways_out(taken: Collection[str], names: Collection[str]) -> dict[str, str]:
    """Return other names for a user's columns that are called as ours, as ``reports_…``."""
    everybody, ways = {*taken, *names}, {}
    for name in names:
        if name in taken:
            free = f"reports_{name}"
            while free in everybody:
                free = f"reports_{free}"
            everybody.add(free)
            ways[name] = free
    return ways


def _measured_columns(reports: ReportTable) -> list[pl.Series]:
    """Return what is measured, its noise, and where sensors were unless that is carried along."""
    values: dict[str, FloatArray] = {}
    noise: dict[str, FloatArray] = {}
    for sensor in range(len(reports.sensors)):
        rows, kind = reports.sensor == sensor, reports.kind_of(sensor)
        is_ours = not isinstance(kind, ForeignKind)
        for place, name in enumerate(kind.columns(reports.dim)):
            unit = np.pi / 180 if is_ours and name.endswith("_deg") else 1.0
            for columns, column, numbers in (
                (values, name, reports.measurement),
                (noise, f"sigma_{name}", reports.sigma),
            ):
                column_values = columns.setdefault(column, np.full(len(reports), np.nan))
                column_values[rows] = numbers[rows, place] / unit
        if isinstance(kind, ForeignKind) and reports.context is not None:
            for place, name in enumerate(kind.context):
                own = values.setdefault(name, np.full(len(reports), np.nan))
                own[rows] = reports.context[rows, place]
    written = {name: numbers for name, numbers in noise.items() if not np.isnan(numbers).all()}
    if any(name in written for name in ("sigma_x", "sigma_y")):
        written = {name: n for name, n in noise.items() if name in written or name[-1] in "xy"}
    if reports.frame is not None and "x" in values:
        position = np.stack([values.pop(name) for name in _AXES if name in values], axis=-1)
        values = {
            c.name: c.to_numpy() for c in _geodetic_columns(position, reports.frame)
        } | values
    columns = {**values, **written}
    if reports.platform is not None and not any(n.startswith("sensor_") for n in reports.carried):
        columns |= _platform(reports.platform, reports.frame)
    return [pl.Series(name, numbers, nan_to_null=True) for name, numbers in columns.items()]


def _number_columns(names: tuple[str, ...], values: FloatArray) -> list[pl.Series]:
    """Return the columns of a matrix by name, null where there is no number."""
    return [
        pl.Series(name, np.ascontiguousarray(values[:, place]), nan_to_null=True)
        for place, name in enumerate(names)
    ]


def _geodetic_columns(position: FloatArray, frame: LocalFrame | None) -> list[pl.Series]:
    """Return ``lat,lon[,alt_m]`` of positions on a plane; none without a plane."""
    if frame is None:
        return []
    latitude, longitude, altitude = frame.to_geodetic(position)
    columns = [pl.Series("lat", latitude), pl.Series("lon", longitude)]
    return [*columns, pl.Series("alt_m", altitude)] if position.shape[1] == 3 else columns


def _platform(platform: FloatArray, frame: LocalFrame | None) -> dict[str, FloatArray]:
    if frame is None:
        return {name: platform[:, place] for place, name in enumerate(_PLATFORM)}
    place = np.stack([*frame.to_geodetic(platform[:, :3]), *platform[:, 3:].T], axis=-1)
    return {name: place[:, column] for column, name in enumerate(_PLATFORM_ON_EARTH)}
