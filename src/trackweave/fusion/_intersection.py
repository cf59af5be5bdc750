"""Weights of covariance intersection, one object after the other, written as loops.

The weights ω ≥ 0, Σ ω = 1, minimise a convex function of Σ ωₛ Yₛ over the simplex. Two weights at
a time are moved against each other: the two whose derivatives differ most, to the least value on
the line between them. Two sensors have only that line.
"""

from typing import NamedTuple

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.jit import jit

_CLOSE = 1e-7
"""The derivatives' difference at which a weight is left, in parts of the function's own size."""
_MOST_MOVES = 40
"""Moves for each sensor of an object; any weights are consistent, only less good."""
_LINE_STEPS = 30


class Locals(NamedTuple):
    """Information matrices of all objects, those of object i in ``start[i]:start[i + 1]``.

    Each object's matrices are scaled so that their sum has a diagonal of ones; ``unit`` is what
    an axis of the scaled covariance weighs in the trace, shape (objects, n).
    """

    information: FloatArray
    start: IntArray
    unit: FloatArray


@jit
def _invert(matrix: FloatArray, inverse: FloatArray) -> None:
    """Write the inverse of a symmetric positive definite matrix, by Gauss and Jordan."""
    n = matrix.shape[0]
    work = matrix.copy()
    inverse[:] = 0.0
    for i in range(n):
        inverse[i, i] = 1.0
    for pivot in range(n):
        factor = 1.0 / work[pivot, pivot]
        for j in range(n):
            work[pivot, j] *= factor
            inverse[pivot, j] *= factor
        for i in range(n):
            share = work[i, pivot]
            if i != pivot and share != 0.0:
                for j in range(n):
                    work[i, j] -= share * work[pivot, j]
                    inverse[i, j] -= share * inverse[pivot, j]


@jit
def _sensitivity(
    total: FloatArray, unit: FloatArray, by_trace: bool, inverse: FloatArray, out: FloatArray
) -> None:
    """Write M, such that the derivative along a change D of the sum is −tr(M D)."""
    n = total.shape[0]
    _invert(total, inverse)
    for i in range(n):
        for j in range(n):
            if by_trace:
                value = 0.0
                for m in range(n):
                    value += inverse[i, m] * unit[m] * inverse[m, j]
                out[i, j] = value
            else:
                out[i, j] = inverse[i, j]


@jit
def _product_trace(first: FloatArray, second: FloatArray) -> float:
    n = first.shape[0]
    value = 0.0
    for i in range(n):
        for j in range(n):
            value += first[i, j] * second[i, j]
    return value


@jit
def _settle(information: FloatArray, unit: FloatArray, by_trace: bool, weight: FloatArray) -> None:
    """Write the best weights of one object."""
    k = information.shape[0]
    n = information.shape[1]
    total = np.zeros((n, n))
    inverse = np.empty((n, n))
    slope = np.empty((n, n))
    gain = np.empty(k)
    for s in range(k):
        weight[s] = 1.0 / k
        total += information[s] / k
    for _ in range(_MOST_MOVES * k):
        _sensitivity(total, unit, by_trace, inverse, slope)
        up, down = 0, -1
        mean = 0.0
        for s in range(k):
            gain[s] = _product_trace(slope, information[s])
            mean += weight[s] * gain[s]
            if gain[s] > gain[up]:
                up = s
        for s in range(k):
            if weight[s] > 0.0 and (down < 0 or gain[s] < gain[down]):
                down = s
        if up == down or gain[up] - gain[down] <= _CLOSE * mean:
            return
        change = information[up] - information[down]
        low, high = 0.0, weight[down]
        _sensitivity(total + high * change, unit, by_trace, inverse, slope)
        step = high
        rise_low, rise_high = gain[up] - gain[down], _product_trace(slope, change)
        if rise_high < 0.0:
            # The root of the derivative lies between; Illinois' variant of false position.
            side = 0
            for _step in range(_LINE_STEPS):
                step = (low * rise_high - high * rise_low) / (rise_high - rise_low)
                _sensitivity(total + step * change, unit, by_trace, inverse, slope)
                rise = _product_trace(slope, change)
                if abs(rise) <= 0.1 * _CLOSE * mean:
                    break
                if rise > 0.0:
                    low, rise_low = step, rise
                    if side == 1:
                        rise_high *= 0.5
                    side = 1
                else:
                    high, rise_high = step, rise
                    if side == -1:
                        rise_low *= 0.5
                    side = -1
            weight[down] -= step
        else:
            weight[down] = 0.0
        weight[up] += step
        total += step * change


@jit
def intersection_weights(given: Locals, by_trace: bool, weight: FloatArray) -> None:
    """Write the weights of every object's matrices, shape (rows,)."""
    for place in range(given.start.shape[0] - 1):
        first, last = given.start[place], given.start[place + 1]
        _settle(given.information[first:last], given.unit[place], by_trace, weight[first:last])
