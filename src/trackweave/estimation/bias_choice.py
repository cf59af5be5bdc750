"""Which sensors have which biases, where the equations alone leave some of that open.

If all clocks are ahead by as much nothing shows it, nor if all positions are shifted. Biases are
taken to be rare: most sensors have none, and who has one may have others. Among explanations the
likeliest is chosen by its evidence, so that one more bias must explain more than chance would.
"""

from collections.abc import Sequence
from itertools import combinations
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from trackweave.arrays import FloatArray
from trackweave.estimation.sightings import EAST, N_BIASES, NORTH, SCALE

__all__ = ["Explanation", "chosen", "conditional"]

# What a sensor with biases costs beforehand, and each of them; a range scale and another place are
# rarer [nats].
A_SENSOR, A_BIAS, A_RARE = 3.0, 1.0, 3.0
RARE = (SCALE, EAST, NORTH)
# Of so many sensors every set is tried; of more, one sensor after another is added or taken away.
MOST_EXHAUSTIVE = 6
# Explanations that differ by less are alike [nats]: then the fewest sensors are corrected, and
# the first by name keep their own.
ALIKE = 1.0


class Explanation(NamedTuple):
    """Some biases that are not 0, and how good an explanation they are."""

    is_free: NDArray[np.bool_]  # Shape (sensors · 6,)
    evidence: float  # [nats], beside no bias at all


def chosen(
    matrix: FloatArray, vector: FloatArray, prior: FloatArray, may: NDArray[np.bool_]
) -> Explanation:
    """Return the explanation to believe."""
    # ``matrix`` and ``vector`` are of the normal equations about no bias, ``prior`` the standard
    # deviations beforehand, and only biases that ``may`` be there are looked at; all raveled.
    found = _likeliest(matrix, vector, prior, may)
    mean = conditional(matrix, vector, prior, found.is_free)[0]
    largest = np.abs(mean).reshape(-1, N_BIASES).max(axis=0)
    wider = np.maximum(prior.reshape(-1, N_BIASES), largest).ravel()
    if np.array_equal(wider, prior):
        return found
    # A bias far larger than usual would cost less if several sensors shared it: once there is one,
    # others of its size are no surprise.
    return _likeliest(matrix, vector, wider, may)


def _likeliest(
    matrix: FloatArray, vector: FloatArray, prior: FloatArray, may: NDArray[np.bool_]
) -> Explanation:
    """Return the explanation of the greatest evidence, the simplest of those alike."""
    n_sensors = may.size // N_BIASES
    if n_sensors <= MOST_EXHAUSTIVE:
        sets = [s for k in range(n_sensors + 1) for s in combinations(range(n_sensors), k)]
        found = [_best_of(s, matrix, vector, prior, may) for s in sets]
    else:
        found = _one_by_one(matrix, vector, prior, may)
    most = max(each.evidence for each in found)
    alike = [each for each in found if each.evidence > most - ALIKE]
    return min(alike, key=lambda each: (len(_sensors(each)), [-s for s in _sensors(each)]))


def conditional(
    matrix: FloatArray, vector: FloatArray, prior: FloatArray, is_free: NDArray[np.bool_]
) -> tuple[FloatArray, FloatArray]:
    """Return the biases that are free with the others 0, and their covariance; 0 elsewhere."""
    free = np.flatnonzero(is_free)
    mean, covariance = np.zeros(is_free.size), np.zeros((is_free.size, is_free.size))
    if free.size:
        precision = matrix[np.ix_(free, free)] + np.diag(1.0 / prior[free] ** 2)
        inverse = np.linalg.inv(precision)
        covariance[np.ix_(free, free)] = inverse
        mean[free] = inverse @ vector[free]
    return mean, covariance


def _sensors(explanation: Explanation) -> list[int]:
    return np.flatnonzero(explanation.is_free.reshape(-1, N_BIASES).any(axis=1)).tolist()


def _best_of(
    sensors: Sequence[int],
    matrix: FloatArray,
    vector: FloatArray,
    prior: FloatArray,
    may: NDArray[np.bool_],
) -> Explanation:
    """Return the best explanation by some sensors: of all their biases what is worth it stays."""
    is_free = np.zeros(may.size, dtype=np.bool_)
    for sensor in sensors:
        is_free[sensor * N_BIASES : (sensor + 1) * N_BIASES] = True
    is_free &= may
    evidence = _evidence(is_free, matrix, vector, prior)
    while is_free.any():
        trials = []
        for place in np.flatnonzero(is_free).tolist():
            without = is_free.copy()
            without[place] = False
            trials.append((_evidence(without, matrix, vector, prior), place))
        better, place = max(trials)
        if better <= evidence:
            break
        is_free[place], evidence = False, better
    return Explanation(is_free, evidence)


def _one_by_one(
    matrix: FloatArray, vector: FloatArray, prior: FloatArray, may: NDArray[np.bool_]
) -> list[Explanation]:
    """Return explanations by more and more sensors, or fewer, each better than the last."""
    every = may.size // N_BIASES
    found = [_best_of((), matrix, vector, prior, may)]
    while True:
        now = set(_sensors(found[-1]))
        trials = [
            _best_of(sorted(now ^ {sensor}), matrix, vector, prior, may) for sensor in range(every)
        ]
        best = max(trials, key=lambda each: each.evidence)
        if best.evidence <= found[-1].evidence:
            return found
        found.append(best)


def _evidence(
    is_free: NDArray[np.bool_], matrix: FloatArray, vector: FloatArray, prior: FloatArray
) -> float:
    """Return the log evidence of biases beside none, with what they cost beforehand."""
    free = np.flatnonzero(is_free)
    if not free.size:
        return 0.0
    # In units of the prior, so that determinants are of numbers of one size.
    size = prior[free]
    scaled = np.eye(free.size) + size[:, None] * matrix[np.ix_(free, free)] * size
    pull = size * vector[free]
    gain = 0.5 * pull @ np.linalg.solve(scaled, pull) - 0.5 * np.linalg.slogdet(scaled)[1]
    n_sensors = np.unique(free // N_BIASES).size
    n_rare = int(np.count_nonzero(np.isin(free % N_BIASES, RARE)))
    cost = A_SENSOR * n_sensors + A_BIAS * (free.size - n_rare) + A_RARE * n_rare
    return float(gain - cost)
