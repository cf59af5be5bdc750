"""Frames whose reports carry their own times: a crowd of them, then none until the next."""

import numpy as np

from trackweave.arrays import FloatArray, IntArray

__all__ = ["bursts_of"]

# There are so many bursts at least, and so many times of reports to each.
FEWEST, LEAST_TIMES = 10, 1.2
# Nearly all reports are of some that last for no more than this share of the time from one to the
# next; and gaps between them are so many times as long as those inside.
NEARLY_ALL, LONGEST, CLEARLY = 0.95, 0.5, 2.0
# They come in step: so many begin this near to a whole number of periods after the one before. Or
# they are short, of so many times on average, and that varies no more than chance would have it.
IN_STEP, NEAR = 0.9, 0.15
SHORT, MANY, VARIED = 0.25, 3.0, 1.5
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
        return None
    begins = moments[np.r_[0, best + 1]]
    lasting = moments[np.r_[best, moments.size - 1]] - begins
    number = np.searchsorted(begins, time, side="right") - 1
    return number, float(np.quantile(lasting, NEARLY_ALL))


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
