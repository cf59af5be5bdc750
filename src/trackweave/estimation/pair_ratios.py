"""How far apart two reports of one object are, learned from all pairs: their correlation.

Two unrelated reports are as far apart in space and time as chance puts them. Where there are many
times as many pairs, these are of one object each: that knows how noisy reports are, how often they
come and how fast objects are, without any of it being told.

After M. S. Bartlett, "The spectral analysis of two-dimensional point processes", Biometrika 51,
1964, and B. D. Ripley, "Modelling spatial patterns", J. R. Statist. Soc. B 39, 1977, where space
and time are parted.
"""

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.estimation.trees import ball_volume

__all__ = ["ratio_of_pairs"]

# From so many reports all pairs are counted, by how far apart they are in so many steps.
SOURCES, DISTANCES, WAITS = 400, 24, 32
# A ratio of few pairs is that of chance.
BY_CHANCE = 0.3
# What is nearer than all but this share of the pairs is counted together.
NEAREST = 0.01


def ratio_of_pairs(
    reports: tuple[FloatArray, FloatArray, FloatArray],
    pairs: tuple[IntArray, IntArray],
    density: float,
) -> tuple[FloatArray, FloatArray]:
    """Return of each pair how many times as many there are as chance makes, and how far apart.

    Parameters
    ----------
    reports
        Times [s], in order, shape (reports,); places [m], shape (reports, dim); and how fast what
        was reported went [m/s], of the same shape: the later report of a pair is as far off as it
        is from where that leads. NaN where unknown: of such pairs the ratio is 0.
    pairs
        Rows of the earlier and of the later reports.
    density
        Of the reports, per m² (m³) and second.

    Returns
    -------
    Ratios and distances [m], shape (pairs,); 0 and NaN of what nothing leads to.
    """
    time, position, velocity = reports
    known = np.flatnonzero(np.isfinite(velocity[:, 0]))
    apart, wait = _between(reports, *pairs)
    is_known = np.isfinite(apart)
    ratio = np.zeros(apart.size)
    if not is_known.any():
        return ratio, apart
    most = 2.0 * float(np.linalg.norm(np.ptp(position, axis=0)))
    distances = _steps(apart[is_known], most, DISTANCES)
    waits = _steps(wait, float(np.ptp(time)), WAITS)
    shape = distances.size + 1, waits.size + 1
    sources = known[np.linspace(0, known.size - 1, min(SOURCES, known.size)).astype(np.int64)]
    found = np.zeros(shape[0] * shape[1])
    for source in sources.tolist():
        later = np.arange(np.searchsorted(time, time[source], side="right"), time.size)
        rows, columns = (
            np.searchsorted(edges, each)
            for edges, each in zip(
                (distances, waits),
                _between(reports, np.full_like(later, source), later),
                strict=True,
            )
        )
        found += np.bincount(rows * shape[1] + columns, minlength=found.size)
    left = time[-1] - time[sources]
    until = np.minimum(left[:, None], np.r_[0.0, waits, np.inf])
    volumes = ball_volume(np.r_[0.0, distances, 2.0 * most], position.shape[1])
    by_chance = density * np.outer(np.diff(volumes), np.diff(until, axis=1).sum(axis=0))
    ratios = (_smooth(found.reshape(shape)) + BY_CHANCE) / (_smooth(by_chance) + BY_CHANCE)
    where = np.searchsorted(distances, apart[is_known]), np.searchsorted(waits, wait[is_known])
    ratio[is_known] = ratios[where]
    return ratio, apart


def _between(
    reports: tuple[FloatArray, FloatArray, FloatArray], before: IntArray, behind: IntArray
) -> tuple[FloatArray, FloatArray]:
    """Return how far later reports are from where the earlier lead, and how long after them."""
    time, position, velocity = reports
    wait = time[behind] - time[before]
    lead = position[before] + velocity[before] * wait[:, None]
    return np.linalg.norm(position[behind] - lead, axis=1), wait


def _steps(typical: FloatArray, most: float, count: int) -> FloatArray:
    """Return edges from what is near to the most there is, evenly by their logarithms."""
    above = typical[typical > 0]
    least = float(np.quantile(above, NEAREST)) if above.size else most
    return np.geomspace(max(least, 1e-9 * most), most, count + 1)


def _smooth(counts: FloatArray) -> FloatArray:
    """Return counts in which each is shared with its neighbours."""
    for axis in (0, 1):
        wider = np.pad(counts, [(1, 1) if axis == each else (0, 0) for each in (0, 1)], "edge")
        before, after = np.delete(wider, [-2, -1], axis), np.delete(wider, [0, 1], axis)
        counts = (before + 2.0 * counts + after) / 4.0
    return counts
