"""What is left of reports once all that is beyond doubt is tracked."""

from dataclasses import replace

import numpy as np

from trackweave.domain.reports import ReportTable
from trackweave.estimation.estimate import WIDER, estimate
from trackweave.estimation.estimates import Estimates, bounded
from trackweave.estimation.refine import Followed, sure_tracks

__all__ = ["unexplained", "with_faster"]


def unexplained(estimates: Estimates, reports: ReportTable, followed: Followed) -> ReportTable:
    """Return the reports on no sure track."""
    is_left = np.ones(len(reports), dtype=bool)
    for track in sure_tracks(estimates, reports, followed):
        is_left[track.rows] = False
    return reports.part(np.flatnonzero(is_left))


def with_faster(estimates: Estimates, left: ReportTable) -> Estimates:
    """Return estimates with the speed of the few among what is left that are faster than all else.

    Where many that are slow are seen by chance, what they leave of themselves hides whoever is
    fast until they are tracked.

    Parameters
    ----------
    estimates
        By which the others were tracked.
    left
        The reports on no sure track.

    Returns
    -------
    The same where none stand out.
    """
    if not len(left):
        return estimates
    sigma = {name: each.plane_sigma for name, each in estimates.sensors.items()}
    looks = {name: each.scans is not False for name, each in estimates.sensors.items()}
    few = estimate(left, sigma, looks).speed_of_few
    if few <= estimates.max_speed:
        return estimates
    return replace(estimates, max_speed=bounded(WIDER * few), speed_of_few=few)
