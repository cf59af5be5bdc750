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
from trackweave.estimation.common_objects import objects_of
from trackweave.estimation.sightings import (
    AZIMUTH,
    CLOCK,
    N_BIASES,
    RANGE,
    USUAL_BIASES,
    Sightings,
)

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


@dataclass(frozen=True, eq=False)
class Registered:
    """Biases of sensors, shape (sensors, 4)."""

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


def registered(sightings: Sightings, may: NDArray[np.bool_], fastest: float) -> Registered:
    """Return the biases that reports of common objects show."""
    # Association and biases by turns: at first as uncertain as beforehand, then as known. ``may``
    # are the biases that are looked for, shape (sensors, 4), ``fastest`` the greatest speed [m/s].
    prior = _prior(sightings, fastest)
    precision = np.where(may, 1.0 / prior**2, PINNED / prior**2).ravel()
    bias, covariance = np.zeros(may.shape), np.diag(1.0 / precision)
    objects, longer = None, 1.0
    for _ in range(MOST_ROUNDS):
        again = objects_of(sightings, bias, covariance, fastest)
        before, pieces = bias, pieces_of(sightings, again, longer)
        n_objects = int(pieces.object.max(initial=-1)) + 1
        if n_objects < FEWEST_OBJECTS:
            return _nothing(may, f"only {n_objects} objects are seen by several sensors at a time")
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
        return registered(sightings, may & ~_clocks(may, untold), fastest)
    moved = np.abs(bias - before).ravel() / np.sqrt(np.diagonal(covariance))
    if scale > WORST_SCALE or inflation > WORST_INFLATION or moved.max() > 1.0:
        return _nothing(may, "no biases make what the sensors see agree")
    matrix = equations.matrix / inflation
    vector = equations.vector / inflation + matrix @ bias.ravel()
    noise = np.repeat(_noise(sightings, pieces), N_BIASES)
    found = _believed((matrix, vector), prior.ravel(), may.ravel(), equations.size / noise)
    return Registered(
        bias=found[0].reshape(may.shape),
        likely=found[1].reshape(may.shape),
        sigma=found[2].reshape(may.shape),
        covariance=found[3],
        n_objects=n_objects,
        n_reports=pieces.row.size,
        scale=inflation,
    )


def _clocks(may: NDArray[np.bool_], sensors: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return which numbers are the clocks of some sensors, in the shape of ``may``."""
    clocks = np.zeros_like(may)
    clocks[sensors, CLOCK] = True
    return clocks


def _prior(sightings: Sightings, fastest: float) -> FloatArray:
    prior = np.tile(USUAL_BIASES, (sightings.n_sensors, 1))
    shift = fastest * float(sightings.period.max())
    for number in (RANGE, AZIMUTH):
        prior[~sightings.is_polar, number] = shift
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
