"""Targets that a scenario names one by one, and ready patterns of them."""

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

from trackweave.errors import InvalidInputError
from trackweave.fields import settle
from trackweave.keys import ABOVE_ZERO, AT_LEAST_ZERO, Key

__all__ = [
    "MANY", "MOST_TARGETS", "NAME", "VECTOR", "Crossing", "Manoeuvre", "Parallel", "Target",
    "require_axes",
]  # fmt: skip

MOST_TARGETS = 100_000
"""As many may be in a scenario; more are a slip."""
LONGEST_NAME = 256
"""Bytes of a name, as files of reports may have."""
MANY = Key(f"a whole number from 0 to {MOST_TARGETS}", 0, MOST_TARGETS)
SEVERAL = Key(f"a whole number from 2 to {MOST_TARGETS}", 2, MOST_TARGETS)
VECTOR = Key("two or three finite numbers", size=(2, 3))
NAME = Key(
    f"a text that is not empty, of at most {LONGEST_NAME} bytes, without blanks around it or line "
    "breaks in it",
    holds=lambda name: (
        name.strip() == name != "" and name.isprintable() and len(name.encode()) <= LONGEST_NAME
    ),
)


@dataclass(frozen=True, slots=True)
class Manoeuvre:
    """A time in which a target turns, to the left [degrees/s], or accelerates: one of the two.

    Examples
    --------
    >>> from trackweave.simulation import Manoeuvre
    >>> Manoeuvre(start=40.0, duration=24.0, turn_rate_deg_s=3.6).end
    64.0
    """

    start: float
    duration: Annotated[float, ABOVE_ZERO]
    turn_rate_deg_s: Annotated[float | None, Key("a number from -180 to 180", -180, 180)] = None
    acceleration: Annotated[tuple[float, ...] | None, VECTOR] = None

    def __post_init__(self) -> None:
        settle(self)
        if (self.turn_rate_deg_s is None) == (self.acceleration is None):
            raise InvalidInputError(
                f"turn_rate_deg_s: {self.turn_rate_deg_s!r}, acceleration: "
                f"{self.acceleration!r}; expected one of the two"
            )

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

    Examples
    --------
    >>> from trackweave.simulation import Manoeuvre, Target
    >>> turn = Manoeuvre(start=40.0, duration=24.0, turn_rate_deg_s=3.6)
    >>> Target((250.0, 120.0), (12.0, 1.0), end=90.0, manoeuvres=(turn,)).at
    0.0
    """

    position: Annotated[tuple[float, ...], VECTOR]
    velocity: tuple[float, ...]
    start: Annotated[float, AT_LEAST_ZERO] = 0.0
    end: float | None = None
    at: float | None = None
    manoeuvres: tuple[Manoeuvre, ...] = ()
    name: Annotated[str | None, NAME] = None

    def __post_init__(self) -> None:
        settle(self)
        require_axes(self.velocity, "velocity", self.dim)
        _check_life(self)
        if self.at is None:
            object.__setattr__(self, "at", self.start)
        ordered = tuple(sorted(self.manoeuvres, key=lambda manoeuvre: manoeuvre.start))
        for first, second in itertools.pairwise(ordered):
            if second.start < first.end:
                raise InvalidInputError(
                    f"manoeuvres: one until {first.end:g} s and one from {second.start:g} s; "
                    "expected manoeuvres that do not overlap"
                )
        for manoeuvre in ordered:
            if manoeuvre.acceleration is not None:
                require_axes(manoeuvre.acceleration, "manoeuvres.acceleration", self.dim)
        object.__setattr__(self, "manoeuvres", ordered)

    @property
    def dim(self) -> int:
        """Number of spatial dimensions, 2 or 3."""
        return len(self.position)


@dataclass(frozen=True, slots=True)
class Crossing:
    """Targets that meet at one point at one time, their headings an angle apart.

    ``heading_deg`` is the middle of their headings, clockwise from north (the y axis); units and
    ranges are those of the reference page "Scenario files".

    Examples
    --------
    >>> from trackweave.simulation import Crossing
    >>> pair = Crossing((500.0, 500.0), time=30.0, speed=10.0, angle_deg=60.0)
    >>> [tuple(round(part, 1) for part in target.velocity) for target in pair.targets()]
    [(8.7, 5.0), (8.7, -5.0)]
    """

    point: Annotated[tuple[float, ...], VECTOR]
    time: Annotated[float, AT_LEAST_ZERO]
    speed: Annotated[float, ABOVE_ZERO]
    count: Annotated[int, SEVERAL] = 2
    angle_deg: Annotated[
        float, Key("a number above 0 and of at most 180", ABOVE_ZERO.least, 180)
    ] = 20.0
    heading_deg: float = 90.0
    start: Annotated[float, AT_LEAST_ZERO] = 0.0
    end: float | None = None

    def __post_init__(self) -> None:
        settle(self)
        _check_life(self)

    @property
    def dim(self) -> int:
        """Number of spatial dimensions, 2 or 3."""
        return len(self.point)

    def targets(self) -> tuple[Target, ...]:
        """Return the targets, those with the smallest heading first."""
        found = []
        for number in range(self.count):
            heading = self.heading_deg + self.angle_deg * (number - (self.count - 1) / 2)
            velocity = _along(heading, self.speed, self.dim)
            found.append(Target(self.point, velocity, self.start, self.end, at=self.time))
        return tuple(found)


@dataclass(frozen=True, slots=True)
class Parallel:
    """Targets that move side by side at a spacing [m]; their row's middle starts at a position.

    Examples
    --------
    >>> from trackweave.simulation import Parallel
    >>> pair = Parallel((100.0, 500.0), (10.0, 0.0), spacing=50.0)
    >>> [target.position for target in pair.targets()]
    [(100.0, 475.0), (100.0, 525.0)]
    """

    position: Annotated[tuple[float, ...], VECTOR]
    velocity: tuple[float, ...]
    spacing: Annotated[float, ABOVE_ZERO]
    count: Annotated[int, SEVERAL] = 2
    start: Annotated[float, AT_LEAST_ZERO] = 0.0
    end: float | None = None

    def __post_init__(self) -> None:
        settle(self)
        require_axes(self.velocity, "velocity", self.dim)
        if not math.hypot(*self.velocity[:2]) > 0:
            raise InvalidInputError(
                f"velocity: {self.velocity!r}; expected a velocity that is not zero in the plane"
            )
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
        for number in range(self.count):
            aside = self.spacing * (number - (self.count - 1) / 2) / speed
            x, y, *rest = self.position
            place = (x - aside * north, y + aside * east, *rest)
            found.append(Target(place, self.velocity, self.start, self.end))
        return tuple(found)


def _along(heading_deg: float, speed: float, dim: int) -> tuple[float, ...]:
    heading = math.radians(heading_deg)
    level = (speed * math.sin(heading), speed * math.cos(heading))
    return level if dim == 2 else (*level, 0.0)


def _check_life(thing: Target | Crossing | Parallel) -> None:
    if thing.end is not None and not thing.end > thing.start:
        raise InvalidInputError(f"end: {thing.end!r}; expected a number above {thing.start:g}")


def require_axes(values: Sequence[float], key: str, dim: int) -> None:
    """Refuse a vector of another number of components."""
    if len(values) != dim:
        many = {2: "two", 3: "three"}[dim]
        raise InvalidInputError(f"{key}: {values!r:.80}; expected {many} finite numbers")
