"""From a scenario to reports and the truth behind them."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.domain.reports import ReportTable
from trackweave.domain.truth import TruthTable
from trackweave.errors import InvalidInputError
from trackweave.randomness import RandomSource, generator_of
from trackweave.simulation._paths import course, random_walk
from trackweave.simulation.scenario import Area, RandomTargets, Scenario, SimulatedSensor
from trackweave.simulation.targets import Target
from trackweave.summaries import summary

__all__ = ["Simulation", "simulate"]

MOST_TRIES = 10_000
FARTHEST = 1e9
"""Coordinates [m] and velocities [m/s] that files of reports may have."""


@dataclass(frozen=True, slots=True, eq=False)
class Simulation:
    """What the sensors reported, and what really was.

    Parameters
    ----------
    reports
        With the column ``target`` in ``carried``: the target behind each report, empty text for
        a false alarm.
    truth
        Position and velocity of every living target at every time of a scan.
    """

    reports: ReportTable
    truth: TruthTable

    __repr__ = summary


class _Truth(NamedTuple):
    """Rows of the truth, grouped by time: those of ``times[k]`` are ``first[k]:first[k + 1]``."""

    times: FloatArray
    first: IntArray
    target: IntArray
    position: FloatArray
    velocity: FloatArray


class _Reports(NamedTuple):
    """Reports of one scan; target -1 for a false alarm."""

    measurement: FloatArray
    target: IntArray


def simulate(scenario: Scenario, rng: RandomSource = 0) -> Simulation:
    """Return what the scenario's sensors report, and the truth.

    A target is reported with the sensor's chance, with normal noise, where its true position is
    in the area (and its margin) and within the sensor's range. False alarms are Poisson in number
    and even over the same space. Reports of one scan come in random order.

    Parameters
    ----------
    scenario
        What to simulate.
    rng
        The only source of randomness: a generator, or a seed. The same gives the same result.

    Returns
    -------
    The reports, sorted by time, then by the sensors' order, and the truth.

    Raises
    ------
    InvalidInputError
        If random targets cannot stay inside the area, a sensor watches none of it, or a target
        or report is too far away or too fast for a file of reports.

    Examples
    --------
    >>> from trackweave.simulation import demo_scenario, simulate
    >>> scene = simulate(demo_scenario(), rng=1)
    >>> len(scene.reports), len(set(scene.truth.target))
    (985, 9)
    >>> int((scene.reports.carried["target"] == "").sum())  # false alarms
    539
    """
    rng = generator_of(rng)
    targets = [*scenario.explicit_targets()]
    if scenario.random is not None:
        targets += _random_targets(scenario, scenario.random, len(targets), rng)
    names = np.array([target.name for target in targets], dtype=object)
    if len(set(names)) < len(names):
        raise InvalidInputError(
            "targets: a name is also a random target's number; expected others"
        )
    schedule = _schedule(scenario)
    truth = _truth(scenario, targets, schedule[0], rng)
    table = TruthTable.from_columns(
        np.repeat(truth.times, np.diff(truth.first)),
        names[truth.target],
        truth.position,
        truth.velocity,
    )
    reports = _reports(scenario, truth, schedule, names, rng)
    _require_near(truth, reports)
    return Simulation(reports, table)


def _require_near(truth: _Truth, reports: ReportTable) -> None:
    """Refuse places and speeds that no reader of reports and truth takes."""
    for what, values, unit in (
        ("place", truth.position, "m"),
        ("velocity", truth.velocity, "m/s"),
        ("report", reports.measurement, "m"),
    ):
        farthest = float(np.max(np.abs(values), initial=0.0))
        if not farthest <= FARTHEST:
            raise InvalidInputError(
                f"targets: a {what} of {farthest:.3g} {unit}; expected at most {FARTHEST:g} "
                "along each axis"
            )


def _schedule(scenario: Scenario) -> tuple[FloatArray, IntArray]:
    """Return the time and the sensor of every scan, in order of time, then of sensor."""
    times, sensors = [], []
    for place, sensor in enumerate(scenario.sensors):
        # Multiples instead of sums, so that hours of scans do not drift; the last time counts.
        last = math.floor((scenario.duration - sensor.start_offset) / sensor.scan_period + 1e-9)
        own = sensor.start_offset + sensor.scan_period * np.arange(last + 1)
        times.append(own)
        sensors.append(np.full(own.size, place))
    time, which = np.concatenate(times), np.concatenate(sensors)
    order = np.lexsort((which, time))
    return time[order], which[order]


def _random_targets(
    scenario: Scenario, wanted: RandomTargets, n_before: int, rng: np.random.Generator
) -> list[Target]:
    n_births = int(rng.poisson(wanted.birth_rate * scenario.duration))
    births = np.sort(rng.uniform(0.0, scenario.duration, n_births))
    starts = np.concatenate([np.zeros(wanted.count), births])
    lives = np.full(starts.size, math.inf)
    if wanted.survival < 1:
        lives = rng.exponential(-1 / math.log(wanted.survival), starts.size)
    ends = np.minimum(starts + lives, scenario.duration)
    return [
        _random_target(scenario.area, wanted, (float(start), float(end)), str(name), rng)
        for name, (start, end) in enumerate(zip(starts, ends, strict=True), start=n_before + 1)
        if end > start
    ]


def _random_target(
    area: Area,
    wanted: RandomTargets,
    life: tuple[float, float],
    name: str,
    rng: np.random.Generator,
) -> Target:
    start, end = life
    low, high = np.array(area.low), np.array(area.high)
    for _ in range(MOST_TRIES):
        place = rng.uniform(low, high)
        speed, heading = rng.uniform(*wanted.speed), rng.uniform(0.0, 2 * math.pi)
        velocity = np.zeros(area.dim)
        velocity[:2] = speed * math.cos(heading), speed * math.sin(heading)
        inside = _time_to_border(place, velocity, area)
        if inside > 0 and (inside >= end - start or not wanted.stay_inside):
            last = min(end, start + inside)
            return Target(tuple(place.tolist()), tuple(velocity.tolist()), start, last, name=name)
    raise InvalidInputError(
        f"random.speed: {wanted.speed!r}; expected speeds at which a target can stay in the area "
        f"for its {end - start:g} s, or stay_inside = false"
    )


def _time_to_border(place: FloatArray, velocity: FloatArray, area: Area) -> float:
    """Return the seconds until a straight course leaves the area."""
    ahead = np.where(velocity > 0, np.array(area.high), np.array(area.low)) - place
    moving = velocity != 0
    return float(np.min(ahead[moving] / velocity[moving], initial=math.inf))


def _truth(
    scenario: Scenario, targets: list[Target], scan_times: FloatArray, rng: np.random.Generator
) -> _Truth:
    times = np.unique(scan_times)
    when, who = [np.empty(0, dtype=np.int64)], [np.empty(0, dtype=np.int64)]
    where = [np.empty((0, scenario.area.dim))]
    how = [np.empty((0, scenario.area.dim))]
    for number, target in enumerate(targets):
        end = scenario.duration if target.end is None else target.end
        alive = np.flatnonzero((times >= target.start) & (times <= end + 1e-9))
        position, velocity = _lived(target, times[alive], scenario.process_noise, rng)
        when.append(alive)
        who.append(np.full(alive.size, number))
        where.append(position)
        how.append(velocity)
    rows = np.concatenate(when)
    order = np.argsort(rows, kind="stable")
    return _Truth(
        times,
        np.searchsorted(rows[order], np.arange(times.size + 1)),
        np.concatenate(who)[order],
        np.concatenate(where)[order],
        np.concatenate(how)[order],
    )


def _lived(
    target: Target, times: FloatArray, process_noise: float, rng: np.random.Generator
) -> tuple[FloatArray, FloatArray]:
    """Return the target's course with process noise spreading from where it is tied down."""
    position, velocity = course(target, times)
    if process_noise == 0:
        return position, velocity
    at = target.start if target.at is None else target.at
    position, velocity = position.copy(), velocity.copy()
    for side in (np.flatnonzero(times >= at), np.flatnonzero(times < at)[::-1]):
        away = np.concatenate([[at], times[side]])
        add_position, add_velocity = random_walk(away, target.dim, process_noise, rng)
        position[side] += add_position[1:]
        velocity[side] += add_velocity[1:]
    return position, velocity


def _reports(
    scenario: Scenario,
    truth: _Truth,
    schedule: tuple[FloatArray, IntArray],
    names: np.ndarray[tuple[int], np.dtype[np.object_]],
    rng: np.random.Generator,
) -> ReportTable:
    dim = scenario.area.dim
    time, which = schedule
    scans = []
    for moment, sensor in zip(np.searchsorted(truth.times, time), which, strict=True):
        rows = slice(truth.first[moment], truth.first[moment + 1])
        here = _Reports(truth.position[rows], truth.target[rows])
        scans.append(_scan(scenario.area, scenario.sensors[sensor], here, rng))
    sizes = np.array([scan.target.size for scan in scans], dtype=np.int64)
    target = np.concatenate([np.empty(0, dtype=np.int64), *(scan.target for scan in scans)])
    sensors = np.repeat(which, sizes).astype(np.int64)
    sigmas = np.array([sensor.sigmas(dim) for sensor in scenario.sensors])
    labels = np.append(names, "")
    return ReportTable(
        time=np.repeat(time, sizes),
        sensor=sensors,
        sensors=tuple(sensor.name for sensor in scenario.sensors),
        measurement=np.concatenate([np.empty((0, dim)), *(scan.measurement for scan in scans)]),
        sigma=sigmas[sensors],
        report=np.arange(1, target.size + 1).astype(str).astype(object),
        carried={"target": labels[target]},
    )


def _scan(
    area: Area, sensor: SimulatedSensor, present: _Reports, rng: np.random.Generator
) -> _Reports:
    seen = _watched(area, sensor, present.measurement)
    seen &= rng.random(seen.size) < sensor.detection_probability
    noise = rng.standard_normal((int(seen.sum()), area.dim)) * sensor.sigmas(area.dim)
    false = _false_alarms(area, sensor, int(rng.poisson(sensor.clutter_per_scan)), rng)
    measurement = np.concatenate([present.measurement[seen] + noise, false])
    target = np.concatenate([present.target[seen], np.full(len(false), -1)])
    order = rng.permutation(target.size)
    return _Reports(measurement[order], target[order])


def _watched(
    area: Area, sensor: SimulatedSensor, position: FloatArray
) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    low, high = np.array(area.low) - area.margin, np.array(area.high) + area.margin
    inside = np.all((position >= low) & (position <= high), axis=1)
    distance = np.linalg.norm(position - np.array(sensor.place(area.dim)), axis=1)
    watched: np.ndarray[tuple[int], np.dtype[np.bool_]] = inside & (distance <= sensor.max_range)
    return watched


def _false_alarms(
    area: Area, sensor: SimulatedSensor, count: int, rng: np.random.Generator
) -> FloatArray:
    """Return ``count`` places, even over what the sensor watches, by rejection."""
    centre = np.array(sensor.place(area.dim))
    low = np.maximum(np.array(area.low) - area.margin, centre - sensor.max_range)
    high = np.minimum(np.array(area.high) + area.margin, centre + sensor.max_range)
    found = np.empty((0, area.dim))
    for _ in range(MOST_TRIES):
        if len(found) >= count:
            return found[:count]
        if np.any(low > high):
            break
        places = rng.uniform(low, high, (2 * count + 8, area.dim))
        found = np.concatenate([found, places[_watched(area, sensor, places)]])
    raise InvalidInputError(
        f"sensor {sensor.name!r}, max_range: {sensor.max_range:g}; "
        "expected a range that reaches into the area"
    )
