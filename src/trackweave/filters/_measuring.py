"""What a sensor will measure of a state, and what its report makes of the state.

States are positions, velocities, then whatever else; see ``domain.measurements`` for the kinds.
Nothing here checks or raises.
"""

import math

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.domain.measurements import MeasurementKind
from trackweave.filters._kernels import invert_three, invert_two
from trackweave.jit import jit

_POSITION = int(MeasurementKind.POSITION)
_AZIMUTH_RATE = int(MeasurementKind.RANGE_AZIMUTH_RATE)
_ELEVATION = int(MeasurementKind.RANGE_AZIMUTH_ELEVATION)
_ELEVATION_RATE = int(MeasurementKind.RANGE_AZIMUTH_ELEVATION_RATE)
_BEARING = int(MeasurementKind.BEARING)
_RANGE_RATE = int(MeasurementKind.RANGE_RATE)

# Nearer on the plane than this share of the position's standard deviation, or than this many
# metres, derivatives are taken from that far: they grow no further, yet an angle tells nothing.
_NEAR_SHARE = 0.1
_NEAR = 1e-6


@jit
def measure(
    kind: int,
    mean: FloatArray,
    covariance: FloatArray,
    platform: FloatArray,
    dim: int,
    unscented: bool,
    predicted_out: FloatArray,
    spread_out: FloatArray,
    cross_out: FloatArray,
) -> None:
    """Write the expected measurement, its covariance and its covariance with the state.

    The covariance is the state's alone, without the report's own noise. ``platform`` holds the
    sensor's x, y, z and their rates. Positions take the first coordinates, as many as asked for.
    """
    size, width = cross_out.shape
    if kind == _POSITION:
        for axis in range(width):
            predicted_out[axis] = mean[axis]
            for other in range(width):
                spread_out[axis, other] = covariance[axis, other]
            for row in range(size):
                cross_out[row, axis] = covariance[row, axis]
        return
    if unscented:
        _measure_by_points(
            kind, mean, covariance, platform, dim, predicted_out, spread_out, cross_out
        )
    else:
        _measure_by_slopes(
            kind, mean, covariance, platform, dim, predicted_out, spread_out, cross_out
        )


@jit
def width_of_influence(kind: int, dim: int) -> int:
    """Return how many of a state's first components a measurement depends on."""
    if kind == _BEARING:
        return 2
    if kind in (_AZIMUTH_RATE, _ELEVATION_RATE, _RANGE_RATE):
        return 2 * dim
    return dim


@jit
def _expected(
    kind: int, state: FloatArray, platform: FloatArray, dim: int, out: FloatArray
) -> None:
    """Write what a sensor without noise measures."""
    east, north = state[0] - platform[0], state[1] - platform[1]
    up = state[2] - platform[2] if dim == 3 else 0.0
    distance = math.sqrt(east * east + north * north + up * up)
    column = 0
    if kind not in (_BEARING, _RANGE_RATE):
        out[column] = distance
        column += 1
    if kind != _RANGE_RATE:
        azimuth = math.atan2(east, north)
        out[column] = azimuth if azimuth >= 0.0 else azimuth + 2.0 * math.pi
        column += 1
    if kind in (_ELEVATION, _ELEVATION_RATE):
        out[column] = math.atan2(up, math.sqrt(east * east + north * north))
        column += 1
    if kind in (_AZIMUTH_RATE, _ELEVATION_RATE, _RANGE_RATE):
        rate = east * (state[dim] - platform[3]) + north * (state[dim + 1] - platform[4])
        if dim == 3:
            rate += up * (state[dim + 2] - platform[5])
        out[column] = rate / max(distance, _NEAR)


@jit
def _slopes(
    kind: int,
    state: FloatArray,
    platform: FloatArray,
    dim: int,
    near: float,
    out: FloatArray,
) -> None:
    """Write the derivatives of a measurement by what it depends on, from no nearer than near."""
    out[:, :] = 0.0
    toward = np.zeros(3)
    speed = np.zeros(3)
    for axis in range(dim):
        toward[axis] = state[axis] - platform[axis]
    level = math.sqrt(toward[0] * toward[0] + toward[1] * toward[1])
    if level < near:
        # As from the nearest place in the same direction, from straight above as to the north.
        toward[0] = toward[0] / level * near if level > 0.0 else 0.0
        toward[1] = toward[1] / level * near if level > 0.0 else near
        level = near
    east, north, up = toward
    distance = math.sqrt(level * level + up * up)
    row = 0
    if kind not in (_BEARING, _RANGE_RATE):
        for axis in range(dim):
            out[row, axis] = toward[axis] / distance
        row += 1
    if kind != _RANGE_RATE:
        out[row, 0] = north / (level * level)
        out[row, 1] = -east / (level * level)
        row += 1
    if kind in (_ELEVATION, _ELEVATION_RATE):
        out[row, 0] = -up * east / (level * distance * distance)
        out[row, 1] = -up * north / (level * distance * distance)
        out[row, 2] = level / (distance * distance)
        row += 1
    if kind in (_AZIMUTH_RATE, _ELEVATION_RATE, _RANGE_RATE):
        closing = 0.0
        for axis in range(dim):
            speed[axis] = state[dim + axis] - platform[3 + axis]
            closing += speed[axis] * toward[axis] / distance
        for axis in range(dim):
            out[row, axis] = (speed[axis] - closing * toward[axis] / distance) / distance
            out[row, dim + axis] = toward[axis] / distance


@jit
def slopes_at(
    kind: int,
    mean: FloatArray,
    covariance: FloatArray,
    platform: FloatArray,
    dim: int,
    out: FloatArray,
) -> None:
    """Write the derivatives of a measurement where a state is, from no nearer than it is exact."""
    variance = max(covariance[0, 0] + covariance[1, 1], 0.0)
    _slopes(kind, mean, platform, dim, max(_NEAR, _NEAR_SHARE * math.sqrt(variance)), out)


@jit
def _measure_by_slopes(
    kind: int,
    mean: FloatArray,
    covariance: FloatArray,
    platform: FloatArray,
    dim: int,
    predicted_out: FloatArray,
    spread_out: FloatArray,
    cross_out: FloatArray,
) -> None:
    """Write the moments of a measurement of the extended Kalman filter."""
    size, width = cross_out.shape
    reach = width_of_influence(kind, dim)
    _expected(kind, mean, platform, dim, predicted_out)
    slope = np.empty((width, reach))
    slopes_at(kind, mean, covariance, platform, dim, slope)
    for row in range(size):
        for column in range(width):
            total = 0.0
            for inner in range(reach):
                total += covariance[row, inner] * slope[column, inner]
            cross_out[row, column] = total
    for row in range(width):
        for column in range(row, width):
            total = 0.0
            for inner in range(reach):
                total += slope[row, inner] * cross_out[inner, column]
            spread_out[row, column] = total
            spread_out[column, row] = total


@jit
def _measure_by_points(
    kind: int,
    mean: FloatArray,
    covariance: FloatArray,
    platform: FloatArray,
    dim: int,
    predicted_out: FloatArray,
    spread_out: FloatArray,
    cross_out: FloatArray,
) -> None:
    """Write the moments of a measurement of the unscented Kalman filter.

    Sigma points spread over the components that the measurement depends on, d of them: the mean
    with weight κ/(d + κ) and 2d points √(d + κ) standard deviations from it with the rest, where
    κ = max(3 − d, 0), so that no weight is negative.
    """
    size, width = cross_out.shape
    reach = width_of_influence(kind, dim)
    kappa = max(3.0 - reach, 0.0)
    step, share = math.sqrt(reach + kappa), 0.5 / (reach + kappa)
    root = np.zeros((size, reach))
    factorise(covariance, root)
    point = mean.copy()
    value, centre = np.empty(width), np.empty(width)
    _expected(kind, mean, platform, dim, centre)
    # Differences from the measurement of the mean, angles the short way round.
    apart = np.empty((2 * reach, width))
    for column in range(reach):
        for side in range(2):
            sign = step if side == 0 else -step
            for row in range(reach):
                point[row] = mean[row] + sign * root[row, column]
            _expected(kind, point, platform, dim, value)
            innovation(kind, value, centre, apart[2 * column + side])
    for row in range(width):
        total = 0.0
        for index in range(2 * reach):
            total += apart[index, row]
        # From here on value is by how much the mean of all points differs from the centre.
        value[row] = share * total
        predicted_out[row] = centre[row] + value[row]
    for row in range(width):
        for column in range(row, width):
            total = 2.0 * kappa * share * value[row] * value[column]
            for index in range(2 * reach):
                total += (
                    share
                    * (apart[index, row] - value[row])
                    * (apart[index, column] - value[column])
                )
            spread_out[row, column] = total
            spread_out[column, row] = total
    for row in range(size):
        for column in range(width):
            total = 0.0
            for inner in range(reach):
                total += root[row, inner] * (
                    apart[2 * inner, column] - apart[2 * inner + 1, column]
                )
            cross_out[row, column] = share * step * total


@jit
def factorise(covariance: FloatArray, root_out: FloatArray) -> None:
    """Write the first columns of a covariance's Cholesky factor, as many as there is room for.

    A component without a variance of its own gets a column of zeros.
    """
    size, reach = root_out.shape
    for column in range(reach):
        pivot = covariance[column, column]
        for inner in range(column):
            pivot -= root_out[column, inner] * root_out[column, inner]
        proper = pivot > 1e-14 * covariance[column, column]
        length = math.sqrt(pivot) if proper else 1.0
        for row in range(column, size):
            value = covariance[row, column]
            for inner in range(column):
                value -= root_out[row, inner] * root_out[column, inner]
            root_out[row, column] = value / length if proper else 0.0


@jit
def innovation(kind: int, measurement: FloatArray, predicted: FloatArray, out: FloatArray) -> None:
    """Write measurement minus prediction, azimuth and bearing wrapped to (−π, π]."""
    for column in range(out.shape[0]):
        out[column] = measurement[column] - predicted[column]
    if kind in (_POSITION, _RANGE_RATE):
        return
    column = 0 if kind == _BEARING else 1
    angle = out[column] % (2.0 * math.pi)
    out[column] = angle if angle <= math.pi else angle - 2.0 * math.pi


@jit
def invert(matrix: FloatArray, inverse_out: FloatArray) -> float:
    """Write the inverse of a symmetric matrix of up to four rows; return ln det.

    Returns infinity where the matrix is not positive definite.
    """
    width = matrix.shape[0]
    if width == 1:
        if not matrix[0, 0] > 0.0:
            return math.inf
        inverse_out[0, 0] = 1.0 / matrix[0, 0]
        return math.log(matrix[0, 0])
    if width == 2:
        return invert_two(matrix[0, 0], matrix[0, 1], matrix[1, 1], inverse_out)
    if width == 3:
        return invert_three(
            matrix[0, 0], matrix[0, 1], matrix[0, 2], matrix[1, 1], matrix[1, 2], matrix[2, 2],
            inverse_out,
        )  # fmt: skip
    return invert_many(matrix, inverse_out)


@jit
def invert_many(matrix: FloatArray, inverse_out: FloatArray) -> float:
    """Write the inverse of a symmetric matrix by its Cholesky factor; return ln det."""
    width = matrix.shape[0]
    root = np.zeros((width, width))
    total = 0.0
    for column in range(width):
        for row in range(column, width):
            value = matrix[row, column]
            for inner in range(column):
                value -= root[row, inner] * root[column, inner]
            if row > column:
                root[row, column] = value / root[column, column]
            elif value > 0.0:
                root[row, row] = math.sqrt(value)
                total += math.log(value)
            else:
                return math.inf
    # The factor's own inverse, column by column in place of the factor.
    for column in range(width):
        root[column, column] = 1.0 / root[column, column]
        for row in range(column + 1, width):
            value = 0.0
            for inner in range(column, row):
                value -= root[row, inner] * root[inner, column]
            root[row, column] = value / root[row, row]
    for row in range(width):
        for column in range(row, width):
            value = 0.0
            for inner in range(column, width):
                value += root[inner, row] * root[inner, column]
            inverse_out[row, column] = value
            inverse_out[column, row] = value
    return total
