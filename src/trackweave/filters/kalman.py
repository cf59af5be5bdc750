"""The Kalman filter on arrays of states."""

import numpy as np

from trackweave.arrays import ROUNDING, FloatArray

__all__ = ["predicted", "transition", "updated"]


def transition(
    interval: FloatArray, process_noise: float, dim: int
) -> tuple[FloatArray, FloatArray]:
    """Return transition matrix and process noise covariance of the constant-velocity model."""
    # By intervals [s], shape (rows,), and the power spectral density of the acceleration along
    # each axis [m²/s³]; each of shape (rows, 2 dim, 2 dim).
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
    """Return states, positions then velocities, after an interval [s] each."""
    # Process noise is the power spectral density of the acceleration along each axis [m²/s³].
    moving, noise = transition(interval, process_noise, mean.shape[1] // 2)
    ahead = np.einsum("kij,kj->ki", moving, mean)
    spread = moving @ covariance @ moving.transpose(0, 2, 1) + noise
    lost = np.where(np.asarray(interval) == 0.0, 0.0, ROUNDING)
    spread *= 1.0 + lost[:, None, None] * np.eye(spread.shape[1])
    return ahead, spread


def updated(
    mean: FloatArray, covariance: FloatArray, position: FloatArray, sigma: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return states after a position report each, with its noise along each axis [m]."""
    dim, size = position.shape[1], mean.shape[1]
    noise = sigma[:, :, None] ** 2 * np.eye(dim)
    gain = np.linalg.solve(covariance[:, :dim, :dim] + noise, covariance[:, :dim, :])
    gain = gain.swapaxes(1, 2)
    # Joseph's form, as in the kernels.
    left = np.eye(size) - gain @ np.eye(dim, size)
    after = left @ covariance @ left.swapaxes(1, 2) + gain @ noise @ gain.swapaxes(1, 2)
    shift = np.einsum("kij,kj->ki", gain, position - mean[:, :dim])
    return mean + shift, (after + after.swapaxes(1, 2)) / 2
