"""Keeps a stamp that cannot be right from blinding a live tracker."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from itertools import pairwise
from statistics import median

import numpy as np

from trackweave.arrays import is_number
from trackweave.domain.scans import Scan
from trackweave.errors import InvalidInputError
from trackweave.models.sensors import Sensor

__all__ = ["MAX_AHEAD", "Arrival", "ClockGuard", "HeldScan", "Verdict", "farthest"]

MAX_AHEAD = 60.0
"""How far ahead of all others a scan may be, unless it is told otherwise [s]."""
IN_A_ROW = 3
"""So many scans that agree with one another are believed, whatever was believed before."""
PERIODS = 2.5
"""So many scan periods are no jump, whatever ``max_ahead`` is: a scan or two may be lost."""
GAPS, FEWEST_GAPS = 9, 2
"""Where sensors have no period, how many gaps between scans are remembered, and needed."""
LEAST_STEP = 0.5
"""Scans of one sensor lie at least so much of its period apart; a clock that stands does not."""
REMEMBERED = 16
"""Refused scans since the last accepted one among which those that agree are looked for."""
MOST_HELD = 100
"""So many scans wait for their time; beyond, the oldest is set aside."""


@dataclass(frozen=True, slots=True)
class HeldScan:
    """A scan that is held back or was set aside because of its time.

    Parameters
    ----------
    time
        Its time [s].
    sensor
        Name of its sensor.
    report
        Numbers of its reports, as in ``Hypothesis``.

    Examples
    --------
    >>> import trackweave as tw
    >>> motion = tw.ConstantVelocity(process_noise=0.1, max_speed=30.0)  # m²/s³, m/s
    >>> tracker = tw.MultiHypothesisTracker(motion=motion, sensors=[tw.Sensor("a", sigma=5.0)])
    >>> for time in (0.0, 1.0, 2.0, 86400.0):  # s; the last a day ahead
    ...     hypothesis = tracker.step(tw.Scan(time, "a", [[time % 60.0, 0.0]]))
    ...
    >>> hypothesis.held
    (HeldScan(time=86400.0, sensor='a', report=(3,)),)
    """

    time: float
    sensor: str
    report: tuple[int, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Arrival:
    """What comes in at once: a scan, or the scans of an instant; its time is that of the last."""

    scans: tuple[Scan, ...]

    @property
    def time(self) -> float:
        """Its time [s]."""
        return max(scan.time for scan in self.scans)

    @property
    def sensors(self) -> frozenset[str]:
        """Whose scans they are."""
        return frozenset(scan.sensor for scan in self.scans)

    def told(self) -> tuple[HeldScan, ...]:
        """Return what a hypothesis tells of it."""
        return tuple(
            HeldScan(scan.time, scan.sensor, tuple(scan.report.tolist())) for scan in self.scans
        )


@dataclass(frozen=True, slots=True, eq=False)
class Verdict:
    """What is done about what comes in."""

    guard: "ClockGuard"  # What is known afterwards
    now: tuple[Arrival, ...] = ()  # In order of time; nothing where it is held back
    aside: tuple[Arrival, ...] = ()  # What is set aside for good
    # Whether the tracker has to forget what it knows before, because it was of another time.
    begins_anew: bool = False
    keeps_priors: bool = False  # Whether the tracks known beforehand count again then


def farthest(max_ahead: float, periods: Iterable[float | None]) -> float:
    """Return how far apart successive scans may be before that is a jump [s]."""
    # Where sensors scan more rarely than ``max_ahead`` allows in any case, it is more than that.
    return max([max_ahead, *(PERIODS * period for period in periods if period is not None)])


@dataclass(frozen=True, slots=True, eq=False)
class ClockGuard:
    """Which times are believed, and what waits until they are.

    A value: judging gives another one. Nothing is believed of a lone scan that jumps ahead of all
    others; three that agree with one another are the truth, be it after an outage or because what
    was believed at first was not. What is believed gives way to earlier times only if hardly
    anything speaks for it, or all sensors that spoke for it do so no more: a sensor that delivers
    what it had stored sets no clock back.
    """

    max_ahead: float | None
    """How far a scan may be ahead of the latest time accepted [s]; None to believe any."""
    periods: Mapping[str, float | None]
    """Scan period of each sensor [s], None for one without."""
    turning: frozenset[str] = frozenset()
    """Sensors whose scans are sectors of turns."""
    latest: float = -np.inf
    """The latest time accepted [s]."""
    held: tuple[Arrival, ...] = ()
    """What waits, in order of arrival."""
    _count: int = 0
    """How many were accepted since time last jumped."""
    _heard: frozenset[str] = frozenset()
    """Whose."""
    _refused: tuple[Arrival, ...] = ()
    """What was not believed since the last was accepted."""
    _gaps: tuple[float, ...] = field(default=())
    """The last gaps between scans, where sensors have no period [s]."""

    @classmethod
    def of(cls, max_ahead: float | None, sensors: Iterable[Sensor]) -> "ClockGuard":
        """Return a guard before the first scan; refuse ``max_ahead`` of 0 or less."""
        if max_ahead is not None and not (is_number(max_ahead) and max_ahead > 0):
            raise InvalidInputError(
                f"max_ahead: {max_ahead!r:.80}; expected a number > 0 [s], or None"
            )
        known = tuple(sensors)
        return cls(
            max_ahead,
            {sensor.name: sensor.scan_period for sensor in known},
            frozenset(sensor.name for sensor in known if sensor.rotation is not None),
        )

    def told(self) -> tuple[HeldScan, ...]:
        """Return what a hypothesis tells of what is held back."""
        return tuple(scan for arrival in self.held for scan in arrival.told())

    def farthest_back(self, usual: float) -> float:
        """Return how old a scan of a tracker may be that usually takes such old ones [s]."""
        # It is that or what is no jump, whichever is more; any age where nothing tells it.
        periods = self.periods.values()
        if self.max_ahead is None or None in periods:
            return np.inf
        return max(usual, farthest(self.max_ahead, periods))

    def parted(self, arrival: Arrival) -> tuple[Arrival, ...]:
        """Return what comes in at once in parts, in order, between which time jumps."""
        # They are judged singly.
        reach = np.inf if self.max_ahead is None else self._reach()
        parts = [[arrival.scans[0]]]
        for early, late in pairwise(arrival.scans):
            if late.time - early.time > reach:
                parts.append([])
            parts[-1].append(late)
        return tuple(Arrival(tuple(part)) for part in parts)

    def judge(self, arrival: Arrival, *, is_late: bool = False) -> Verdict:
        """Return what is done about what comes in."""
        # It is late if the tracker has no use for it because of its age.
        if self.max_ahead is None:
            return Verdict(self, now=(arrival,))
        ahead, reach = arrival.time - self.latest, self._reach()
        is_young = self._count < IN_A_ROW
        if ahead <= reach and not (ahead < -reach and (is_late or is_young)):
            return self.accepted(arrival)
        if self._count == 0:
            return self.accepted(arrival)
        chain = self._chain(arrival, max(reach, abs(ahead)))
        if len(chain) >= IN_A_ROW and (ahead > 0 or self._is_overruled(chain)):
            return self._jumped(chain, is_back=ahead < 0)
        refused = (*self._refused, arrival)[-REMEMBERED:]
        if ahead < 0 and not is_young:
            # Too late, and most probably only that: the tracker says so.
            return Verdict(replace(self, _refused=refused), now=(arrival,))
        held = (*self.held, arrival)
        aside, held = held[: max(0, len(held) - MOST_HELD)], held[-MOST_HELD:]
        return Verdict(replace(self, held=held, _refused=refused), aside=aside)

    def _reach(self) -> float:
        """Return how far time may go on from scan to scan [s]."""
        reach = farthest(self.max_ahead or 0.0, self.periods.values())
        if len(self._gaps) >= FEWEST_GAPS:
            reach = max(reach, PERIODS * median(self._gaps))
        return reach

    def accepted(self, *arrivals: Arrival) -> Verdict:
        """Return that arrivals, the newest last, are taken in, and what their time has reached."""
        latest = max(self.latest, *(arrival.time for arrival in arrivals))
        # A sensor that went on at an earlier time has said that a stamp of before was wrong.
        wrong = [
            old
            for old in self.held
            if (old.time > arrivals[-1].time and old.sensors & arrivals[-1].sensors)
            or old.time < self.latest - self._reach()
        ]
        due = [old for old in self.held if old.time <= latest and old not in wrong]
        guard = replace(
            self,
            latest=latest,
            held=tuple(old for old in self.held if old not in wrong and old not in due),
            _count=self._count + len(arrivals),
            _heard=self._heard.union(*(arrival.sensors for arrival in arrivals)),
            _refused=(),
            _gaps=self._longer([self.latest, *(arrival.time for arrival in arrivals)]),
        )
        now = sorted([*due, *arrivals], key=lambda arrival: arrival.time)
        return Verdict(guard, now=tuple(now), aside=tuple(wrong))

    def _jumped(self, chain: list[Arrival], *, is_back: bool) -> Verdict:
        """Return that those which agree are believed, and what was believed no more."""
        is_young = self._count < IN_A_ROW
        held = tuple(old for old in self.held if old not in chain)
        # Of those that agree, the late ones have had their word.
        chain = [new for new in chain if new in self.held or new is chain[-1]]
        latest = -np.inf if is_back or is_young else self.latest
        since = replace(self, latest=latest, held=held, _count=0, _heard=frozenset())
        verdict = since.accepted(*chain)
        times = [arrival.time for arrival in chain]
        guard = replace(verdict.guard, _count=max(IN_A_ROW, len(chain)))
        guard = replace(guard, _gaps=self._longer(sorted(times)))
        return replace(
            verdict, guard=guard, begins_anew=is_back or is_young, keeps_priors=is_young
        )

    def _longer(self, times: list[float]) -> tuple[float, ...]:
        """Return the last gaps with those between some times in a row."""
        if None not in self.periods.values():
            return ()
        gaps = [float(gap) for gap in np.diff(times) if 0.0 < gap < np.inf]
        return (*self._gaps, *gaps)[-GAPS:]

    def _chain(self, arrival: Arrival, span: float) -> list[Arrival]:
        """Return what came since the last was accepted and agrees with one that comes in."""
        chain = [arrival]
        for old in reversed(self._refused):
            if all(
                self._agree(old, new, len(chain) - place, span) for place, new in enumerate(chain)
            ):
                chain.append(old)
        return chain[::-1]

    def _agree(self, old: Arrival, new: Arrival, steps: int, span: float) -> bool:
        """Tell whether one follows the other, so many steps later, as their periods say."""
        gap, both = new.time - old.time, old.sensors & new.sensors
        known = [self.periods.get(name) for name in both or old.sensors | new.sensors]
        periods = [period for period in known if period is not None]
        most = steps * (PERIODS * max(periods) if periods else span)
        if not both:
            return abs(gap) <= (most if len(periods) == len(known) else steps * span)
        least = 0.0
        if periods and not both & self.turning:
            least = LEAST_STEP * min(periods)
        return max(least, np.finfo(float).tiny) <= gap <= most

    def _is_overruled(self, chain: list[Arrival]) -> bool:
        """Tell whether those which agree on an earlier time speak for more than the present."""
        spoken = frozenset[str]().union(*(arrival.sensors for arrival in chain))
        is_periodic = all(self.periods.get(name) is not None for name in spoken)
        return len(chain) >= self._count or (is_periodic and spoken >= self._heard)
