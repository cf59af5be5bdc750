"""Kalman filter of the constant-velocity model on small matrices, written as loops.

States are positions, then velocities: x, y[, z], vx, vy[, vz]. Nothing here checks or raises.
Loops are 4 to 7 times faster than ``@`` on matrices of this size.
"""

import math

import numpy as np

from trackweave._loops import overwrite, overwrite_rows
from trackweave.arrays import ROUNDING, FloatArray
from trackweave.jit import jit

LOST = 1e-14
"""What a report leaves of a variance is no less than this share of it: its last digits."""


@jit
def predict(
    mean: FloatArray,
    covariance: FloatArray,
    interval: float,
    process_noise: float,
    mean_out: FloatArray,
    covariance_out: FloatArray,
) -> None:
    """Write the state after an interval [s] to ``mean_out``, ``covariance_out``.

    Each axis is driven by white acceleration of the given power spectral density [m²/s³]. Each
    variance is wider by ``ROUNDING``: where an interval makes position and velocity as good as
    one thing, a covariance of 16 digits would be singular or worse.
    """
    predict_first(
        mean.shape[0] // 2, mean, covariance, interval, process_noise, mean_out, covariance_out
    )


@jit
def predict_first(
    dim: int,
    mean: FloatArray,
    covariance: FloatArray,
    interval: float,
    process_noise: float,
    mean_out: FloatArray,
    covariance_out: FloatArray,
) -> None:
    """Do the same for the positions and velocities of states that hold more than these."""
    for axis in range(dim):
        mean_out[axis] = mean[axis] + interval * mean[dim + axis]
        mean_out[dim + axis] = mean[dim + axis]
    for row in range(dim):
        for column in range(dim):
            position = covariance[row, column]
            cross = covariance[row, dim + column]
            cross_t = covariance[dim + row, column]
            velocity = covariance[dim + row, dim + column]
            moved_cross = cross + interval * velocity
            covariance_out[row, column] = (
                position + interval * (cross + cross_t) + interval * interval * velocity
            )
            covariance_out[row, dim + column] = moved_cross
            covariance_out[dim + row, column] = cross_t + interval * velocity
            covariance_out[dim + row, dim + column] = velocity
    for axis in range(dim):
        covariance_out[axis, axis] += process_noise * interval**3 / 3.0
        covariance_out[axis, dim + axis] += process_noise * interval**2 / 2.0
        covariance_out[dim + axis, axis] += process_noise * interval**2 / 2.0
        covariance_out[dim + axis, dim + axis] += process_noise * interval
    if interval != 0.0:
        for row in range(2 * dim):
            covariance_out[row, row] *= 1.0 + ROUNDING


@jit
def invert_two(s00: float, s01: float, s11: float, inverse_out: FloatArray) -> float:
    """Write the inverse of a symmetric matrix of two rows; return ln det.

    Returns infinity where the matrix is not positive definite.
    """
    determinant = s00 * s11 - s01 * s01
    if not (s00 > 0.0 and determinant > 0.0):
        return math.inf
    inverse_out[0, 0] = s11 / determinant
    inverse_out[1, 1] = s00 / determinant
    inverse_out[0, 1] = -s01 / determinant
    inverse_out[1, 0] = -s01 / determinant
    return math.log(determinant)


@jit
def invert_three(
    s00: float, s01: float, s02: float, s11: float, s12: float, s22: float,
    inverse_out: FloatArray,
) -> float:  # fmt: skip
    """Do the same for three rows, by cofactors."""
    c00 = s11 * s22 - s12 * s12
    c01 = s02 * s12 - s01 * s22
    c02 = s01 * s12 - s02 * s11
    determinant = s00 * c00 + s01 * c01 + s02 * c02
    if not (s00 > 0.0 and s00 * s11 - s01 * s01 > 0.0 and determinant > 0.0):
        return math.inf
    inverse_out[0, 0] = c00 / determinant
    inverse_out[0, 1] = inverse_out[1, 0] = c01 / determinant
    inverse_out[0, 2] = inverse_out[2, 0] = c02 / determinant
    inverse_out[1, 1] = (s00 * s22 - s02 * s02) / determinant
    inverse_out[1, 2] = inverse_out[2, 1] = (s01 * s02 - s00 * s12) / determinant
    inverse_out[2, 2] = (s00 * s11 - s01 * s01) / determinant
    return math.log(determinant)


@jit
def invert_innovation(covariance: FloatArray, sigma: FloatArray, inverse_out: FloatArray) -> float:
    """Write the inverse of S = P_position + diag(sigma²); return ln det S, as `invert_two`."""
    s00 = covariance[0, 0] + sigma[0] * sigma[0]
    s11 = covariance[1, 1] + sigma[1] * sigma[1]
    if sigma.shape[0] == 2:
        return invert_two(s00, covariance[0, 1], s11, inverse_out)
    s22 = covariance[2, 2] + sigma[2] * sigma[2]
    s01, s02, s12 = covariance[0, 1], covariance[0, 2], covariance[1, 2]
    return invert_three(s00, s01, s02, s11, s12, s22, inverse_out)


@jit
def invert_sum(
    covariance: FloatArray, noise: FloatArray, setting: int, inverse_out: FloatArray
) -> float:
    """Write the inverse of S = P_position + noise[setting]; return ln det S, as `invert_two`."""
    s00 = covariance[0, 0] + noise[setting, 0, 0]
    s11 = covariance[1, 1] + noise[setting, 1, 1]
    s01 = covariance[0, 1] + noise[setting, 0, 1]
    if noise.shape[1] == 2:
        return invert_two(s00, s01, s11, inverse_out)
    s22 = covariance[2, 2] + noise[setting, 2, 2]
    s02 = covariance[0, 2] + noise[setting, 0, 2]
    s12 = covariance[1, 2] + noise[setting, 1, 2]
    return invert_three(s00, s01, s02, s11, s12, s22, inverse_out)


@jit
def squared_distance(measurement: FloatArray, mean: FloatArray, inverse: FloatArray) -> float:
    """Return the squared Mahalanobis distance νᵀS⁻¹ν of a position from a predicted state."""
    dim = measurement.shape[0]
    total = 0.0
    for row in range(dim):
        partial = 0.0
        for column in range(dim):
            partial += inverse[row, column] * (measurement[column] - mean[column])
        total += partial * (measurement[row] - mean[row])
    return total


@jit
def update(
    mean: FloatArray,
    covariance: FloatArray,
    measurement: FloatArray,
    noise: FloatArray,
    mean_out: FloatArray,
    covariance_out: FloatArray,
) -> None:
    """Write the state after a position report of covariance R, ``noise``.

    Number by number where their errors are independent, as each then leaves exactly r/s of its
    own variance, s = p + r; P − P Hᵀ S⁻¹ H P would lose r behind the last digit of p. Positions
    come first in a state. The outputs must not be the inputs.
    """
    size, dim = mean.shape[0], measurement.shape[0]
    for axis in range(dim):
        for other in range(axis):
            if noise[axis, other] != 0.0:
                _update_at_once(mean, covariance, measurement, noise, mean_out, covariance_out)
                return
    overwrite(mean_out, mean)
    overwrite_rows(covariance_out, covariance)
    for axis in range(dim):
        whole = covariance_out[axis, axis] + noise[axis, axis]
        share = noise[axis, axis] / whole
        off = measurement[axis] - mean_out[axis]
        for row in range(size):
            known = covariance_out[row, axis] / whole
            mean_out[row] += known * off
            for column in range(row, size):
                if row != axis and column != axis:
                    value = covariance_out[row, column] - known * covariance_out[column, axis]
                    if row == column:
                        value += LOST * covariance_out[row, row]
                    covariance_out[row, column] = value
                    covariance_out[column, row] = value
        for row in range(size):
            value = covariance_out[min(row, axis), max(row, axis)] * share
            covariance_out[row, axis] = covariance_out[axis, row] = value


@jit
def _update_at_once(
    mean: FloatArray,
    covariance: FloatArray,
    measurement: FloatArray,
    noise: FloatArray,
    mean_out: FloatArray,
    covariance_out: FloatArray,
) -> None:
    """Do the same where the errors of a position's numbers depend on one another."""
    size, dim = mean.shape[0], measurement.shape[0]
    cross, spread, off = np.empty((size, dim)), np.empty((dim, dim)), np.empty(dim)
    for axis in range(dim):
        off[axis] = measurement[axis] - mean[axis]
        for row in range(size):
            cross[row, axis] = covariance[row, axis]
        for other in range(dim):
            spread[axis, other] = covariance[axis, other] + noise[axis, other]
    correct(mean, covariance, off, spread, cross, mean_out, covariance_out)


@jit
def correct(
    mean: FloatArray,
    covariance: FloatArray,
    innovation: FloatArray,
    spread: FloatArray,
    cross: FloatArray,
    mean_out: FloatArray,
    covariance_out: FloatArray,
) -> None:
    """Write the state after a report: x + C S⁻¹ ν and P − C S⁻¹ Cᵀ, symmetric to the last bit.

    ``spread`` is S, with the report's noise. The outputs may be the inputs.
    """
    size, width = cross.shape
    root, part = np.empty((width, width)), np.empty((size, width))
    whiten(spread, cross, root, part)
    overwrite(mean_out, mean)
    add_shift(root, part, innovation, mean_out)
    narrow(covariance, part, covariance_out)


@jit
def whiten(
    spread: FloatArray, cross: FloatArray, root_out: FloatArray, part_out: FloatArray
) -> None:
    """Write the Cholesky factor L of S and W = C L⁻ᵀ, so that C S⁻¹ Cᵀ = W Wᵀ.

    W is never larger than the state's own standard deviations, whatever S. Variances in S are
    wider by what rounding may have lost of them; what has none tells nothing.
    """
    size, width = cross.shape
    for column in range(width):
        pivot = spread[column, column] * (1.0 + ROUNDING)
        for inner in range(column):
            pivot -= root_out[column, inner] * root_out[column, inner]
        length = math.sqrt(pivot) if pivot > 0.0 else math.inf
        root_out[column, column] = length
        for row in range(column + 1, width):
            value = spread[row, column]
            for inner in range(column):
                value -= root_out[row, inner] * root_out[column, inner]
            root_out[row, column] = value / length
        for row in range(size):
            value = cross[row, column]
            for inner in range(column):
                value -= part_out[row, inner] * root_out[column, inner]
            part_out[row, column] = value / length


@jit
def add_shift(root: FloatArray, part: FloatArray, off: FloatArray, out: FloatArray) -> None:
    """Add C S⁻¹ times a vector, ``off``, by the factors that ``whiten`` wrote."""
    width = root.shape[0]
    white = np.empty(width)
    for column in range(width):
        value = off[column]
        for inner in range(column):
            value -= root[column, inner] * white[inner]
        white[column] = value / root[column, column]
    for row in range(part.shape[0]):
        value = 0.0
        for inner in range(width):
            value += part[row, inner] * white[inner]
        out[row] += value


@jit
def narrow(covariance: FloatArray, part: FloatArray, covariance_out: FloatArray) -> None:
    """Write P − W Wᵀ, wider by the last digits of P, so that it is positive definite."""
    size, width = part.shape
    for row in range(size):
        for column in range(row, size):
            value = covariance[row, column]
            if row == column:
                value *= 1.0 + LOST
            for inner in range(width):
                value -= part[row, inner] * part[column, inner]
            covariance_out[row, column] = value
            covariance_out[column, row] = value


@jit
def distance_of(
    measurement: FloatArray, index: int, mean: FloatArray, inverse: FloatArray
) -> float:
    """Return the squared Mahalanobis distance of one of many positions from a predicted state."""
    dim = measurement.shape[1]
    total = 0.0
    for row in range(dim):
        partial = 0.0
        for column in range(dim):
            partial += inverse[row, column] * (measurement[index, column] - mean[column])
        total += partial * (measurement[index, row] - mean[row])
    return total
