"""Sets of plots that one object may have made, and where it then is.

The position is the most likely one given all plots of the set: a Kalman filter without motion as
long as no bearing is among them, Gauss-Newton steps otherwise. Nothing here checks or raises.
"""

import math
from typing import NamedTuple

import numpy as np

from trackweave._loops import overwrite
from trackweave.arrays import FloatArray, IntArray
from trackweave.filters._kernels import invert_sum, squared_distance, update
from trackweave.jit import jit

MAX_STEPS = 30

FIXED_AFTER = 20
"""Steps after which drifting bearings keep their weights, so that the steps come to rest."""

LEAST_SQUARED_RANGE = 1e-60
"""Nearer to a sensor than this there is no azimuth [m²]; the square of this is still no zero."""


class PlotTable(NamedTuple):
    """The plots of all sensors, each sensor's sorted by its first column.

    ``first`` says where each sensor's plots begin. A bearing stands in the first column of
    ``value``, from 0 to 2π, its variance in the first of ``covariance``, without what
    ``drift_squared`` adds by its distance; of positions, ``covariance`` holds that too, and
    ``information`` and ``log_spread`` are its inverse and ln det. ``place`` is where a bearing's
    sensor stood. ``number`` is a plot's number in its sensor's own order, from 1. ``hit`` is what
    each plot adds to the cost, but for how well it fits, and ``miss`` what each sensor adds that
    has no plot in the set [nats]; 0 where that depends on the place. ``promise`` is the most that
    each sensor and those after it can take off a set's cost. ``widest`` is each sensor's largest
    sigma, and ``farthest`` its largest drift; a sensor ``moves`` whose plots are not all from one
    place. ``drifts`` tells whether any bearing does.
    """

    first: IntArray
    value: FloatArray
    covariance: FloatArray
    information: FloatArray
    log_spread: FloatArray
    drift_squared: FloatArray
    place: FloatArray
    number: IntArray
    hit: FloatArray
    miss: FloatArray
    promise: FloatArray
    is_bearing: np.ndarray
    moves: np.ndarray
    widest: FloatArray
    farthest: FloatArray
    drifts: bool


class PlotLimits(NamedTuple):
    """Which sets are grown and written, and how they are priced.

    ``with_evidence`` adds half the logarithm of the information about the position to the cost,
    which begins at ``base_cost``.
    Only tuples that cost less than ``max_cost`` are written, and only with a position between
    ``low`` and ``high``, or beyond by no more than the gate. ``with_lone`` writes positions that
    stand alone, too. A set is grown by the nearest plots of a sensor only, by ``most``, if that
    is not 0; it is not also grown without them if ``is_chain``. Sets begin with every plot, or
    every so many by ``stride``.
    """

    gate: float
    with_evidence: bool
    base_cost: float
    max_cost: float
    with_lone: bool
    low: FloatArray
    high: FloatArray
    most: int
    is_chain: bool
    stride: int


class Path(NamedTuple):
    """The set being grown, plot by plot: entry n describes its first n + 1 plots.

    ``counter`` holds how many plots the set has less one, the next plot to begin with, and how
    many rows are written. ``cost`` is the sum of hits and misses, ``total`` what the set costs as
    a tuple, but for what its place adds by drift and coverage, ``distance`` the squared
    distance of all plots from the set's position, and ``weight`` what each bearing's squared
    error counts for.
    """

    counter: IntArray
    plot: IntArray
    sensor: IntArray
    is_located: np.ndarray
    n_bearings: IntArray
    cost: FloatArray
    total: FloatArray
    distance: FloatArray
    log_information: FloatArray
    mean: FloatArray
    covariance: FloatArray
    next_sensor: IntArray
    cursor: IntArray
    stop: IntArray
    weight: FloatArray
    scratch: FloatArray


@jit
def updated(
    mean: FloatArray,
    covariance: FloatArray,
    value: FloatArray,
    noise: FloatArray,
    plot: int,
    gate: float,
    scratch: FloatArray,
    mean_out: FloatArray,
    covariance_out: FloatArray,
) -> tuple[float, float]:
    """Write the position updated by another, if that lies in the gate.

    Returns the squared distance, infinite if it does not, and ln det of its covariance.
    """
    log_spread = invert_sum(covariance, noise, plot, scratch)
    distance = squared_distance(value, mean, scratch)
    if not (distance <= gate and log_spread < math.inf):
        return math.inf, 0.0
    update(mean, covariance, value, noise[plot], mean_out, covariance_out)
    return distance, log_spread


@jit
def bearing_distance(
    mean: FloatArray,
    covariance: FloatArray,
    place: FloatArray,
    bearing: float,
    noise: float,
    drift_squared: float,
    gate: float,
) -> float:
    """Return the squared distance of a position from a bearing.

    Infinite so close to the sensor that, by the gate, the object may be on any side.
    """
    east, north = mean[0] - place[0], mean[1] - place[1]
    aside = _wrap(bearing - math.atan2(east, north))
    variance = azimuth_variance(east, north, covariance, drift_squared)
    distance: float = aside * aside / (variance + noise)
    return distance if gate * variance < 1.0 else math.inf


@jit
def cross(table: PlotTable, limits: PlotLimits, path: Path, child: int) -> tuple[int, float]:
    """Write where the last bearing crosses an earlier one, the one that tells most.

    Returns 1, and how much that is, by the squares of distances over their variances. Returns 0
    if, as far as the gate can tell, the crossing may as well be behind a sensor as in front of
    it, since the bearings are nearly parallel or cross close to the sensor; -1 if it is behind.
    """
    plot = path.plot[child]
    place, drift_squared = table.place[plot], table.drift_squared[plot]
    sine, cosine = math.sin(table.value[plot, 0]), math.cos(table.value[plot, 0])
    variance = table.covariance[plot, 0, 0]
    best, in_front = limits.gate, False
    found = 0
    for entry in range(child):
        other_plot = path.plot[entry]
        other = table.place[other_plot]
        angle = table.value[other_plot, 0]
        other_sine, other_cosine = math.sin(angle), math.cos(angle)
        east, north = other[0] - place[0], other[1] - place[1]
        # The sine and cosine of the angle between the two, and the distances from both sensors
        # to the crossing, times that sine.
        turn = sine * other_cosine - cosine * other_sine
        along = sine * other_sine + cosine * other_cosine
        away = east * other_cosine - north * other_sine
        other_away = east * cosine - north * sine
        # How far off each ray the crossing may be: the variance, times the square of that sine;
        # then the variances of the distances, times its fourth power.
        beside = away**2 * variance + drift_squared * turn**2
        other_beside = other_away**2 * table.covariance[other_plot, 0, 0]
        other_beside += table.drift_squared[other_plot] * turn**2
        spread = other_beside + along**2 * beside
        other_spread = beside + along**2 * other_beside
        if not (spread > 0.0 and other_spread > 0.0):
            continue
        squared = min(away**2 / spread, other_away**2 / other_spread) * turn**2
        if squared > best:
            best = squared
            in_front = away * turn > 0.0 and other_away * turn > 0.0
            path.mean[child, 0] = place[0] + away / turn * sine
            path.mean[child, 1] = place[1] + away / turn * cosine
            found = 1
    return (found if in_front or found == 0 else -1), best


@jit
def locate(table: PlotTable, limits: PlotLimits, path: Path, child: int) -> bool:
    """Write the most likely position by Gauss-Newton steps from where the mean stands.

    Two dimensions. Returns False where the steps lead nowhere, or to where, as far as the gate
    can tell, the position may as well be behind a sensor of the set's bearings.
    """
    mean, covariance = path.mean[child], path.covariance[child]
    information, gradient, trial = path.scratch, np.empty(2), np.empty(2)
    _weigh(table, path, child, mean)
    distance = _linearise(table, path, child, mean, information, gradient)
    for step in range(MAX_STEPS):
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
            return _is_in_front(table, limits, path, child)
        share = 1.0
        while True:
            trial[0], trial[1] = mean[0] + share * east, mean[1] + share * north
            reached = _linearise(table, path, child, trial, information, gradient)
            if reached <= distance:
                break
            share /= 2.0
            if share < 1e-3:
                return _is_in_front(table, limits, path, child)
        overwrite(mean, trial)
        distance = reached
        if table.drifts and step < FIXED_AFTER:
            _weigh(table, path, child, mean)
            distance = _linearise(table, path, child, mean, information, gradient)
    return False


@jit
def drift_price(table: PlotTable, path: Path, child: int) -> float:
    """Return what the set's drifting bearings add to its cost, beyond their hits [nats]."""
    price = 0.0
    for entry in range(child + 1):
        plot = path.plot[entry]
        if table.is_bearing[path.sensor[entry]] and table.drift_squared[plot] > 0.0:
            # Their variance is the inverse of their weight.
            price -= 0.5 * math.log(path.weight[entry] * table.covariance[plot, 0, 0])
    return price


@jit
def _is_in_front(table: PlotTable, limits: PlotLimits, path: Path, child: int) -> bool:
    """Tell whether the position is farther from each bearing's sensor than it is uncertain."""
    covariance = path.covariance[child]
    for entry in range(child + 1):
        if not table.is_bearing[path.sensor[entry]]:
            continue
        plot = path.plot[entry]
        east = path.mean[child, 0] - table.place[plot, 0]
        north = path.mean[child, 1] - table.place[plot, 1]
        squared_range = east * east + north * north
        # The variance of the distance when the sensor looked, times its square.
        spread = (
            east * east * covariance[0, 0]
            + 2.0 * east * north * covariance[0, 1]
            + north * north * covariance[1, 1]
            + table.drift_squared[plot] * squared_range
        )
        if not squared_range**2 > limits.gate * spread:
            return False
    return True


@jit
def _weigh(table: PlotTable, path: Path, child: int, point: FloatArray) -> None:
    """Write what each bearing's squared error counts for, as uncertain as it is at the point."""
    for entry in range(child + 1):
        plot = path.plot[entry]
        if not table.is_bearing[path.sensor[entry]]:
            continue
        variance = table.covariance[plot, 0, 0]
        if table.drift_squared[plot] > 0.0:
            east, north = point[0] - table.place[plot, 0], point[1] - table.place[plot, 1]
            squared_range = max(east * east + north * north, LEAST_SQUARED_RANGE)
            variance += table.drift_squared[plot] / squared_range
        path.weight[entry] = 1.0 / variance


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
        plot = path.plot[entry]
        if not table.is_bearing[path.sensor[entry]]:
            for axis in range(2):
                aside = table.value[plot, axis] - point[axis]
                for other in range(2):
                    weight = table.information[plot, axis, other]
                    information[axis, other] += weight
                    gradient[other] += weight * aside
                    distance += weight * aside * (table.value[plot, other] - point[other])
            continue
        weight = path.weight[entry]
        east, north = point[0] - table.place[plot, 0], point[1] - table.place[plot, 1]
        squared_range = east * east + north * north
        if not squared_range > LEAST_SQUARED_RANGE:
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
def azimuth_variance(
    east: float, north: float, covariance: FloatArray, drift_squared: float
) -> float:
    """Return how uncertain the azimuth of an uncertain position is; infinite without a range."""
    squared_range = east * east + north * north
    if not squared_range > LEAST_SQUARED_RANGE:
        return math.inf
    across: float = (
        north * north * covariance[0, 0]
        - 2.0 * north * east * covariance[0, 1]
        + east * east * covariance[1, 1]
    )
    return across / (squared_range * squared_range) + drift_squared / squared_range


@jit
def _wrap(angle: float) -> float:
    """Return the angle between −π and π."""
    return angle - 2.0 * math.pi * math.floor((angle + math.pi) / (2.0 * math.pi))
