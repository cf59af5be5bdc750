"""Tracks that are known before the first report."""

from itertools import combinations_with_replacement

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.domain.frames import LocalFrame
from trackweave.domain.tracks import CONFIRMED, TrackTable
from trackweave.errors import DataFormatError
from trackweave.io.checks import Range, RowChecks
from trackweave.io.columns import BoolArray
from trackweave.io.positions import TRACK_COVARIANCE, TRACK_PLACE, TRACK_SPEED
from trackweave.io.tables import TableSource, load_table, with_time
from trackweave.io.truth import read_status

__all__ = ["covariance_names", "read_covariances", "read_priors", "state_names"]

_TRACK = Range(0.0, 2.0**53, expected="a whole number")
_COUNT = Range(0.0, 2.0**53, expected="a whole number")
_SCORE = Range(-1e300, 1e300)
# How far two planes may lay one position apart and still be called the same [m].
_SAME_PLACE_M = 1.0


def state_names(dim: int) -> tuple[str, ...]:
    """Return the names of a state's components: positions, then velocities.

    Parameters
    ----------
    dim
        Number of spatial dimensions, 2 or 3.

    Returns
    -------
    Such as x, y, vx, vy.
    """
    axes = ("x", "y", "z")[:dim]
    return (*axes, *(f"v{axis}" for axis in axes))


def covariance_names(dim: int) -> tuple[str, ...]:
    """Return the names of the upper triangle of a state's covariance, row by row.

    Parameters
    ----------
    dim
        Number of spatial dimensions, 2 or 3.

    Returns
    -------
    Such as p_x_x, p_x_y, p_x_vx, ….
    """
    pairs = combinations_with_replacement(state_names(dim), 2)
    return tuple(f"p_{first}_{second}" for first, second in pairs)


def read_priors(source: TableSource, frame: LocalFrame | None = None) -> TrackTable:
    """Read the last row of each track that lives at the end of a tracks table.

    A track whose last row is older than the table's newest by its usual time between rows, the
    median over all tracks, or by more has ended and does not come back. Where no track has two
    rows, as in a table made by hand, all are taken. Tentative tracks are left out unless there
    are no others in the table.

    Needed are ``time,track,x,y[,z],vx,vy[,vz]`` and the upper triangle of the covariance,
    ``p_x_x,p_x_y,p_x_vx,…``. Where they are missing, ``status`` is confirmed, ``score`` and
    ``hits`` are 0 and ``last_update`` is the row's time.

    Parameters
    ----------
    source
        A path that ends in .csv, .csv.gz or .parquet, or a pandas, polars or Arrow table; it may
        have no rows.
    frame
        The plane of the reports, None for plane coordinates. Where the table has ``lat,lon`` too,
        they must lie there at ``x,y``: tracks of another plane are refused.

    Returns
    -------
    One row per track that lives, sorted by track.

    Raises
    ------
    DataFormatError
        If the table is not one of tracks with covariances, or has a bad row.
    """
    checks = RowChecks(with_time(load_table(source, may_be_empty=True)))
    dim = 3 if checks.filled("z") else 2
    for name in ("time", "track", *state_names(dim), *covariance_names(dim)):
        checks.require(name, "a tracks table with velocities and covariances")
    time, _ = checks.times("time")
    track = checks.whole_numbers("track", _TRACK)
    within = (TRACK_PLACE,) * dim + (TRACK_SPEED,) * dim
    columns = [
        checks.numbers(name, limits) for name, limits in zip(state_names(dim), within, strict=True)
    ]
    mean = np.stack(columns, axis=-1)
    covariance = read_covariances(checks, dim)
    if frame is not None:
        _require_same_plane(checks, frame, mean)
    status = np.full(len(checks), CONFIRMED)
    if "status" in checks.names:
        status = read_status(checks)
    score = _filled(checks, "score", _SCORE)
    hits = _filled(checks, "hits", _COUNT)
    last_update = time
    if checks.filled("last_update"):
        updates, _ = checks.times("last_update", optional=True)
        last_update = np.where(np.isnan(updates), time, updates)
    checks.finish("fail")

    # A stable sort: of two rows of one track and time the later row is the last.
    order = np.lexsort((time, track))
    last = order[np.flatnonzero(np.diff(track[order], append=np.inf))]
    last = last[_alive(time[order], track[order], time[last])]
    if np.any(status >= CONFIRMED):
        last = last[status[last] >= CONFIRMED]
    return TrackTable(
        time=time[last],
        track=track[last].astype(np.int64),
        status=status[last],
        mean=mean[last],
        covariance=covariance[last],
        score=score[last],
        hits=hits[last].astype(np.int64),
        last_update=last_update[last],
    )


def _alive(time: FloatArray, track: FloatArray, last: FloatArray) -> BoolArray:
    """Return which tracks live at the end; rows come by track, then time."""
    gaps = np.diff(time)[np.diff(track) == 0]
    gaps = gaps[gaps > 0]
    if gaps.size == 0:
        return np.ones(last.size, dtype=np.bool_)
    # Times are sums of periods, so that one period may come a rounding error short.
    return np.asarray(last.max() - last < np.median(gaps) * (1 - 1e-6))


def read_covariances(checks: RowChecks, dim: int) -> FloatArray:
    """Return the covariances of a table of tracks.

    Parameters
    ----------
    checks
        The table; a row whose numbers make no positive definite matrix is complained of there.
    dim
        Number of spatial dimensions, 2 or 3.

    Returns
    -------
    Matrices, shape (rows, 2 dim, 2 dim).
    """
    n = 2 * dim
    matrices = np.empty((len(checks), n, n))
    for (row, column), name in zip(
        combinations_with_replacement(range(n), 2), covariance_names(dim), strict=True
    ):
        matrices[:, row, column] = matrices[:, column, row] = checks.numbers(
            name, TRACK_COVARIANCE
        )
    good = np.flatnonzero(checks.good)
    bad = np.zeros(len(checks), dtype=bool)
    if good.size:
        # Scaled to correlations: metres and metres per second may differ in size by far.
        variances = np.diagonal(matrices[good], axis1=1, axis2=2)
        scale = 1.0 / np.sqrt(np.where(variances > 0, variances, 1.0))
        correlations = matrices[good] * scale[:, :, np.newaxis] * scale[:, np.newaxis, :]
        smallest = np.linalg.eigvalsh(correlations)[:, 0]
        bad[good] = (variances <= 0).any(axis=1) | (smallest <= 0)
    checks.refuse("p_x_x", bad, "the start of a positive definite covariance")
    return matrices


def _filled(checks: RowChecks, name: str, within: Range) -> FloatArray:
    if not checks.filled(name):
        return np.zeros(len(checks))
    return np.nan_to_num(checks.numbers(name, within, optional=True))


def _require_same_plane(checks: RowChecks, frame: LocalFrame, mean: FloatArray) -> None:
    if not (checks.filled("lat") and checks.filled("lon")):
        return
    latitude = checks.numbers("lat", Range(-90.0, 90.0))
    longitude = checks.numbers("lon", Range(-180.0, 360.0))
    good = checks.good
    here = frame.to_plane(latitude[good], longitude[good], np.zeros(int(good.sum())))[:, :2]
    apart = np.abs(here - mean[good, :2]).max(initial=0.0)
    if apart > _SAME_PLACE_M:
        raise DataFormatError(
            f"{checks.name}, columns x and y: on another plane than the reports, {apart:.0f} m "
            f"apart; expected the plane with its origin at latitude {frame.latitude_deg:g}, "
            f"longitude {frame.longitude_deg:g} (or [frame] origin as in that run's run.json)"
        )
