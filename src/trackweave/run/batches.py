"""Batches: what a sensor that does not scan hears of objects that name themselves, each once.

One by one such reports would each be a scan of their own, and a receiver of three hundred aircraft
hundreds a second; a batch of them grows the tree once.
"""

from collections.abc import Collection, Iterable

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.domain.reports import ReportTable
from trackweave.models.sensors import Sensor

__all__ = ["Batch", "batch_rows", "batches", "hearing_in", "naming"]

LASTING_S = 0.5
"""A batch lasts no longer [s]; live, its reports wait so long for the others."""


class Batch:
    """Whose reports are in a batch, and since when [s]."""

    def __init__(self) -> None:
        self._names: set[int] = set()
        self._first = np.nan
        self._is_named = True

    def takes(self, time: float, names: list[int]) -> bool:
        """Take in what is reported at a time, by number of the object, if it belongs here.

        Parameters
        ----------
        time
            No earlier than what was taken in before [s].
        names
            Who reports then; -1 for who does not say.

        Returns
        -------
        Whether it belongs here: whoever reports again, or does not say who it is, begins another.
        """
        is_named = min(names) >= 0 and len(set(names)) == len(names)
        if not self._names:
            self._first, self._is_named = time, is_named
        elif not is_named or self.is_over(time) or not self._names.isdisjoint(names):
            return False
        self._names.update(names)
        return True

    def is_over(self, now: float) -> bool:
        """Tell whether nothing of a time, and nothing later, belongs here any more."""
        return not self._is_named or now > self._first + LASTING_S


def hearing_in(sensors: Iterable[Sensor]) -> list[str]:
    """Return the names of the sensors that do not scan, but hear objects report themselves."""
    return [sensor.name for sensor in sensors if sensor.scans is False]


def batches(time: FloatArray, identity: IntArray) -> IntArray:
    """Return the number of the batch of each report of a sensor that does not scan.

    Parameters
    ----------
    time
        When it was [s], shape (reports,).
    identity
        Whose it says it is, shape (reports,), -1 for nobody's.

    Returns
    -------
    Numbers from 0 in order of time, shape (reports,).
    """
    order = np.argsort(time, kind="stable")
    cuts = np.flatnonzero(np.diff(time[order])) + 1
    number = np.empty(time.size, dtype=np.int64)
    batch, count = Batch(), 0
    for rows in np.split(order, cuts) if time.size else []:
        moment, names = float(time[rows[0]]), identity[rows].tolist()
        if not batch.takes(moment, names):
            batch, count = Batch(), count + 1
            batch.takes(moment, names)
        number[rows] = count
    return number


def naming(reports: ReportTable, hearing: Collection[str]) -> list[str]:
    """Return the sensors whose reports make batches, as they name objects and no scan is long."""
    if reports.identity is None:
        return []
    return [name for name in sorted(hearing) if not _has_long_scans(reports, name)]


def _has_long_scans(reports: ReportTable, sensor: str) -> bool:
    """Tell whether reports of several times are in one scan of a sensor."""
    if reports.scan is None or sensor not in reports.sensors:
        return False
    rows = reports.sensor == reports.sensors.index(sensor)
    pairs = np.unique(np.stack([reports.scan[rows], reports.time[rows]]), axis=1)
    return bool(np.any(np.diff(pairs[0]) == 0))


def batch_rows(reports: ReportTable, sensor: str) -> list[IntArray]:
    """Return the rows of each batch of a sensor, in order of time."""
    assert reports.identity is not None
    if sensor not in reports.sensors:
        return []
    rows = np.flatnonzero(reports.sensor == reports.sensors.index(sensor))
    number = batches(reports.time[rows], reports.identity[rows])
    order = np.argsort(number, kind="stable")
    return np.split(rows[order], np.flatnonzero(np.diff(number[order])) + 1)
