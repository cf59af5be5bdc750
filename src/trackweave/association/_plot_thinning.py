"""The few plots that a set may grow by where there are too many. Nothing here checks or raises."""

import math
from typing import NamedTuple

import numpy as np

from trackweave._loops import kth_least
from trackweave.arrays import FloatArray, IntArray
from trackweave.association._plot_sets import (
    Path,
    PlotLimits,
    PlotTable,
    bearing_distance,
    cross,
)
from trackweave.filters._kernels import invert_sum, squared_distance
from trackweave.jit import jit


class Choice(NamedTuple):
    """The plots of the next sensor that each set on the path may grow by.

    ``near`` are these, and ``has_grown`` tells whether the set has by any; ``plot`` and
    ``distance`` are all those among which a choice is made.
    """

    near: IntArray
    has_grown: np.ndarray
    plot: IntArray
    distance: FloatArray


@jit
def choose_nearest(
    table: PlotTable, limits: PlotLimits, path: Path, choice: Choice, depth: int
) -> None:
    """Write which plots of the next sensor the set may grow by: the nearest, in sorted order.

    They are chosen from those from ``cursor`` to ``stop``, which then count the chosen. A set
    without a position is nearest to the bearings that, crossed with its own, give the surest one.
    """
    count = _measure(table, limits, path, choice, depth)
    most = limits.most
    path.cursor[depth] = 0
    path.stop[depth] = min(count, most)
    if count <= most:
        for index in range(count):
            choice.near[depth, index] = choice.plot[index]
        return
    bound = kth_least(choice.distance[:count].copy(), most - 1)
    n_at_bound = most
    for index in range(count):
        n_at_bound -= 1 if choice.distance[index] < bound else 0
    kept = 0
    for index in range(count):
        # Of equally near ones the first, so that it is always the same.
        if choice.distance[index] == bound:
            n_at_bound -= 1
        if choice.distance[index] < bound or (choice.distance[index] == bound and n_at_bound >= 0):
            choice.near[depth, kept] = choice.plot[index]
            kept += 1


@jit
def _measure(table: PlotTable, limits: PlotLimits, path: Path, choice: Choice, depth: int) -> int:
    """Write the plots in the gate and how near each is to the set; return their number."""
    sensor = path.next_sensor[depth]
    first, last = table.first[sensor], table.first[sensor + 1]
    count = 0
    for cursor in range(path.cursor[depth], path.stop[depth]):
        choice.plot[count] = first + cursor % (last - first)
        count += 1
    plots = choice.plot[:count]
    # All at once, with the arrays that it takes: see the growth of sets.
    if path.is_located[depth]:
        if table.is_bearing[sensor]:
            return _near_bearings(
                path.mean[depth], path.covariance[depth], limits.gate, plots, choice.distance,
                table.place, table.value, table.covariance, table.drift_squared,
            )  # fmt: skip
        return _near_positions(
            path.mean[depth], path.covariance[depth], limits.gate, plots, choice.distance,
            table.value, table.covariance, path.scratch,
        )  # fmt: skip
    own, child = path.plot[depth], depth + 1
    count = 0
    for plot in plots:
        if table.is_bearing[sensor]:
            path.plot[child], path.sensor[child] = plot, sensor
            found, certainty = cross(table, limits, path, child)
            distance = -certainty if found >= 0 else math.inf
        else:
            distance = bearing_distance(
                table.value[plot], table.covariance[plot], table.place[own],
                table.value[own, 0], table.covariance[own, 0, 0], table.drift_squared[own], 0.0,
            )  # fmt: skip
        if distance < math.inf:
            choice.plot[count] = plot
            choice.distance[count] = distance
            count += 1
    return count


@jit
def _near_bearings(
    mean: FloatArray,
    covariance: FloatArray,
    gate: float,
    plots: IntArray,
    distance_out: FloatArray,
    place: FloatArray,
    value: FloatArray,
    noise: FloatArray,
    drift_squared: FloatArray,
) -> int:
    """Keep of the plots, in place, those in the gate, and write their squared distances."""
    count = 0
    for plot in plots:
        distance = bearing_distance(
            mean, covariance, place[plot], value[plot, 0], noise[plot, 0, 0],
            drift_squared[plot], gate,
        )  # fmt: skip
        if distance <= gate:
            plots[count] = plot
            distance_out[count] = distance
            count += 1
    return count


@jit
def _near_positions(
    mean: FloatArray,
    covariance: FloatArray,
    gate: float,
    plots: IntArray,
    distance_out: FloatArray,
    value: FloatArray,
    noise: FloatArray,
    scratch: FloatArray,
) -> int:
    """Keep of the plots, in place, those in the gate, and write their squared distances."""
    count = 0
    for plot in plots:
        distance = math.inf
        if value.shape[1] == 3:
            if invert_sum(covariance, noise, plot, scratch) < math.inf:
                distance = squared_distance(value[plot], mean, scratch)
        else:
            # By hand, which takes no logarithm.
            s00 = covariance[0, 0] + noise[plot, 0, 0]
            s01 = covariance[0, 1] + noise[plot, 0, 1]
            s11 = covariance[1, 1] + noise[plot, 1, 1]
            determinant = s00 * s11 - s01 * s01
            if determinant > 0.0:
                east, north = value[plot, 0] - mean[0], value[plot, 1] - mean[1]
                distance = s11 * east * east - 2.0 * s01 * east * north + s00 * north * north
                distance /= determinant
        if distance <= gate:
            plots[count] = plot
            distance_out[count] = distance
            count += 1
    return count
