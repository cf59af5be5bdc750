"""How fast a tracker takes its estimates to age, told from the tracks that it wrote."""

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.domain.tracks import TrackTable
from trackweave.filters.kalman import transition

__all__ = ["assumed_process_noise"]

MOST_ROWS = 2_000
HALVINGS = 60


def assumed_process_noise(tracks: TrackTable) -> float | None:
    """Return the process noise [m²/s³] that a tracker must have assumed for such covariances."""
    # A report of position tells nothing of velocity but through the prediction. So the information
    # that a track has gained between two rows, beside its prediction, has nothing in the block of
    # velocities: that is so for one process noise only. The median over rows; None where no track
    # has two.
    before, after, gap = _steps(tracks)
    if not gap.size:
        return None
    dim = tracks.dim
    told = _velocity_trace(np.linalg.inv(after), dim)
    moving, unit = transition(gap, 1.0, dim)
    carried = moving @ before @ moving.swapaxes(1, 2)
    # Between these the answer lies: the noise adds from almost nothing to almost all of the
    # velocity's variance.
    size = np.trace(after[:, dim:, dim:], axis1=1, axis2=2) / dim / gap
    low, high = np.log(1e-9 * size), np.log(1e3 * size)
    for _ in range(HALVINGS):
        middle = (low + high) / 2.0
        ahead = carried + np.exp(middle)[:, None, None] * unit
        too_small = told < _velocity_trace(np.linalg.inv(ahead), dim)
        low, high = np.where(too_small, middle, low), np.where(too_small, high, middle)
    return float(np.exp(np.median(high)))


def _steps(tracks: TrackTable) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return covariances of successive rows of a track, of very many some, and their gaps."""
    order = np.lexsort((tracks.time, tracks.track))
    gap = np.diff(tracks.time[order])
    follows = np.flatnonzero((np.diff(tracks.track[order]) == 0) & (gap > 0.0))
    if follows.size > MOST_ROWS:
        follows = follows[np.linspace(0, follows.size - 1, MOST_ROWS).astype(np.int64)]
    covariance = tracks.covariance[order]
    return covariance[follows], covariance[follows + 1], gap[follows]


def _velocity_trace(information: np.ndarray, dim: int) -> FloatArray:
    return np.asarray(np.trace(information[:, dim:, dim:], axis1=1, axis2=2))
