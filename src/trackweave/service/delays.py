"""How late sensors usually tell what they saw: up to when nothing has to be waited for.

By the clock, and by what they say of time themselves.
"""

from collections import deque
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from math import inf

__all__ = ["STRANGE", "Delays", "Standstill"]

REMEMBERED = 200
"""So many arrivals of each sensor are remembered."""
USUAL = 0.98
"""The share of arrivals that is waited for."""
MARGIN = 0.05
"""Seconds that are waited beyond."""
MOST = 10.0
"""A sensor is waited for so much longer than the quickest at most [s]."""
ENOUGH = 20
"""After so many arrivals it is known how far what a sensor saw is behind its own marks."""
FINEST = 1.0 / 128.0
"""Seconds by which marks are exact."""
MOST_SENSORS = 2_000
"""As many as a recording's of which anything is estimated: each new name is a configuration."""
AHEAD = 5.0
"""The clock closes scans no farther beyond the times that the tracker believed of a sensor [s]."""
STRANGE = 60.0
"""What is so far off is of another clock, or wrong [s]."""
IN_PACE = 5.0
"""So long the others' reports wait for what a sensor may still have to say [s of the clock], where
a recording is sent faster than it was made."""

FAST = 2.0
"""A recording is sent so many times faster at least than it was made."""


@dataclass
class Standstill:
    """A clock that stands while inputs are not read: what they wait with is not late for it.

    So it does while the service itself gets no core.
    """

    _since: float | None = None
    _stood: float = 0.0

    def begin(self, now: float) -> None:
        """Stand from here on, unless it does."""
        if self._since is None:
            self._since = now

    def end(self, now: float) -> None:
        """Go on."""
        if self._since is not None:
            self._stood += now - self._since
            self._since = None

    def miss(self, seconds: float) -> None:
        """Take it that nothing was read for so long, unless the clock stands anyway."""
        if self._since is None:
            self._stood += seconds

    def clock(self, now: float) -> float:
        """Return what it shows [s]."""
        return (now if self._since is None else self._since) - self._stood


@dataclass
class Delays:
    """What the wall clock says when a time was told, less that time, by sensor."""

    _seen: dict[str, deque[tuple[float, float]]] = field(default_factory=dict)
    _delay: dict[str, float] = field(default_factory=dict)
    _marks: dict[str, float] = field(default_factory=dict)
    _behind: dict[str, deque[float]] = field(default_factory=dict)
    _last: dict[str, float] = field(default_factory=dict)
    heard: dict[str, float] = field(default_factory=dict)
    """When each was last heard, by the wall clock [s]."""
    _course: dict[str, float] = field(default_factory=dict)  # How far reports had come by then [s]
    _high: dict[str, float] = field(default_factory=dict)  # The latest time that counts for that
    _farthest: deque[tuple[float, float]] = field(default_factory=lambda: deque([(-inf, 0.0)]))

    def note(self, told: Mapping[str, Sequence[float]], now: float) -> None:
        """Take in which times sensors told, from first to last [s], at a time of the clock."""
        self._go_on(told, now)
        for name, (first, last, *_) in told.items():
            seen = self._seen.setdefault(name, deque(maxlen=REMEMBERED))
            if seen and abs((now - last) - seen[-1][1]) > STRANGE:
                # Another recording, or a clock that was set: what was learned is of no use.
                seen.clear()
                self._marks.pop(name, None)
                self._behind.pop(name, None)
            seen.append((now - first, now - last))
            ordered = sorted(each[0] for each in seen)
            least = min(each[1] for each in seen)
            usual = ordered[min(int(USUAL * len(ordered)), len(ordered) - 1)]
            self._delay[name] = min(usual, least + MOST)
            self.heard[name], self._last[name] = now, last
            if name in self._marks:
                behind = self._behind.setdefault(name, deque(maxlen=REMEMBERED))
                behind.append(self._marks[name] - first)

    def _go_on(self, told: Mapping[str, Sequence[float]], now: float) -> None:
        """Take in how far sensors' reports have come, whatever their clocks show."""
        start, is_first = self._farthest[-1][1], not self._course
        for name, (first, last, _, course) in told.items():
            known, high = self._course.get(name, start), self._high.get(name, -inf)
            if abs(first - high) < STRANGE:
                # What overlaps or comes out of order is no progress.
                gone = max(min(last - high, course + max(first - high, 0.0)), 0.0)
                self._course[name], self._high[name] = known + gone, high + gone
            else:
                # Who was silent, or whose clock was set, goes on from where the others are.
                self._course[name] = start + (course if is_first else 0.0)
                self._high[name] = last
        if (farthest := max(self._course.values(), default=0.0)) > start:
            self._farthest.append((now, farthest))
        while len(self._farthest) > 1 and self._farthest[1][0] <= now - IN_PACE:
            self._farthest.popleft()

    def overtaken(self, name: str, now: float) -> float:
        """Return how far others' reports had come beyond a sensor's, some seconds ago [s]."""
        by_then = [course for when, course in self._farthest if when <= now - IN_PACE]
        return max(by_then, default=0.0) - self._course.get(name, inf)

    def closed(self, told: Mapping[str, float], now: float) -> dict[str, float]:
        """Return up to when nothing of sensors is waited for that told their latest times [s]."""
        found = {}
        for name, until in self.until(now).items():
            if name not in told:
                continue
            silent, overtaken = now - self.heard[name] + AHEAD, self.overtaken(name, now)
            # A time that cannot be, or a clock that was set, closes nothing that may still come; a
            # recording that is sent faster than it was made is not held up by who fell silent.
            ahead = overtaken if overtaken > FAST * silent else min(until - told[name], silent)
            found[name] = told[name] + ahead
        return found

    def too_many(self, names: Collection[str]) -> str:
        """Return what is wrong with hearing sensors of these names, "" for nothing."""
        count = len(self.heard.keys() | set(names))
        if count <= MOST_SENSORS:
            return ""
        return f"column sensor: {count:,} sensors in all; expected at most {MOST_SENSORS:,}"

    def mark(self, times: Mapping[str, float]) -> None:
        """Take in when sensors' beams came by somewhere, as they say themselves [s].

        It is no promise: some radars tell plots with the mark behind them, others seconds later.
        How far plots are behind is learned from those that follow.
        """
        for name, time in times.items():
            if name in self._last and abs(time - self._last[name]) <= STRANGE:
                self._marks[name] = time

    def until(self, now: float) -> dict[str, float]:
        """Return up to when nothing has to be waited for, by sensor [s]."""
        found = {name: now - delay - MARGIN for name, delay in self._delay.items()}
        for name, time in self._marks.items():
            behind = sorted(self._behind.get(name, ()))
            if len(behind) >= ENOUGH:
                usual = behind[min(int(USUAL * len(behind)), len(behind) - 1)]
                found[name] = max(found[name], time + FINEST - max(usual, 0.0))
        return found
