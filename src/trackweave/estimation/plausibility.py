"""Estimates that no sensor and no object can have, and what stands in for them."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.domain.reports import ReportTable
from trackweave.estimation.estimates import Estimates, SensorEstimate, bounded, digits
from trackweave.estimation.frames import is_absurd_period
from trackweave.estimation.lone import fastest_below
from trackweave.estimation.trees import tree_of

__all__ = ["believable", "without_stale"]

# Nothing that is seen from the ground flies faster [m/s], where numbers are metres for sure.
FASTEST_ON_EARTH, FASTEST = 1_500.0, 12_000.0
USUAL_SPEED = 50.0
# Above the air objects are in orbit, or fall as fast.
ABOVE_AIR_M, ORBITAL_SPEED = 90_000.0, 8_000.0
# An object that crosses all that is covered between two scans is none that can be followed.
CROSSED = 1.0
# Of so many reports the nearest neighbours are looked at; those of one object lie within this
# many times their distance, and its noise is no more than that.
SAMPLED, FEWEST = 300, 30
WITHIN, USUAL_NOISE = 30.0, 10.0
# How sentences on what stands in begin.
OF_SPEED, OF_NOISE = "motion.max_speed:", "a sigma of"


def believable(
    estimates: Estimates, reports: ReportTable, *, in_metres: bool, is_speed_told: bool = False
) -> Estimates:
    """Return estimates in which what cannot be is replaced, and a sentence says so."""
    # Positions are in metres for sure if they are of latitudes or ranges. Of a speed that is told
    # no estimate is used.
    notes = list(estimates.notes)
    sensors = dict(estimates.sensors)
    for index, name in enumerate(reports.sensors):
        rows = reports.sensor == index
        if name in sensors and np.any(rows):
            sensors[name], said = _sensor(sensors[name], reports, rows)
            notes += [f"sensor {name}: {sentence}" for sentence in said]
    speed = _speed(estimates.max_speed, sensors, reports, in_metres=in_metres)
    if speed != estimates.max_speed and not is_speed_told:
        notes.append(
            f"{OF_SPEED} {estimates.max_speed:.4g} m/s is what reports seem to tell, which "
            f"no object can be followed at; {speed:.4g} m/s stands in: better give it, and look "
            "at sensors' positions, clocks and units"
        )
    notes = list(dict.fromkeys(notes))
    return replace(estimates, sensors=sensors, max_speed=speed, notes=tuple(notes))


def without_stale(first: Estimates, last: Estimates) -> Estimates:
    """Return the last estimates without sentences of the first on what tracks told since."""
    stale = [OF_SPEED] if last.max_speed != first.max_speed else []
    stale += [
        f"sensor {name}: {OF_NOISE}"
        for name, each in first.sensors.items()
        if name in last.sensors and last.sensors[name].sigma != each.sigma
    ]
    keep = [n for n in last.notes if n not in first.notes or not n.startswith(tuple(stale))]
    return replace(last, notes=tuple(keep))


def _sensor(
    sensor: SensorEstimate, reports: ReportTable, rows: np.ndarray
) -> tuple[SensorEstimate, list[str]]:
    """Return a sensor with a noise and a period that can be, and what was wrong with them."""
    notes = []
    moments = np.unique(reports.time[rows])
    gap = float(np.median(np.diff(moments))) if moments.size > 1 else 0.0
    if sensor.scan_period is None and is_absurd_period(moments, gap):
        notes.append(
            f"its times lie {gap:.2g} s apart, which is taken for no scan period: it counts as a "
            "sensor that does not scan; better give scan_period"
        )
    near = _nearest(reports.measurement[rows])
    if near is not None and sensor.plane_sigma > WITHIN * near:
        sigma = bounded(USUAL_NOISE * near, 1e-9)
        notes.append(
            f"{OF_NOISE} {sensor.plane_sigma:.4g} m is what its reports seem to tell, although "
            f"they lie {near:.2g} m from one another; {sigma:.4g} m stands in: better give sigma"
        )
        sensor = replace(sensor, sigma=sigma, disagreement=0.0)
    return sensor, notes


def _nearest(position: FloatArray) -> float | None:
    """Return how near to one another reports of one object lie [m], None where none stand out."""
    some = np.unique(position[:: max(1, position.shape[0] // SAMPLED)], axis=0)
    if some.shape[0] < FEWEST:
        return None
    near = float(np.median(tree_of(some).query(some, k=2)[0][:, 1]))
    sides = np.maximum(np.ptp(some, axis=0), 1e-9)
    by_chance = 0.5 * float(np.prod(sides) / some.shape[0]) ** (1 / sides.size)
    return near if 0.0 < near < by_chance / WITHIN else None


def _speed(
    speed: float,
    sensors: Mapping[str, SensorEstimate],
    reports: ReportTable,
    *,
    in_metres: bool,
) -> float:
    """Return a greatest speed that can be [m/s]."""
    position = reports.measurement
    extent = float(np.linalg.norm(np.ptp(position, axis=0)))
    periods = [s.scan_period for s in sensors.values() if s.scan_period is not None]
    is_in_orbit = (
        in_metres and position.shape[1] > 2 and np.nanmedian(position[:, 2]) > ABOVE_AIR_M
    )
    # Other numbers may be of any unit: nanometres, or metres a day.
    most = np.inf
    if in_metres:
        most = FASTEST if is_in_orbit else FASTEST_ON_EARTH
    if periods and extent > 0:
        most = min(most, CROSSED * extent / min(periods))
    if speed <= most:
        return speed
    if is_in_orbit:
        return min(most, ORBITAL_SPEED)
    usual = [10 * s.plane_sigma / s.scan_period for s in sensors.values() if s.scan_period]
    lone = [
        index
        for index, name in enumerate(reports.sensors)
        if name in sensors and sensors[name].scans is False
    ]
    told = fastest_below(reports, lone, most) if in_metres else None
    if told is not None:
        return digits(told)
    return digits(min([most, *([USUAL_SPEED] if in_metres else []), *usual]))
