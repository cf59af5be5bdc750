"""False alarms that come again at their place from scan to scan, as those of the sea do."""

from collections.abc import Sequence

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.association._nodes import ScanInput
from trackweave.models.sensors import Sensor

__all__ = ["last_scans", "repeats"]

NEAREST = 4
"""Of so many reports of the scan before each may be the same false alarm."""
SOONEST, LATEST = 0.5, 1.5
"""It comes again after so many scan periods."""


def last_scans(time: float, scans: Sequence[ScanInput], period: float | None) -> list[ScanInput]:
    """Return of a sensor's scans those in which false alarms at a time may have been before."""
    told = [each for each in scans if each.is_located and each.time < time and each.slot.size]
    if period is None:
        return told[-1:]
    # Sectors of a turn are scans of their own, and last for a part of it.
    return [each for each in told if time - each.time < (LATEST + 1.0) * period]


def repeats(scan: ScanInput, before: Sequence[ScanInput], sensor: Sensor) -> FloatArray:
    """Return by how much each report is likelier as a false alarm that came again [nats].

    Parameters
    ----------
    scan
        The scan.
    before
        The sensor's scans before it, as ``last_scans`` returns them.
    sensor
        The sensor; what counts is its ``clutter_persistence`` and its clutter.

    Returns
    -------
    The logarithm of how many times as dense false alarms are at each report if those of the scan
    before come again, as they are without; at least 0, shape (reports,).
    """
    count = scan.slot.shape[0]
    if not count or not before or not scan.is_located:
        return np.zeros(count)
    # Sensors without such false alarms need not wait for the import.
    from scipy.spatial import KDTree

    place, spread, moment = (
        np.concatenate([getattr(each, name) for each in before])
        for name in ("position", "position_covariance", "moment")
    )
    nearest = min(NEAREST, place.shape[0])
    at = KDTree(place).query(scan.position, k=nearest)[1].reshape(count, nearest)
    aside = scan.position[:, None] - place[at]
    both = scan.position_covariance[:, None] + spread[at]
    square = np.einsum("kni,knij,knj->kn", aside, np.linalg.inv(both), aside)
    density = np.exp(-0.5 * square) / np.sqrt(np.linalg.det(2.0 * np.pi * both))
    if sensor.scan_period is not None:
        waited = (scan.moment[:, None] - moment[at]) / sensor.scan_period
        density[(waited < SOONEST) | (waited > LATEST)] = 0.0
    volume = scan.measurement[:, 0] if sensor.measurement.has_range else np.ones(count)
    gathered = sensor.false_alarms(scan.position[:, :2], volume)
    # What is the same false alarm is as strong again: its strength says nothing a second time.
    strong = np.maximum(scan.evidence + np.log(gathered), 0.0)
    again = sensor.clutter_persistence * density.sum(axis=1) * np.exp(scan.log_begin + strong)
    repeat: FloatArray = np.log1p(again / (sensor.clutter_density * gathered))
    return repeat
