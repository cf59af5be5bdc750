"""What a track's reports say of those between them, and whose noise is far beyond that of most."""

import numpy as np
from numpy.typing import NDArray

from trackweave.arrays import FloatArray
from trackweave.chi_squared import quantile_of

__all__ = [
    "LONGEST_SPAN",
    "beside_neighbours",
    "expected_of",
    "is_as_most",
    "noise_beside_curves",
    "noises_of_chains",
]

# Neighbours are no farther apart than so many usual intervals.
LONGEST_SPAN = 6.0
# Noise so many times that of most chains is a bad transponder's: azimuths make it two or three
# times as large far out as it is in the middle.
WILD = 4.0
# … where so many reports tell: one has two before it and two after.
FEWEST = 6


def is_as_most(time: FloatArray, place: FloatArray) -> NDArray[np.bool_]:
    """Tell which chains are not far noisier than most, or too short to tell."""
    # Chains as in ``noise_of_chains``.
    noise = noises_of_chains(time, place)
    told = noise[np.isfinite(noise)]
    most = float(np.median(told)) if told.size else np.inf
    return ~(noise > WILD * most)


def noise_beside_curves(time: FloatArray, place: FloatArray) -> float:
    """Return the standard deviation of chains' reports along an axis [m], whatever the turns."""
    # Chains as in ``noise_of_chains``; 0 where all are too short to tell.
    noise = noises_of_chains(time, place)
    told = noise[np.isfinite(noise)]
    if not told.size:
        return 0.0
    return float(np.sqrt(np.mean(told**2) / quantile_of(place.shape[2], 0.5)))


def noises_of_chains(time: FloatArray, place: FloatArray) -> FloatArray:
    """Return how far off each chain's reports are [m], as a median; NaN where too few tell."""
    # Beside the curve through two reports before and two after neither a turn nor a change of
    # speed leaves anything, as it does beside a filter.
    noise = np.full(time.shape[0], np.nan)
    for row in range(time.shape[0]):
        is_report = np.isfinite(time[row])
        own, where = time[row, is_report], place[row, is_report]
        if own.size < FEWEST:
            continue
        curve, known = expected_of(own, where)[-1]
        off = np.linalg.norm(where[2:-2] - curve, axis=1) / np.sqrt(1.0 + known)
        noise[row] = np.median(off)
    return noise


def beside_neighbours(time: FloatArray, place: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return places of reports, and how far they lie off the curve through their neighbours."""
    # The curve is that through the two before and the two after, and distances are as those of a
    # single report from where it should be; those among long pauses are left out.
    apart = np.flatnonzero(np.diff(time, prepend=-np.inf) > 1e-6)
    time, place = time[apart], place[apart]
    if time.size < FEWEST - 1:
        return np.empty((0, place.shape[1])), np.empty((0, place.shape[1]))
    curve, known = expected_of(time, place)[-1]
    near = time[4:] - time[:-4] < LONGEST_SPAN * float(np.median(np.diff(time)))
    middle = place[2:-2][near]
    return middle, (middle - curve[near]) / np.sqrt(1.0 + known[near])[:, None]


def expected_of(time: FloatArray, place: FloatArray) -> list[tuple[FloatArray, FloatArray]]:
    """Return where neighbours say that reports are, several ways, and how exactly."""
    # Two of them, straight, or all four, by the curve through them, as an object that turns goes;
    # with the variance of each as a share of one report's. One that is off itself spoils some.
    n = time.size
    at = {step: time[2 + step : n - 2 + step] for step in (-2, -1, 0, 1, 2)}
    of = {step: place[2 + step : n - 2 + step] for step in (-2, -1, 1, 2)}
    ways = []
    for used in ((-1, 1), (-2, 1), (-1, 2), (-2, 2), (-2, -1, 1, 2)):
        expected, known = np.zeros_like(of[1]), np.zeros(n - 4)
        for one in used:
            weight = np.ones(n - 4)
            for other in used:
                if other != one:
                    weight = weight * (at[0] - at[other]) / (at[one] - at[other])
            expected += weight[:, None] * of[one]
            known += weight**2
        ways.append((expected, known))
    return ways
