"""What a configuration tells, against what tracks show."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trackweave.arrays import FloatArray
from trackweave.estimation.coverage import covered
from trackweave.models.motion import ConstantVelocity
from trackweave.run.diagnostics.case import Case, Finding, Path
from trackweave.run.diagnostics.scatter import Scatter, is_noise, scatter_of, without_motion
from trackweave.run.observing import filled

__all__ = [
    "Chances",
    "chances_of",
    "clutter",
    "detection",
    "expected_false",
    "is_random",
    "motion",
    "noise",
    "out_of_view",
    "scans_of",
]

MOST_PATHS, MOST_LOOKS = 120, 200


@dataclass(frozen=True, slots=True, eq=False)
class Chances:
    """A sensor's looks while tracks were there, between their first and last reports."""

    place: FloatArray  # Where the track was [m], shape (chances, 2)
    is_hit: NDArray[np.bool_]  # Whether the sensor reported it, shape (chances,)


def chances_of(case: Case, index: int) -> Chances:
    """Return the chances that a sensor had to see the tracks; none if nobody knows its looks."""
    places, hits, times = [np.empty((0, 2))], [np.empty(0, dtype=bool)], [np.empty(0)]
    for path in case.paths[:MOST_PATHS]:
        looks, near = _looks(case, index, path)
        if looks.size == 0:
            continue
        own = path.rows[case.reports.sensor[path.rows] == index]
        time = case.reports.time[own]
        at = np.searchsorted(time, looks - near)
        hits.append((at < time.size) & (time[np.minimum(at, time.size - 1)] <= looks + near)
                    if time.size else np.zeros(looks.size, dtype=bool))  # fmt: skip
        places.append(path.at(looks))
        times.append(looks)
    place, is_hit = np.concatenate(places), np.concatenate(hits)
    known = ~np.isnan(place[:, 0])
    view = case.sensors[index].field_of_view
    if view is not None:
        known &= covered(place, _platform(case, index, np.concatenate(times)), view.coverage())
    return Chances(place[known], is_hit[known])


def _platform(case: Case, index: int, time: FloatArray) -> FloatArray:
    """Return where a sensor was at some times [m]."""
    rows = case.rows[index]
    where = [np.interp(time, case.reports.time[rows], axis) for axis in case.platform[rows].T]
    return np.stack(where, axis=1)


def _looks(case: Case, index: int, path: Path) -> tuple[FloatArray, float]:
    """Return when a sensor looked at a track's place, and how far off a report's time may be."""
    sensor, time = case.sensors[index], case.reports.time[path.rows]
    first, last = float(time[0]), float(time[-1])
    period = sensor.scan_period
    if sensor.rotation is not None and period:
        # Once in a turn, whenever its report comes.
        return np.arange(first + 1.5 * period, last - 1.5 * period, period), 0.5 * period
    if period is None or sensor.name not in case.looks:
        return np.empty(0), 0.0
    looks = case.looks[sensor.name]
    # The first and the last report are why the track is there, and say nothing.
    looks = looks[np.searchsorted(looks, first, "right") : np.searchsorted(looks, last)]
    # A numbered scan ends after its reports.
    near = 0.5 * period if case.reports.scan is not None else 1e-9 * max(abs(last), 1.0)
    return looks[:: -(-max(looks.size, 1) // MOST_LOOKS)], near


FEWEST_OUTSIDE, OUTSIDE_SHARE, MOST_LOOKED_AT = 10, 0.1, 600


def out_of_view(case: Case) -> Iterator[Finding]:
    """Yield sensors whose reports come from outside their own field of view."""
    for index in case.examined:
        sensor, rows = case.sensors[index], case.rows[index]
        rows = rows[~np.isnan(case.position[rows, 0])]
        view = sensor.field_of_view
        if view is None or rows.size == 0:
            continue
        some = rows[:: -(-rows.size // MOST_LOOKED_AT)]
        outside = ~covered(case.position[some], case.platform[some], view.coverage())
        count = int(outside.sum())
        if count < max(FEWEST_OUTSIDE, OUTSIDE_SHARE * some.size):
            continue
        away = np.linalg.norm((case.position - case.platform)[some], axis=1)
        reach = "" if not np.isfinite(view.max_range) else f" of {view.max_range:g} m"
        yield Finding(
            "field of view",
            sensor.name,
            f"sensor {sensor.name}: {count / some.size:.0%} of its {rows.size} reports lie "
            f"outside its own field_of_view{reach}; they come from {np.min(away):.3g} m to "
            f"{np.max(away):.3g} m: correct the field_of_view, or its position",
            weight=90.0 * count / some.size,
            told=float(view.max_range),
            seen=float(np.max(away)),
            is_clear=True,
        )


# Where fewer than one report in so many is in a track, there is none to judge by.
HARDLY_ANY = 10
MOST_REPORTS = 1500
# Two are near one another where noise puts two reports of what is as fast as most tracks.
REACH_SIGMAS = 4.0
# So many standard deviations more pairs than by chance, and this share of the reports in them,
# are objects.
DEVIATIONS, LEFT_SHARE = 4.0, 0.1


def is_random(case: Case) -> bool:
    """Tell whether reports in no track follow on one another no more often than by chance."""
    left = case.track < 0
    if (len(case.reports) - np.count_nonzero(left)) * HARDLY_ANY < len(case.reports):
        return False
    speeds = [float(np.median(path.speed)) for path in case.paths]
    fast = float(np.quantile(speeds, 0.75)) if speeds else 0.0
    return not any(
        _follow_on(case, index, left[rows], fast)
        for index, rows in enumerate(case.rows)
        if index in case.examined and case.tells_place(index)
    )


def _follow_on(case: Case, index: int, left: NDArray[np.bool_], speed: float) -> bool:
    """Tell whether a sensor's reports in no track follow on one another as objects' do."""
    own = case.rows[index][left]
    own = own[np.argsort(case.reports.time[own], kind="stable")][:MOST_REPORTS]
    time, place = case.reports.time[own], case.position[own]
    moments = np.unique(case.reports.time[case.rows[index]])
    if own.size < HARDLY_ANY or moments.size < HARDLY_ANY:
        return False
    period = case.sensors[index].scan_period or float(np.median(np.diff(moments)))
    wait = time[None, :] - time[:, None]
    reach = REACH_SIGMAS * case.plane_sigma(index) + speed * period
    is_next = (wait > 0.5 * period) & (wait < 1.5 * period)
    low, high = place.min(axis=0), place.max(axis=0)
    counts = []
    for mirrored in ((), (0,), (1,), (0, 1)):
        other = place.copy()
        for axis in mirrored:
            other[:, axis] = low[axis] + high[axis] - other[:, axis]
        apart = np.linalg.norm(place[:, None] - other[None, :], axis=2)
        counts.append(int(np.count_nonzero(is_next & (apart < reach))))
    chance = float(np.mean(counts[1:]))
    more = counts[0] - chance
    return bool(more > max(DEVIATIONS * np.sqrt(chance + 1.0), LEFT_SHARE * own.size))


FEWEST_TRIPLES, FEWEST_CHANCES, FEWEST_ROWS = 30, 50, 30
# Steps over which noise is told from motion.
SHORT, LONG = 1, 3
# Noise so many times larger or smaller than told is a contradiction; what wanders slowly scatters
# less from scan to scan than it is off.
NOISE_LARGER, NOISE_SMALLER = 3.0, 3.0
# Process noise, and what it does to the scatter over long steps.
PROCESS_TIMES, SCATTER_TIMES, LEAST_PROCESS = 5.0, 3.0, 1e-12
SPEED_OVER, SPEED_UNDER = 1.3, 8.0
ODDS, SIGMAS, CORRELATED, LEAST_ERROR = 3.0, 4.0, 4.0, 0.005
CLUTTER_TIMES, FEWEST_FALSE = 6.0, 20.0
WEIGHT = 50.0


def noise(case: Case) -> Iterator[Finding]:
    """Yield sensors whose reports scatter otherwise than their sigma says."""
    for index in case.examined:
        name = case.reports.sensors[index]
        if not case.tells_place(index):
            continue
        short, long = (scatter_of(case, index, stride) for stride in (SHORT, LONG))
        if min(len(short), len(long)) < FEWEST_TRIPLES:
            continue
        for column, told, own, far, ratio in _components(case, index, short, long):
            if 1 / NOISE_SMALLER < ratio < NOISE_LARGER:
                continue
            seen = np.sqrt(own if ratio > 1 else far)
            turn = np.degrees(1.0) if column.endswith("_deg") else 1.0
            unit = "degrees" if column.endswith("_deg") else "m"
            key = f"sigma of {column}" if column else "sigma"
            times = f"{max(ratio, 1 / ratio):.3g} times {'more' if ratio > 1 else 'less'}"
            unless = "" if ratio > 1 else ", unless it covers an extent or errors that wander"
            yield Finding(
                "sigma",
                name,
                f"sensor {name}: {key} is told as {turn * told:.3g} {unit}, but along tracks its "
                f"reports scatter by {turn * seen:.3g} {unit}: {times}; correct it, or its unit"
                f"{unless}",
                weight=WEIGHT + abs(float(np.log(ratio))),
                told=float(turn * told),
                seen=float(turn * seen),
            )


def _components(
    case: Case, index: int, short: Scatter, long: Scatter
) -> Iterator[tuple[str, float, float, float, float]]:
    """Yield column, sigma told, variances over short and long steps, and how many times told."""
    kind = case.reports.kind_of(index)
    told = _told_sigma(case, index)
    if told is None:
        return
    near, far = short.usual(), long.usual()
    if kind.is_position:
        # Axes may differ, and then each has to be compared with its own.
        usual = np.mean(told**2)
        near, far = (np.mean(each / told**2, keepdims=True) * usual for each in (near, far))
        told = np.sqrt([usual])
    own = without_motion(short, long, near, far)
    noisy = is_noise(case, index, (short, long), own, near)
    columns = kind.columns(case.reports.dim) if kind.has_range else ("",)
    for k, sigma in enumerate(told[: near.size]):
        ratio = 1.0
        if noisy[k] and own[k] > sigma**2:
            ratio = float(np.sqrt(own[k]) / sigma)
        elif far[k] < sigma**2:
            ratio = float(np.sqrt(max(far[k], 1e-30)) / sigma)
        yield columns[k], float(sigma), float(own[k]), float(far[k]), ratio


def _told_sigma(case: Case, index: int) -> FloatArray | None:
    """Return the noise that was told, by component, None where nobody told one of all reports."""
    sensor, carried = case.sensors[index], case.reports.sigma[case.rows[index]]
    # What reports carry is each one's own: no median of it was told.
    if np.isfinite(carried).any() or not case.is_told(f"sensors.{sensor.name}.sigma"):
        return None
    return sensor.sigmas(case.reports.dim)[:2]


def motion(case: Case) -> Iterator[Finding]:
    """Yield what objects do otherwise than the greatest speed and the process noise say."""
    yield from _speed(case)
    yield from _process(case)


def _speed(case: Case) -> Iterator[Finding]:
    speeds = np.concatenate([path.speed for path in case.paths] or [np.empty(0)])
    if speeds.size < FEWEST_ROWS or not case.is_told("motion.max_speed"):
        return
    told = float(case.settings.values["motion"]["max_speed"])
    many, most = np.quantile(speeds, [0.9, 0.99])
    usual = [np.median(path.speed) for path in case.paths]
    if many > SPEED_OVER * told:
        what, seen = f"one row of a track in ten is faster than {many:.3g} m/s", many
        change = "correct it, or the unit of positions or times"
    elif most > 0 and told > SPEED_UNDER * most:
        what, seen = f"hardly any track is faster than {most:.3g} m/s", most
        change = "lower it if nothing faster can come"
    else:
        return
    yield Finding(
        "max_speed",
        None,
        f"motion.max_speed is told as {told:g} m/s, but {what}; {change}",
        weight=WEIGHT + abs(float(np.log(told / seen))),
        told=told,
        seen=float(seen),
        # Single rows are fast by noise.
        is_clear=bool(np.quantile(usual, 0.9) > SPEED_OVER * told),
    )


def _process(case: Case) -> Iterator[Finding]:
    model = case.settings.motion
    if not isinstance(model, ConstantVelocity) or not case.is_told("motion.process_noise"):
        return
    told, found = model.process_noise, []
    for index in case.examined:
        if case.tells_place(index) and not case.reports.kind_of(index).has_range:
            value = _process_seen(case, index, told)
            if value is not None:
                found.append(value)
    if not found:
        return
    seen = float(np.median(found))
    times = max(seen, LEAST_PROCESS) / max(told, LEAST_PROCESS)
    if 1 / PROCESS_TIMES < times < PROCESS_TIMES:
        return
    word = "more" if seen > told else "less"
    yield Finding(
        "process_noise",
        None,
        f"motion.process_noise is told as {told:g} m²/s³, but tracks bend as with {seen:.2g}: "
        f"{max(times, 1 / times):.3g} times {word}; correct it",
        weight=WEIGHT - 10 + abs(float(np.log(times))),
        told=told,
        seen=seen,
    )


def _process_seen(case: Case, index: int, told: float) -> float | None:
    """Return the process noise that a sensor's reports show; that told where they tell little."""
    short, long = (scatter_of(case, index, stride) for stride in (SHORT, LONG))
    if min(len(short), len(long)) < FEWEST_TRIPLES:
        return None
    drift = float(np.median(short.drift)), float(np.median(long.drift))
    near, far = float(short.usual().mean()), float(long.usual().mean())
    process = max(far - near, 0.0) / max(drift[1] - drift[0], 1e-30)
    own = max(near - process * drift[0], 0.0)
    if far > SCATTER_TIMES * (own + told * drift[1]):
        return process
    # Noise that serves a few sharp turns is no contradiction: the tail must be calm as well.
    tail = float(long.tail().mean())
    if own + told * drift[1] > SCATTER_TIMES * tail:
        return max(tail - own, 1e-3 * tail) / max(drift[1], 1e-30)
    return told


def detection(case: Case) -> Iterator[Finding]:
    """Yield sensors that see tracks more or less often than told."""
    for index in case.examined:
        sensor = case.sensors[index]
        if not case.is_told(f"sensors.{sensor.name}.detection_probability"):
            continue
        chances = chances_of(case, index)
        count = chances.is_hit.size
        if count < FEWEST_CHANCES:
            continue
        told, seen = sensor.detection_probability, float(chances.is_hit.mean())
        smooth = (chances.is_hit.sum() + 0.5) / (count + 1.0)
        odds = float(smooth / (1 - smooth) / (told / (1 - told)))
        error = np.sqrt(CORRELATED * told * (1 - told) / count) + LEAST_ERROR
        if 1 / ODDS < odds < ODDS or abs(seen - told) < SIGMAS * error:
            continue
        yield Finding(
            "detection_probability",
            sensor.name,
            f"sensor {sensor.name}: detection_probability is told as {told:g}, but it reported "
            f"{seen:.1%} of {count} chances to see a track; correct it, or give where it sees "
            "(field_of_view) and when (scan_period)",
            weight=WEIGHT - 10 + abs(float(np.log(odds))),
            told=told,
            seen=seen,
            is_clear=True,
        )


def clutter(case: Case) -> Iterator[Finding]:
    """Yield sensors of which more or fewer reports are in no track than told."""
    for index in case.examined:
        sensor = case.sensors[index]
        key = f"sensors.{sensor.name}.clutter_"
        is_told = [case.is_told(key + word) for word in ("density", "per_scan")]
        rows, looks = case.rows[index], scans_of(case, index)
        if not any(is_told) or looks < 1 or rows.size < FEWEST_ROWS or sensor.scans is False:
            continue
        told = expected_false(case, index)
        alone = float(np.count_nonzero(case.track[rows] < 0)) + 0.5
        seen = alone / looks
        if 1 / CLUTTER_TIMES < seen / told < CLUTTER_TIMES:
            continue
        if max(alone, told * looks) < FEWEST_FALSE:
            continue
        yield Finding(
            "clutter",
            sensor.name,
            f"sensor {sensor.name}: {'clutter_per_scan' if is_told[1] else 'clutter_density'} "
            f"leads to expect {told:.3g} false alarms a scan where its reports come from, but "
            f"{seen:.3g} of them a scan are in no track: {max(seen / told, told / seen):.3g} "
            f"times {'more' if seen > told else 'fewer'}; correct it",
            weight=WEIGHT - 5 + abs(float(np.log(seen / told))),
            told=told,
            seen=seen,
            is_clear=True,
        )


def scans_of(case: Case, index: int) -> float:
    """Return how many scans a sensor made; 0 where nobody knows."""
    sensor, time = case.sensors[index], case.reports.time[case.rows[index]]
    if sensor.rotation is not None and sensor.scan_period and time.size:
        return float(np.ptp(time)) / sensor.scan_period
    return float(case.looks.get(sensor.name, np.empty(0)).size)


def expected_false(case: Case, index: int) -> float:
    """Return the mean number of false alarms in a sensor's scan, where its reports come from."""
    sensor, rows = case.sensors[index], case.rows[index]
    measured = case.reports.measurement[rows]
    kind = case.reports.kind_of(index)
    if kind.is_position:
        sides = np.maximum(np.ptp(measured, axis=0), 6 * case.plane_sigma(index))
        return sensor.clutter_density * float(np.prod(sides))
    return sensor.clutter_density * filled(kind, measured)
