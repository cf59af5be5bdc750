"""Where objects that report themselves stay: ships at their berths that AIS tells of.

What a sensor sees there is no false alarm that comes again, however seldom it sees it.
"""

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.domain.reports import ReportTable
from trackweave.estimation.estimates import Estimates
from trackweave.estimation.trees import all_within, n_within, tree_of

__all__ = ["REACH", "heard_at_rest"]

REACH = 4.0
"""What another sensor sees of it lies so near, in standard deviations of that sensor."""
# Who stays reports so often, over such a part of the time, within so many standard deviations; and
# of what comes twice as near it is such a share, or others pass by.
FEWEST, LASTING, NEAR, OWN = 3, 0.5, 8.0, 0.7


def heard_at_rest(estimates: Estimates, reports: ReportTable) -> FloatArray:
    """Return from which places objects report themselves for most of the time.

    Parameters
    ----------
    estimates
        What is known of sensors: of those that do not look, objects report themselves.
    reports
        All of them, as positions.

    Returns
    -------
    Places [m], shape (places, 2); none where no sensor looks.
    """
    places = []
    looks = any(sensor.scans is not False for sensor in estimates.sensors.values())
    for name, sensor in estimates.sensors.items() if looks else ():
        rows = np.flatnonzero(reports.sensor == reports.sensors.index(name))
        if sensor.scans is not False or rows.size < FEWEST:
            continue
        place, time = reports.measurement[rows][:, :2], reports.time[rows]
        tree, near = tree_of(place), NEAR * sensor.plane_sigma
        count, around = (n_within(tree, place, reach) for reach in (near, 2.0 * near))
        is_free = np.ones(rows.size, dtype=np.bool_)
        for row in np.argsort(-count, kind="stable"):
            if count[row] < FEWEST:
                break
            if not is_free[row]:
                continue
            own = all_within(tree, place[[row]], near)[0]
            is_free[own] = False
            stays = np.ptp(time[own]) >= LASTING * np.ptp(reports.time)
            if stays and count[row] >= OWN * around[row]:
                places.append(np.median(place[own], axis=0))
    return np.array(places).reshape(-1, 2)
