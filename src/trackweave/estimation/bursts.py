"""Frames whose reports carry their own times: a crowd of them, then none until the next."""

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.estimation.steady_turn import settled_rate
from trackweave.estimation.trees import tree_of

__all__ = ["bursts_of", "slices_of"]

# There are so many bursts at least, and so many times of reports to each.
FEWEST, LEAST_TIMES = 10, 1.2
# Nearly all reports are of some that last for no more than this share of the time from one to the
# next; and gaps between them are so many times as long as those inside.
NEARLY_ALL, LONGEST, CLEARLY = 0.95, 0.5, 2.0
# They come in step: so many begin this near to a whole number of periods after the one before. Or
# they are short, of so many times on average, and that varies no more than chance would have it.
IN_STEP, NEAR = 0.9, 0.15
SHORT, MANY, VARIED = 0.25, 3.0, 1.5
# Where stragglers fill gaps, periods are those between gaps longer than these shares of all; the
# first so many reports tell them, and so much of a period before most a burst has begun.
GAPS_TRIED, FIRST, STRAGGLE = (0.5, 0.8, 0.9, 0.95, 0.98, 0.99, 0.995), 60, 0.1
# Slices of one look are parted by gaps so many times as short as those between looks; what is
# nearest a report is of its own slice, but for this part of what chance would make otherwise.
PASSES, APART, FEWEST_NEAR = 30.0, 0.7, 30
# So many ways are tried to part gaps into those inside and those between.
WAYS = 60


def bursts_of(time: FloatArray) -> tuple[IntArray, float] | None:
    """Return the number of each report's burst, and how long nearly all bursts last [s].

    A camera or an array of microphones looks at one time, but what it tells is stamped one after
    the other: taken by their times alone its reports would be frames of one each, and all else
    missed in each.

    Parameters
    ----------
    time
        Of the reports [s], ascending.

    Returns
    -------
    None where times do not come in bursts as frames do.
    """
    moments = np.unique(time)
    gaps = np.diff(moments)
    if moments.size < FEWEST * LEAST_TIMES:
        return None
    best, widest = None, CLEARLY
    for limit in np.geomspace(gaps.min(), gaps.max(), WAYS)[:-1]:
        between = np.flatnonzero(gaps > limit)
        inside = gaps[gaps <= limit]
        if between.size + 1 < FEWEST or moments.size < LEAST_TIMES * (between.size + 1):
            continue
        ratio = float(gaps[between].min() / inside.max())
        if ratio > widest and _are_frames(moments, between):
            best, widest = between, ratio
    if best is None:
        return _in_step(time, moments)
    begins = moments[np.r_[0, best + 1]]
    lasting = moments[np.r_[best, moments.size - 1]] - begins
    number = np.searchsorted(begins, time, side="right") - 1
    return number, float(np.quantile(lasting, NEARLY_ALL))


def slices_of(time: FloatArray, position: FloatArray) -> tuple[IntArray, float] | None:
    """Return the number of each report's look, and how long looks last at most [s].

    What a satellite sees as it passes comes in slices along its way, each with its own time. Taken
    by their times these would be scans seconds apart of all that is covered.

    Parameters
    ----------
    time
        Of the reports [s], in any order.
    position
        Theirs [m], shape (reports, dim).

    Returns
    -------
    None where reports of some times close together are not of one place each.
    """
    moments = np.unique(time)
    gaps = np.sort(np.diff(moments))
    if moments.size < FEWEST:
        return None
    wider = gaps[1:] / gaps[:-1]
    widest = int(np.argmax(wider))
    between = np.flatnonzero(np.diff(moments) > gaps[widest])
    if wider[widest] < PASSES or not FEWEST <= between.size + 1 <= moments.size / LEAST_TIMES:
        return None
    begins, ends = moments[np.r_[0, between + 1]], moments[np.r_[between, moments.size - 1]]
    number = np.searchsorted(begins, time, side="right") - 1
    if not _are_apart(number, np.searchsorted(moments, time), position):
        return None
    return number, float(np.max(ends - begins))


def _are_apart(look: IntArray, moment: IntArray, position: FloatArray) -> bool:
    """Tell whether what is nearest a report in its look is of the same moment."""
    n_near, n_same, by_chance = 0, 0, 0.0
    for number in np.unique(look):
        rows = np.flatnonzero(look == number)
        own = moment[rows]
        if np.unique(own).size < 2:
            continue
        near = tree_of(position[rows]).query(position[rows], k=2)[1][:, 1]
        alike = np.count_nonzero(own[:, None] == own, axis=1) - 1
        n_near += int(np.count_nonzero(alike))
        n_same += int(np.count_nonzero(own[near] == own))
        by_chance += float(np.sum(alike)) / (rows.size - 1)
    return n_near >= FEWEST_NEAR and n_near - n_same < APART * (n_near - by_chance)


def _in_step(time: FloatArray, moments: FloatArray) -> tuple[IntArray, float] | None:
    """Return the same where stragglers fill gaps, but nearly all keep to a part of a period."""
    gaps = np.diff(moments)
    tried = 0.0
    for limit in np.quantile(gaps, GAPS_TRIED):
        begins = moments[np.r_[True, gaps > limit]]
        period = float(np.median(np.diff(begins))) if begins.size > FEWEST else 0.0
        if period <= 0.0 or abs(period - tried) < NEAR * period:
            continue
        tried = period
        found = _folded(time, period)
        if found is None:
            continue
        n_bursts = np.unique(found[0]).size
        if n_bursts >= FEWEST and time.size > MANY * n_bursts:
            return found
    return None


def _folded(time: FloatArray, period: float) -> tuple[IntArray, float] | None:
    """Return each report's number and how long bursts last that come about each period."""
    elapsed = time - time[0]
    first = max(FIRST, int(np.searchsorted(elapsed, FEWEST * period)))
    rate = 2.0 * np.pi / period
    settled = settled_rate(elapsed, np.zeros_like(elapsed), rate, min(first, elapsed.size))
    if settled is None or not abs(settled[0] / rate - 1.0) < NEAR:
        return None
    turned = settled[0] * elapsed / (2.0 * np.pi)
    phase = np.sort(turned % 1.0)
    ahead = np.r_[phase, phase + 1.0]
    span = ahead[np.arange(phase.size) + int(NEARLY_ALL * phase.size)] - phase
    if span.min() > LONGEST:
        return None
    # They end where for longest hardly any comes: a straggler is of the burst before.
    begin = float(phase[np.argmin(span)])
    number = np.floor(turned - begin + STRAGGLE).astype(np.int64)
    return number - number.min(), float(span.min()) * 2.0 * np.pi / settled[0]


def _are_frames(moments: FloatArray, between: IntArray) -> bool:
    """Tell whether bursts, the gaps between which are given, are those of one that looks."""
    begins, ends = moments[np.r_[0, between + 1]], moments[np.r_[between, moments.size - 1]]
    apart = np.diff(begins)
    usual = float(np.median(apart))
    count = np.diff(np.r_[-1, between, moments.size - 1])
    lasting = float(np.quantile(np.repeat(ends - begins, count), NEARLY_ALL))
    if lasting > LONGEST * usual:
        return False
    steps = apart / usual
    near = np.abs(steps - np.round(steps)) < NEAR * np.maximum(np.round(steps), 1.0)
    if np.mean(near & (steps > 0.5)) >= IN_STEP:
        return True
    # Passes of a satellite that hears ships again and again are of any number of reports.
    usual_count = float(np.mean(count))
    is_steady = usual_count > MANY and np.var(count) < VARIED * usual_count
    return lasting < SHORT * usual and bool(is_steady)
