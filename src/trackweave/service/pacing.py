"""How much work a step may take: chosen by the clock, and written down before it counts."""

from dataclasses import dataclass
from typing import Any

__all__ = ["LEVELS", "Pace"]

LEVELS: tuple[dict[str, Any], ...] = (
    {"nodes": None, "keep": None, "evaluations": None, "branches": None},
    {"nodes": 100_000, "keep": [60, 8], "evaluations": 10_000, "branches": 10},
    {"nodes": 30_000, "keep": [25, 4], "evaluations": 2_000, "branches": 3},
    {"nodes": 10_000, "keep": [10, 2], "evaluations": 500, "branches": 0},
    {"nodes": 4_000, "keep": [4, 1], "evaluations": 100, "branches": 0},
)
"""From no bound to hardly more than one sequence for each track: sequences in all, for each track
and for each that begins, evaluations of the search, branches."""
LATE, EARLY = 0.5, 0.1
"""A tracker that lags behind by more is given less to do [s], by less again more."""
PATIENCE, RELIEF = 1.5, 15.0
"""Seconds of lag before it is given still less, and of none before it is given more."""
BEGINNING = 20.0
"""Seconds after its first lag in which that may be kernels being loaded or compiled."""


@dataclass(slots=True)
class Pace:
    """The bound now, and since when."""

    level: int = 0
    _changed: float = 0.0
    _early_since: float | None = None
    _late_since: float | None = None
    _first: float | None = None

    def bound(self, lag: float, now: float) -> dict[str, Any] | None:
        """Return another bound where the tracker lags [s] or has time; None for the same."""
        if lag > EARLY:
            self._early_since = None
        elif self._early_since is None:
            self._early_since = now
        if lag <= LATE:
            self._late_since = None
        elif self._late_since is None:
            self._late_since = now
            self._first = now if self._first is None else self._first
        late = self._late_since
        is_late = late is not None and now - max(late, self._changed) >= PATIENCE
        is_settled = self._first is not None and now - self._first >= BEGINNING
        if is_late and is_settled and self.level + 1 < len(LEVELS):
            return self._to(self.level + 1, now)
        since = self._early_since
        if self.level and since is not None and now - max(since, self._changed) >= RELIEF:
            return self._to(self.level - 1, now)
        return None

    def _to(self, level: int, now: float) -> dict[str, Any]:
        self.level, self._changed = level, now
        return LEVELS[level]
