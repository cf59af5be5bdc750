"""The Kalman filter on arrays of states."""

import numpy as np

from trackweave.arrays import ROUNDING, FloatArray

__all__ = ["predicted", "transition"]


def transition(
    interval: FloatArray, process_noise: float, dim: int
) -> tuple[FloatArray, FloatArray]:
    """Return the transition matrix and process noise covariance of each interval [s]."""
    # Both have the shape (rows, 2 dim, 2 dim). The model is of constant velocity; the process
    # noise is the power spectral density of the acceleration along each axis [m²/s³].
    interval = np.asarray(interval, dtype=np.float64)
    eye = np.eye(dim)
    rows = interval.shape[0]
    moving, noise = np.zeros((2, rows, 2 * dim, 2 * dim))
    step = interval[:, None, None]
    moving[:, :dim, :dim] = moving[:, dim:, dim:] = eye
    moving[:, :dim, dim:] = step * eye
    noise[:, :dim, :dim] = step**3 / 3.0 * eye
    noise[:, :dim, dim:] = noise[:, dim:, :dim] = step**2 / 2.0 * eye
    noise[:, dim:, dim:] = step * eye
    return moving, process_noise * noise


def predicted(
    mean: FloatArray, covariance: FloatArray, interval: FloatArray, process_noise: float
) -> tuple[FloatArray, FloatArray]:
    """Return mean (rows, 2 dim) and covariance of states after an interval [s] each."""
    # States are positions, then velocities; the process noise is as for ``transition``.
    moving, noise = transition(interval, process_noise, mean.shape[1] // 2)
    ahead = np.einsum("kij,kj->ki", moving, mean)
    spread = moving @ covariance @ moving.transpose(0, 2, 1) + noise
    lost = np.where(np.asarray(interval) == 0.0, 0.0, ROUNDING)
    spread *= 1.0 + lost[:, None, None] * np.eye(spread.shape[1])
    return ahead, spread
