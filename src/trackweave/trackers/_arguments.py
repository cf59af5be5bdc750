"""The tracker's border: what it is given is checked here, before anything changes.

Values come as ``object``, because a caller's types are not to be trusted.
"""

from collections.abc import Iterable, Mapping
from dataclasses import replace
from itertools import pairwise

import numpy as np

from trackweave.arrays import (
    FloatArray,
    IntArray,
    is_number,
    is_whole,
    require_instance,
)
from trackweave.association.growth_limits import GrowthLimits
from trackweave.domain.foreign_kind import ForeignKind
from trackweave.domain.measurements import MeasurementKind
from trackweave.domain.scans import Scan
from trackweave.domain.tracks import TrackTable
from trackweave.errors import InvalidInputError
from trackweave.fields import checked_dimension, checked_members, plain
from trackweave.models.foreign_motion import AnyMotion, checked_motion
from trackweave.models.sensors import Sensor
from trackweave.randomness import RandomSource, generator_of
from trackweave.solvers.protocol import require_solver
from trackweave.trackers.lifecycle import Lifecycle
from trackweave.trackers.used_numbers import UsedNumbers
from trackweave.trackers.window import Window

MOST_TURNS = 2.0
"""Azimuths may go on counting beyond a turn, but not so far."""


def checked_sensors(sensors: object) -> dict[str, Sensor]:
    """Return the sensors by name, the names as text."""
    listed = checked_members(sensors, Sensor, "sensors")
    known = {sensor.name: sensor for sensor in listed}
    if not known:
        raise InvalidInputError("sensors: none; expected at least one")
    if len(known) < len(listed):
        names = [sensor.name for sensor in listed]
        twice = next(name for name in names if names.count(name) > 1)
        raise InvalidInputError(f"sensors: two called {twice!r:.80}; expected names that differ")
    return known


def tells_place(sensor: Sensor) -> bool:
    """Tell whether a sensor's reports say where their objects are, not just in which direction."""
    kind = sensor.measurement
    if isinstance(kind, ForeignKind):
        return kind.gives_position(kind.dim or 2)
    return not kind.is_bearing_only


def slowest_of(sensors: Iterable[Sensor]) -> Sensor | None:
    """Return the slowest periodic sensor, of those that tell positions where there are some."""
    periodic = [sensor for sensor in sensors if sensor.scan_period is not None]
    telling = [sensor for sensor in periodic if tells_place(sensor)]
    return max(telling or periodic, key=lambda sensor: sensor.scan_period or 0.0, default=None)


def reference_of(slowest: Sensor | None) -> tuple[str | None, float]:
    """Return whose scans the window counts, and how far the sectors of one may lie apart [s]."""
    if slowest is None:
        return None, 0.0
    return slowest.name, (slowest.scan_period or 0.0) if slowest.rotation else 0.0


def period_of(sensors: Iterable[Sensor]) -> float:
    """Return the scan period in which misses and survival are counted [s]."""
    slowest = slowest_of(sensors)
    return slowest.scan_period or 1.0 if slowest else 1.0


def checked_window(window: object) -> Window:
    """Return the window, which may be given as its depth or not at all."""
    if window is None:
        return Window()
    if isinstance(window, Window):
        return window
    depth = plain(window)
    if not is_whole(depth):
        raise InvalidInputError(f"window: {window!r:.80}; expected a Window or a number of scans")
    return Window(depth=depth)


def checked_priors(priors: TrackTable | None) -> TrackTable | None:
    """Return the tracks known beforehand, None where there are none."""
    if priors is None:
        return None
    require_instance(priors, TrackTable, "priors")
    if np.any(priors.track < 0) or np.unique(priors.track).shape[0] < len(priors):
        raise InvalidInputError("priors: expected one row for each track, and no name below 0")
    return priors if len(priors) else None


def require_parts(motion: object, search: object, lifecycle: object, limits: object) -> AnyMotion:
    """Refuse parts of a tracker that are of another kind, and return how objects move."""
    # Only that must be there.
    moving = checked_motion(motion)
    if search is not None:
        require_solver(search, "search")
    if lifecycle is not None:
        require_instance(lifecycle, Lifecycle, "lifecycle")
    if limits is not None:
        require_instance(limits, GrowthLimits, "limits")
    return moving


def require_step(
    scan: object, rng: RandomSource, deadline: object, stop: object
) -> np.random.Generator:
    """Refuse what no step can be taken with, and return the source of randomness."""
    require_instance(scan, Scan, "scan")
    return require_haste(rng, deadline, stop)


def in_order(scans: object) -> tuple[Scan, ...]:
    """Return the scans of a step, of which each has to be later than the one before."""
    if isinstance(scans, Scan):
        return (scans,)
    listed = checked_members(scans, Scan, "scan")
    if not listed:
        raise InvalidInputError("scan: no scans; expected a Scan, or several")
    for place, (early, late) in enumerate(pairwise(listed), start=1):
        if late.time <= early.time:
            raise InvalidInputError(
                f"scan: number {place + 1} of {len(listed)} (sensor {late.sensor}) at "
                f"{late.time:.15g} s, after one (sensor {early.sensor}) at {early.time:.15g} s; "
                "expected each later than the last"
            )
    return tuple(listed)


def require_haste(rng: RandomSource, deadline: object, stop: object) -> np.random.Generator:
    """Refuse a deadline or a stop that is none, and return the source of randomness."""
    generator = generator_of(rng)
    if deadline is not None and not (is_number(plain(deadline)) and plain(deadline) > 0):
        raise InvalidInputError(f"deadline: {deadline!r:.80}; expected a number > 0 [s], or None")
    if stop is not None and not callable(stop):
        raise InvalidInputError(
            f"stop: {stop!r:.80}; expected a function without arguments, or None"
        )
    return generator


def checked_dim(
    dim: object, priors: TrackTable | None, sensors: Mapping[str, Sensor]
) -> int | None:
    """Return the number of dimensions as far as it is known before the first report."""
    if dim is not None:
        dim = checked_dimension(dim)
        if priors is not None and priors.dim != dim:
            raise InvalidInputError(f"priors of {priors.dim} dimensions; expected {dim}")
        return dim
    if priors is not None:
        return priors.dim
    kinds = [sensor.measurement for sensor in sensors.values()]
    if any(kind.has_elevation for kind in kinds):
        return 3
    return None if any(kind.is_position for kind in kinds) else 2


def checked_scan(
    scan: Scan, sensors: Mapping[str, Sensor], dim: int | None, used: UsedNumbers
) -> tuple[Scan, int | None]:
    """Return a scan with numbers, which count as used now, and the dimensions as far as known."""
    if scan.sensor not in sensors:
        known = ", ".join(sorted(sensors))
        raise InvalidInputError(f"scan of sensor {scan.sensor!r}; expected one of {known}")
    dim = dimensions_of(scan, sensors[scan.sensor], dim)
    _require_radians(scan, sensors[scan.sensor].measurement)
    report = numbered(scan.report, used)
    # Most scans come with their numbers, and need not be checked again.
    return scan if np.array_equal(report, scan.report) else replace(scan, report=report), dim


def _require_radians(scan: Scan, kind: MeasurementKind | ForeignKind) -> None:
    """Refuse positions, and degrees, where a sensor measures azimuths."""
    if isinstance(kind, ForeignKind) or kind.azimuth is None or not len(scan):
        return
    azimuth = scan.measurement[:, kind.azimuth]
    widest = float(azimuth[np.argmax(np.abs(azimuth))])
    if abs(widest) > MOST_TURNS * 2.0 * np.pi:
        raise InvalidInputError(
            f"scan of sensor {scan.sensor}: an azimuth of {widest:.6g} rad; expected radians, "
            f"0 to 2π, as its measurement is {kind.word} (not x and y, nor degrees)"
        )


def numbered(given: IntArray, used: UsedNumbers) -> IntArray:
    """Return numbers for reports that have none, -1, and enter all; refuse a number used."""
    report, is_given = given.copy(), given >= 0
    if not used.add(report[is_given]):
        raise InvalidInputError("scan: a report's number was used before; expected new ones")
    # Counting on never meets a number again.
    report[~is_given] = used.count_on(report.shape[0] - int(np.count_nonzero(is_given)))
    return report


def dimensions_of(scan: Scan, sensor: Sensor, expected: int | None) -> int | None:
    """Return the number of dimensions once a scan fits; None where nothing tells it."""
    size = int(scan.measurement.shape[1])
    kind = sensor.measurement
    if len(scan) == 0 and size == 0:
        own = int(np.size(sensor.sigma)) if kind.is_position else 1
        if expected is None and own == 1:
            return None
        dim = expected or own
    elif kind.is_position:
        # In a space of three dimensions a position may lack its height.
        lacks = size == 2 and expected == 3 and np.size(sensor.sigma) < 3
        dim = 3 if lacks else size
    else:
        dim = expected or (3 if kind.has_elevation else 2)
        if size != kind.n_components(dim):
            raise InvalidInputError(
                f"scan of sensor {scan.sensor}: {size} numbers per report; expected "
                f"{kind.n_components(dim)} of {kind.word}"
            )
    if dim not in (2, 3) or (expected is not None and dim != expected):
        raise InvalidInputError(f"scan of {dim} dimensions; expected {expected or '2 or 3'}")
    sensor.sigmas(dim)
    return dim


def with_width(
    known: Mapping[str, int], scan: Scan, dim: int | None, *, is_alone: bool
) -> Mapping[str, int]:
    """Return how many numbers a report of each sensor has, with those of a scan; refuse others."""
    # Positions may lack their height where others tell it, not where a sensor is alone, nor in
    # some scans of a sensor: what nobody tells the height of begins no track.
    size = int(scan.measurement.shape[1])
    expected, why = known.get(scan.sensor), "as in its scans before"
    if len(scan) == 0 or expected == size:
        return known
    if expected is None and is_alone and (size, dim) == (2, 3):
        expected, why = 3, "as no other sensor tells heights"
    if expected is not None:
        raise InvalidInputError(
            f"scan of sensor {scan.sensor}: {size} numbers per report; expected {expected}, {why}"
        )
    return {**known, scan.sensor: size}


def with_dimensions(scan: Scan, sensor: Sensor, dim: int) -> Scan:
    """Return a scan that is empty with as many numbers as the sensor's reports have."""
    return _of_width(scan, sensor.measurement.n_components(dim))


def _of_width(scan: Scan, size: int) -> Scan:
    """Return a scan that is empty with so many numbers to a report."""
    if len(scan) or scan.measurement.shape[1] == size:
        return scan
    return replace(
        scan, measurement=np.empty((0, size)), sigma=np.empty((0, size)), covariance=None,
        context=None,
    )  # fmt: skip


def merged(first: Scan, second: Scan, sensor: Sensor) -> Scan:
    """Return a scan with the reports of two of the same sensor and time, the first one's first."""
    # An empty one has as many numbers as whoever made it thought.
    size = (first if len(first) else second).measurement.shape[1]
    first, second = (_of_width(scan, size) for scan in (first, second))

    def both(name: str, missing: float) -> FloatArray | None:
        parts = [getattr(scan, name) for scan in (first, second)]
        if all(part is None for part in parts):
            return None
        sizes = (len(first), len(second))
        return np.concatenate(
            [
                np.full(size, missing) if part is None else part
                for part, size in zip(parts, sizes, strict=True)
            ]
        )

    platform = None
    if first.platform is not None or second.platform is not None:
        places = [
            sensor.platform if scan.platform is None else scan.platform for scan in (first, second)
        ]
        platform = np.concatenate(
            [
                np.broadcast_to(place, (len(scan), 6))
                for place, scan in zip(places, (first, second), strict=True)
            ]
        )
        if not platform.size:
            platform = places[1]
    identity = both("identity", -1)
    return Scan(
        time=first.time,
        sensor=first.sensor,
        measurement=np.concatenate([first.measurement, second.measurement]),
        sigma=np.concatenate([first.sigma, second.sigma]),
        report=np.concatenate([first.report, second.report]),
        moments=both("moments", first.time),
        platform=platform,
        identity=None if identity is None else identity.astype(np.int64),
        strength=both("strength", np.nan),
        height=both("height", np.nan),
        covariance=_both_covariances(first, second, sensor),
        context=_both_contexts(first, second),
        tells_silence=(
            first.tells_silence if first.tells_silence == second.tells_silence else None
        ),
    )


def _both_contexts(first: Scan, second: Scan) -> FloatArray | None:
    """Return the context of two scans' reports; None where neither has any."""
    told = [scan.context for scan in (first, second) if scan.context is not None and len(scan)]
    return np.concatenate(told) if told else None


def _both_covariances(first: Scan, second: Scan, sensor: Sensor) -> FloatArray | None:
    """Return the covariances of two scans' reports; None where neither has any."""
    scans = (first, second)
    if all(scan.covariance is None for scan in scans):
        return None
    parts = []
    for scan in scans:
        size = scan.measurement.shape[1]
        sigma = np.where(np.isnan(scan.sigma), np.resize(sensor.sigma, size), scan.sigma)
        independent = sigma[:, :, None] ** 2 * np.eye(size)
        parts.append(independent if scan.covariance is None else scan.covariance)
    return np.concatenate(parts)
