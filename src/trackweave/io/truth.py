"""What ``evaluate`` compares: true positions, tracks and assignments."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import polars as pl

from trackweave.arrays import FloatArray
from trackweave.domain.frames import LocalFrame
from trackweave.domain.tracks import CONFIRMED, STATUSES
from trackweave.domain.truth import TruthTable
from trackweave.io.checks import Range, RowChecks
from trackweave.io.columns import BoolArray, numbered, read_numbers, text_array
from trackweave.io.positions import DISTANCE, TRACK_PLACE, TRACK_SPEED, read_positions
from trackweave.io.tables import TableSource, load_table, with_time
from trackweave.io.times import read_times

__all__ = [
    "AssignmentTable",
    "plane_of",
    "read_assignments",
    "read_status",
    "read_tracks",
    "read_truth",
]

_SPEED = Range(-1e9, 1e9)
_STATUS = "tentative, confirmed or coasting"


@dataclass(frozen=True, slots=True, eq=False)
class AssignmentTable:
    """Which report belongs to which track.

    Parameters
    ----------
    report
        Identifier of each report as text, shape (reports,).
    track
        Identifier of its track as text, empty for a false alarm.
    target
        The target behind each report as text, empty for a false alarm; None where the table does
        not know targets.
    """

    report: np.ndarray[Any, Any]
    track: np.ndarray[Any, Any]
    target: np.ndarray[Any, Any] | None

    def __len__(self) -> int:
        return len(self.report)


def plane_of(source: TableSource) -> LocalFrame | None:
    """Return the plane on which to compare a truth in latitudes and longitudes with tracks.

    Parameters
    ----------
    source
        The truth: a path, or a table of another library.

    Returns
    -------
    The plane about the truth's median position; None where the truth has ``x,y``.

    Raises
    ------
    DataFormatError
        If the table cannot be read or has no positions.
    """
    checks = RowChecks(load_table(source))
    return read_positions(checks, among=_there(checks)).frame


def read_truth(source: TableSource, frame: LocalFrame | None = None) -> TruthTable:
    """Read true positions: ``time,target,x,y[,z][,vx,vy[,vz]]``, or ``lat,lon[,alt_m]``.

    ``time`` may be called ``t`` or ``frame``. ISO 8601 times become seconds from 1970 UTC. Other
    columns are passed over, and so are velocities unless every row has them. A row whose position
    is empty or NaN throughout says that its target is away, as if there were no such row.

    Parameters
    ----------
    source
        A path that ends in .csv, .csv.gz or .parquet, or a pandas, polars or Arrow table.
    frame
        The plane for latitudes and longitudes, such as that of ``plane_of``.

    Returns
    -------
    The truth, sorted by time, then target.

    Raises
    ------
    DataFormatError
        If the table is not one of true positions, or has a bad row.

    Examples
    --------
    >>> import polars as pl
    >>> import trackweave as tw
    >>> frame = pl.DataFrame({"time": [0.0], "target": ["a"], "x": [1.0], "y": [2.0]})
    >>> tw.read_truth(frame).position  # m
    array([[1., 2.]])
    """
    checks = RowChecks(with_time(load_table(source)))
    there = _there(checks)
    return _as_truth(checks, _paths(checks, "target", frame, there), there)


def read_tracks(source: TableSource, frame: LocalFrame | None = None) -> TruthTable:
    """Read what tracks claim: positions of confirmed and coasting tracks, ready for ``evaluate``.

    Tentative rows are left out; where there is no column ``status`` every row counts. Track
    identifiers may be numbers or text.

    Parameters
    ----------
    source
        A path that ends in .csv, .csv.gz or .parquet, or a pandas, polars or Arrow table; it may
        have no rows.
    frame
        When given, positions are the table's ``lat,lon[,alt_m]`` laid on this plane.

    Returns
    -------
    Positions, with the tracks' identifiers in the place of targets.

    Raises
    ------
    DataFormatError
        If the table is not one of tracks, or has a bad row.

    Examples
    --------
    >>> import polars as pl
    >>> import trackweave as tw
    >>> frame = pl.DataFrame({
    ...     "time": [0.0], "track": [7], "x": [0.0], "y": [0.0], "vx": [1.0], "vy": [0.0],
    ...     "p_x_x": [4.0], "p_x_y": [0.0], "p_x_vx": [0.0], "p_x_vy": [0.0],
    ...     "p_y_y": [4.0], "p_y_vx": [0.0], "p_y_vy": [0.0],
    ...     "p_vx_vx": [1.0], "p_vx_vy": [0.0], "p_vy_vy": [1.0],
    ... })
    >>> tw.read_tracks(frame).target
    array(['7'], dtype=object)
    """
    checks = RowChecks(with_time(load_table(source, may_be_empty=True)))
    if frame is not None:
        checks.require("lat", "latitudes, because the truth is in latitudes and longitudes")
    tracks = _paths(checks, "track", frame)
    claimed = np.ones(len(checks), dtype=bool)
    if "status" in checks.names:
        claimed = read_status(checks) >= CONFIRMED
    return _as_truth(checks, tracks, claimed)


def read_assignments(source: TableSource) -> AssignmentTable:
    """Read which report belongs to which track: ``report,track`` and, where known, ``target``.

    Parameters
    ----------
    source
        A path that ends in .csv, .csv.gz or .parquet, or a pandas, polars or Arrow table; it may
        have no rows.

    Returns
    -------
    One row per report, in order of time, then sensor, then row, where the table tells these.

    Raises
    ------
    DataFormatError
        If a column is missing, or a report has no identifier or appears twice.
    """
    checks = RowChecks(load_table(source, may_be_empty=True))
    checks.require("report", "identifiers of reports")
    checks.require("track", "identifiers of tracks, empty for a false alarm")
    report = checks.text("report", "an identifier")
    again = ~report.is_first_distinct().to_numpy()
    checks.refuse("report", again, "an identifier that no row before has")
    track = text_array(checks.text("track"))
    target = text_array(checks.text("target")) if "target" in checks.names else None
    checks.finish("fail")
    # Switches are counted in order of time, whatever the order of the file.
    time = np.zeros(len(checks))
    if "time" in checks.names:
        time = read_times(checks.column("time")).numbers.values
    sensor = np.zeros(len(checks), dtype=np.int64)
    if "sensor" in checks.names:
        sensor = numbered(checks.text("sensor").fill_null(""))[1]
    rows = np.lexsort((sensor, time))
    return AssignmentTable(
        text_array(report)[rows], track[rows], None if target is None else target[rows]
    )


def read_status(checks: RowChecks) -> np.ndarray[Any, Any]:
    """Return the codes of a table's column ``status``, -1 in bad rows.

    Parameters
    ----------
    checks
        The table; bad cells are complained of there.

    Returns
    -------
    TENTATIVE, CONFIRMED or COASTING, shape (rows,).
    """
    words = text_array(checks.text("status"))
    codes = np.full(len(words), -1, dtype=np.int64)
    for code, word in enumerate(STATUSES):
        codes[words == word] = code
    checks.refuse("status", codes < 0, _STATUS)
    return codes


@dataclass(frozen=True, slots=True, eq=False)
class _Paths:
    """Columns of positions with a name each, in the table's order."""

    name_column: str
    time: FloatArray
    name: np.ndarray[Any, Any]
    position: FloatArray
    velocity: FloatArray | None


def _there(checks: RowChecks) -> BoolArray:
    """Return the rows that hold any part of a position, right or wrong."""
    there = np.zeros(len(checks), dtype=np.bool_)
    for name in {"x", "y", "z", "lat", "lon"} & set(checks.names):
        numbers = read_numbers(checks.column(name))
        there |= numbers.unreadable | ~np.isnan(numbers.values)
    return there


def _paths(
    checks: RowChecks,
    name_column: str,
    frame: LocalFrame | None,
    among: BoolArray | None = None,
) -> _Paths:
    checks.require("time", "seconds or ISO 8601 times")
    checks.require(name_column, f"identifiers of {name_column}s")
    time, _ = checks.times("time")
    name = text_array(checks.text(name_column, "an identifier"))
    is_track = name_column == "track"
    within = TRACK_PLACE if is_track else DISTANCE
    position = read_positions(checks, frame, among, within).values
    velocity_columns = ("vx", "vy", "vz")[: position.shape[1]]
    velocity, speed = None, TRACK_SPEED if is_track else _SPEED
    if all(checks.filled(column) for column in velocity_columns):
        speeds = [checks.numbers(column, speed, among=among) for column in velocity_columns]
        velocity = np.stack(speeds, -1)
    return _Paths(name_column, time, name, position, velocity)


def _as_truth(checks: RowChecks, paths: _Paths, claimed: BoolArray | None = None) -> TruthTable:
    """Return the claimed rows; who is at two places at one time is refused here."""
    rows = np.flatnonzero(checks.good if claimed is None else checks.good & claimed)
    place = pl.DataFrame({"time": paths.time[rows], "name": pl.Series(paths.name[rows].tolist())})
    again = np.zeros(len(checks), dtype=bool)
    again[rows] = ~place.select(pl.struct(pl.all()).is_first_distinct()).to_series().to_numpy()
    checks.refuse(paths.name_column, again, f"one row of a {paths.name_column} at one time")
    checks.finish("fail")
    velocity = None if paths.velocity is None else paths.velocity[rows]
    return TruthTable.from_columns(
        paths.time[rows], paths.name[rows], paths.position[rows], velocity
    )
