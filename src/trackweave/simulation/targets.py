"""Targets that a scenario names one by one, and ready patterns of them."""

import itertools
import math
from dataclasses import dataclass

from trackweave.errors import InvalidInputError
from trackweave.simulation._checks import number, text, vector, whole

__all__ = ["MOST_TARGETS", "Crossing", "Manoeuvre", "Parallel", "Target"]

MOST_TARGETS = 100_000
"""As many may be in a scenario; more are a slip."""


@dataclass(frozen=True, slots=True)
class Manoeuvre:
    """A time in which a target turns, to the left [degrees/s], or accelerates: one of the two."""

    start: float
    duration: float
    turn_rate_deg_s: float | None = None
    acceleration: tuple[float, ...] | None = None

    def __post_init__(self) -> None:
        _set(self, "start", number(self.start, "start"))
        _set(self, "duration", number(self.duration, "duration", above=0.0))
        if (self.turn_rate_deg_s is None) == (self.acceleration is None):
            raise InvalidInputError(
                f"turn_rate_deg_s: {self.turn_rate_deg_s!r}, acceleration: "
                f"{self.acceleration!r}; expected one of the two"
            )
        if self.turn_rate_deg_s is not None:
            rate = number(self.turn_rate_deg_s, "turn_rate_deg_s", low=-180.0, high=180.0)
            _set(self, "turn_rate_deg_s", rate)
        if self.acceleration is not None:
            _set(self, "acceleration", vector(self.acceleration, "acceleration"))

    @property
    def end(self) -> float:
        """When it is over [s]."""
        return self.start + self.duration


@dataclass(frozen=True, slots=True)
class Target:
    """One target: where it is at one time, and what it does before and after.

    Position [m] and velocity [m/s] hold at the time ``at`` [s], left out at ``start``; process
    noise spreads from here in both directions of time. Manoeuvres do not overlap. Without an end
    it stays to the scenario's; without a name it is called by its number.
    """

    position: tuple[float, ...]
    velocity: tuple[float, ...]
    start: float = 0.0
    end: float | None = None
    at: float | None = None
    manoeuvres: tuple[Manoeuvre, ...] = ()
    name: str | None = None

    def __post_init__(self) -> None:
        position = vector(self.position, "position")
        _set(self, "position", position)
        _set(self, "velocity", vector(self.velocity, "velocity", len(position)))
        _check_life(self)
        _set(self, "at", self.start if self.at is None else number(self.at, "at"))
        if self.name is not None:
            text(self.name, "name")
        ordered = tuple(sorted(self.manoeuvres, key=lambda manoeuvre: manoeuvre.start))
        for first, second in itertools.pairwise(ordered):
            if second.start < first.end:
                raise InvalidInputError(
                    f"manoeuvres: one until {first.end:g} s and one from {second.start:g} s; "
                    "expected manoeuvres that do not overlap"
                )
        for manoeuvre in ordered:
            if manoeuvre.acceleration is not None:
                vector(manoeuvre.acceleration, "manoeuvres.acceleration", len(position))
        _set(self, "manoeuvres", ordered)

    @property
    def dim(self) -> int:
        """Number of spatial dimensions, 2 or 3."""
        return len(self.position)


@dataclass(frozen=True, slots=True)
class Crossing:
    """Targets that meet at one point at one time, their headings an angle apart.

    ``heading_deg`` is the middle of their headings, clockwise from north (the y axis); units and
    ranges are those of the reference page "Scenario files".
    """

    point: tuple[float, ...]
    time: float
    speed: float
    count: int = 2
    angle_deg: float = 20.0
    heading_deg: float = 90.0
    start: float = 0.0
    end: float | None = None

    def __post_init__(self) -> None:
        _set(self, "point", vector(self.point, "point"))
        _set(self, "time", number(self.time, "time", low=0.0))
        _set(self, "speed", number(self.speed, "speed", above=0.0))
        _set(self, "count", whole(self.count, "count", 2, MOST_TARGETS))
        _set(self, "angle_deg", number(self.angle_deg, "angle_deg", above=0.0, high=180.0))
        _set(self, "heading_deg", number(self.heading_deg, "heading_deg"))
        _check_life(self)

    @property
    def dim(self) -> int:
        """Number of spatial dimensions, 2 or 3."""
        return len(self.point)

    def targets(self) -> tuple[Target, ...]:
        """Return the targets, those with the smallest heading first."""
        found = []
        for number_ in range(self.count):
            heading = self.heading_deg + self.angle_deg * (number_ - (self.count - 1) / 2)
            velocity = _along(heading, self.speed, self.dim)
            found.append(Target(self.point, velocity, self.start, self.end, at=self.time))
        return tuple(found)


@dataclass(frozen=True, slots=True)
class Parallel:
    """Targets that move side by side at a spacing [m]; their row's middle starts at a position."""

    position: tuple[float, ...]
    velocity: tuple[float, ...]
    spacing: float
    count: int = 2
    start: float = 0.0
    end: float | None = None

    def __post_init__(self) -> None:
        position = vector(self.position, "position")
        _set(self, "position", position)
        velocity = vector(self.velocity, "velocity", len(position))
        if not math.hypot(*velocity[:2]) > 0:
            raise InvalidInputError(
                f"velocity: {self.velocity!r}; expected a velocity that is not zero in the plane"
            )
        _set(self, "velocity", velocity)
        _set(self, "spacing", number(self.spacing, "spacing", above=0.0))
        _set(self, "count", whole(self.count, "count", 2, MOST_TARGETS))
        _check_life(self)

    @property
    def dim(self) -> int:
        """Number of spatial dimensions, 2 or 3."""
        return len(self.position)

    def targets(self) -> tuple[Target, ...]:
        """Return the targets, from the right of their course to the left."""
        east, north = self.velocity[:2]
        speed = math.hypot(east, north)
        found = []
        for number_ in range(self.count):
            aside = self.spacing * (number_ - (self.count - 1) / 2) / speed
            x, y, *rest = self.position
            place = (x - aside * north, y + aside * east, *rest)
            found.append(Target(place, self.velocity, self.start, self.end))
        return tuple(found)


def _along(heading_deg: float, speed: float, dim: int) -> tuple[float, ...]:
    heading = math.radians(heading_deg)
    level = (speed * math.sin(heading), speed * math.cos(heading))
    return level if dim == 2 else (*level, 0.0)


def _check_life(thing: Target | Crossing | Parallel) -> None:
    start = number(thing.start, "start", low=0.0)
    _set(thing, "start", start)
    if thing.end is not None:
        _set(thing, "end", number(thing.end, "end", above=start))


def _set(thing: object, key: str, value: object) -> None:
    # Frozen dataclasses keep the checked and converted value this way.
    object.__setattr__(thing, key, value)
