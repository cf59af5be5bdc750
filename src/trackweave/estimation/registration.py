"""Biases of sensors from what several of them saw of the same objects."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trackweave.arrays import FloatArray
from trackweave.estimation.bias_choice import chosen, conditional
from trackweave.estimation.bias_equations import (
    Equations,
    Pieces,
    equations_of,
    feigned_of,
    pieces_of,
    weights_of,
)
from trackweave.estimation.clocks_apart import clocks_apart
from trackweave.estimation.common_objects import objects_of
from trackweave.estimation.displaced import displaced
from trackweave.estimation.sightings import (
    CLOCK,
    EAST,
    N_BIASES,
    NORTH,
    USUAL_BIASES,
    Sightings,
)
from trackweave.estimation.turned_apart import turned_apart

__all__ = ["Registered", "registered"]

MOST_ROUNDS, MOST_STEPS, SETTLED = 8, 8, 0.02
# How many times as sure it is beforehand that there is no bias that is not looked for.
PINNED = 1e12
# So many objects tell something of biases, if most reports lie so many times as far off as
# expected at most.
FEWEST_OBJECTS, WORST_SCALE = 6, 2.0
# Objects contradict one another if biases are so many times less sure than reports by themselves
# would make them.
WORST_INFLATION = 6.0
# Pieces are longer where more than this share of what tells of clocks is noise; a clock of which
# so much is nothing tells.
NOISY, FEIGNED, LONGEST = 0.05, 0.2, 4.0
# A bias is believed so many standard deviations from none, and corrected where it moves reports
# by such a share of their noise.
CLEAR, WORTH = 4.0, 0.2
# A number that is surer than beforehand by less than this factor is not told.
TOLD = 0.5
# A sensor that measures ranges may stand elsewhere than told by this share of its usual distance.
ELSEWHERE = 0.02
# One may where its tracks are so many times as seldom those of others, too, as the best one's.
LONELY = 0.5


@dataclass(frozen=True, eq=False)
class Registered:
    """Biases of sensors, shape (sensors, 6)."""

    # What is to be taken out of reports: 0 where nothing is.
    bias: FloatArray
    # What reports say of each number if it may be other than 0 beside ``bias``, and how sure that
    # is; infinite where they say nothing.
    likely: FloatArray
    sigma: FloatArray
    covariance: FloatArray  # Of ``bias`` raveled, 0 where it is 0
    n_objects: int  # Seen by several sensors
    n_reports: int  # Of them
    doubt: str = ""  # Why nothing was looked for, where it was not
    scale: float = 1.0  # Factor on covariances that objects turned out to need


@dataclass(frozen=True, eq=False)
class _Agreed:
    """Objects and biases that make what sensors saw agree."""

    may: NDArray[np.bool_]  # The biases that were looked for
    prior: FloatArray
    pieces: Pieces
    bias: FloatArray
    equations: Equations
    inflation: float

    @property
    def matrix(self) -> FloatArray:
        """Of the normal equations, raveled."""
        return self.equations.matrix / self.inflation

    @property
    def vector(self) -> FloatArray:
        """Their right side about no bias."""
        return self.equations.vector / self.inflation + self.matrix @ self.bias.ravel()


def registered(sightings: Sightings, may: NDArray[np.bool_], fastest: float) -> Registered:
    """Return the biases that reports of common objects show."""
    # ``may`` are the biases that are looked for, shape (sensors, 6), ``fastest`` the greatest
    # speed [m/s]. Who measures ranges stands where it is told to, unless that explains less.
    moved = np.zeros_like(may)
    moved[:, [EAST, NORTH]] = sightings.is_polar[:, None]
    moved &= may
    agreed = _agreed(sightings, may & ~moved, fastest)
    if isinstance(agreed, str) and (start := clocks_apart(sightings, may))[0].any():
        agreed = _agreed(sightings, may & ~moved, fastest, start)
    if isinstance(agreed, str) or _is_lonely(agreed, sightings):
        start = turned_apart(sightings, may)
        turned = _agreed(sightings, may & ~moved, fastest, start) if start[0].any() else ""
        agreed = agreed if isinstance(turned, str) else turned
    if moved.any() and _is_in_doubt(agreed, sightings, moved):
        # Near by it is found as other biases are, far off by the ways of objects.
        for far in (np.zeros(may.shape), displaced(sightings, moved)):
            elsewhere = _agreed(sightings, may, fastest, (far, np.inf))
            if not isinstance(elsewhere, str) and _stands_elsewhere(elsewhere, moved):
                agreed = elsewhere
                break
    if isinstance(agreed, str):
        return _nothing(may, agreed)
    noise = np.repeat(_noise(sightings, agreed.pieces), N_BIASES)
    found = _believed(
        (agreed.matrix, agreed.vector),
        agreed.prior.ravel(),
        agreed.may.ravel(),
        agreed.equations.size / noise,
    )
    return Registered(
        bias=found[0].reshape(may.shape),
        likely=found[1].reshape(may.shape),
        sigma=found[2].reshape(may.shape),
        covariance=found[3],
        n_objects=int(agreed.pieces.object.max()) + 1,
        n_reports=agreed.pieces.row.size,
        scale=agreed.inflation,
    )


def _is_in_doubt(agreed: _Agreed | str, sightings: Sightings, moved: NDArray[np.bool_]) -> bool:
    """Tell whether a sensor may stand elsewhere than told."""
    if isinstance(agreed, str) or _stands_elsewhere(agreed, moved):
        return True
    return _is_lonely(agreed, sightings)


def _is_lonely(agreed: _Agreed, sightings: Sightings) -> bool:
    """Tell whether hardly a track of some sensor is where the others' are."""
    every = np.bincount(sightings.sensor, minlength=sightings.n_sensors)
    paired = np.bincount(sightings.sensor[agreed.pieces.row], minlength=sightings.n_sensors)
    share = paired[every > 0] / every[every > 0]
    return bool(share.min() < LONELY * share.max())


def _stands_elsewhere(agreed: _Agreed, moved: NDArray[np.bool_]) -> bool:
    """Tell whether some of the biases are part of the best explanation, if they are allowed."""
    found = chosen(
        agreed.matrix, agreed.vector, agreed.prior.ravel(), (agreed.may | moved).ravel()
    )
    return bool(found.is_free[moved.ravel()].any())


def _agreed(
    sightings: Sightings,
    may: NDArray[np.bool_],
    fastest: float,
    start: tuple[FloatArray, FloatArray | float] | None = None,
) -> _Agreed | str:
    """Return objects and biases that agree, or why none do."""
    # Association and biases by turns: at first as uncertain as beforehand, then as known. A
    # ``start`` is about which biases, and how far off these are at most.
    usual = _prior(sightings, fastest)
    bias, sure = (np.zeros(may.shape), np.inf) if start is None else start
    prior = np.maximum(usual, np.abs(bias))
    precision, covariance = (
        np.where(may, 1.0 / each**2, PINNED / each**2).ravel()
        for each in (prior, np.minimum(usual, sure))
    )
    covariance = np.diag(1.0 / covariance)
    objects, longer = None, 1.0
    for _ in range(MOST_ROUNDS):
        again = objects_of(sightings, bias, covariance, fastest)
        before, pieces = bias, pieces_of(sightings, again, longer)
        n_objects = int(pieces.object.max(initial=-1)) + 1
        if n_objects < FEWEST_OBJECTS:
            return f"only {n_objects} objects are seen by several sensors at a time"
        bias, equations, scale = _fitted(sightings, pieces, bias, precision)
        inflation = _inflation(equations, pieces, precision)
        covariance = np.linalg.inv(equations.matrix / inflation + np.diag(precision))
        feigned = feigned_of(sightings, pieces, bias, equations)
        noisy = feigned.max() > NOISY and longer < LONGEST
        if objects is not None and not noisy and np.array_equal(again, objects):
            break
        objects, longer = again, 2.0 * longer if noisy else longer
    untold = feigned > FEIGNED
    if np.any(untold & may[:, CLOCK]):
        return _agreed(sightings, may & ~_clocks(may, untold), fastest, start)
    moved = np.abs(bias - before).ravel() / np.sqrt(np.diagonal(covariance))
    if scale > WORST_SCALE or inflation > WORST_INFLATION or moved.max() > 1.0:
        return "no biases make what the sensors see agree"
    return _Agreed(may, prior, pieces, bias, equations, inflation)


def _clocks(may: NDArray[np.bool_], sensors: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return which numbers are the clocks of some sensors, in the shape of ``may``."""
    clocks = np.zeros_like(may)
    clocks[sensors, CLOCK] = True
    return clocks


def _prior(sightings: Sightings, fastest: float) -> FloatArray:
    prior = np.tile(USUAL_BIASES, (sightings.n_sensors, 1))
    shift = fastest * float(sightings.period.max())
    for sensor, polar in enumerate(sightings.is_polar):
        distance = sightings.distance[sightings.sensor == sensor]
        far = ELSEWHERE * float(np.median(distance)) if polar and distance.size else shift
        prior[sensor, [EAST, NORTH]] = far
    return prior


def _nothing(may: NDArray[np.bool_], doubt: str) -> Registered:
    none = np.zeros(may.shape)
    return Registered(
        none, none, np.full(may.shape, np.inf), np.zeros((may.size, may.size)), 0, 0, doubt
    )


def _fitted(
    sightings: Sightings, pieces: Pieces, bias: FloatArray, precision: FloatArray
) -> tuple[FloatArray, Equations, float]:
    """Return the bias that explains pieces best, by weighted least squares again and again."""
    weight = np.ones(pieces.row.size)
    size = SETTLED / np.sqrt(precision)
    for _ in range(MOST_STEPS):
        equations = equations_of(sightings, pieces, bias, weight)
        weight, scale = weights_of(pieces, equations.off)
        normal = equations.matrix / scale**2 + np.diag(precision)
        pull = equations.vector / scale**2 - precision * bias.ravel()
        step = np.linalg.solve(normal, pull)
        bias = bias + step.reshape(bias.shape)
        if np.all(np.abs(step) < size):
            break
    equations = equations_of(sightings, pieces, bias, weight)
    return bias, equations, weights_of(pieces, equations.off)[1]


def _inflation(equations: Equations, pieces: Pieces, precision: FloatArray) -> float:
    """Return how many times as uncertain biases are as if all reports erred by themselves."""
    # An object's reports may err together, as in turns: the sums of objects tell how they differ.
    by_object = np.zeros((int(pieces.object.max()) + 1, precision.size))
    np.add.at(by_object, pieces.object, equations.score)
    inverse = np.linalg.inv(equations.matrix + np.diag(precision))
    expected = float(np.einsum("ij,ji->", inverse, equations.matrix))
    return max(1.0, float(np.einsum("oi,ij,oj->", by_object, inverse, by_object)) / expected)


def _noise(sightings: Sightings, pieces: Pieces) -> FloatArray:
    """Return the usual noise of each sensor's reports [m]."""
    row = pieces.row
    sigma = sightings.track_sigma[sightings.track[row]]
    noise = np.hypot(sigma[:, 0], sigma[:, 1] * sightings.distance[row])
    own = [noise[sightings.sensor[row] == sensor] for sensor in range(sightings.n_sensors)]
    return np.array([np.median(each) if each.size else np.inf for each in own])


def _believed(
    equations: tuple[FloatArray, FloatArray],
    prior: FloatArray,
    may: NDArray[np.bool_],
    worth: FloatArray,
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return biases, what is likely of each, how sure that is, and the biases' covariance."""
    # ``worth`` is how many standard deviations of a report a unit of each bias is.
    matrix, vector = equations
    is_free = chosen(matrix, vector, prior, may).is_free
    while is_free.any():
        mean, covariance = conditional(matrix, vector, prior, is_free)
        sigma = np.sqrt(np.diagonal(covariance))
        clear = np.where(is_free, np.abs(mean) / np.maximum(sigma, 1e-300), np.inf)
        small = is_free & (np.abs(mean) * worth < WORTH)
        if clear.min() >= CLEAR and not small.any():
            break
        # The least sure first: the others may be surer without it.
        out = int(np.argmin(np.where(small, 0.0, clear))) if small.any() else int(np.argmin(clear))
        is_free[out] = False
    bias, covariance = conditional(matrix, vector, prior, is_free)
    likely, sigma = bias.copy(), np.sqrt(np.diagonal(covariance))
    for place in np.flatnonzero(may & ~is_free):
        beside = is_free.copy()
        beside[place] = True
        mean, spread = conditional(matrix, vector, prior, beside)
        likely[place], sigma[place] = mean[place], np.sqrt(spread[place, place])
    # Where the reports add next to nothing to what was known beforehand, they do not tell.
    untold = ~may | (~is_free & (sigma > TOLD * prior))
    likely[untold], sigma[untold] = 0.0, np.inf
    return bias, likely, sigma, covariance
