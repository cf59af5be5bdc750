"""What looks wrong with how often sensors scan."""

from collections.abc import Container, Iterable

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.domain.reports import ReportTable
from trackweave.models.sensors import Sensor

__all__ = ["doubts_on_scans"]

# From so many moments on it can be told how a sensor's reports come.
FEWEST_MOMENTS = 10
# Moments this many times nearer than the scan period are within a turn, and this many times
# farther apart more than a miss.
WITHIN_TURN = 1.5


def doubts_on_scans(
    reports: ReportTable,
    sensors: Iterable[Sensor],
    guessed: Container[str],
    turning: Container[str] = (),
) -> list[str]:
    """Return sentences on sensors whose reports come otherwise than their scan period says.

    Parameters
    ----------
    reports
        The reports.
    sensors
        The sensors as they are configured or estimated.
    guessed
        Names of the sensors whose scan period nobody gave.
    turning
        Names of the sensors whose reports are grouped into turns.

    Returns
    -------
    A sentence for each sensor whose reports come one by one, as a rotating one's do, unless the
    table numbers its scans; and for each that has far fewer scans than it should.
    """
    notes = []
    for sensor in sensors:
        if sensor.name in turning or sensor.name not in reports.sensors:
            continue
        number, is_given = reports.sensors.index(sensor.name), sensor.name not in guessed
        times = reports.time[reports.sensor == number]
        moments, sizes = np.unique(times, return_counts=True)
        if moments.size < FEWEST_MOMENTS:
            continue
        gaps = np.diff(moments)
        if reports.scan is None and np.median(sizes) <= 1:
            notes += _on_lone_reports(sensor, sizes, gaps, is_given=is_given)
        if is_given:
            notes += _on_sparse_scans(sensor, float(np.median(gaps)))
    return notes


def _on_lone_reports(
    sensor: Sensor, sizes: IntArray, gaps: FloatArray, *, is_given: bool
) -> list[str]:
    """Return a sentence where scans of one report are pieces of something larger."""
    period = sensor.scan_period
    if is_given:
        if period is None or WITHIN_TURN * float(np.median(gaps)) >= period:
            return []
        but = f"although its scan period is {period:g} s"
    elif period is not None and _is_steady(gaps, period):
        return []
    else:
        but = "and no scan_period is given, so that each is taken for a scan of its own"
    return [
        f"sensor {sensor.name}: {np.sum(sizes == 1)} of {sizes.size} scans hold one report {but}; "
        "for a rotating sensor give its rotation and scan_period, or a `scan` column"
    ]


def _on_sparse_scans(sensor: Sensor, usual: float) -> list[str]:
    """Return a sentence where fewer scans hold a report than with a single object."""
    period = sensor.scan_period
    if period is None or usual <= WITHIN_TURN * period / sensor.detection_probability:
        return []
    return [
        f"sensor {sensor.name}: its reports come every {usual:g} s, although its scan period is "
        f"{period:g} s; the scans between count as misses of every track"
    ]


def _is_steady(gaps: FloatArray, period: float) -> bool:
    """Tell whether a sensor's clock is better than the azimuths of plots would let it seem."""
    turns = gaps / period
    return float(np.mean(np.abs(turns - np.round(turns)) < 0.05)) > 0.95
