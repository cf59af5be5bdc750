"""What is known of each report of the window, by its slot."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackweave.arrays import FloatArray, IntArray
from trackweave.trackers.hypothesis import Assignments
from trackweave.trackers.window import OpenScan

__all__ = ["ReportIndex"]

_EMPTY = {
    "report": -1, "time": 0.0, "track": -1, "probability": np.nan, "price": 0.0, "is_known": False,
    "repeat": 0.0,
}  # fmt: skip


class ReportIndex:
    """Columns over the reports of the window; a report's row is its slot less ``origin``.

    ``report`` is its number and ``time`` when its scan ended [s]; ``track`` is the track that the
    last hypothesis gave it, -1 for none, and ``probability`` how probable that is; ``price`` is
    what it was worth to who took it [nats]. ``is_known`` tells whether a hypothesis has spoken of
    it, and ``repeat`` what it says for a false alarm that came again [nats]. Rows of slots that
    are closed are there until their room is needed.
    """

    report: IntArray
    time: FloatArray
    track: IntArray
    probability: FloatArray
    price: FloatArray
    is_known: NDArray[np.bool_]
    repeat: FloatArray

    def __init__(self) -> None:
        self.origin = 0
        self.end = 0
        self._allocate(256)

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, **{name: getattr(self, name).copy() for name in _EMPTY}}

    def add(self, scan: OpenScan, first: int) -> None:
        """Append reports of which no hypothesis has spoken; before ``first`` all is forgotten."""
        count = scan.report.shape[0]
        if self.end + count - self.origin > self.report.shape[0]:
            self._make_room(first, count)
        span = slice(self.end - self.origin, self.end - self.origin + count)
        for name, nothing in _EMPTY.items():
            getattr(self, name)[span] = nothing
        self.report[span] = scan.report
        self.time[span] = scan.data.time
        self.repeat[span] = scan.repeat
        self.end += count

    def assignments(self, first: int, end: int) -> Assignments:
        """Return what the last hypothesis says of a span of slots."""
        rows = slice(first - self.origin, end - self.origin)
        return Assignments(
            report=self.report[rows].copy(),
            track=self.track[rows].copy(),
            probability=self.probability[rows].copy(),
        )

    def repeated(self, slot: IntArray) -> FloatArray:
        """Return what each column of slots says for false alarms that came again; -1 for none."""
        if not self.repeat.any():
            return np.zeros(slot.shape[1])
        row = np.maximum(slot - self.origin, 0)
        said: FloatArray = np.where(slot >= 0, self.repeat[row], 0.0).sum(axis=0)
        return said

    def instants(self, slot: IntArray) -> IntArray:
        """Return the rank in time of each slot, given ascending; equal within an instant."""
        time = self.time[slot - self.origin]
        rank = np.zeros(slot.shape[0], dtype=np.int64)
        np.cumsum(time[1:] > time[:-1], out=rank[1:])
        return rank

    def relay(self, first: int, scans: Sequence[OpenScan]) -> None:
        """Put the reports of the window's scans in another order; some may be new."""
        # What is known goes with each report.
        known = self.report[: self.end - self.origin].tolist()
        place = {number: row for row, number in enumerate(known)}
        now = [number for scan in scans for number in scan.report.tolist()]
        was = np.array([place.get(number, -1) for number in now], dtype=np.int64)
        old = {name: getattr(self, name) for name in ("track", "probability", "is_known")}
        self._allocate(max(256, 2 * len(now)))
        self.origin = self.end = first
        for scan in scans:
            self.add(scan, first)
        rows = np.flatnonzero(was >= 0)
        for name, column in old.items():
            getattr(self, name)[rows] = column[was[rows]]

    def _make_room(self, first: int, count: int) -> None:
        """Forget what lies before a slot, and make room for so many more."""
        live = slice(first - self.origin, self.end - self.origin)
        old = {name: getattr(self, name)[live] for name in _EMPTY}
        size = self.end - first
        self._allocate(max(256, 2 * (size + count)))
        for name, column in old.items():
            getattr(self, name)[:size] = column
        self.origin = first

    def _allocate(self, room: int) -> None:
        for name, nothing in _EMPTY.items():
            column: NDArray[Any] = np.full(room, nothing)
            setattr(self, name, column)
