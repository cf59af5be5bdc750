"""Every tuple of plots that one object may have made, one at a time, by matrices and scipy."""

import math
from dataclasses import dataclass
from itertools import product

import numpy as np
from scipy.optimize import least_squares


@dataclass
class Scored:
    """A tuple's cost, position and information about it."""

    cost: float
    position: np.ndarray
    information: np.ndarray


def azimuth(sensor, point):
    """Return the azimuth at which the sensor sees the point, clockwise from north."""
    return math.atan2(point[0] - sensor.place[0], point[1] - sensor.place[1])


def wrap(angle):
    """Return the angle between -π and π."""
    return math.remainder(angle, 2 * math.pi)


def residuals(plots, point):
    """Return how far each plot lies from what its sensor would report, over its sigma."""
    parts = []
    for sensor, index in plots:
        if sensor.is_bearing:
            parts.append([wrap(sensor.value[index] - azimuth(sensor, point))])
        else:
            parts.append(sensor.value[index] - point)
        parts[-1] = np.asarray(parts[-1]) / sensor.sigma[index]
    return np.concatenate(parts)


def derivative(plots, point):
    """Return the derivative of what the sensors would report, over sigma."""
    rows = []
    for sensor, index in plots:
        if sensor.is_bearing:
            east, north = np.asarray(point) - sensor.place
            row = np.array([[north, -east]]) / (east**2 + north**2)
            rows.append(row / sensor.sigma[index])
        else:
            rows.append(np.diag(1 / np.broadcast_to(sensor.sigma[index], len(point))))
    return np.concatenate(rows)


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
        away = np.linalg.solve(ways, pair[1][0].place - pair[0][0].place)
        at = pair[0][0].place + away[0] * way(*pair[0])
        slope = derivative(pair, at)
        spread = np.linalg.inv(slope.T @ slope)
        sure = [away[n] ** 2 / (way(*pair[n]) @ spread @ way(*pair[n])) for n in (0, 1)]
        if min(sure) > best:
            best, found = min(sure), at if np.all(away > 0) else np.full(2, np.nan)
    return found


def locate(plots, start):
    """Return the most likely position and the information there."""
    result = least_squares(lambda x: residuals(plots, x), start, xtol=1e-14, ftol=1e-14, gtol=None)
    slope = derivative(plots, result.x)
    return result.x, slope.T @ slope


def may_be_behind(plots, at, information, gate):
    """Return whether the position's distance from the sensor of a bearing may be nothing."""
    for sensor, _ in plots:
        if sensor.is_bearing:
            away = at - sensor.place
            variance = away @ np.linalg.inv(information) @ away / (away @ away)
            if away @ away <= gate * variance:
                return True
    return False


def is_near(sensor, index, at, information, gate):
    """Return whether a plot lies in the gate about a position."""
    spread = np.linalg.inv(information)
    noise = np.diag(np.atleast_1d(sensor.sigma[index] ** 2))
    slope = derivative([(sensor, index)], at) * np.atleast_1d(sensor.sigma[index])[:, None]
    if sensor.is_bearing and gate * (slope @ spread @ slope.T)[0, 0] >= 1:
        return False
    aside = residuals([(sensor, index)], at) * sensor.sigma[index]
    return aside @ np.linalg.solve(slope @ spread @ slope.T + noise, aside) <= gate


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


def price(sensors, choice, at, information, rule):
    """Return the cost of a tuple, by the formula."""
    cost = 0.0
    for sensor, index in zip(sensors, choice, strict=True):
        if index is None:
            cost -= math.log(1 - sensor.detection_probability)
            continue
        density = 1 / sensor.volume
        if rule.cost == "evidence":
            density *= sensor.false_alarms
        dim = 1 if sensor.is_bearing else sensor.value.shape[1]
        root = np.prod(np.broadcast_to(sensor.sigma[index], dim)) * (2 * math.pi) ** (dim / 2)
        cost += 0.5 * np.sum(residuals([(sensor, index)], at) ** 2)
        cost += math.log(root * density / sensor.detection_probability)
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
