"""Whether reports in no track lie as false alarms do."""

import numpy as np
from numpy.typing import NDArray

from trackweave.run.diagnostics.case import Case

__all__ = ["is_random"]

# Where fewer than one report in so many is in a track, there is none to judge by.
HARDLY_ANY = 10
MOST_REPORTS = 1500
# Two are near one another where noise puts two reports of what is as fast as most tracks.
SIGMAS = 4.0
# So many standard deviations more pairs than by chance, and this share of the reports in them,
# are objects.
DEVIATIONS, SHARE = 4.0, 0.1


def is_random(case: Case) -> bool:
    """Tell whether reports in no track follow on one another no more often than by chance."""
    left = case.track < 0
    if (len(case.reports) - np.count_nonzero(left)) * HARDLY_ANY < len(case.reports):
        return False
    speeds = [float(np.median(path.speed)) for path in case.paths]
    fast = float(np.quantile(speeds, 0.75)) if speeds else 0.0
    return not any(
        _follow_on(case, index, left[rows], fast)
        for index, rows in enumerate(case.rows)
        if index in case.examined and case.tells_place(index)
    )


def _follow_on(case: Case, index: int, left: NDArray[np.bool_], speed: float) -> bool:
    """Tell whether a sensor's reports in no track follow on one another as objects' do."""
    own = case.rows[index][left]
    own = own[np.argsort(case.reports.time[own], kind="stable")][:MOST_REPORTS]
    time, place = case.reports.time[own], case.position[own]
    moments = np.unique(case.reports.time[case.rows[index]])
    if own.size < HARDLY_ANY or moments.size < HARDLY_ANY:
        return False
    period = case.sensors[index].scan_period or float(np.median(np.diff(moments)))
    wait = time[None, :] - time[:, None]
    reach = SIGMAS * case.plane_sigma(index) + speed * period
    is_next = (wait > 0.5 * period) & (wait < 1.5 * period)
    low, high = place.min(axis=0), place.max(axis=0)
    counts = []
    for mirrored in ((), (0,), (1,), (0, 1)):
        other = place.copy()
        for axis in mirrored:
            other[:, axis] = low[axis] + high[axis] - other[:, axis]
        apart = np.linalg.norm(place[:, None] - other[None, :], axis=2)
        counts.append(int(np.count_nonzero(is_next & (apart < reach))))
    chance = float(np.mean(counts[1:]))
    more = counts[0] - chance
    return bool(more > max(DEVIATIONS * np.sqrt(chance + 1.0), SHARE * own.size))
