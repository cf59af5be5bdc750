"""The scans that are still open to change."""

from bisect import bisect_left, bisect_right
from dataclasses import dataclass, replace
from typing import Annotated, Any

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.association._nodes import ScanInput
from trackweave.domain.scans import Scan
from trackweave.fields import settle
from trackweave.keys import Key
from trackweave.trackers.lifecycle import Lifecycle

__all__ = ["OpenScan", "OpenScans", "Window"]

WHOLE = 0.9
"""From so much of a period on sectors make a turn, since none takes exactly as long as another."""


@dataclass(frozen=True, slots=True)
class Window:
    """How much of the past stays open to change.

    Parameters
    ----------
    depth
        Scans of the slowest periodic sensor; the others' scans of that time are inside too.
    max_scans
        Most scans over all sensors; older ones are fixed.

    Raises
    ------
    InvalidInputError
        If a value is no whole number, or less than 1.

    Examples
    --------
    >>> import trackweave as tw
    >>> window = tw.Window(depth=3)  # scans of the slowest sensor
    >>> window.max_scans
    15
    """

    depth: Annotated[int, Key("a whole number from 1 to 200", 1, 200)] = 5
    max_scans: Annotated[int, Key("a whole number from 1 to 200", 1, 200)] = 15

    def __post_init__(self) -> None:
        settle(self)


@dataclass(frozen=True, slots=True, eq=False)
class OpenScan:
    """A scan of the window: as it came, as the tree grew by it, and the numbers of its reports.

    ``report``, ``log_density`` and ``repeat`` are in the order of the slots.
    """

    scan: Scan
    data: ScanInput
    report: IntArray
    log_density: FloatArray
    repeat: FloatArray
    """What each report says for a false alarm that came again [nats]."""
    share: float = 1.0
    """How much of a scan it is, for the sector of a turn."""

    @property
    def sensor(self) -> str:
        """Name of its sensor."""
        return self.scan.sensor


class OpenScans:
    """The scans of the window in order of time; slots count their reports in that order.

    Slots are numbered on over a tracker's life: closing scans renumbers nothing.
    """

    def __init__(self, window: Window, reference: str | None, period: float = 0.0) -> None:
        self._window = window
        self._reference = reference
        self._period = period
        self._marks: list[float] = []
        """When the scans that the window counts ended, each moment once, ascending [s]."""
        self._share = 0.0
        self.scans: list[OpenScan] = []
        self.fixed_until = -np.inf
        """Time up to which nothing can change any more [s]."""
        self.first_slot = 0
        """The oldest report's slot."""
        self.end_slot = 0
        """One more than the newest report's slot."""

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "scans": self.scans.copy(), "_marks": self._marks.copy()}

    @property
    def last_time(self) -> float:
        """Time of the latest scan [s]; minus infinity when there was none."""
        return self.scans[-1].data.time if self.scans else self.fixed_until

    def find(self, sensor: str, time: float) -> int | None:
        """Return the place of a sensor's scan of that time, None where there is none."""
        place = bisect_left(self.scans, time, key=_time)
        while place < len(self.scans) and self.scans[place].data.time == time:
            if self.scans[place].sensor == sensor:
                return place
            place += 1
        return None

    def timed(
        self, place: int, last: float, lifecycle: Lifecycle, period: float
    ) -> tuple[ScanInput, float]:
        """Return a scan ready to grow by, and how long after the last it was [s]."""
        known = self.scans[place]
        waited = max(0.0, known.data.time - last) if np.isfinite(last) else 0.0
        living = -np.log(lifecycle.survival) * min(waited / period, 1e6)
        hiding, showing = lifecycle.hiding(waited)
        data = known.data._replace(survival_cost=float(living), hiding=hiding, showing=showing)
        self.scans[place] = replace(known, data=data)
        return data, waited

    def insert(self, scan: OpenScan) -> None:
        """Put a late scan into its place in time, behind those of its instant; renumber."""
        place = bisect_right(self.scans, scan.data.time, key=_time)
        self.scans.insert(place, scan)
        self._share += scan.share
        if self._counts(scan.sensor):
            mark = bisect_left(self._marks, scan.data.time)
            if mark == len(self._marks) or self._marks[mark] != scan.data.time:
                self._marks.insert(mark, scan.data.time)
        self.end_slot += scan.report.shape[0]
        self._renumber(place)

    def remove(self, place: int) -> OpenScan:
        """Take a scan out and return it; renumber."""
        scan = self.scans.pop(place)
        self._share -= scan.share
        self.end_slot -= scan.report.shape[0]
        self._marks = sorted({s.data.time for s in self.scans if self._counts(s.sensor)})
        self._renumber(place)
        return scan

    def n_closing(self, sensor: str, time: float) -> int:
        """Return how many of the oldest scans must be fixed before a scan comes in."""
        # A whole instant at a time where that is possible, so that the sensors of an instant stay
        # together. The time is that of the scan that comes in [s], later than all others.
        ordered = self._scan_ends([*self._marks, time] if self._counts(sensor) else self._marks)
        depth = self._window.depth
        boundary = ordered[-depth - 1] if len(ordered) > depth else -np.inf
        closing = bisect_right(self.scans, boundary, key=_time)
        excess = self._n_excess()
        if excess > closing:
            limit = self.scans[excess - 1].data.time
            # Where more sensors see one instant than the window holds, it stays as it is.
            side = bisect_left if limit == time else bisect_right
            closing = side(self.scans, limit, key=_time)
        return closing

    def _counts(self, sensor: str) -> bool:
        """Tell whether the window goes by the scans of a sensor."""
        return self._reference is None or sensor == self._reference

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
        held, place = self._share, 0
        while held > room and place < len(self.scans):
            held -= self.scans[place].share
            place += 1
        return place

    def close(self, count: int) -> list[OpenScan]:
        """Forget the oldest scans and return them."""
        closing = self.scans[:count]
        del self.scans[:count]
        if closing:
            self.fixed_until = float(closing[-1].data.time)
        self._marks = self._marks[bisect_right(self._marks, self.fixed_until) :]
        self.first_slot += sum(scan.report.shape[0] for scan in closing)
        # Summed anew once in a while: what is added and taken away leaves roundings behind.
        self._share = sum(scan.share for scan in self.scans) if closing else self._share
        if self.scans and self.scans[0].data.time == self.fixed_until:
            self._marks = sorted({s.data.time for s in self.scans if self._counts(s.sensor)})
            self._renumber(0)
        return closing

    def _renumber(self, place: int) -> None:
        """Give slots to the scans from a place on, and say which of them begin an instant."""
        first = self.end_slot - sum(scan.report.shape[0] for scan in self.scans[place:])
        instant = self.scans[place - 1].data.time if place else self.fixed_until
        for scan in self.scans[place:]:
            count = scan.report.shape[0]
            data = scan.data._replace(
                slot=np.arange(first, first + count), new_instant=scan.data.time != instant
            )
            self.scans[place] = replace(scan, data=data)
            first, instant, place = first + count, scan.data.time, place + 1


def _time(scan: OpenScan) -> float:
    return scan.data.time
