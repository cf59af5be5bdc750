"""Which reports a state may reach at all. Nothing here checks or raises.

Functions take arrays one by one: handing over whole scans costs more than what they do.
"""

import math

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.association._nodes import ScanInput
from trackweave.jit import jit


@jit
def widest(scan: ScanInput, dim: int) -> FloatArray:
    """Return the largest variance of a report's place along each axis, tails and all [m²]."""
    widest = np.zeros(dim)
    for index in range(scan.position_covariance.shape[0]):
        for axis in range(dim):
            widest[axis] = max(widest[axis], scan.position_covariance[index, axis, axis])
    return widest * (scan.tail_scale * scan.tail_scale)


@jit
def most_moved(scan: ScanInput, max_speed: float) -> float:
    """Return how far an object moves at most between a scan's own time and its reports' [m]."""
    slack = 0.0
    for index in range(scan.moment.shape[0]):
        slack = max(slack, max_speed * abs(scan.moment[index] - scan.reference))
    return slack


@jit
def _count_before(position: FloatArray, first: int, value: float, and_equal: bool) -> int:
    """Return how many reports, in order, lie below a value; at least the first ones do."""
    last = position.shape[0]
    while first < last:
        middle = (first + last) // 2
        place = position[middle, 0]
        if place < value or (and_equal and place == value):
            first = middle + 1
        else:
            last = middle
    return first


@jit
def within_reach(
    position: FloatArray, gate: float, mean: FloatArray, covariance: FloatArray,
    widest: float, slack: float,
) -> tuple[int, int]:  # fmt: skip
    """Return the span of reports that any mode may reach along the first axis."""
    low, high = math.inf, -math.inf
    for mode in range(mean.shape[0]):
        reach = math.sqrt(gate * (covariance[mode, 0, 0] + widest)) + slack
        low = min(low, mean[mode, 0] - reach)
        high = max(high, mean[mode, 0] + reach)
    first = _count_before(position, 0, low, False)
    return first, _count_before(position, first, high, True)


@jit
def is_beside(
    place: float, gate: float, mean: FloatArray, covariance: FloatArray, widest: float,
    slack: float,
) -> bool:  # fmt: skip
    """Tell whether any mode may reach a report along the second axis."""
    for mode in range(mean.shape[0]):
        side = abs(place - mean[mode, 1]) - slack
        if side <= 0.0 or side * side <= gate * (covariance[mode, 1, 1] + widest):
            return True
    return False


@jit
def is_reachable(
    mean: FloatArray, covariance: FloatArray, weight: FloatArray, node: int,
    position: FloatArray, position_covariance: FloatArray, index: int, reach: float, scale: float,
) -> bool:  # fmt: skip
    """Tell whether an object no faster than allowed can have come from its last place.

    The report's noise may be ``scale`` times as wide as told.
    """
    distance, variance = 0.0, 0.0
    for axis in range(position.shape[1]):
        place, spread = 0.0, 0.0
        for mode in range(weight.shape[1]):
            place += weight[node, mode] * mean[node, mode, axis]
            spread += weight[node, mode] * covariance[node, mode, axis, axis]
        distance += (position[index, axis] - place) ** 2
        variance += spread + scale * scale * position_covariance[index, axis, axis]
    return bool(math.sqrt(distance) <= reach + 3.0 * math.sqrt(variance))


@jit
def is_any_reachable(
    mean: FloatArray, covariance: FloatArray, weight: FloatArray, node: int,
    position: FloatArray, position_covariance: FloatArray, broad: FloatArray, reach: float,
    scale: float,
) -> bool:  # fmt: skip
    """Tell whether `is_reachable` holds for any report."""
    place, variance = 0.0, 0.0
    for mode in range(weight.shape[1]):
        place += weight[node, mode] * mean[node, mode, 0]
    for axis in range(position.shape[1]):
        variance += broad[axis]
        for mode in range(weight.shape[1]):
            variance += weight[node, mode] * covariance[node, mode, axis, axis]
    # A little more than that: roundings must not leave out what the exact test lets through.
    far = (1.0 + 1e-9) * (reach + 3.0 * math.sqrt(variance)) + 1e-9
    first = _count_before(position, 0, place - far, False)
    for index in range(first, position.shape[0]):
        if position[index, 0] > place + far:
            return False
        if is_reachable(
            mean, covariance, weight, node, position, position_covariance, index, reach, scale
        ):
            return True
    return False
