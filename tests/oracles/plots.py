"""Every tuple of plots that one object may have made, one at a time, by matrices and scipy."""

import math
from dataclasses import dataclass
from itertools import product
from types import SimpleNamespace

import numpy as np
from scipy.optimize import least_squares

from oracles.coverage import share


@dataclass
class Scored:
    """A tuple's cost, position and information about it."""

    cost: float
    position: np.ndarray
    information: np.ndarray


def azimuth(sensor, index, point):
    """Return the azimuth at which the sensor sees the point, clockwise from north."""
    east, north = np.asarray(point) - place_of(sensor, index)
    return math.atan2(east, north)


def wrap(angle):
    """Return the angle between -π and π."""
    return math.remainder(angle, 2 * math.pi)


def place_of(sensor, index):
    """Return where the sensor of a bearing stood."""
    return sensor.place if sensor.place.ndim == 1 else sensor.place[index]


def drift_of(sensor, index):
    """Return how far an object may have come since a plot."""
    return sensor.drift if np.ndim(sensor.drift) == 0 else sensor.drift[index]


def noise(sensor, index, at):
    """Return the covariance of a plot's error, if the object is at a place."""
    drift = drift_of(sensor, index)
    if sensor.is_bearing:
        away = np.asarray(at) - place_of(sensor, index)
        return np.array([[sensor.sigma[index] ** 2 + drift**2 / (away @ away)]])
    if sensor.covariance is not None:
        own = sensor.covariance[index]
    else:
        own = np.diag(np.square(np.broadcast_to(sensor.sigma[index], len(at))))
    return own + drift**2 * np.eye(len(at))


def aside(sensor, index, point):
    """Return how far a plot lies from what its sensor would report."""
    if sensor.is_bearing:
        return np.array([wrap(sensor.value[index] - azimuth(sensor, index, point))])
    return sensor.value[index] - point


def slope(sensor, index, point):
    """Return the derivative of what a sensor would report."""
    if not sensor.is_bearing:
        return np.eye(len(point))
    east, north = np.asarray(point) - place_of(sensor, index)
    return np.array([[north, -east]]) / (east**2 + north**2)


def whitened(plots, point, seen_at, of):
    """Return errors or derivatives over the square roots of the noise at a place."""
    parts = []
    for sensor, index in plots:
        spread = noise(sensor, index, point if seen_at is None else seen_at)
        error = of(sensor, index, point)
        if spread.size == 1:
            parts.append(error / math.sqrt(spread[0, 0]))
        else:
            parts.append(np.linalg.solve(np.linalg.cholesky(spread), error))
    return np.concatenate(parts)


def residuals(plots, point, seen_at=None):
    """Return how far each plot lies from what its sensor would report, over its noise."""
    return whitened(plots, point, seen_at, aside)


def derivative(plots, point):
    """Return the derivative of what the sensors would report, over its noise."""
    return whitened(plots, point, None, slope)


def way(sensor, index):
    """Return the direction in which a bearing points."""
    return np.array([math.sin(sensor.value[index]), math.cos(sensor.value[index])])


def crossing(plots, gate):
    """Return where the last bearing crosses the one that tells most.

    None if the crossing's distance from a sensor may be nothing, NaN if it is behind a sensor.
    """
    best, found = gate, None
    for pair in [(plot, plots[-1]) for plot in plots[:-1]]:
        ways = np.stack([way(*pair[0]), -way(*pair[1])], axis=1)
        if abs(np.linalg.det(ways)) < 1e-9:
            continue
        away = np.linalg.solve(ways, place_of(*pair[1]) - place_of(*pair[0]))
        at = place_of(*pair[0]) + away[0] * way(*pair[0])
        steep = derivative(pair, at)
        spread = np.linalg.inv(steep.T @ steep)
        sure = [away[n] ** 2 / (way(*pair[n]) @ spread @ way(*pair[n])) for n in (0, 1)]
        if min(sure) > best:
            best, found = min(sure), at if np.all(away > 0) else np.full(2, np.nan)
    return found


def locate(plots, start):
    """Return the most likely position and the information there.

    The noise is that at the position itself, and does not change in the search for the next.
    """
    at, drifts = np.asarray(start), any(drift_of(*plot) and plot[0].is_bearing for plot in plots)
    for _ in range(100 if drifts else 1):
        before = at
        at = least_squares(
            lambda x, seen_at: residuals(plots, x, seen_at),
            at,
            args=(at if drifts else None,),
            xtol=1e-14,
            ftol=1e-14,
            gtol=None,
        ).x
        if np.max(np.abs(at - before)) < 1e-9:
            break
    steep = derivative(plots, at)
    return at, steep.T @ steep


def may_be_behind(plots, at, information, gate):
    """Return whether the position's distance from the sensor of a bearing may be nothing."""
    for sensor, index in plots:
        if sensor.is_bearing:
            away = at - place_of(sensor, index)
            variance = away @ np.linalg.inv(information) @ away / (away @ away)
            if away @ away <= gate * (variance + drift_of(sensor, index) ** 2):
                return True
    return False


def is_near(sensor, index, at, information, gate):
    """Return whether a plot lies in the gate about a position."""
    steep = slope(sensor, index, at)
    spread = steep @ np.linalg.inv(information) @ steep.T
    if sensor.is_bearing:
        away = at - place_of(sensor, index)
        if gate * (spread[0, 0] + drift_of(sensor, index) ** 2 / (away @ away)) >= 1:
            return False
    off = aside(sensor, index, at)
    return off @ np.linalg.solve(spread + noise(sensor, index, at), off) <= gate


def position(plots, gate):
    """Return position and information of a set, grown plot by plot; None if a rule is broken."""
    at = information = None
    for count in range(1, len(plots) + 1):
        now, (sensor, index) = plots[:count], plots[count - 1]
        is_first = at is None
        if not is_first:
            if not is_near(sensor, index, at, information, gate):
                return None
            start = at
        elif sensor.is_bearing:
            start = crossing(now, gate)
            if start is None:
                continue
            if np.any(np.isnan(start)):
                return None
        else:
            start = sensor.value[index]
        at, information = locate(now, start)
        if may_be_behind(now, at, information, gate):
            return None
        if is_first and np.sum(residuals(now, at) ** 2) > gate:
            return None
    return None if at is None else (at, information)


def covers(view, point):
    """Return whether a ring sector, without a polygon, holds a point."""
    east, north = np.asarray(point)[:2] - view.position
    start, end = view.azimuth_deg
    turn = (math.degrees(math.atan2(east, north)) - start) % 360
    width = 360 if end - start >= 360 else (end - start) % 360
    return view.min_range <= math.hypot(east, north) <= view.max_range and turn <= width


def share_covered(view, at, information):
    """Return how much of the position's uncertainty a field of view holds."""
    if view is None:
        return 1.0
    sensor = SimpleNamespace(field_of_view=view)
    look = SimpleNamespace(sees_everything=False, sensor=sensor, blur=lambda _: (0.0, 0.0, 0.0))
    return share(look, at[:2], np.linalg.inv(information)[:2, :2])


def clutter(sensor, index, rule):
    """Return the density of false alarms at a plot."""
    if rule.cost == "evidence" and sensor.clutter_density is not None:
        return np.broadcast_to(sensor.clutter_density, len(sensor.value))[index]
    volume = np.broadcast_to(sensor.volume, len(sensor.value))[index]
    return (sensor.false_alarms if rule.cost == "evidence" else 1) / volume


def price(sensors, choice, at, information, rule):
    """Return the cost of a tuple, by the formula."""
    cost = 0.0
    for sensor, index in zip(sensors, choice, strict=True):
        if index is None:
            share = share_covered(sensor.coverage, at, information)
            cost -= math.log(1 - sensor.detection_probability * share)
            continue
        root = math.sqrt(np.linalg.det(2 * math.pi * noise(sensor, index, at)))
        cost += 0.5 * np.sum(residuals([(sensor, index)], at) ** 2)
        cost += math.log(root * clutter(sensor, index, rule) / sensor.detection_probability)
    if rule.cost == "evidence":
        volume = math.sqrt(np.linalg.det(2 * math.pi * np.linalg.inv(information)))
        cost -= math.log(rule.object_density * volume)
    return cost


def every_tuple(sensors, rule, *, least=2):
    """Return all tuples of so many plots that keep the rules, by 1-based numbers."""
    scored = {}
    for choice in product(*([None, *range(len(sensor.value))] for sensor in sensors)):
        plots = [
            (sensor, index)
            for sensor, index in zip(sensors, choice, strict=True)
            if index is not None
        ]
        if len(plots) < least:
            continue
        found = position(plots, rule.gate)
        if found is None:
            continue
        cost = price(sensors, choice, *found, rule)
        key = tuple(0 if index is None else index + 1 for index in choice)
        scored[key] = Scored(cost, *found)
    return scored
