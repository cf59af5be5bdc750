"""What is known of each report of the window, by its slot."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackweave.arrays import FloatArray, IntArray
from trackweave.trackers.hypothesis import Assignments

__all__ = ["ReportIndex"]

_EMPTY = {
    "report": -1, "time": 0.0, "track": -1, "probability": np.nan, "price": 0.0, "is_known": False,
}  # fmt: skip


class ReportIndex:
    """Columns over the reports of the window; a report's row is its slot less ``origin``.

    ``report`` is its number and ``time`` when its scan ended [s]; ``track`` is the track that the
    last hypothesis gave it, -1 for none, and ``probability`` how probable that is; ``price`` is
    what it was worth to who took it [nats]. ``is_known`` tells whether a hypothesis has spoken of
    it. Rows of slots that are closed are there until their room is needed.
    """

    report: IntArray
    time: FloatArray
    track: IntArray
    probability: FloatArray
    price: FloatArray
    is_known: NDArray[np.bool_]

    def __init__(self) -> None:
        self.origin = 0
        self.end = 0
        self._allocate(256)

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, **{name: getattr(self, name).copy() for name in _EMPTY}}

    def add(self, report: IntArray, time: float | FloatArray, first: int) -> None:
        """Append reports of which no hypothesis has spoken; before ``first`` all is forgotten."""
        count = report.shape[0]
        if self.end + count - self.origin > self.report.shape[0]:
            self._make_room(first, count)
        span = slice(self.end - self.origin, self.end - self.origin + count)
        for name, nothing in _EMPTY.items():
            getattr(self, name)[span] = nothing
        self.report[span] = report
        self.time[span] = time
        self.end += count

    def assignments(self, first: int, end: int) -> Assignments:
        """Return what the last hypothesis says of a span of slots."""
        rows = slice(first - self.origin, end - self.origin)
        return Assignments(
            report=self.report[rows].copy(),
            track=self.track[rows].copy(),
            probability=self.probability[rows].copy(),
        )

    def instants(self, slot: IntArray) -> IntArray:
        """Return the rank in time of each slot, given ascending; equal within an instant."""
        time = self.time[slot - self.origin]
        rank = np.zeros(slot.shape[0], dtype=np.int64)
        np.cumsum(time[1:] > time[:-1], out=rank[1:])
        return rank

    def relay(self, first: int, report: IntArray, time: FloatArray) -> None:
        """Put the window's reports in another order; what is known goes with each report."""
        # ``report`` and ``time`` are those of each slot from the first on; some may be new.
        known = self.report[: self.end - self.origin].tolist()
        place = {number: row for row, number in enumerate(known)}
        was = np.array([place.get(number, -1) for number in report.tolist()], dtype=np.int64)
        old = {name: getattr(self, name) for name in ("track", "probability", "is_known")}
        self._allocate(max(256, 2 * report.shape[0]))
        self.origin = self.end = first
        self.add(report, time, first)
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
