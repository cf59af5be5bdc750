"""How often false alarms come again at their place: those of the sea last for a scan or two.

Who counts each for itself takes three of them for an object. They show in the pairs of reports at
one place: of one scan and the next there are more than of scans far apart, where what stands and
where false alarms are dense make all the pairs; of a scan and the second next, as many fewer as
hardly any lasts so long. Objects that move are left out beforehand, and what is left of them, or
blinks, does not fall off so fast.
"""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.domain.reports import ReportTable
from trackweave.estimation.estimates import Estimates, SensorEstimate, digits
from trackweave.estimation.refine import Followed, sure_tracks
from trackweave.estimation.trees import n_within, tree_of

__all__ = ["notes_on_persistence", "with_persistence"]

FEWEST_SCANS, FEWEST_PAIRS = 30, 200
"""So many scans tell of it, and so many pairs more than by chance."""
MOVES = 6.0
"""What goes farther than so many standard deviations of the noise is an object that moves."""
REACH = 3.5
"""Reports of one place are no farther apart."""
LAGS = (8, 11, 14, 17, 20)
"""Scans so far apart have no false alarm in common."""
UNLIKE = 0.2
"""What is told and what is seen may differ by so much."""
LEAST_SHARE, MOST = 0.15, 0.6
"""So many come again at least, and of these so many once more at most."""
HIGHEST = 0.9
"""No sensor is taken for one of which more come again."""


def with_persistence(estimates: Estimates, reports: ReportTable, followed: Followed) -> Estimates:
    """Return estimates with the chance that a false alarm comes again in the next scan."""
    sensors = dict(estimates.sensors)
    tracks = [track.rows for track in sure_tracks(estimates, reports, followed)]
    for index, name in enumerate(reports.sensors):
        looks = followed.looks.get(name, np.empty(0))
        if name not in sensors or sensors[name].scans is False or looks.size < FEWEST_SCANS:
            continue
        own = reports.sensor == index
        is_left = own.copy()
        for track in tracks:
            rows = track[own[track]]
            if rows.size and _moves(reports.measurement[rows], sensors[name].plane_sigma):
                is_left[rows] = False
        rows = np.flatnonzero(is_left)
        scan = np.searchsorted(looks, reports.time[rows])
        found = _persistence(sensors[name], reports.measurement[rows], scan, looks.size)
        sensors[name] = replace(sensors[name], clutter_persistence=found)
    return replace(estimates, sensors=sensors)


def notes_on_persistence(estimates: Estimates, told: Mapping[str, float | None]) -> list[str]:
    """Return a sentence on each sensor whose false alarms come again, unless that is told."""
    # ``told`` is its persistence by the sensor's name, None where nobody says it.
    notes = []
    for name, sensor in estimates.sensors.items():
        seen, said = sensor.clutter_persistence, told.get(name)
        if seen == 0.0 or (said is not None and abs(said - seen) < UNLIKE):
            continue
        again = f"{seen:.0%} of its false alarms come again at their place in the next scan"
        notes.append(
            f"sensor {name}: {again}, as those of the sea do (clutter_persistence); what stands "
            "is a track only where that does not explain it as well"
            if said is None
            else f"sensor {name}: clutter_persistence is told as {said:g}, but {again}"
        )
    return notes


def _moves(place: FloatArray, sigma: float) -> bool:
    """Tell whether a track's reports are spread wider than by noise."""
    return float(np.linalg.norm(np.ptp(place, axis=0))) > MOVES * sigma


def _persistence(sensor: SensorEstimate, place: FloatArray, scan: IntArray, n_scans: int) -> float:
    """Return how often reports that are of no moving object come again; 0 for unknown."""
    if place.shape[0] < FEWEST_PAIRS:
        return 0.0
    reach = REACH * sensor.plane_sigma
    far = 4.0 * float(np.ptp(place, axis=0).max()) + 2.0 * reach
    tree = tree_of(np.column_stack([place, far * scan]))

    def pairs(lag: int) -> float:
        """Return the mean number of pairs of a scan and the one so many later."""
        before = np.column_stack([place, far * (scan - lag)])
        return float(n_within(tree, before, reach).sum()) / (n_scans - lag)

    usual = float(np.median([pairs(lag) for lag in LAGS]))
    once, twice = pairs(1) - usual, pairs(2) - usual
    share = once * n_scans / place.shape[0]
    if once * n_scans < FEWEST_PAIRS or share < LEAST_SHARE or twice > MOST * once:
        return 0.0
    if share <= 1.0:
        return digits(min(max(twice / once, share), HIGHEST), 2)
    # Where several lie at a place, each has pairs with all of them: only how they fall off tells.
    return digits(twice / once, 2) if twice >= LEAST_SHARE * once else 0.0
