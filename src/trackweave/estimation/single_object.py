"""Whether all that a sensor reports is one object at rest, or slow beside its noise.

Nothing lines up there: as wide as it is spread, so wide is the noise, and reports of a single
object fill their own surroundings as densely as false alarms would.
"""

from dataclasses import dataclass
from statistics import NormalDist

import numpy as np
from numpy.typing import NDArray

from trackweave.arrays import FloatArray, IntArray
from trackweave.chi_squared import quantile_of

__all__ = ["SingleObject", "single_object"]

FEWEST, FEW = 6, 20
# So many of the instants hold a single report, and of all so many may lie far off, where less than
# one in a thousand of noise does.
SINGLE, MOST_WILD, INSIDE = 0.95, 0.15, 0.999
# Along each axis the distribution is the normal one but for so much, and what chance makes of few
# reports (H. W. Lilliefors, 1967; about one normal sample in a thousand is farther off).
# Kurtosis tells two places from one sooner; that of a few is less.
ALIKE, LILLIEFORS, LEAST_KURTOSIS, LESS_OF_FEW = 0.01, 1.2, 1.75, 4.0
# It is likelier than a uniform one by so much for each report [nats]; where reports come as evenly
# as false alarms never do (pauses' deviation over their mean), hardly less likely: few reach less
# far, by about so much beside their number.
LIKELIER, AS_LIKELY, OF_FEW, EVEN = 0.25, 0.1, 10.0, 0.5
# Squares of steps from a report to the next are twice the variance, as those of independent ones
# are, but for so many standard deviations; of few no less than once.
ERRORS, LEAST_RATIO = 3.5, 1.0
# Who moves beside it shows: of so many that lie far off each is near the one before, at less than
# this part of how far any two are apart.
FEW_WILD, NEXT = 4, 0.3
# Of several that report by turns the last few reports hold one that is nearer than those of half
# the recording away do, more often than every second time by so many standard deviations.
LAST, NEARER = 10, 3.0
# Ways are straight lines, and curves of one bend: with so many reports for each number of one, and
# no longer than so many standard deviations.
WAYS, REPORTS_FOR_EACH, FARTHEST = 2, 10, 30.0
MEDIAN_OF_NORMAL = 0.6745
NORMAL = NormalDist()


@dataclass(frozen=True, slots=True, eq=False)
class SingleObject:
    """What reports of a single object tell."""

    own: NDArray[np.bool_]  # Which reports are its, shape (reports,); those of nobody lie far off
    sigma: float  # Their noise along an axis [m]
    speed: float  # The greatest on its way [m/s]


def single_object(time: FloatArray, position: FloatArray) -> SingleObject | None:
    """Return what reports tell of one object that rests, or goes a simple way in their noise.

    Parameters
    ----------
    time
        Of each report [s], ascending, shape (reports,).
    position
        Of each [m], shape (reports, dim).

    Returns
    -------
    None where nearly all reports are not of one such object.
    """
    count = position.shape[0]
    if count < FEWEST or np.unique(time).size < SINGLE * count:
        return None
    # Nothing is further from 0 than 1, so that powers are no greater.
    span = 0.5 * float(np.ptp(time))
    elapsed = (time - time[0]) / span - 1.0
    for degree in range(min(WAYS, count // REPORTS_FOR_EACH) + 1):
        powers = np.vander(elapsed, degree + 1, increasing=True)
        found = _on_way(elapsed, powers, position)
        if found is not None:
            own, residual, way = found
            steps = np.arange(1, degree + 1)[:, None] * way[1:] / span
            velocity = np.vander(elapsed, degree, increasing=True) @ steps
            free = (int(np.count_nonzero(own)) - degree - 1) * position.shape[1]
            sigma = float(np.sqrt(np.sum(residual**2) / free))
            if np.linalg.norm(np.ptp(powers @ way, axis=0)) > FARTHEST * sigma:
                return None  # It lines up.
            return SingleObject(own, sigma, float(np.linalg.norm(velocity, axis=1).max()))
    return None


def _on_way(
    elapsed: FloatArray, powers: FloatArray, position: FloatArray
) -> tuple[NDArray[np.bool_], FloatArray, FloatArray] | None:
    """Return who is on a way of some powers of time, how far off it, and its coefficients."""
    (count, dim), near = position.shape, np.ones(position.shape[0], dtype=np.bool_)
    middle = np.median(position, axis=0)
    if powers.shape[1] > 1:
        middle = powers @ _way(powers, position)
    away = position - middle
    spread = np.median(np.abs(away), axis=0) / MEDIAN_OF_NORMAL
    if not spread.all():
        return None
    if count >= FEW:
        # The middle deviation of fewer tells none from another.
        near = np.sum((away / spread) ** 2, axis=1) < quantile_of(dim, INSIDE)
    n_near = int(np.count_nonzero(near))
    if n_near < max((1.0 - MOST_WILD) * count, FEWEST) or _go_on(position[~near]):
        return None
    pauses = np.diff(elapsed[near])
    is_even = pauses.std() < EVEN * pauses.mean()
    least = AS_LIKELY - OF_FEW / n_near if is_even else LIKELIER
    way = _way(powers[near], position[near])
    away = position[near] - powers[near] @ way
    return (near, away, way) if _is_noise(away, least) else None


def _way(powers: FloatArray, position: FloatArray) -> FloatArray:
    return np.asarray(np.linalg.lstsq(powers, position, rcond=None)[0])


def _is_noise(away: FloatArray, least: float) -> bool:
    """Tell whether what is left of reports, shape (reports, dim), is normal and each its own."""
    sides = float(np.sum(np.log(np.maximum(np.ptp(away, axis=0), 1e-300))))
    variances, ways = np.linalg.eigh(np.atleast_2d(np.cov(away.T)))
    if variances[0] <= 0.0:
        return False
    along = away @ ways / np.sqrt(variances)
    entropy = 0.5 * float(np.sum(np.log(2.0 * np.pi * variances) + 1.0))
    is_alike = sides - entropy > least and _are_normal(along) and _are_white(along)
    return is_alike and not _take_turns(along)


def _go_on(wild: FloatArray) -> bool:
    """Tell whether each of what lies far off is near the one before, as what moves would be."""
    if wild.shape[0] < FEW_WILD:
        return False
    steps = np.linalg.norm(np.diff(wild, axis=0), axis=1)
    apart = np.linalg.norm(wild[:, None] - wild[None], axis=2)[np.triu_indices(wild.shape[0], 1)]
    return bool(np.median(steps) < NEXT * np.median(apart))


def _are_normal(along: FloatArray) -> bool:
    """Tell whether numbers of variance 1, shape (reports, dim), are normal along each axis."""
    count = along.shape[0]
    expected = np.array([NORMAL.cdf(each) for each in np.sort(along, axis=0).ravel().tolist()])
    share = (np.arange(count)[:, None] + 0.5) / count
    off = float(np.abs(expected.reshape(along.shape) - share).max())
    is_peaked = np.mean(along**4, axis=0).min() > LEAST_KURTOSIS - LESS_OF_FEW / count
    return bool(is_peaked and off < ALIKE + LILLIEFORS / np.sqrt(count))


def _are_white(along: FloatArray) -> bool:
    """Tell whether each place is independent of the one before (J. von Neumann's ratio, 1941)."""
    ratio = np.mean(np.diff(along, axis=0) ** 2, axis=0)
    off = ERRORS * 2.0 / np.sqrt(along.shape[0])
    return bool(np.all((ratio > max(2.0 - off, LEAST_RATIO)) & (ratio < 2.0 + off)))


def _take_turns(along: FloatArray) -> bool:
    """Tell whether a report is near one of the last few, as where several report by turns."""
    count = along.shape[0]
    if count < 4 * LAST:
        return False
    every = np.arange(count)
    last = np.min([_apart(along, every - lag) for lag in range(1, LAST + 1)], axis=0)
    far = [_apart(along, every - count // 2 - lag) for lag in range(LAST)]
    nearer = float(np.mean((last < np.min(far, axis=0))[LAST:]))
    return bool(nearer > 0.5 + NEARER * 0.5 / np.sqrt(count - LAST))


def _apart(along: FloatArray, other: IntArray) -> FloatArray:
    return np.asarray(np.linalg.norm(along - along[other], axis=1))
