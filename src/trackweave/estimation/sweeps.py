"""Sweeps of a beam over a sector and back, from when and from where reports came.

Reports of the same moment of a period come from the same direction. Ordered by that moment they
lie on a curve, by any other period they do not: the period is the one with the shortest string
through the reports [1]_.

.. [1] M. M. Dworetsky, A period-finding method for sparse randomly spaced observations, Monthly
   Notices of the Royal Astronomical Society 203, 1983.
"""

import numpy as np

from trackweave.arrays import FloatArray, IntArray

__all__ = ["sweeps_of"]

# The period is found from so many reports, then followed through the others, each time twice as
# many, of which so many are looked at.
FIRST_REPORTS, FEWEST_REPORTS, MOST_REPORTS = 240, 40, 5000
# Where reports are so dense that these are of few sweeps, stretches so many times as long tell.
LONGER = (1, 4, 16, 64)
# The period that is found may be so many of the true one.
MOST_PERIODS = 4
# There are so many sweeps at least in these, and more than so many reports in each.
FEWEST_SWEEPS, LEAST_REPORTS = 4.0, 1.2
# Periods are tried so many to a period over all reports, and near one that is known this far off.
STEPS, NEAR_STEPS, PERIOD_ERROR = 12, 24, 0.1
# The string is so much shorter than by the usual period, though stamps be loose.
SHORT, AS_SHORT = 0.35, 1.2
# A beam that flies back over what it does not see is that far ahead of one that turns [rad].
SOONER = np.pi / 2
# Directions are told apart in so many moments of a period. A beam flies back where nearly all of
# the way back is in so many times fewer of them than nearly all of the way there.
MOMENTS, FLIES_BACK, NEARLY_ALL = 24, 0.5, 0.7
# Where it turns is told to one of so many parts of half a period, by so many reports.
FOLDS, FOLDED = 200, 1000


def sweeps_of(
    time: FloatArray, azimuth: FloatArray, period: float | None = None
) -> tuple[IntArray, float] | None:
    """Return the number of each report's sweep, and how long a sweep takes and the way back [s].

    Parameters
    ----------
    time
        Of the reports [s], ascending.
    azimuth
        From the sensor [rad].
    period
        About how long it takes, where that is known [s].

    Returns
    -------
    None where no beam sweeps so, or it turns round, or too few reports tell.
    """
    elapsed = time - time[0]
    found = _begun(elapsed, azimuth, period)
    if found is None:
        return None
    rate, usual, count = found
    while count < time.size:
        count = min(2 * count, time.size)
        step = 1.0 / (STEPS * float(elapsed[count - 1]))
        near = rate + step * np.arange(-NEAR_STEPS, NEAR_STEPS + 1) / 2
        some = np.linspace(0, count - 1, min(count, MOST_REPORTS)).astype(np.int64)
        lengths = _strings(elapsed[some] * near[:, None] % 1.0, azimuth[some])
        rate = float(near[np.argmin(lengths)])
        if lengths.min() >= SHORT * usual:
            return None
    rate = _shortest(elapsed, azimuth, rate)
    turned = rate * elapsed
    cuts = _cuts(turned % 1.0, azimuth)
    if not cuts.size:
        return None
    begun = np.floor(turned[:, None] - cuts).astype(np.int64).sum(axis=1)
    return begun - begun[0], 1.0 / (rate * cuts.size)


def _begun(
    elapsed: FloatArray, azimuth: FloatArray, period: float | None
) -> tuple[float, float, int] | None:
    """Return sweeps per second, the string by the usual period, and by how many reports."""
    most = FIRST_REPORTS / LEAST_REPORTS
    for longer in LONGER:
        count = min(longer * FIRST_REPORTS, elapsed.size)
        some = np.linspace(0, count - 1, min(count, FIRST_REPORTS)).astype(np.int64)
        rates = _possible_rates(float(elapsed[count - 1]), most, period)
        if some.size < FEWEST_REPORTS or rates.size < 3:
            return None
        lengths = _strings(elapsed[some] * rates[:, None] % 1.0, azimuth[some])
        rate, usual = float(rates[np.argmin(lengths)]), float(np.median(lengths))
        if lengths.min() < SHORT * usual:
            turns = not _cuts(rate * elapsed[some] % 1.0, azimuth[some]).size
            return None if turns else (rate, usual, count)
        if count == elapsed.size:
            return None
        # Of more sweeps in the same time these would have told.
        most = FEWEST_SWEEPS * (LONGER[1] / LONGER[0]) ** 2
    return None


def _shortest(elapsed: FloatArray, azimuth: FloatArray, rate: float) -> float:
    """Return how many periods there are in a second where the one found may be several."""
    some = np.linspace(0, elapsed.size - 1, min(elapsed.size, MOST_REPORTS)).astype(np.int64)
    step = 1.0 / (STEPS * float(elapsed[-1]))
    aside = step * np.arange(-NEAR_STEPS, NEAR_STEPS + 1) / 2
    rates = np.concatenate([times * rate + aside for times in range(1, MOST_PERIODS + 1)])
    lengths = _strings(elapsed[some] * rates[:, None] % 1.0, azimuth[some])
    # By several of a period the string is as short, but for what stamps are off.
    of_each = lengths.reshape(MOST_PERIODS, -1)
    times = int(np.flatnonzero(of_each.min(axis=1) < AS_SHORT * lengths.min())[-1])
    return float(rates.reshape(MOST_PERIODS, -1)[times, np.argmin(of_each[times])])


def _possible_rates(span: float, most: float, period: float | None) -> FloatArray:
    """Return how many periods there may be in a second, at most so many in all of the time."""
    if span <= 0:
        return np.empty(0)
    least = FEWEST_SWEEPS
    if period is not None:
        least, most = span / period * (1 - PERIOD_ERROR), span / period * (1 + PERIOD_ERROR)
    return np.arange(least, most, 1.0 / STEPS) / span


def _strings(moments: FloatArray, azimuth: FloatArray) -> FloatArray:
    """Return how far reports of successive moments are apart in direction, of each row."""
    order = np.argsort(moments, axis=1)
    step = np.diff(azimuth[order], axis=1)
    return np.asarray(np.mean(1.0 - np.cos(step), axis=1))


def _cuts(moment: FloatArray, azimuth: FloatArray) -> FloatArray:
    """Return at which moments of the period, from 0 to 1, sweeps begin: of turns at none."""
    place = np.minimum((MOMENTS * moment).astype(np.int64), MOMENTS - 1)
    weight = np.bincount(place, minlength=MOMENTS)
    beam = np.exp(1j * azimuth)
    total = np.bincount(place, beam.real, MOMENTS) + 1j * np.bincount(place, beam.imag, MOMENTS)
    held = np.flatnonzero(weight)
    way = np.angle(np.roll(total[held], -1) * np.conj(total[held]))
    gap = (np.roll(held, -1) - held - 1) % MOMENTS + 1
    if abs(float(way.sum())) > np.pi:
        # It turns round, unless it is sooner beyond where it sees nothing than a turn would be.
        sooner = np.abs(way) - 2.0 * np.pi * gap / MOMENTS
        last = int(np.argmax(sooner))
        return _amid(held, gap, last) if sooner[last] >= SOONER else np.empty(0)
    sense = 1.0 if np.count_nonzero(way > 0) >= np.count_nonzero(way < 0) else -1.0
    back = np.maximum(-sense * way, 0.0)
    if _steps(back) < FLIES_BACK * _steps(np.maximum(sense * way, 0.0)):
        return _amid(held, gap, int(np.argmax(back)))
    # Folded where it turns, what it sees on both ways lies on one curve.
    turns = np.arange(0.0, 0.5, 0.5 / FOLDS)
    some = np.linspace(0, moment.size - 1, min(moment.size, FOLDED)).astype(np.int64)
    lengths = _strings(np.abs((moment[some] - turns[:, None] + 0.5) % 1.0 - 0.5), azimuth[some])
    turn = turns[np.argmin(lengths)]
    return np.array([turn, turn + 0.5])


def _amid(held: IntArray, gap: IntArray, last: int) -> FloatArray:
    """Return the midst of the moments in which it flies back, where hardly any report comes."""
    return np.array([((held[last] + 0.5 + gap[last] / 2.0) / MOMENTS) % 1.0])


def _steps(way: FloatArray) -> int:
    """Return how many of the longest steps make nearly all of a way."""
    longest = np.cumsum(np.sort(way)[::-1])
    return int(np.searchsorted(longest, NEARLY_ALL * longest[-1])) + 1
