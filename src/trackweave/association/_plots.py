"""Growing the sets of plots that one object may have made. Nothing here checks or raises.

A set takes at most one plot of each sensor, in the sensors' order. It is grown depth first, so
that only the sets on the way to the present one are held; the tuples that may be chosen are
written to a table.
"""

import math
from typing import NamedTuple

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.association._plot_sets import (
    Path,
    PlotLimits,
    PlotTable,
    azimuth_variance,
    bearing_distance,
    cross,
    drift_price,
    locate,
    updated,
)
from trackweave.association._plot_thinning import Choice, choose_nearest
from trackweave.association._plot_views import Views, unseen_price
from trackweave.jit import jit

GROWING, FULL, DONE = 0, 1, 2
DEPTH, ROOT, N_ROWS = 0, 1, 2

LAPLACE_SLACK = 1.0
"""How far Laplace's approximation may be from falling when a bearing joins [nats]; ample."""


class TupleRows(NamedTuple):
    """Tuples as they are written: 1-based numbers of plots, cost, position and covariance."""

    plot: IntArray
    cost: FloatArray
    mean: FloatArray
    covariance: FloatArray


@jit
def grow_sets(
    table: PlotTable,
    views: Views,
    limits: PlotLimits,
    path: Path,
    choice: Choice,
    rows: TupleRows,
    n_steps: int,
) -> int:
    """Grow sets from where ``path`` stands, for at most so many steps; write tuples to ``rows``.

    Returns GROWING, FULL when there is no more room in ``rows``, or DONE.
    """
    n_sensors = table.miss.shape[0]
    n_plots = table.value.shape[0]
    depth = path.counter[DEPTH]
    for _ in range(n_steps):
        if path.counter[N_ROWS] == rows.cost.shape[0]:
            path.counter[DEPTH] = depth
            return FULL
        has_grown = False
        if depth < 0:
            if path.counter[ROOT] >= n_plots:
                path.counter[DEPTH] = depth
                return DONE
            _begin(table, limits, path)
            depth = 0
            choice.has_grown[depth] = False
            has_grown = limits.with_lone
        elif path.cursor[depth] == path.stop[depth]:
            path.next_sensor[depth] += 1
            is_done = limits.is_chain and choice.has_grown[depth]
            if is_done or path.next_sensor[depth] >= n_sensors:
                depth -= 1
            else:
                _open_gate(table, limits, path, depth)
                if limits.most > 0:
                    choose_nearest(table, limits, path, choice, depth)
        else:
            # Calls for each candidate take the arrays that they need, here and below: numba
            # copies and counts references to each array of a tuple, which took twice as long.
            sensor = path.next_sensor[depth]
            first, last = table.first[sensor], table.first[sensor + 1]
            if limits.most == 0 and path.is_located[depth] and not table.is_bearing[sensor]:
                near = _first_near(
                    table.value,
                    table.covariance,
                    first + path.cursor[depth],
                    first + path.stop[depth],
                    path.mean[depth],
                    path.covariance[depth],
                    limits.gate,
                )
                path.cursor[depth] = near - first
            if path.cursor[depth] < path.stop[depth]:
                cursor = path.cursor[depth]
                plot = first + cursor % (last - first)
                if limits.most > 0:
                    plot = choice.near[depth, cursor]
                path.cursor[depth] += 1
                has_grown = _join(table, limits, path, depth, plot)
            if has_grown:
                choice.has_grown[depth] = True
                depth += 1
                choice.has_grown[depth] = False
        if has_grown and path.is_located[depth]:
            _write(table, views, limits, path, depth, rows)
    path.counter[DEPTH] = depth
    return GROWING


@jit
def _begin(table: PlotTable, limits: PlotLimits, path: Path) -> None:
    """Begin a set with the next plot."""
    plot = path.counter[ROOT]
    path.counter[ROOT] += limits.stride
    sensor = 0
    while table.first[sensor + 1] <= plot:
        sensor += 1
    dim = table.value.shape[1]
    path.plot[0] = plot
    path.sensor[0] = sensor
    path.is_located[0] = not table.is_bearing[sensor]
    path.n_bearings[0] = 1 if table.is_bearing[sensor] else 0
    path.cost[0] = table.hit[plot] - table.miss[sensor]
    for other in range(table.miss.shape[0]):
        path.cost[0] += table.miss[other]
    path.distance[0] = 0.0
    path.log_information[0] = 0.0
    if not table.is_bearing[sensor]:
        for axis in range(dim):
            path.mean[0, axis] = table.value[plot, axis]
            for other in range(dim):
                path.covariance[0, axis, other] = table.covariance[plot, axis, other]
        path.log_information[0] = -table.log_spread[plot]
    path.total[0] = path.cost[0] + limits.base_cost
    if limits.with_evidence:
        path.total[0] += 0.5 * path.log_information[0]
    _start_children(path, 0)


@jit
def _start_children(path: Path, depth: int) -> None:
    """Let the set grow by the sensors after its last."""
    path.next_sensor[depth] = path.sensor[depth]
    path.cursor[depth] = 0
    path.stop[depth] = 0


@jit
def _open_gate(table: PlotTable, limits: PlotLimits, path: Path, depth: int) -> None:
    """Set which plots of the next sensor, in its sorted order, may lie in the gate."""
    sensor = path.next_sensor[depth]
    first, last = table.first[sensor], table.first[sensor + 1]
    path.cursor[depth] = 0
    path.stop[depth] = last - first
    if not path.is_located[depth] or first == last or table.moves[sensor]:
        return
    key = table.value[first:last, 0]
    if not table.is_bearing[sensor]:
        variance = path.covariance[depth, 0, 0] + table.widest[sensor] ** 2
        reach = math.sqrt(limits.gate * variance) * (1.0 + 1e-9)
        path.cursor[depth] = np.searchsorted(key, path.mean[depth, 0] - reach)
        path.stop[depth] = np.searchsorted(key, path.mean[depth, 0] + reach, side="right")
        return
    east = path.mean[depth, 0] - table.place[first, 0]
    north = path.mean[depth, 1] - table.place[first, 1]
    variance = azimuth_variance(east, north, path.covariance[depth], 0.0)
    if limits.gate * variance >= 1.0:
        # As close to the sensor as this, the object may be on any side of it.
        path.stop[depth] = 0
        return
    variance += table.farthest[sensor] ** 2 / (east * east + north * north)
    reach = math.sqrt(limits.gate * (variance + table.widest[sensor] ** 2)) * (1.0 + 1e-9)
    if not reach < 3.0:
        return
    low = (math.atan2(east, north) - reach) % (2.0 * math.pi)
    high = low + 2.0 * reach
    path.cursor[depth] = np.searchsorted(key, low)
    if high < 2.0 * math.pi:
        path.stop[depth] = np.searchsorted(key, high, side="right")
    else:
        # Once around: the cursor goes on at the beginning.
        turned = np.searchsorted(key, high - 2.0 * math.pi, side="right")
        path.stop[depth] = last - first + turned


@jit
def _first_near(
    value: FloatArray,
    noise: FloatArray,
    cursor: int,
    stop: int,
    mean: FloatArray,
    covariance: FloatArray,
    gate: float,
) -> int:
    """Return the next position that is in the gate along each axis but the first."""
    limit = gate * (1.0 + 1e-9)
    while cursor < stop:
        is_near = True
        for axis in range(1, value.shape[1]):
            side = value[cursor, axis] - mean[axis]
            variance = covariance[axis, axis] + noise[cursor, axis, axis]
            is_near = is_near and side * side <= limit * variance
        if is_near:
            break
        cursor += 1
    return cursor


@jit
def _join(table: PlotTable, limits: PlotLimits, path: Path, depth: int, plot: int) -> bool:
    """Write the set with a plot to the entry after ``depth``; tell whether it may grow."""
    sensor = path.next_sensor[depth]
    child = depth + 1
    is_bearing = table.is_bearing[sensor]
    path.plot[child] = plot
    path.sensor[child] = sensor
    path.n_bearings[child] = path.n_bearings[depth] + (1 if is_bearing else 0)
    path.is_located[child] = True
    if path.is_located[depth]:
        if is_bearing:
            distance = bearing_distance(
                path.mean[depth],
                path.covariance[depth],
                table.place[plot],
                table.value[plot, 0],
                table.covariance[plot, 0, 0],
                table.drift_squared[plot],
                limits.gate,
            )
            if not distance <= limits.gate:
                return False
        else:
            distance, log_spread = updated(
                path.mean[depth],
                path.covariance[depth],
                table.value[plot],
                table.covariance,
                plot,
                limits.gate,
                path.scratch,
                path.mean[child],
                path.covariance[child],
            )
            if not distance < math.inf:
                return False
            path.distance[child] = path.distance[depth] + distance
            # |P⁺| = |P| |R| / |S|
            path.log_information[child] = path.log_information[depth]
            path.log_information[child] += log_spread - table.log_spread[plot]
        if path.n_bearings[child] > 0:
            path.mean[child, :] = path.mean[depth, :]
            if not locate(table, limits, path, child):
                return False
    else:
        if not is_bearing:
            path.mean[child, :] = table.value[plot, :]
        else:
            found, _ = cross(table, limits, path, child)
            if found < 0:
                return False
            path.is_located[child] = found > 0
        if path.is_located[child] and not (
            locate(table, limits, path, child) and path.distance[child] <= limits.gate
        ):
            return False
    path.cost[child] = path.cost[depth] + table.hit[plot] - table.miss[sensor]
    path.total[child] = path.cost[child] + 0.5 * path.distance[child] + limits.base_cost
    if limits.with_evidence:
        path.total[child] += 0.5 * path.log_information[child]
    _start_children(path, child)
    if not path.is_located[child]:
        return True
    # A plot adds at least its hit: neither squared distance nor information ever falls.
    slack = LAPLACE_SLACK if limits.with_evidence and path.n_bearings[child] > 0 else 0.0
    if table.drifts and path.n_bearings[child] > 0:
        # But for drifting bearings, which are less off from closer by: only information counts.
        slack += 0.5 * path.distance[child]
    reached: float = path.total[child] + table.promise[sensor + 1] - slack
    return reached < limits.max_cost


@jit
def _write(
    table: PlotTable, views: Views, limits: PlotLimits, path: Path, depth: int, rows: TupleRows
) -> None:
    """Write the set as a tuple, if it may be chosen."""
    cost = path.total[depth]
    if not cost < limits.max_cost:
        return
    for axis in range(table.value.shape[1]):
        place = path.mean[depth, axis]
        outside = max(limits.low[axis] - place, place - limits.high[axis], 0.0)
        if outside * outside > limits.gate * path.covariance[depth, axis, axis]:
            return
    if views.any_bounded:
        cost += unseen_price(
            views, path.sensor[: depth + 1], path.mean[depth], path.covariance[depth]
        )
    if table.drifts and path.n_bearings[depth] > 0:
        cost += drift_price(table, path, depth)
    if not cost < limits.max_cost:
        return
    row = path.counter[N_ROWS]
    path.counter[N_ROWS] += 1
    rows.plot[row, :] = 0
    for entry in range(depth + 1):
        rows.plot[row, path.sensor[entry]] = table.number[path.plot[entry]]
    rows.cost[row] = cost
    rows.mean[row, :] = path.mean[depth]
    rows.covariance[row, :, :] = path.covariance[depth]
