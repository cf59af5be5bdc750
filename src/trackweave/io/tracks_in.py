"""Tracks of one sensor, as files of tracks hold them: every row, not only the last."""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.domain.tracks import CONFIRMED, TrackTable
from trackweave.io.checks import Range, RowChecks
from trackweave.io.columns import BoolArray
from trackweave.io.positions import LATITUDE, LONGITUDE, TRACK_PLACE, TRACK_SPEED
from trackweave.io.priors import covariance_names, read_covariances, state_names
from trackweave.io.tables import TableSource, load_table, with_time
from trackweave.io.truth import read_status
from trackweave.summaries import summary

__all__ = ["LocalTracks", "read_local_tracks"]

_TRACK = Range(0.0, 2.0**53, expected="a whole number")
_WHAT = "a tracks table with velocities and covariances"


@dataclass(frozen=True, slots=True, eq=False)
class LocalTracks:
    """All that one sensor's tracker said, one row per track and time.

    Parameters
    ----------
    name
        What messages call the table.
    tracks
        Its rows, sorted by time, then track; their scores and hits are 0.
    latitude, longitude
        Where each row is [degrees], None where the table does not say.
    iso_time
        Whether times came as ISO 8601; they are seconds from 1970 UTC then.
    kind
        Library that the table came from: "polars" (also for files), "pandas" or "pyarrow".
    n_left_out
        Number of tentative rows that do not take part.
    is_tentative
        Whether all rows are tentative ones, there being no others.

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
    >>> local = tw.read_local_tracks(frame)
    >>> len(local), local.tracks.track, local.tracks.mean
    (1, array([7]), array([[0., 0., 1., 0.]]))
    """

    name: str
    tracks: TrackTable
    latitude: FloatArray | None = None
    longitude: FloatArray | None = None
    iso_time: bool = False
    kind: str = "polars"
    n_left_out: int = 0
    is_tentative: bool = False

    __repr__ = summary

    def __len__(self) -> int:
        return len(self.tracks)

    def with_states(self, mean: FloatArray, covariance: FloatArray) -> Self:
        """Return the same rows with other states, such as on another plane."""
        return replace(self, tracks=replace(self.tracks, mean=mean, covariance=covariance))


def read_local_tracks(source: TableSource) -> LocalTracks:
    """Read the tracks of one sensor: confirmed and coasting rows, all where there is no status.

    Needed are ``time,track,x,y[,z],vx,vy[,vz]`` and the upper triangle of the covariance,
    ``p_x_x,p_x_y,p_x_vx,…``; ``lat,lon`` are kept where they are. Where all rows are tentative
    they are taken.

    Parameters
    ----------
    source
        A path that ends in .csv, .csv.gz or .parquet, or a pandas, polars or Arrow table; it may
        have no rows.

    Returns
    -------
    The rows.

    Raises
    ------
    DataFormatError
        If the table is not one of tracks with covariances, a row is bad, or a track has two rows
        at one time.

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
    >>> tw.read_local_tracks(frame).tracks.mean  # m, m/s
    array([[0., 0., 1., 0.]])
    """
    table = with_time(load_table(source, may_be_empty=True))
    checks = RowChecks(table)
    has_height = checks.filled("z") or (len(checks) == 0 and "z" in checks.names)
    dim = 3 if has_height else 2
    for name in ("time", "track", *state_names(dim), *covariance_names(dim)):
        checks.require(name, _WHAT)
    time, iso_time = checks.times("time")
    track = checks.whole_numbers("track", _TRACK)
    within = (TRACK_PLACE,) * dim + (TRACK_SPEED,) * dim
    columns = [
        checks.numbers(name, limits) for name, limits in zip(state_names(dim), within, strict=True)
    ]
    mean = np.stack(columns, axis=-1)
    covariance = read_covariances(checks, dim)
    status = np.full(len(checks), CONFIRMED)
    if "status" in checks.names:
        status = read_status(checks)
    latitude, longitude = _geodetic(checks)
    is_tentative = bool(len(checks)) and not np.any(status >= CONFIRMED)
    takes_part = np.ones(len(checks), dtype=np.bool_) if is_tentative else status >= CONFIRMED
    _refuse_doubles(checks, time, track, takes_part)
    checks.finish("fail")
    order = np.lexsort((track, time))
    order = order[takes_part[order]]
    nothing = np.zeros(order.size)
    tracks = TrackTable(
        time[order], track[order].astype(np.int64), status[order], mean[order], covariance[order],
        nothing, nothing.astype(np.int64), time[order],
    )  # fmt: skip
    return LocalTracks(
        checks.name, tracks,
        None if latitude is None else latitude[order],
        None if longitude is None else longitude[order],
        iso_time, table.kind, int(len(checks) - order.size), is_tentative,
    )  # fmt: skip


def _geodetic(checks: RowChecks) -> tuple[FloatArray | None, FloatArray | None]:
    if not (checks.filled("lat") and checks.filled("lon")):
        return None, None
    return checks.numbers("lat", LATITUDE), checks.numbers("lon", LONGITUDE)


def _refuse_doubles(
    checks: RowChecks, time: FloatArray, track: FloatArray, takes_part: BoolArray
) -> None:
    """Complain of every row but the first of a track at one time."""
    rows = np.flatnonzero(takes_part & checks.good)
    key: IntArray = rows[np.lexsort((rows, time[rows], track[rows]))]
    same = (np.diff(track[key]) == 0) & (np.diff(time[key]) == 0)
    again = np.zeros(len(checks), dtype=np.bool_)
    again[key[1:][same]] = True
    checks.refuse("track", again, "one row of a track at one time")
