"""The scans that are still open to change."""

from dataclasses import dataclass, replace

import numpy as np

from trackweave.arrays import FloatArray, IntArray, is_whole
from trackweave.association._nodes import ScanInput
from trackweave.domain.scans import Scan
from trackweave.errors import InvalidInputError

__all__ = ["OpenScan", "OpenScans", "Window"]

WHOLE = 0.9
"""From so much of a period on sectors make a turn, since none takes exactly as long as another."""


@dataclass(frozen=True, slots=True)
class Window:
    """How much of the past stays open to change.

    Parameters
    ----------
    depth
        Scans of the slowest periodic sensor, at least 1; the others' scans of that time are
        inside too. Where no sensor is periodic, instants.
    max_scans
        Greatest number of scans over all sensors, at least 1.

    Raises
    ------
    InvalidInputError
        If a value is no whole number, or less than 1.
    """

    depth: int = 5
    max_scans: int = 15

    def __post_init__(self) -> None:
        if not all(is_whole(value) and value >= 1 for value in (self.depth, self.max_scans)):
            raise InvalidInputError(
                f"window: depth {self.depth!r:.80}, max_scans {self.max_scans!r:.80}; expected "
                "whole numbers, at least 1"
            )


@dataclass(frozen=True, slots=True, eq=False)
class OpenScan:
    """A scan of the window: as it came, as the tree grew by it, and the numbers of its reports.

    ``report`` and ``log_density`` are in the order of the slots.
    """

    scan: Scan
    data: ScanInput
    report: IntArray
    log_density: FloatArray
    share: float = 1.0
    """How much of a scan it is, for the sector of a turn."""

    @property
    def sensor(self) -> str:
        """Name of its sensor."""
        return self.scan.sensor


class OpenScans:
    """The scans of the window in order of time; a report's slot is its place in that order."""

    def __init__(self, window: Window, reference: str | None, period: float = 0.0) -> None:
        self._window = window
        self._reference = reference
        self._period = period
        self.scans: list[OpenScan] = []
        self.fixed_until = -np.inf
        """Time up to which nothing can change any more [s]."""

    @property
    def n_slots(self) -> int:
        """Number of reports in the window."""
        return sum(scan.report.shape[0] for scan in self.scans)

    @property
    def last_time(self) -> float:
        """Time of the latest scan [s]; minus infinity when there was none."""
        return self.scans[-1].data.time if self.scans else self.fixed_until

    def reports(self) -> IntArray:
        """Return the report number of each slot."""
        return np.concatenate([np.empty(0, dtype=np.int64), *(scan.report for scan in self.scans)])

    def instants(self) -> IntArray:
        """Return the rank in time of each slot, equal within an instant."""
        times = np.array([scan.data.time for scan in self.scans])
        sizes = [scan.report.shape[0] for scan in self.scans]
        return np.repeat(np.unique(times, return_inverse=True)[1], sizes).astype(np.int64)

    def find(self, sensor: str, time: float) -> int | None:
        """Return the place of a sensor's scan of that time, None where there is none."""
        for place, scan in enumerate(self.scans):
            if scan.sensor == sensor and scan.data.time == time:
                return place
        return None

    def insert(self, scan: OpenScan) -> None:
        """Put a late scan into its place in time, behind those of its instant; renumber."""
        place = sum(other.data.time <= scan.data.time for other in self.scans)
        self.scans.insert(place, scan)
        self._renumber(place)

    def remove(self, place: int) -> OpenScan:
        """Take a scan out and return it; renumber."""
        scan = self.scans.pop(place)
        self._renumber(place)
        return scan

    def n_closing(self, sensor: str, time: float) -> int:
        """Return how many of the oldest scans must be fixed before a scan comes in.

        A whole instant at a time where that is possible, so that the sensors of an instant stay
        together.

        Parameters
        ----------
        sensor, time
            The sensor of the scan that comes in, and its time [s]; later than all others.

        Returns
        -------
        How many of the oldest scans have to go.
        """
        marks = {
            scan.data.time
            for scan in self.scans
            if self._reference is None or scan.sensor == self._reference
        }
        if self._reference is None or sensor == self._reference:
            marks.add(time)
        ordered = self._scan_ends(sorted(marks))
        depth = self._window.depth
        boundary = ordered[-depth - 1] if len(ordered) > depth else -np.inf
        closing = sum(scan.data.time <= boundary for scan in self.scans)
        excess = self._n_excess()
        if excess > closing:
            limit = self.scans[excess - 1].data.time
            closing = sum(scan.data.time <= limit for scan in self.scans)
            if limit == time:
                # More sensors see one instant than the window holds: it stays as it is.
                closing = sum(scan.data.time < limit for scan in self.scans)
        return closing

    def _scan_ends(self, marks: list[float]) -> list[float]:
        """Return the last moments of whole scans: sectors of one turn are one scan."""
        ends: list[float] = []
        for mark in reversed(marks):
            if not ends or ends[-1] - mark > WHOLE * self._period:
                ends.append(mark)
        return ends[::-1]

    def _n_excess(self) -> int:
        """Return how many of the oldest scans are too many beside one that comes in."""
        room = self._window.max_scans - 1.0 + 1e-9
        for place in range(len(self.scans), 0, -1):
            room -= self.scans[place - 1].share
            if room < 0.0:
                return place
        return 0

    def close(self, count: int) -> int:
        """Forget the oldest scans; return how many slots they had."""
        closing, self.scans = self.scans[:count], self.scans[count:]
        if closing:
            self.fixed_until = float(closing[-1].data.time)
        n_slots: int = sum(scan.report.shape[0] for scan in closing)
        # In place: a window of many sectors is too long to be written anew for each of them.
        for scan in self.scans:
            scan.data.slot[:] -= n_slots
        if self.scans and self.scans[0].data.time == self.fixed_until:
            self._renumber(0)
        return n_slots

    def _renumber(self, place: int) -> None:
        """Give slots to the scans from a place on, and say which of them begin an instant."""
        first = sum(scan.report.shape[0] for scan in self.scans[:place])
        instant = self.scans[place - 1].data.time if place else self.fixed_until
        for scan in self.scans[place:]:
            count = scan.report.shape[0]
            data = scan.data._replace(
                slot=np.arange(first, first + count), new_instant=scan.data.time != instant
            )
            self.scans[place] = replace(scan, data=data)
            first, instant, place = first + count, scan.data.time, place + 1
