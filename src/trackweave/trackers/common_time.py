"""Plots of moments that differ, brought to one time."""

import math
from dataclasses import replace

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.association.sensor_plots import SensorPlots
from trackweave.domain.tracks import TrackTable

__all__ = ["carried_along"]


def carried_along(
    plots: SensorPlots, lag: FloatArray, time: float, tracks: TrackTable, gate: float
) -> SensorPlots:
    """Return plots in which those near a track have moved with it to the common time."""
    # A plot is near the track whose predicted place is nearest to it at the plot's own time, if
    # that lies in the gate. A position moves by the track's velocity v times the lag Δt, and is
    # less sure by P_v Δt²; a bearing turns by as much as the track's own bearing does, and is less
    # sure by the same seen from its sensor. Of other plots nothing is known but their ``drift``. A
    # ``lag`` is how long before the common time a plot was made [s]; plots of none stay as they
    # are, bit by bit. The gate is the greatest squared distance of a plot from a track.
    late = np.flatnonzero(lag != 0.0)
    if late.size == 0 or len(tracks) == 0 or tracks.dim != _dim(plots):
        return plots
    place, spread = _foretold(tracks, time - lag[late])
    if plots.is_bearing:
        return _bearings_along(plots, (late, lag[late]), tracks, (place, spread), gate)
    dim = tracks.dim
    value, covariance = plots.value.copy(), _covariances(plots)
    aside = value[late, None, :] - place
    nearest, is_near = _nearest(aside, spread + covariance[late, None], gate)
    rows, own, ahead = late[is_near], nearest[is_near], lag[late][is_near, None]
    value[rows] += tracks.mean[own, dim:] * ahead
    covariance[rows] += tracks.covariance[own, dim:, dim:] * ahead[:, :, None] ** 2
    return replace(
        plots, value=value, sigma=None, covariance=covariance, drift=_without(plots, rows)
    )


def _dim(plots: SensorPlots) -> int:
    return 2 if plots.is_bearing else int(plots.value.shape[1])


def _foretold(tracks: TrackTable, moments: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return where each track is at each moment, and how uncertain that is."""
    dim = tracks.dim
    ahead = moments[:, None] - tracks.time
    p = tracks.covariance
    cross = p[:, :dim, dim:] + p[:, dim:, :dim]
    place = tracks.mean[:, :dim] + tracks.mean[:, dim:] * ahead[:, :, None]
    step = ahead[:, :, None, None]
    return place, p[:, :dim, :dim] + cross * step + p[:, dim:, dim:] * step**2


def _covariances(plots: SensorPlots) -> FloatArray:
    """Return the covariance of each position [m²]."""
    if plots.covariance is not None:
        return np.array(plots.covariance)
    sigma = np.broadcast_to(np.asarray(plots.sigma, dtype=np.float64), plots.value.shape)
    return np.asarray(sigma[:, :, None] ** 2 * np.eye(plots.value.shape[1]))


def _nearest(aside: FloatArray, spread: FloatArray, gate: float) -> tuple[IntArray, FloatArray]:
    """Return each plot's nearest track, and whether it lies in the gate."""
    pull = np.linalg.solve(spread, aside[..., None])[..., 0]
    square = np.einsum("ptk,ptk->pt", aside, pull)
    nearest = np.argmin(square, axis=1)
    return nearest, square[np.arange(nearest.shape[0]), nearest] <= gate


def _bearings_along(
    plots: SensorPlots,
    late: tuple[IntArray, FloatArray],
    tracks: TrackTable,
    foretold: tuple[FloatArray, FloatArray],
    gate: float,
) -> SensorPlots:
    """Return bearings in which those near a track have turned with it."""
    row, lag = late
    (place, spread), stand = foretold, np.asarray(plots.place)
    stand = stand if stand.ndim == 1 else stand[row][:, None, :]
    sigma = np.array(np.broadcast_to(np.asarray(plots.sigma), plots.value.shape))
    away = place - stand
    square = np.maximum(np.sum(away**2, axis=-1), 1e-60)
    across = np.stack([away[..., 1], -away[..., 0]], axis=-1) / square[..., None]
    variance = np.einsum("pti,ptij,ptj->pt", across, spread, across)
    bearing = np.arctan2(away[..., 0], away[..., 1])
    aside = _wrapped(plots.value[row, None] - bearing)
    total = (variance + sigma[row, None] ** 2)[..., None, None]
    nearest, is_near = _nearest(aside[..., None], total, gate)
    each = np.arange(row.shape[0])
    then = away[each, nearest] + tracks.mean[nearest, 2:] * lag[:, None]
    turn = _wrapped(np.arctan2(then[:, 0], then[:, 1]) - bearing[each, nearest])
    seen = across[each, nearest]
    slow = np.einsum("pi,pij,pj->p", seen, tracks.covariance[nearest, 2:, 2:], seen)
    rows = row[is_near]
    value = plots.value.copy()
    value[rows] += turn[is_near]
    sigma[rows] = np.sqrt(sigma[rows] ** 2 + (slow * lag**2)[is_near])
    return replace(plots, value=value, sigma=sigma, drift=_without(plots, rows))


def _without(plots: SensorPlots, rows: IntArray) -> FloatArray:
    """Return the drift of the plots, none for those that moved with a track."""
    drift = np.array(
        np.broadcast_to(np.asarray(plots.drift, dtype=np.float64), plots.value.shape[:1])
    )
    drift[rows] = 0.0
    return drift


def _wrapped(angle: FloatArray) -> FloatArray:
    return np.asarray((angle + math.pi) % (2.0 * math.pi) - math.pi)
