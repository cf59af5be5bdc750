"""What ``evaluate`` compares: true positions, tracks and assignments."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import polars as pl

from trackweave.domain.frames import LocalFrame
from trackweave.domain.tracks import CONFIRMED
from trackweave.domain.truth import TruthTable
from trackweave.errors import DataFormatError
from trackweave.io.checks import Range, RowChecks, checks_of
from trackweave.io.columns import BoolArray, numbered, read_numbers, read_times, text_array
from trackweave.io.positions import DISTANCE, TRACK_PLACE, TRACK_SPEED, read_positions
from trackweave.io.tables import TableSource, load_table
from trackweave.io.tracks_in import read_status

__all__ = [
    "AssignmentTable",
    "read_assignments",
    "read_tracks",
    "read_truth",
    "read_truth_on_plane",
]

_SPEED = Range(-1e9, 1e9)


@dataclass(frozen=True, slots=True, eq=False)
class AssignmentTable:
    """Which report belongs to which track."""

    report: np.ndarray[Any, Any]  # Identifier of each report as text, shape (reports,)
    track: np.ndarray[Any, Any]  # Identifier of its track as text, empty for a false alarm
    # The target behind each report as text, empty for a false alarm; None where the table does not
    # know targets.
    target: np.ndarray[Any, Any] | None

    def __len__(self) -> int:
        return len(self.report)


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
        The plane for latitudes and longitudes; None to choose one about their median.

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
    return read_truth_on_plane(source, frame)[0]


def read_truth_on_plane(
    source: TableSource, frame: LocalFrame | None = None
) -> tuple[TruthTable, LocalFrame | None]:
    """Read true positions, and the plane on which they were laid, None where they are ``x,y``."""
    checks = checks_of(source)
    if "target" in checks.names and not {"x", "y", "lat", "lon", "left"} & set(checks.names):
        raise DataFormatError(
            f"{checks.name}, columns x and y: missing; expected the positions of targets. What "
            "tells the target of each report judges assignments alone: leave out truth and tracks"
        )
    return _paths(checks, "target", frame, _there(checks))


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
    >>> frame = pl.DataFrame({"time": [0.0], "track": [7], "x": [0.0], "y": [0.0]})
    >>> tw.read_tracks(frame).target
    array(['7'], dtype=object)
    """
    checks = checks_of(source, may_be_empty=True)
    if frame is not None:
        checks.require("lat", "latitudes, because the truth is in latitudes and longitudes")
    return _paths(checks, "track", frame)[0]


def read_assignments(source: TableSource) -> AssignmentTable:
    """Read ``report,track[,target]``, in order of time, then sensor where it tells them."""
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


def _there(checks: RowChecks) -> BoolArray:
    """Return the rows that hold any part of a position, right or wrong."""
    there = np.zeros(len(checks), dtype=np.bool_)
    for name in {"x", "y", "z", "lat", "lon"} & set(checks.names):
        numbers = read_numbers(checks.column(name))
        there |= numbers.unreadable | ~np.isnan(numbers.values)
    return there


def _paths(
    checks: RowChecks, names: str, frame: LocalFrame | None, there: BoolArray | None = None
) -> tuple[TruthTable, LocalFrame | None]:
    """Return positions and velocities by name; who is at two places at one time is refused."""
    checks.require("time", "seconds or ISO 8601 times")
    checks.require(names, f"identifiers of {names}s")
    time, _ = checks.times("time")
    name = text_array(checks.text(names, "an identifier"))
    within, fastest = (DISTANCE, _SPEED) if names == "target" else (TRACK_PLACE, TRACK_SPEED)
    positions = read_positions(checks, frame, there, within)
    columns, velocity = ("vx", "vy", "vz")[: positions.values.shape[1]], None
    if all(checks.filled(column) for column in columns):
        speeds = [checks.numbers(column, fastest, among=there) for column in columns]
        velocity = np.stack(speeds, -1)
    if there is None:
        there = read_status(checks) >= CONFIRMED
    rows = np.flatnonzero(checks.good & there)
    place = pl.DataFrame({"time": time[rows], "name": pl.Series(name[rows].tolist())})
    again = np.zeros(len(checks), dtype=bool)
    again[rows] = ~place.select(pl.struct(pl.all()).is_first_distinct()).to_series().to_numpy()
    checks.refuse(names, again, f"one row of a {names} at one time")
    checks.finish("fail")
    truth = TruthTable.from_columns(
        time[rows],
        name[rows],
        positions.values[rows],
        None if velocity is None else velocity[rows],
    )
    return truth, positions.frame
