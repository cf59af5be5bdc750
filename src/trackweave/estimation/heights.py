"""Heights of objects that several sensors see, from their ranges.

A range along the line of sight is longer than that on the ground, the more so the nearer and the
higher the object. Sensors that take it for the ground's see one object at several places; the
height at which these meet is the object's. Biases move places too, a clock's along the way: they
are fitted beside the heights of all objects, and left to registration.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from trackweave.arrays import FloatArray
from trackweave.estimation.bias_changes import BiasChange, explained_by_biases
from trackweave.estimation.height_pairs import (
    GATE,
    ROUGH_GATE,
    USUAL,
    Fit,
    Looks,
    Moments,
    candidates,
    fitted,
    held_at,
    moments_of,
)
from trackweave.estimation.sightings import N_BIASES, USUAL_BIASES, Sightings

__all__ = ["Heights", "heights_of"]

ROUNDS = 3
# A pair tells clearly where its height explains so much more than biases alone (chi-square, in
# units of what is left). So many have to, and this share of all: else ranges may be on the ground
# already.
CLEAR, FEWEST_PAIRS, SHARE = 16.0, 3, 0.25
# They are where objects at a usual height would explain so much less, of as many pairs, and hardly
# any tells otherwise.
MOST_CLEAR = 0.1


@dataclass(frozen=True, eq=False)
class Heights:
    """Heights that ranges of several sensors tell."""

    height: FloatArray  # Of each report of the sightings [m], NaN where it is not known
    n_objects: int
    n_pairs: int  # Of tracks of two sensors
    n_clear: int  # Of these, that tell clearly
    is_on_ground: bool = False  # Whether ranges clearly are those on the ground
    change: BiasChange | None = None  # Of biases, that explains as much as heights would

    def allowed(self, may: NDArray[np.bool_]) -> "Heights":
        """Return these with a change of those biases alone that it ``may``, shape (sensors, 6)."""
        if self.change is None:
            return self
        step = np.where(may, self.change.step, 0.0)
        return replace(self, change=self.change._replace(step=step) if step.any() else None)


def heights_of(
    sightings: Sightings, level: FloatArray, is_slant: NDArray[np.bool_], curve: float
) -> Heights:
    """Return the heights of objects that several sensors see."""
    # ``level`` is how high each report's sensor stands [m]; ``is_slant`` which reports tell a
    # range whose height nobody knows; ``curve`` is one by the Earth's radius [1/m], 0 on a plane.
    looks = Looks(sightings, level, is_slant, curve)
    moments = untold = moments_of(looks)
    pairs = candidates(moments)
    bias = np.zeros((sightings.n_sensors, N_BIASES))
    known: dict[tuple[int, int], float | None] = dict.fromkeys(map(tuple, pairs.tolist()))
    for number in range(ROUNDS):
        # Before any bias is known, a clock's may take places of one object far apart.
        found = _fits(moments, known, GATE if number else ROUGH_GATE)
        fits = _one_to_one(found, sightings)
        bias = bias + _step([(fit.bias_matrix, fit.bias_vector) for fit in fits], bias)
        moments = moments_of(replace(looks, sightings=sightings.without(bias)))
        known |= {fit.pair: float(np.median(fit.height)) for fit in found}
    fits = _one_to_one(_fits(moments, known, GATE), sightings)
    pairs_of_one, height = [fit.pair for fit in fits], np.full(sightings.time.size, np.nan)
    rough = _one_to_one(_fits(untold, known, ROUGH_GATE), sightings)
    is_explained, change = explained_by_biases(untold, rough)
    if change is not None:
        return Heights(height, 0, len(rough), 0, is_on_ground=True, change=change)
    ground = _costs_at(0.0, looks, pairs_of_one)
    n_clear = 0 if is_explained else _clear(fits, ground)
    if n_clear >= max(FEWEST_PAIRS, SHARE * len(fits)):
        height, n_objects = _entered(height, fits, sightings, moments)
        return Heights(height, n_objects, len(fits), n_clear)
    is_on_ground = n_clear <= MOST_CLEAR * len(fits) and len(fits) >= FEWEST_PAIRS
    if is_on_ground:
        worse = sum(_costs_at(USUAL, looks, pairs_of_one)) - sum(ground)
        is_on_ground = worse > FEWEST_PAIRS * CLEAR * _left(ground, fits)
    return Heights(height, 0, len(fits), n_clear, is_on_ground)


def _left(costs: Sequence[float], fits: list[Fit]) -> float:
    """Return what usually is left of a squared distance, which is 1 where noise is as told."""
    each = [cost / fit.moment.size / 2.0 for cost, fit in zip(costs, fits, strict=True)]
    return float(np.median(each)) if each else 0.0


def _clear(fits: list[Fit], ground: list[float]) -> int:
    """Return how many pairs tell clearly of a height above the ground."""
    # Without heights, too, biases may be what they like.
    least = CLEAR * _left([fit.cost for fit in fits], fits)
    return sum(
        cost - fit.cost > least and float(np.median(fit.height)) > 0.0
        for cost, fit in zip(ground, fits, strict=True)
    )


def _fits(moments: Moments, known: dict[tuple[int, int], float | None], gate: float) -> list[Fit]:
    """Return the fits of pairs, each from the height that is known of it."""
    found = (fitted(moments, pair, start, gate=gate) for pair, start in known.items())
    return [fit for fit in found if fit is not None]


def _one_to_one(fits: list[Fit], sightings: Sightings) -> list[Fit]:
    """Return the fits in which no track has two of one sensor at a time, the best first."""
    partners: dict[tuple[int, int], list[tuple[float, float]]] = {}
    ends = [(sightings.time[rows[0]], sightings.time[rows[-1]]) for rows in sightings.rows]
    kept = []
    for fit in sorted(fits, key=_lack):
        sides = [
            ((own, int(sightings.track_sensor[other])), ends[other])
            for own, other in (fit.pair, fit.pair[::-1])
        ]
        taken = (
            begin < end_of and begin_of < end
            for key, (begin, end) in sides
            for begin_of, end_of in partners.get(key, [])
        )
        if not any(taken):
            for key, extent in sides:
                partners.setdefault(key, []).append(extent)
            kept.append(fit)
    return kept


def _lack(fit: Fit) -> float:
    """Return how badly a pair fits: the less, the longer it does."""
    return fit.cost / fit.moment.size - math.log(fit.moment.size)


def _step(equations: list[tuple[FloatArray, FloatArray]], bias: FloatArray) -> FloatArray:
    """Return by how much biases differ from what they are taken for."""
    precision = 1.0 / np.tile(USUAL_BIASES, bias.shape[0]) ** 2
    matrix, vector = np.diag(precision), -precision * bias.ravel()
    for own, pull in equations:
        matrix, vector = matrix + own, vector + pull
    return np.asarray(np.linalg.solve(matrix, vector)).reshape(bias.shape)


def _costs_at(above: float, looks: Looks, pairs: list[tuple[int, int]]) -> list[float]:
    """Return how far apart pairs are with the best biases where all are so high above ground."""
    sightings = looks.sightings
    bias = np.zeros((sightings.n_sensors, N_BIASES))
    moments = moments_of(looks)
    for _ in range(ROUNDS):
        equations = [held_at(moments, pair, above)[1:] for pair in pairs]
        bias = bias + _step(equations, bias)
        moments = moments_of(replace(looks, sightings=sightings.without(bias)))
    return [held_at(moments, pair, above)[0] for pair in pairs]


def _entered(
    height: FloatArray, fits: list[Fit], sightings: Sightings, moments: Moments
) -> tuple[FloatArray, int]:
    """Return heights of all reports of tracks in pairs, held before and after, and of how many."""
    # Only networks of sensors wait for these imports.
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    n_tracks, pairs = len(sightings.rows), np.array([fit.pair for fit in fits])
    links = coo_matrix((np.ones(len(pairs)), tuple(pairs.T)), shape=(n_tracks, n_tracks))
    objects = connected_components(links, directed=False)[1]
    numbers = np.unique(objects[pairs[:, 0]])
    for number in numbers:
        own = [fit for fit in fits if objects[fit.pair[0]] == number]
        weight = np.concatenate([fit.precision for fit in own])
        weighed = weight * np.concatenate([fit.height for fit in own])
        at, place = np.unique(np.concatenate([fit.moment for fit in own]), return_inverse=True)
        mean = np.bincount(place, weighed) / np.bincount(place, weight)
        tracks = np.flatnonzero(objects == number)
        rows = np.concatenate([sightings.rows[track] for track in tracks])
        height[rows] = np.interp(sightings.time[rows], moments.begin + moments.step * at, mean)
    return height, numbers.size
