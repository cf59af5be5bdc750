"""What a simulation is made of: an area, sensors, targets."""

import math
from dataclasses import dataclass

from trackweave.domain.reports import NOISE_M
from trackweave.errors import InvalidInputError
from trackweave.simulation._checks import flag, number, text, vector, whole
from trackweave.simulation.targets import MOST_TARGETS, Crossing, Parallel, Target

__all__ = ["Area", "RandomTargets", "Scenario", "SimulatedSensor"]

# A slip of a unit (a period in microseconds, say) must not fill the memory.
MOST_SCANS = 1_000_000
MOST_SECONDS = 1e11
MOST_FALSE_ALARMS = 1_000_000
MOST_ROWS = 10_000_000


@dataclass(frozen=True, slots=True)
class Area:
    """The box in which random targets live and which the sensors watch, with a margin [m].

    Fields, units and ranges are those of the reference page "Scenario files"; a value that does
    not fit is refused.
    """

    low: tuple[float, ...]
    high: tuple[float, ...]
    margin: float = 0.0

    def __post_init__(self) -> None:
        low = vector(self.low, "low")
        high = vector(self.high, "high", len(low))
        if not all(least < most for least, most in zip(low, high, strict=True)):
            raise InvalidInputError(f"high: {self.high!r}; expected numbers above low {low!r}")
        _set(self, "low", low)
        _set(self, "high", high)
        _set(self, "margin", number(self.margin, "margin", low=0.0))

    @property
    def dim(self) -> int:
        """Number of spatial dimensions, 2 or 3."""
        return len(self.low)


@dataclass(frozen=True, slots=True)
class SimulatedSensor:
    """A sensor that reports positions from time to time, with noise, misses and false alarms.

    Fields, units and ranges are those of the reference page "Scenario files"; without a position
    it stands in the origin, without ``max_range`` it sees the whole area.
    """

    name: str
    sigma: float | tuple[float, ...]
    scan_period: float
    detection_probability: float = 0.9
    clutter_per_scan: float = 0.0
    start_offset: float = 0.0
    position: tuple[float, ...] | None = None
    max_range: float = math.inf

    def __post_init__(self) -> None:
        text(self.name, "name")
        raw: object = self.sigma
        if hasattr(raw, "__len__") and not isinstance(raw, str):
            sigmas = vector(raw, "sigma")
            _set(self, "sigma", tuple(_noise(sigma) for sigma in sigmas))
        else:
            _set(self, "sigma", _noise(raw))
        _set(self, "scan_period", number(self.scan_period, "scan_period", above=0.0))
        chance = number(self.detection_probability, "detection_probability", above=0.0, high=1.0)
        _set(self, "detection_probability", chance)
        clutter = number(
            self.clutter_per_scan, "clutter_per_scan", low=0.0, high=MOST_FALSE_ALARMS
        )
        _set(self, "clutter_per_scan", clutter)
        _set(
            self,
            "start_offset",
            number(self.start_offset, "start_offset", low=0.0, high=MOST_SECONDS),
        )
        if self.position is not None:
            _set(self, "position", vector(self.position, "position"))
        if self.max_range != math.inf:
            _set(self, "max_range", number(self.max_range, "max_range", above=0.0))

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
    """

    count: int
    speed: tuple[float, float]
    birth_rate: float = 0.0
    survival: float = 1.0
    stay_inside: bool = True

    def __post_init__(self) -> None:
        _set(self, "count", whole(self.count, "count", 0, MOST_TARGETS))
        least, greatest = vector(self.speed, "speed", 2)
        if not 0 <= least <= greatest:
            raise InvalidInputError(
                f"speed: {self.speed!r}; expected a least speed of at least 0 and a greatest "
                "not below it"
            )
        _set(self, "speed", (least, greatest))
        _set(self, "birth_rate", number(self.birth_rate, "birth_rate", low=0.0))
        _set(self, "survival", number(self.survival, "survival", above=0.0, high=1.0))
        flag(self.stay_inside, "stay_inside")


@dataclass(frozen=True, slots=True)
class Scenario:
    """A scene to simulate, with the keys of the reference page "Scenario files".

    ``simulate`` takes its generator as an argument and does not read the seed.
    """

    area: Area
    duration: float
    sensors: tuple[SimulatedSensor, ...]
    targets: tuple[Target, ...] = ()
    crossings: tuple[Crossing, ...] = ()
    parallels: tuple[Parallel, ...] = ()
    random: RandomTargets | None = None
    process_noise: float = 0.0
    seed: int = 1

    def __post_init__(self) -> None:
        _set(self, "duration", number(self.duration, "duration", above=0.0, high=MOST_SECONDS))
        _set(self, "process_noise", number(self.process_noise, "process_noise", low=0.0))
        _set(self, "seed", whole(self.seed, "seed", low=0))
        for key in ("sensors", "targets", "crossings", "parallels"):
            _set(self, key, tuple(getattr(self, key)))
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
            target if target.name is not None else _named(target, str(place))
            for place, target in enumerate(everyone, start=1)
        )


def _noise(value: object) -> float:
    # Above 0 first, so that the message of a negative one says no more than that.
    return number(number(value, "sigma", above=0.0), "sigma", low=NOISE_M[0], high=NOISE_M[1])


def _named(target: Target, name: str) -> Target:
    return Target(
        target.position,
        target.velocity,
        target.start,
        target.end,
        target.at,
        target.manoeuvres,
        name,
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


def _set(thing: object, key: str, value: object) -> None:
    # Frozen dataclasses keep the checked and converted value this way.
    object.__setattr__(thing, key, value)
