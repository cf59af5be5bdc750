"""Objects that change their names: where one identity ends, another begins."""

import numpy as np

from trackweave.arrays import IntArray
from trackweave.domain.reports import ReportTable
from trackweave.estimation.identities import by_identity

__all__ = ["renaming_share"]

# A name begins anew within so many usual waits, at once or after a short silence, as far off as
# all but a share of steps are fast.
WITHIN, FASTEST = (2.5, 10.0), 0.95
# So many names, and such a share of those that end, go on under another; and so many times as
# many as begin there while the other name is still heard, which doors and quays bring about.
FEWEST, SHARE, BESIDE = 3, 0.3, 3.0
MOST_NAMES = 5000
# Of names that change, some go on as another's where two meet, or after a longer silence: so many
# times as many changes are reckoned with, but for a share of reports at most.
UNSEEN, MOST_CHANGING = 5.0, 0.05


def renaming_share(reports: ReportTable, sensor: int) -> float:
    """Return how often an object's report is under another identity than the one before it.

    Parameters
    ----------
    reports
        Reports of positions.
    sensor
        The sensor's index.

    Returns
    -------
    A share; 0 where chance makes as many names begin where others end.
    """
    if reports.identity is None:
        return 0.0
    rows = by_identity(
        reports, np.flatnonzero((reports.sensor == sensor) & (reports.identity >= 0))
    )
    same = np.diff(reports.identity[rows]) == 0
    wait = np.diff(reports.time[rows])[same]
    step = np.linalg.norm(np.diff(reports.measurement[rows], axis=0)[same], axis=1)
    if not np.any(wait > 0.0):
        return 0.0
    step, wait = step[wait > 0.0], wait[wait > 0.0]
    speed = float(np.quantile(step / wait, FASTEST))
    ends = rows[np.r_[True, ~same]][:MOST_NAMES], rows[np.r_[~same, True]][:MOST_NAMES]
    usual = float(np.median(wait))
    changes = max(_more_after(reports, ends, (within * usual, speed)) for within in WITHIN)
    return min(UNSEEN * changes / rows.size, MOST_CHANGING)


def _more_after(
    reports: ReportTable, ends: tuple[IntArray, IntArray], reach: tuple[float, float]
) -> float:
    """Return at how many names' ends others begin, but for as many as begin before by chance."""
    first, last = ends
    # Who is heard last at the end of the recording goes on under no name.
    last = last[reports.time[last] < reports.time[last].max(initial=-np.inf) - reach[0]]
    after, before = (_n_met(reports, last, first, reach, way) for way in (1, -1))
    is_clear = after >= max(FEWEST, SHARE * last.size, BESIDE * before)
    return float(after - before) if is_clear else 0.0


def _n_met(
    reports: ReportTable, last: IntArray, first: IntArray, reach: tuple[float, float], way: int
) -> int:
    """Count last reports of names that others begin soon after, or with -1 shortly before."""
    # ``reach`` is for how long [s], and the greatest speed [m/s].
    most, speed = reach
    place, met = reports.measurement, 0
    for row in last.tolist():
        wait = way * (reports.time[first] - reports.time[row])
        near = first[(wait > 0.0) & (wait <= most)]
        off = np.linalg.norm(place[near] - place[row], axis=1)
        met += bool(np.any(off <= speed * np.abs(reports.time[near] - reports.time[row])))
    return met
