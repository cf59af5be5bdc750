"""States conditioned on all reports, later ones included."""

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.filters.kalman import predicted, transition, updated

__all__ = ["smooth"]


def smooth(
    time: FloatArray,
    position: FloatArray,
    sigma: FloatArray,
    start: tuple[FloatArray, FloatArray],
    process_noise: float,
) -> tuple[FloatArray, FloatArray]:
    """Return the states of tracks at given moments, each conditioned on all of its reports.

    Rauch, Tung and Striebel's smoother [1]_, all tracks at once.

    Parameters
    ----------
    time
        Moments of each track [s], ascending, shape (tracks, moments).
    position
        Reports [m], shape (tracks, moments, dim); NaN where a moment has none.
    sigma
        Their standard deviation along each axis [m], of the same shape.
    start
        Mean and covariance at the first moment, before its report, shapes (tracks, 2 dim) and
        (tracks, 2 dim, 2 dim): positions, then velocities.
    process_noise
        Power spectral density of the acceleration along each axis [m²/s³].

    Returns
    -------
    Means and covariances, shapes (tracks, moments, 2 dim) and (tracks, moments, 2 dim, 2 dim).

    References
    ----------
    .. [1] H. E. Rauch, F. Tung, C. T. Striebel, *Maximum likelihood estimates of linear dynamic
       systems*, 1965, eqs. 3.28 and 3.30. doi:10.2514/3.3166
    """
    n_tracks, length, dim = position.shape
    size = 2 * dim
    ahead_mean = np.empty((n_tracks, length, size))
    ahead_covariance = np.empty((n_tracks, length, size, size))
    mean, covariance = np.empty_like(ahead_mean), np.empty_like(ahead_covariance)
    x, p = start[0].copy(), start[1].copy()
    for k in range(length):
        if k > 0:
            x, p = predicted(x, p, time[:, k] - time[:, k - 1], process_noise)
        ahead_mean[:, k], ahead_covariance[:, k] = x, p
        seen = np.flatnonzero(np.isfinite(position[:, k, 0]))
        if seen.size:
            x, p = x.copy(), p.copy()
            x[seen], p[seen] = updated(x[seen], p[seen], position[seen, k], sigma[seen, k])
        mean[:, k], covariance[:, k] = x, p
    for k in range(length - 2, -1, -1):
        moving, _ = transition(time[:, k + 1] - time[:, k], process_noise, dim)
        later = ahead_covariance[:, k + 1]
        gain = np.linalg.solve(later, moving @ covariance[:, k]).swapaxes(1, 2)
        mean[:, k] += np.einsum("tij,tj->ti", gain, mean[:, k + 1] - ahead_mean[:, k + 1])
        covariance[:, k] += gain @ (covariance[:, k + 1] - later) @ gain.swapaxes(1, 2)
    return mean, covariance
