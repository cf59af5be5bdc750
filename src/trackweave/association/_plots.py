"""Growing the sets of plots that one object may have made. Nothing here checks or raises.

A set takes at most one plot of each sensor, in the sensors' order. It is grown depth first, so
that only the sets on the way to the present one are held; the tuples that may be chosen are
written to a table.
"""

import math
from typing import NamedTuple

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.filters._kernels import invert_innovation, squared_distance, update
from trackweave.jit import jit

GROWING, FULL, DONE = 0, 1, 2
DEPTH, ROOT, N_ROWS, N_SETS = 0, 1, 2, 3
MAX_STEPS = 30


class PlotTable(NamedTuple):
    """The plots of all sensors, each sensor's sorted by its first column.

    ``first`` says where each sensor's plots begin. A bearing stands in the first column of
    ``value`` and ``sigma``, from 0 to 2π. ``number`` is a plot's number in its sensor's own order,
    from 1. ``hit`` is what each plot adds to the cost, but for how well it fits, and ``miss`` what
    each sensor adds that has no plot in the set [nats]. ``widest`` is each sensor's largest sigma.
    """

    first: IntArray
    value: FloatArray
    sigma: FloatArray
    number: IntArray
    hit: FloatArray
    miss: FloatArray
    is_bearing: np.ndarray
    place: FloatArray
    widest: FloatArray


class PlotLimits(NamedTuple):
    """Which sets are grown and written, and how they are priced.

    ``with_evidence`` adds the position's uncertainty and ``base_cost`` to the cost.
    Only tuples that cost less than ``max_cost`` are written, and only with a position between
    ``low`` and ``high``, or beyond by no more than the gate.
    """

    gate: float
    with_evidence: bool
    base_cost: float
    max_cost: float
    low: FloatArray
    high: FloatArray


class Path(NamedTuple):
    """The set being grown, plot by plot: entry n describes its first n + 1 plots.

    ``counter`` holds how many plots the set has less one, the next plot to begin with, and how
    many rows are written and sets grown. ``cost`` is the sum of hits and misses, ``distance`` the
    squared distance of all plots from the set's position.
    """

    counter: IntArray
    plot: IntArray
    sensor: IntArray
    is_located: np.ndarray
    n_bearings: IntArray
    cost: FloatArray
    distance: FloatArray
    log_information: FloatArray
    mean: FloatArray
    covariance: FloatArray
    next_sensor: IntArray
    cursor: IntArray
    stop: IntArray
    scratch: FloatArray


class TupleRows(NamedTuple):
    """Tuples as they are written: 1-based numbers of plots, cost, position and covariance."""

    plot: IntArray
    cost: FloatArray
    mean: FloatArray
    covariance: FloatArray


@jit
def grow_sets(
    table: PlotTable, limits: PlotLimits, path: Path, rows: TupleRows, n_steps: int
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
        if depth < 0:
            if path.counter[ROOT] == n_plots:
                path.counter[DEPTH] = depth
                return DONE
            _begin(table, path)
            depth = 0
            continue
        if path.cursor[depth] == path.stop[depth]:
            path.next_sensor[depth] += 1
            if path.next_sensor[depth] >= n_sensors:
                depth -= 1
            else:
                _open_gate(table, limits, path, depth)
            continue
        if _join(table, limits, path, depth):
            depth += 1
            path.counter[N_SETS] += 1
            if path.is_located[depth]:
                _write(table, limits, path, depth, rows)
    path.counter[DEPTH] = depth
    return GROWING


@jit
def _begin(table: PlotTable, path: Path) -> None:
    """Begin a set with the next plot."""
    plot = path.counter[ROOT]
    path.counter[ROOT] += 1
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
                path.covariance[0, axis, other] = 0.0
            path.covariance[0, axis, axis] = table.sigma[plot, axis] ** 2
            path.log_information[0] -= 2.0 * math.log(table.sigma[plot, axis])
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
    if not path.is_located[depth] or first == last:
        return
    key = table.value[first:last, 0]
    if not table.is_bearing[sensor]:
        variance = path.covariance[depth, 0, 0] + table.widest[sensor] ** 2
        reach = math.sqrt(limits.gate * variance) * (1.0 + 1e-9)
        path.cursor[depth] = np.searchsorted(key, path.mean[depth, 0] - reach)
        path.stop[depth] = np.searchsorted(key, path.mean[depth, 0] + reach, side="right")
        return
    east = path.mean[depth, 0] - table.place[sensor, 0]
    north = path.mean[depth, 1] - table.place[sensor, 1]
    variance = _azimuth_variance(east, north, path.covariance[depth]) + table.widest[sensor] ** 2
    reach = math.sqrt(limits.gate * variance) * (1.0 + 1e-9)
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
def _join(table: PlotTable, limits: PlotLimits, path: Path, depth: int) -> bool:
    """Write the set with the next plot to the entry after ``depth``; tell whether it may grow."""
    sensor = path.next_sensor[depth]
    first = table.first[sensor]
    n_plots = table.first[sensor + 1] - first
    plot = first + path.cursor[depth] % n_plots
    path.cursor[depth] += 1
    child = depth + 1
    is_bearing = table.is_bearing[sensor]
    path.plot[child] = plot
    path.sensor[child] = sensor
    path.n_bearings[child] = path.n_bearings[depth] + (1 if is_bearing else 0)
    path.is_located[child] = True
    if path.is_located[depth]:
        if is_bearing:
            if not _sees(table, limits, path, depth, sensor, plot):
                return False
        elif not _is_near(table, limits, path, depth, plot):
            return False
        if path.n_bearings[child] > 0:
            path.mean[child, :] = path.mean[depth, :]
            if not _locate(table, path, child):
                return False
    else:
        if not is_bearing:
            path.mean[child, :] = table.value[plot, :]
        else:
            found = _cross(table, limits, path, child)
            if found < 0:
                return False
            path.is_located[child] = found > 0
        if path.is_located[child]:
            if not _locate(table, path, child) or path.distance[child] > limits.gate:
                return False
    path.cost[child] = path.cost[depth] + table.hit[plot] - table.miss[sensor]
    _start_children(path, child)
    return True


@jit
def _is_near(table: PlotTable, limits: PlotLimits, path: Path, depth: int, plot: int) -> bool:
    """Tell whether a position lies in the gate; write the updated set if no bearing is in it."""
    dim = table.value.shape[1]
    child = depth + 1
    mean, covariance = path.mean[depth], path.covariance[depth]
    for axis in range(1, dim):
        side = table.value[plot, axis] - mean[axis]
        reach = covariance[axis, axis] + table.sigma[plot, axis] ** 2
        if side * side > limits.gate * reach * (1.0 + 1e-9):
            return False
    inverse = path.scratch
    log_determinant = invert_innovation(covariance, table.sigma[plot], inverse)
    distance = squared_distance(table.value[plot], mean, inverse)
    if not distance <= limits.gate:
        return False
    if path.n_bearings[depth] == 0:
        update(
            mean, covariance, table.value[plot], inverse, path.mean[child], path.covariance[child]
        )
        path.distance[child] = path.distance[depth] + distance
        # |P⁺| = |P| |R| / |S|
        path.log_information[child] = path.log_information[depth] + log_determinant
        for axis in range(dim):
            path.log_information[child] -= 2.0 * math.log(table.sigma[plot, axis])
    return True


@jit
def _sees(
    table: PlotTable, limits: PlotLimits, path: Path, depth: int, sensor: int, plot: int
) -> bool:
    """Tell whether the set's position lies in the gate about a bearing."""
    east = path.mean[depth, 0] - table.place[sensor, 0]
    north = path.mean[depth, 1] - table.place[sensor, 1]
    aside = _wrap(table.value[plot, 0] - math.atan2(east, north))
    variance = _azimuth_variance(east, north, path.covariance[depth])
    return aside * aside <= limits.gate * (variance + table.sigma[plot, 0] ** 2)


@jit
def _cross(table: PlotTable, limits: PlotLimits, path: Path, child: int) -> int:
    """Write where the last bearing crosses an earlier one, the one most square to it.

    Returns 1; 0 if it is parallel to them all, as far as their noise and the gate can tell; -1
    if they cross behind a sensor.
    """
    plot, place = path.plot[child], table.place[path.sensor[child]]
    best, widest = -1, 0.0
    for entry in range(child):
        sine = abs(math.sin(table.value[plot, 0] - table.value[path.plot[entry], 0]))
        variance = table.sigma[plot, 0] ** 2 + table.sigma[path.plot[entry], 0] ** 2
        if sine > max(widest, math.sqrt(limits.gate * variance)):
            best, widest = entry, sine
    if best < 0:
        return 0
    other = table.place[path.sensor[best]]
    sine, cosine = math.sin(table.value[plot, 0]), math.cos(table.value[plot, 0])
    angle = table.value[path.plot[best], 0]
    other_sine, other_cosine = math.sin(angle), math.cos(angle)
    east, north = other[0] - place[0], other[1] - place[1]
    turn = sine * other_cosine - cosine * other_sine
    away = (east * other_cosine - north * other_sine) / turn
    other_away = (east * cosine - north * sine) / turn
    if not (away > 0.0 and other_away > 0.0):
        return -1
    path.mean[child, 0] = place[0] + away * sine
    path.mean[child, 1] = place[1] + away * cosine
    return 1


@jit
def _locate(table: PlotTable, path: Path, child: int) -> bool:
    """Write the most likely position by Gauss-Newton steps from where the mean stands.

    Two dimensions. Returns False where no position explains the plots.
    """
    mean, covariance = path.mean[child], path.covariance[child]
    information, gradient, trial = path.scratch, np.empty(2), np.empty(2)
    distance = _linearise(table, path, child, mean, information, gradient)
    for _ in range(MAX_STEPS):
        determinant = information[0, 0] * information[1, 1] - information[0, 1] ** 2
        if not (determinant > 0.0 and distance < math.inf):
            return False
        covariance[0, 0] = information[1, 1] / determinant
        covariance[1, 1] = information[0, 0] / determinant
        covariance[0, 1] = covariance[1, 0] = -information[0, 1] / determinant
        path.log_information[child] = math.log(determinant)
        path.distance[child] = distance
        east = covariance[0, 0] * gradient[0] + covariance[0, 1] * gradient[1]
        north = covariance[1, 0] * gradient[0] + covariance[1, 1] * gradient[1]
        # How much the squared distance would fall, if it were quadratic.
        if gradient[0] * east + gradient[1] * north < 1e-12:
            return True
        share = 1.0
        while True:
            trial[0], trial[1] = mean[0] + share * east, mean[1] + share * north
            reached = _linearise(table, path, child, trial, information, gradient)
            if reached <= distance:
                break
            share /= 2.0
            if share < 1e-3:
                return True
        mean[:] = trial
        distance = reached
    return False


@jit
def _linearise(
    table: PlotTable,
    path: Path,
    child: int,
    point: FloatArray,
    information: FloatArray,
    gradient: FloatArray,
) -> float:
    """Write the information about the position and its pull there; return the squared distance."""
    distance = 0.0
    information[:, :] = 0.0
    gradient[:] = 0.0
    for entry in range(child + 1):
        plot, sensor = path.plot[entry], path.sensor[entry]
        if not table.is_bearing[sensor]:
            for axis in range(2):
                weight = 1.0 / table.sigma[plot, axis] ** 2
                aside = table.value[plot, axis] - point[axis]
                information[axis, axis] += weight
                gradient[axis] += weight * aside
                distance += weight * aside * aside
            continue
        weight = 1.0 / table.sigma[plot, 0] ** 2
        east, north = point[0] - table.place[sensor, 0], point[1] - table.place[sensor, 1]
        squared_range = east * east + north * north
        if not squared_range > 0.0:
            return math.inf
        aside = _wrap(table.value[plot, 0] - math.atan2(east, north))
        by_east, by_north = north / squared_range, -east / squared_range
        information[0, 0] += weight * by_east * by_east
        information[0, 1] += weight * by_east * by_north
        information[1, 1] += weight * by_north * by_north
        gradient[0] += weight * by_east * aside
        gradient[1] += weight * by_north * aside
        distance += weight * aside * aside
    information[1, 0] = information[0, 1]
    return distance


@jit
def _write(table: PlotTable, limits: PlotLimits, path: Path, depth: int, rows: TupleRows) -> None:
    """Write the set as a tuple, if it may be chosen."""
    dim = table.value.shape[1]
    cost = path.cost[depth] + 0.5 * path.distance[depth] + limits.base_cost
    if limits.with_evidence:
        cost += 0.5 * (path.log_information[depth] - dim * math.log(2.0 * math.pi))
    if not cost < limits.max_cost:
        return
    for axis in range(dim):
        place = path.mean[depth, axis]
        outside = max(limits.low[axis] - place, place - limits.high[axis], 0.0)
        if outside * outside > limits.gate * path.covariance[depth, axis, axis]:
            return
    row = path.counter[N_ROWS]
    path.counter[N_ROWS] += 1
    rows.plot[row, :] = 0
    for entry in range(depth + 1):
        rows.plot[row, path.sensor[entry]] = table.number[path.plot[entry]]
    rows.cost[row] = cost
    rows.mean[row, :] = path.mean[depth]
    rows.covariance[row, :, :] = path.covariance[depth]


@jit
def _azimuth_variance(east: float, north: float, covariance: FloatArray) -> float:
    """Return how uncertain the azimuth of an uncertain position is; infinite without a range."""
    squared_range = east * east + north * north
    if not squared_range > 0.0:
        return math.inf
    return (
        north * north * covariance[0, 0]
        - 2.0 * north * east * covariance[0, 1]
        + east * east * covariance[1, 1]
    ) / (squared_range * squared_range)


@jit
def _wrap(angle: float) -> float:
    """Return the angle between −π and π."""
    return angle - 2.0 * math.pi * math.floor((angle + math.pi) / (2.0 * math.pi))
