"""What fused reports are to a tracker: how likely an object is among them, and how many are false.

A set of sensors that report at one instant is one sensor to the tracker. An object is among its
reports if the plots of some of them make a tuple that costs less than its plots do alone; chance
tuples are its false alarms. Both follow from the plots' own cost: for sensors A whose plots
measure a place with Jacobian H and noise R, a tuple costs c₀(A) + ½ d², where d² is χ² with as
many degrees of freedom as there are numbers more than dimensions. So it stands with the
probability of A reporting and nobody else, times that of d² < −2 c₀; and chance makes Π λ tuples
per unit of what is measured, over a ball of that radius: Π λ · V(−2 c₀) · |R|^½ |HᵀR⁻¹H|^½ per m².
"""

import itertools
import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.special import gammainc

from trackweave.arrays import FloatArray
from trackweave.association.plots_rule import PlotsRule
from trackweave.errors import InvalidInputError
from trackweave.models._kernels import is_covered
from trackweave.models.sensors import Sensor

__all__ = ["chances_of", "likely_places"]

MOST_TOGETHER = 3
"""Sets of more sensors than this always stand, and chance makes none of them."""
FEWEST_CHANCES, LEAST_CLUTTER = 1e-9, 1e-30
N_SIDE = 7
USUAL_SIDE = 1000.0
NEAREST = 1e-6


class _Reports(NamedTuple):
    """One sensor's reports of objects at several places.

    ``information`` on the place [m⁻²], shape (places, dim, dim), of ``size`` numbers; ``watches``
    which places are covered. ``log_noise`` is ln|R|, ``log_clutter`` that of the false alarms per
    unit of measurement. ``hit`` is what a report that fits exactly costs, ``miss`` what none does.
    """

    information: FloatArray
    watches: FloatArray
    size: int
    log_noise: float
    log_clutter: float
    detection: float
    hit: float
    miss: float


def chances_of(
    sensors: Sequence[Sensor],
    rule: PlotsRule,
    places: FloatArray,
    volumes: Sequence[float | None],
    *,
    keep_lone: bool = False,
) -> tuple[float, float]:
    """Return an object's chance to become a fused report, and the density of chance tuples."""
    # The chance is averaged over the places [m] where it can, the density [per m² or m³] is the
    # median over these; both are above 0. ``volumes`` are the fields of view in units of each
    # one's measurement, which equation 1 takes; None where not known. ``keep_lone`` says whether
    # positions where only one sensor looks are reports as they are.
    dim = places.shape[1]
    watching = [
        _reports(sensor, places, rule, volume)
        for sensor, volume in zip(sensors, volumes, strict=True)
    ]
    chance, density = np.zeros((2, places.shape[0]))
    for count in range(1, min(len(watching), MOST_TOGETHER) + 1):
        for chosen in itertools.combinations(range(len(watching)), count):
            odds = np.ones(places.shape[0])
            for index, each in enumerate(watching):
                seen = each.detection * each.watches
                odds *= seen if index in chosen else 1.0 - seen
            stands, by_chance = _of_set(watching, chosen, rule, dim)
            if keep_lone and count == 1 and watching[chosen[0]].size >= dim:
                only = np.sum([each.watches for each in watching], axis=0) == 1.0
                only &= watching[chosen[0]].watches > 0.0
                stands = np.where(only, 1.0, stands)
                by_chance = np.where(only, _lone_density(watching[chosen[0]]), by_chance)
            chance += odds * stands
            density += by_chance
    chance += _more_than(MOST_TOGETHER, watching)
    can = chance > FEWEST_CHANCES
    if not np.any(can):
        return FEWEST_CHANCES, LEAST_CLUTTER
    mean = float(np.clip(chance[can].mean(), FEWEST_CHANCES, 1.0 - FEWEST_CHANCES))
    return mean, max(float(np.median(density[can])), LEAST_CLUTTER)


def likely_places(sensors: Sequence[Sensor], dim: int) -> FloatArray:
    """Return places where objects may be: a grid over what sensors see, at no height [m]."""
    low, high = np.full(2, np.inf), np.full(2, -np.inf)
    stands = np.array([sensor.platform[:2] for sensor in sensors])
    for sensor in sensors:
        view = sensor.field_of_view
        if view is not None and view.polygon is not None:
            corners = np.asarray(view.polygon, dtype=np.float64)
        elif view is not None and np.isfinite(view.max_range):
            corners = np.array(view.position) + view.max_range * np.array([[-1.0, -1], [1, 1]])
        else:
            continue
        low, high = np.minimum(low, corners.min(axis=0)), np.maximum(high, corners.max(axis=0))
    if not np.all(low < high):
        middle = stands.mean(axis=0)
        side = float(np.ptp(stands, axis=0).max()) or USUAL_SIDE
        low, high = middle - side, middle + side
    # Off the middle of the box, where sensors stand and their plots' noise is none.
    share = (np.arange(N_SIDE) + 0.37) / N_SIDE
    east, north = np.meshgrid(low[0] + share * (high - low)[0], low[1] + share * (high - low)[1])
    places = np.zeros((east.size, dim))
    places[:, 0], places[:, 1] = east.ravel(), north.ravel()
    return places


def _reports(
    sensor: Sensor, places: FloatArray, rule: PlotsRule, volume: float | None
) -> _Reports:
    """Return what a sensor's reports of objects at some places would tell."""
    rows = _jacobian(sensor, places)
    noise = sensor.sigmas(places.shape[1])[: rows.shape[1]]
    scaled = rows / noise[:, None]
    view = sensor.field_of_view
    watches = np.ones(places.shape[0])
    if view is not None:
        coverage = view.coverage()
        watches[:] = [is_covered(place[0], place[1], coverage) for place in places]
    false = sensor.clutter_density
    if rule.cost == "equation-1":
        if volume is None:
            raise InvalidInputError(
                f"sensor {sensor.name}: no bounded field_of_view, nor one of volumes; expected "
                "either for equation 1"
            )
        false = 1.0 / volume
    log_noise = 2.0 * float(np.log(noise).sum())
    hit = 0.5 * (rows.shape[1] * math.log(2.0 * math.pi) + log_noise)
    return _Reports(
        information=np.swapaxes(scaled, 1, 2) @ scaled,
        watches=watches,
        size=rows.shape[1],
        log_noise=log_noise,
        log_clutter=math.log(sensor.clutter_density),
        detection=sensor.detection_probability,
        hit=hit + math.log(false / sensor.detection_probability),
        miss=-math.log1p(-sensor.detection_probability),
    )


def _jacobian(sensor: Sensor, places: FloatArray) -> FloatArray:
    """Return how the numbers of a report change with the place, range rates left out."""
    kind, (count, dim) = sensor.measurement, places.shape
    if kind.is_position:
        return np.broadcast_to(np.eye(dim), (count, dim, dim))
    away = places - sensor.platform[:dim]
    level = np.maximum(np.hypot(away[:, 0], away[:, 1]), NEAREST)
    full = np.maximum(np.linalg.norm(away, axis=1), NEAREST)
    nothing = np.zeros((count, dim - 2))
    across = np.stack([away[:, 1], -away[:, 0]], axis=1) / level[:, None] ** 2
    rows = [np.hstack([across, nothing])]
    if kind.has_range:
        rows.insert(0, away / full[:, None])
    if kind.has_elevation:
        falls = -away[:, :2] * (away[:, 2:] / level[:, None])
        rows.append(np.hstack([falls, level[:, None]]) / full[:, None] ** 2)
    return np.stack(rows, axis=1)


def _of_set(
    watching: Sequence[_Reports], chosen: Sequence[int], rule: PlotsRule, dim: int
) -> tuple[FloatArray, FloatArray]:
    """Return how probably the plots of a set of sensors stand, and their chance tuples per m²."""
    own = [watching[index] for index in chosen]
    none = np.zeros(own[0].watches.shape[0])
    with_evidence = rule.cost == "evidence"
    spare = sum(each.size for each in own) - dim
    if spare < 0 or (len(own) == 1 and not (rule.lone_plots and with_evidence)):
        return none, none
    sign, log_information = np.linalg.slogdet(np.sum([each.information for each in own], axis=0))
    cost = _cost(watching, chosen)
    if with_evidence and rule.object_density is not None:
        cost += 0.5 * log_information - math.log(rule.object_density)
        cost -= 0.5 * dim * math.log(2.0 * math.pi)
    elif rule.lone_plots:
        cost -= np.sum([_cost(watching, [index]) for index in chosen], axis=0)
    square = np.clip(-2.0 * cost, 0.0, rule.gate * max(1, len(own) - 1))
    may = (sign > 0) & (square > 0.0) & np.all([each.watches > 0 for each in own], axis=0)
    reach = np.where(may, square, 1.0)
    log_density = np.where(may, 0.5 * log_information, -np.inf)
    log_density += sum(each.log_clutter + 0.5 * each.log_noise for each in own)
    log_density += 0.5 * spare * np.log(math.pi * reach) - math.lgamma(0.5 * spare + 1.0)
    stands = np.ones_like(reach) if spare == 0 else gammainc(0.5 * spare, 0.5 * reach)
    return np.where(may, stands, 0.0), np.exp(np.minimum(log_density, 300.0))


def _lone_density(reports: _Reports) -> FloatArray:
    """Return the density of a sensor's false alarms at each place [per m² or m³]."""
    log_information = np.linalg.slogdet(reports.information)[1]
    return np.asarray(np.exp(reports.log_clutter + 0.5 * (reports.log_noise + log_information)))


def _cost(watching: Sequence[_Reports], chosen: Sequence[int]) -> FloatArray:
    """Return what plots that fit exactly cost, but for what the whole tuple's position adds."""
    cost: FloatArray = np.sum([each.miss * each.watches for each in watching], axis=0)
    for index in chosen:
        cost = cost + watching[index].hit - watching[index].miss * watching[index].watches
    return cost


def _more_than(count: int, watching: Sequence[_Reports]) -> FloatArray:
    """Return the probability that more than so many sensors report an object."""
    ways = np.zeros((len(watching) + 1, watching[0].watches.shape[0]))
    ways[0] = 1.0
    for each in watching:
        seen = each.detection * each.watches
        ways[1:] = ways[1:] * (1.0 - seen) + ways[:-1] * seen
        ways[0] *= 1.0 - seen
    more: FloatArray = ways[count + 1 :].sum(axis=0)
    return more
