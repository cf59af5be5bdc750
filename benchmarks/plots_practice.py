"""How plots of many sensors are mostly associated: one sensor after another, two lists at a time.

The groups so far and the next sensor's plots are paired by an optimal assignment; each
group's place is then estimated anew from all its plots, and plots without a partner stay
candidates for the sensors to come. For comparison only: no part of the library.
"""

import itertools
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from scipy.optimize import linear_sum_assignment

from trackweave.association.plots_rule import PlotsRule, scene_plots
from trackweave.simulation.scenes import Scene

GATE = 16.0
MOST_ORDERS, FEW_ORDERS, MANY_OBJECTS = 24, 6, 20
STEPS = 8
LONGEST_STEP = 2000.0
"""Gauss-Newton steps from afar are cut to this [m]."""
Pricing = Literal["distance", "evidence"]


@dataclass(frozen=True)
class Told:
    """Groups of plots (one column per sensor, -1 for none), their places, and their cost."""

    groups: Any
    places: Any
    cost: float


def by_pairs(scene: Scene, pricing: Pricing) -> Told:
    """Return the practice's groups; with bearings the best of several orders of the sensors."""
    sensors = range(len(scene.plots))
    if scene.places is None:
        return sequential(scene, pricing, sensors)
    orders = itertools.islice(itertools.permutations(sensors), _most_orders(scene))
    return _cheapest(sequential(scene, pricing, order) for order in orders)


def by_triples(scene: Scene) -> Told:
    """Return groups that begin as triples, the best first; the other sensors come one by one.

    A third bearing confirms where two cross, which pairs alone leave open.
    """
    sensors = range(len(scene.plots))
    orders = itertools.islice(itertools.combinations(sensors, 3), _most_orders(scene))
    return _cheapest(
        sequential(
            scene, "evidence", [*first, *(s for s in sensors if s not in first)],
            _triples(scene, first),
        )
        for first in orders
    )  # fmt: skip


def sequential(scene: Scene, pricing: Pricing, order: Sequence[int], begun: Any = None) -> Told:
    """Return the groups that come of taking the sensors in an order.

    Pairs are priced by their squared distance beyond the groups', to a gate, or by how much less
    probable the plots are apart: the groups' evidence. ``begun`` are groups of the first three.
    """
    fit = _Fit(scene)
    n_sensors = len(scene.plots)
    if begun is None:
        seen, groups = [order[0]], _alone(order[0], range(len(scene.plots[order[0]])), n_sensors)
    else:
        seen, groups = list(order[:3]), begun
    for sensor in order[len(seen) :]:
        groups = _joined(fit, pricing, groups, seen, sensor)
        seen.append(sensor)
    is_object = np.sum(groups >= 0, axis=1) > 1
    if pricing == "evidence":
        is_object &= fit.judged(groups, seen)[0] < 0.0
    groups = groups[is_object]
    cost, _, places, _ = fit.judged(groups, seen)
    return Told(groups, places, float(cost.sum()))


def _most_orders(scene: Scene) -> int:
    return FEW_ORDERS if len(scene.objects) >= MANY_OBJECTS else MOST_ORDERS


def _cheapest(found: Iterable[Told]) -> Told:
    return min(found, key=lambda told: told.cost)


def _joined(fit: "_Fit", pricing: Pricing, groups: Any, seen: list[int], sensor: int) -> Any:
    """Return the groups with a further sensor's plots, and those plots that found none."""
    n, n_plots = len(groups), len(fit.scene.plots[sensor])
    cost, distance, _, _ = fit.judged(groups, seen)
    without = cost + np.where(np.sum(groups >= 0, axis=1) > 1, fit.miss, 0.0)
    tried = np.repeat(groups, n_plots, axis=0)
    tried[:, sensor] = np.tile(np.arange(n_plots), n)
    tried_cost, tried_distance, _, is_sound = fit.judged(tried, [*seen, sensor])
    farther = tried_distance - np.repeat(distance, n_plots)
    cheaper = tried_cost - np.repeat(without, n_plots)
    gain = farther - GATE if pricing == "distance" else cheaper
    gain = np.where(is_sound & (farther <= GATE), np.minimum(gain, 0.0), 0.0)
    gain = gain.reshape(n, n_plots)
    row, plot = linear_sum_assignment(gain)
    is_pair = gain[row, plot] < 0.0
    row, plot = row[is_pair], plot[is_pair]
    groups = groups.copy()
    groups[row, sensor] = plot
    rest = np.setdiff1d(np.arange(n_plots), plot)
    return np.concatenate([groups, _alone(sensor, rest, groups.shape[1])])


def _alone(sensor: int, plots: Any, n_sensors: int) -> Any:
    groups = np.full((len(plots), n_sensors), -1)
    groups[:, sensor] = plots
    return groups


def _triples(scene: Scene, first: tuple[int, ...]) -> Any:
    """Return disjoint triples of three sensors' plots, the best first, and the plots left."""
    plots = scene_plots(scene)
    rule = PlotsRule(
        scene.object_density, area=scene.area, negative_only=True, max_tuples=2_000_000
    )
    scored = rule([plots[sensor] for sensor in first])
    is_triple = np.count_nonzero(scored.tuples, axis=1) == 3
    table = scored.tuples[is_triple][np.argsort(scored.costs[is_triple], kind="stable")] - 1
    free = [np.ones(len(scene.plots[sensor]), dtype=bool) for sensor in first]
    chosen = []
    for triple in table.tolist():
        if all(is_free[plot] for is_free, plot in zip(free, triple, strict=True)):
            chosen.append(triple)
            for is_free, plot in zip(free, triple, strict=True):
                is_free[plot] = False
    groups = np.full((len(chosen), len(scene.plots)), -1)
    groups[:, list(first)] = np.reshape(chosen, (-1, 3))
    left = [
        _alone(sensor, np.flatnonzero(is_free), len(scene.plots))
        for sensor, is_free in zip(first, free, strict=True)
    ]
    return np.concatenate([groups, *left])


class _Fit:
    """Prices and places many groups at once."""

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self.miss = -math.log1p(-scene.detection_probability)
        self._clutter = np.maximum(scene.false_alarms, 1e-9) / scene.volume
        self._values = [np.reshape(v, (len(v), -1)) for v in scene.plots]

    def judged(self, groups: Any, seen: Sequence[int]) -> tuple[Any, Any, Any, Any]:
        """Return costs, squared distances, places, and which groups have a place at all.

        A group of one plot costs nothing: it is a false alarm.
        """
        scene = self.scene
        dim = 1 if scene.places is not None else 2
        cost = np.full(len(groups), -math.log(scene.object_density) - math.log(2.0 * math.pi))
        for sensor in seen:
            hit = dim * math.log(math.sqrt(2.0 * math.pi) * scene.sigma[sensor])
            hit += math.log(self._clutter[sensor] / scene.detection_probability)
            cost += np.where(groups[:, sensor] >= 0, hit, self.miss)
        values = [
            self._values[s][groups[:, s]] if len(self._values[s]) else np.zeros((len(groups), dim))
            for s in seen
        ]
        has = [groups[:, s] >= 0 for s in seen]
        find = self._cross if dim == 1 else self._average
        places, distance, log_information, is_sound = find(seen, values, has)
        is_lone = np.sum(groups >= 0, axis=1) < 2
        cost += 0.5 * (distance + log_information)
        return np.where(is_lone, 0.0, cost), np.where(is_lone, 0.0, distance), places, is_sound

    def _average(self, seen: Sequence[int], values: Any, has: Any) -> tuple[Any, Any, Any, Any]:
        weight = sum(h / self.scene.sigma[s] ** 2 for s, h in zip(seen, has, strict=True))
        total = sum(
            (h / self.scene.sigma[s] ** 2)[:, None] * v
            for s, h, v in zip(seen, has, values, strict=True)
        )
        places = total / weight[:, None]
        distance = sum(
            h * np.sum((v - places) ** 2, axis=1) / self.scene.sigma[s] ** 2
            for s, h, v in zip(seen, has, values, strict=True)
        )
        return places, distance, 2.0 * np.log(weight), np.ones(len(places), dtype=bool)

    def _cross(self, seen: Sequence[int], values: Any, has: Any) -> tuple[Any, Any, Any, Any]:
        """Return the most likely crossings: from the nearest point of all lines, Gauss-Newton."""
        lines = [
            (self.scene.places[s], self.scene.sigma[s], h, v[:, 0])
            for s, h, v in zip(seen, has, values, strict=True)
        ]
        n = len(lines[0][2])
        info, pull = np.zeros((n, 3)), np.zeros((n, 2))
        for place, _, h, angle in lines:
            across = np.stack([np.cos(angle), -np.sin(angle)], axis=1)
            _add(info, pull, across, h * 1.0, across @ place)
        is_sound = info[:, 0] * info[:, 2] - info[:, 1] ** 2 > 1e-6
        places = _solve(info, pull)
        for step in range(STEPS):
            info, pull, distance = np.zeros((n, 3)), np.zeros((n, 2)), np.zeros(n)
            for place, sigma, h, angle in lines:
                aside = places - place
                squared = np.maximum(np.sum(aside**2, axis=1), 1e-6)
                left = angle - np.arctan2(aside[:, 0], aside[:, 1])
                left = np.remainder(left + math.pi, 2.0 * math.pi) - math.pi
                slope = np.stack([aside[:, 1], -aside[:, 0]], axis=1) / squared[:, None]
                _add(info, pull, slope, h / sigma**2, left)
                distance += h / sigma**2 * left**2
            if step < STEPS - 1:
                move = _solve(info, pull)
                length = np.maximum(np.hypot(move[:, 0], move[:, 1]), 1e-9)
                places = places + move * np.minimum(1.0, LONGEST_STEP / length)[:, None]
        determinant = np.maximum(info[:, 0] * info[:, 2] - info[:, 1] ** 2, 1e-300)
        low, high = np.array(self.scene.area)
        edge = 0.02 * (high - low)
        is_sound &= np.all((places > low - edge) & (places < high + edge), axis=1)
        return places, distance, np.log(determinant), is_sound


def _add(info: Any, pull: Any, slope: Any, weight: Any, left: Any) -> None:
    info[:, 0] += weight * slope[:, 0] ** 2
    info[:, 1] += weight * slope[:, 0] * slope[:, 1]
    info[:, 2] += weight * slope[:, 1] ** 2
    pull += (weight * left)[:, None] * slope


def _solve(info: Any, pull: Any) -> Any:
    determinant = info[:, 0] * info[:, 2] - info[:, 1] ** 2
    determinant = np.where(determinant > 1e-300, determinant, 1.0)
    east = (info[:, 2] * pull[:, 0] - info[:, 1] * pull[:, 1]) / determinant
    north = (info[:, 0] * pull[:, 1] - info[:, 1] * pull[:, 0]) / determinant
    return np.stack([east, north], axis=1)
