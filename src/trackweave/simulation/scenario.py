"""What a simulation is made of: an area, sensors, targets."""

import math
from dataclasses import dataclass, replace
from typing import Annotated

from trackweave.errors import InvalidInputError
from trackweave.fields import Limit, settle
from trackweave.keys import ABOVE_ZERO, AT_LEAST_ZERO, NOISE, Key
from trackweave.simulation.targets import (
    MANY,
    MOST_TARGETS,
    NAME,
    VECTOR,
    Crossing,
    Parallel,
    Target,
    require_axes,
)

__all__ = ["Area", "RandomTargets", "Scenario", "SimulatedSensor"]

# A slip of a unit (a period in microseconds, say) must not fill the memory.
MOST_SCANS = 1_000_000
MOST_SECONDS = 1e11
MOST_FALSE_ALARMS = 1_000_000
MOST_ROWS = 10_000_000
SHARE = Key("a number above 0 and of at most 1", ABOVE_ZERO.least, 1)


@dataclass(frozen=True, slots=True)
class Area:
    """The box in which random targets live and which the sensors watch, with a margin [m].

    Fields, units and ranges are those of the reference page "Scenario files"; a value that does
    not fit is refused.

    Examples
    --------
    >>> from trackweave.simulation import Area
    >>> Area(low=(0.0, 0.0), high=(2000.0, 1400.0), margin=50.0).dim
    2
    """

    low: Annotated[tuple[float, ...], VECTOR]
    high: Annotated[tuple[float, ...], VECTOR]
    margin: Annotated[float, AT_LEAST_ZERO] = 0.0

    def __post_init__(self) -> None:
        settle(self)
        require_axes(self.high, "high", len(self.low))
        if not all(least < most for least, most in zip(self.low, self.high, strict=True)):
            raise InvalidInputError(
                f"high: {self.high!r}; expected numbers above low {self.low!r}"
            )

    @property
    def dim(self) -> int:
        """Number of spatial dimensions, 2 or 3."""
        return len(self.low)


@dataclass(frozen=True, slots=True)
class SimulatedSensor:
    """A sensor that reports positions from time to time, with noise, misses and false alarms.

    Fields, units and ranges are those of the reference page "Scenario files"; without a position
    it stands in the origin, without ``max_range`` it sees the whole area.

    Examples
    --------
    >>> from trackweave.simulation import SimulatedSensor
    >>> pier = SimulatedSensor("pier", sigma=8.0, scan_period=6.0, clutter_per_scan=4.0)
    >>> pier.detection_probability, pier.sigmas(2)
    (0.9, (8.0, 8.0))
    """

    name: Annotated[str, NAME]
    sigma: Annotated[
        Annotated[float, NOISE] | tuple[Annotated[float, NOISE], ...],
        Key(
            f"a number above 0, {NOISE.least:g} to {NOISE.most:g} m, or one per axis", size=(2, 3)
        ),
    ]
    scan_period: Annotated[float, ABOVE_ZERO]
    detection_probability: Annotated[float, SHARE] = 0.9
    clutter_per_scan: Annotated[
        float, Key("a number of at least 0 and of at most 1e+06", 0, MOST_FALSE_ALARMS)
    ] = 0.0
    start_offset: Annotated[
        float, Key("a number of at least 0 and of at most 1e+11", 0, MOST_SECONDS)
    ] = 0.0
    position: Annotated[tuple[float, ...] | None, VECTOR] = None
    max_range: Annotated[Limit, ABOVE_ZERO] = math.inf

    def __post_init__(self) -> None:
        settle(self)

    def sigmas(self, dim: int) -> tuple[float, ...]:
        """Return the standard deviation along each of ``dim`` axes [m]."""
        return self.sigma if isinstance(self.sigma, tuple) else (self.sigma,) * dim

    def place(self, dim: int) -> tuple[float, ...]:
        """Return where it stands [m]."""
        return (0.0,) * dim if self.position is None else self.position


@dataclass(frozen=True, slots=True)
class RandomTargets:
    """Targets that appear anywhere in the area, move in any direction, and disappear.

    Fields, units and ranges are those of the reference page "Scenario files". With ``stay_inside``
    a target's place and heading are drawn so that its course stays in the area for as long as it
    lives; else it goes anywhere, and disappears where it leaves the area. Either holds for the
    straight course; process noise may carry it a little beyond.

    Examples
    --------
    >>> from trackweave.simulation import RandomTargets
    >>> RandomTargets(count=20, speed=(5.0, 15.0), birth_rate=0.1).survival
    1.0
    """

    count: Annotated[int, MANY]
    speed: tuple[float, float]
    birth_rate: Annotated[float, AT_LEAST_ZERO] = 0.0
    survival: Annotated[float, SHARE] = 1.0
    stay_inside: bool = True

    def __post_init__(self) -> None:
        settle(self)
        if not 0 <= self.speed[0] <= self.speed[1]:
            raise InvalidInputError(
                f"speed: {self.speed!r}; expected a least speed of at least 0 and a greatest "
                "not below it"
            )


@dataclass(frozen=True, slots=True)
class Scenario:
    """A scene to simulate, with the keys of the reference page "Scenario files".

    ``simulate`` takes its generator as an argument and does not read the seed.

    Examples
    --------
    >>> from trackweave.simulation import Area, Scenario, SimulatedSensor, Target
    >>> scene = Scenario(
    ...     area=Area((0.0, 0.0), (1000.0, 1000.0)),
    ...     duration=30.0,
    ...     sensors=(SimulatedSensor("radar", sigma=5.0, scan_period=2.0),),
    ...     targets=(Target((100.0, 100.0), (10.0, 0.0)),),
    ... )
    >>> [target.name for target in scene.explicit_targets()]
    ['1']
    """

    area: Area
    duration: Annotated[
        float, Key("a number above 0 and of at most 1e+11", ABOVE_ZERO.least, MOST_SECONDS)
    ]
    sensors: tuple[SimulatedSensor, ...]
    targets: tuple[Target, ...] = ()
    crossings: tuple[Crossing, ...] = ()
    parallels: tuple[Parallel, ...] = ()
    random: RandomTargets | None = None
    process_noise: Annotated[float, AT_LEAST_ZERO] = 0.0
    seed: Annotated[int, Key("a whole number of at least 0", 0)] = 1

    def __post_init__(self) -> None:
        settle(self)
        if not self.sensors:
            raise InvalidInputError("sensors: none; expected at least one")
        _check_dimensions(self)
        _check_size(self)
        _check_names("sensors", [sensor.name for sensor in self.sensors])
        _check_names("targets", [target.name for target in self.explicit_targets()])

    def explicit_targets(self) -> tuple[Target, ...]:
        """Return all targets but the random ones, each with a name."""
        # One without a name is called by its number, counted from 1.
        everyone = list(self.targets)
        groups: tuple[Crossing | Parallel, ...] = (*self.crossings, *self.parallels)
        for group in groups:
            everyone.extend(group.targets())
        return tuple(
            target if target.name is not None else replace(target, name=str(place))
            for place, target in enumerate(everyone, start=1)
        )


def _check_dimensions(scenario: Scenario) -> None:
    dim = scenario.area.dim
    for place, sensor in enumerate(scenario.sensors):
        for key in ("sigma", "position"):
            value = getattr(sensor, key)
            if isinstance(value, tuple) and len(value) != dim:
                raise InvalidInputError(
                    f"sensors[{place}].{key}: {value!r}; expected {dim} numbers, as the area has"
                )
    for kind in ("targets", "crossings", "parallels"):
        for place, thing in enumerate(getattr(scenario, kind)):
            if thing.dim != dim:
                raise InvalidInputError(
                    f"{kind}[{place}]: {thing.dim} dimensions; expected {dim}, as the area has"
                )
            if thing.start > scenario.duration:
                raise InvalidInputError(
                    f"{kind}[{place}].start: {thing.start:g}; expected at most the duration "
                    f"{scenario.duration:g}"
                )


def _check_size(scenario: Scenario) -> None:
    duration, wanted = scenario.duration, scenario.random
    scans = [duration / sensor.scan_period for sensor in scenario.sensors]
    if sum(scans) > MOST_SCANS:
        raise InvalidInputError(
            f"sensors: {sum(scans):.3g} scans in {duration:g} s; expected at most {MOST_SCANS}"
        )
    births = 0.0 if wanted is None else wanted.birth_rate * duration
    if births > MOST_TARGETS:
        raise InvalidInputError(
            f"random.birth_rate: {births:.3g} births in {duration:g} s; "
            f"expected at most {MOST_TARGETS}"
        )
    groups: tuple[Crossing | Parallel, ...] = (*scenario.crossings, *scenario.parallels)
    explicit = len(scenario.targets) + sum(group.count for group in groups)
    n_targets = explicit + births + (wanted.count if wanted else 0)
    if n_targets > MOST_TARGETS:
        raise InvalidInputError(
            f"targets: {n_targets:.15g} with crossings, parallels and random ones; expected at "
            f"most {MOST_TARGETS}"
        )
    clutter = sum(
        many * sensor.clutter_per_scan
        for many, sensor in zip(scans, scenario.sensors, strict=True)
    )
    if n_targets * sum(scans) + clutter > MOST_ROWS:
        raise InvalidInputError(
            f"duration: {duration:g} s with {n_targets:.3g} targets, {sum(scans):.3g} scans and "
            f"{clutter:.3g} false alarms; expected at most {MOST_ROWS:.3g} reports"
        )


def _check_names(kind: str, names: list[str | None]) -> None:
    seen: set[str | None] = set()
    for place, name in enumerate(names):
        if name in seen:
            raise InvalidInputError(f"{kind}[{place}].name: {name!r} comes twice; expected once")
        seen.add(name)
