"""Rows of tracks as they become known live; see ``trackweave.run.record.Rows``."""

from dataclasses import dataclass, field

from trackweave.domain.tracks import TrackTable

__all__ = ["RowsDue"]


@dataclass(slots=True)
class RowsDue:
    """Which rows are written: of scans that end together the last word, once in a period."""

    period: float | None = None
    """Least time between scans after which rows are written [s], None for every scan."""
    waiting: TrackTable | None = None
    time: float = 0.0
    written: float | None = None
    ready: list[TrackTable] = field(default_factory=list)

    def wants(self, time: float) -> bool:
        """Tell whether rows at a time are written, if no other scan ends then too."""
        if self.waiting is not None and time > self.time:
            self._write()
        return self._is_due(time)

    def add(self, tracks: TrackTable, time: float) -> None:
        """Take the rows after a scan that ends at a time."""
        if self.waiting is None and time == self.written:
            # The scan was put aside, and the tracker is where it was.
            return
        if self.waiting is not None and time > self.time:
            self._write()
        self.waiting, self.time = tracks, time

    def taken(self) -> tuple[TrackTable, ...]:
        """Return, and take out, what is to be written."""
        ready, self.ready = tuple(self.ready), []
        return ready

    def begin_anew(self) -> None:
        """Write what waits, and the next rows whenever they are: the clock was set back."""
        if self.waiting is not None:
            self.ready.append(self.waiting)
        self.waiting = self.written = None

    def finish(self) -> None:
        """Write the last rows, which are always written."""
        if self.waiting is not None:
            self.written = None
            self._write()

    def _write(self) -> None:
        if self._is_due(self.time) and self.waiting is not None:
            self.ready.append(self.waiting)
            self.waiting, self.written = None, self.time

    def _is_due(self, time: float) -> bool:
        # Times are sums of periods, so that a row due may come a rounding error early.
        wait = 0.0 if self.period is None else self.period * (1 - 1e-9)
        return self.written is None or time >= self.written + wait
