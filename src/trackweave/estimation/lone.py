"""What the reports of a sensor tell that does not look: AIS, position reports, tags."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.domain.reports import ReportTable
from trackweave.estimation.identities import identity_threads
from trackweave.estimation.looking import (
    LASTING,
    Looking,
    are_even_steps,
    is_filled_evenly,
    line_up,
    looking,
)
from trackweave.estimation.noise import (
    MOST_CHAINS,
    arrays_of,
    least_noise,
    noise_of_chains,
    noise_of_longer_steps,
)
from trackweave.estimation.place_spacing import AS_NOISE, spacing_of_places
from trackweave.estimation.stop_and_go import fastest_step, noise_at_rest, process_of_starts
from trackweave.estimation.there_and_back import there_and_back
from trackweave.estimation.threads import SHORTEST, Threads, once, threads_of

__all__ = ["LoneReports", "fastest_below", "judged", "lone_reports", "middle_of"]

MOST_REPORTS = 12000
# Threads of fewer are false alarms.
OF_OBJECTS = 3
LEAST_REPORTS = 20
HALF = 0.5  # Of a noise; a search for it may begin with no less
PIECE = 5
FASTER, FASTEST_SHARE = 1.5, 0.98
# An object's speed is that of the middle of its thread where this may lead to others, and where
# it is all of the object, which may have lain still for most of the time, hardly ever exceeded.
USUALLY, AT_MOST = 0.5, 0.95
LEAST_FALSE = 0.001
# Where one ends and another begins it is often one object's thread, torn; this share of those
# that begin are of new objects at least.
TORN = 0.03
# What so much more process noise follows is a start or a stop; noise is no part so small of that
# of what rests.
STARTED, UNTOLD = 8.0, 3.0
# In a turn an object wanders more than on the whole.
AGILE = 2.0
# So many times as fast is who changes its velocity as much from one report to the next, where that
# is such a part of its speed.
WANDERS, TURNS = 2.0, 0.5
# An end of a thread that is so many times as fast as any other step, and far, is another's.
WILD_END = 5.0
# The median of how far a standard normal number is from 0.
MEDIAN_OF_NORMAL = 0.6745
# What stands seems to move at no more than so many standard deviations, and shares of the
# greatest speed; threads of so many reports tell.
STANDING, SLOW, TOLD = 3.0, 0.01, 4


@dataclass(frozen=True, slots=True)
class LoneReports:
    """What lone reports tell; rates are per second."""

    pause: float  # Usual time between an object's reports [s]
    # Reports of an object [1/s]: the inverse of the mean pause, so that the slow count.
    rate: float
    false_rate: float  # Reports that are of no object [1/s]
    n_objects: float  # Objects present at a time
    new_rate: float  # Objects that come [1/s]
    sigma: float | None  # Noise of a position along an axis [m]; None for unknown
    process_noise: float | None  # Of the acceleration [m²/s³]; None for unknown
    max_speed: float | None  # [m/s]; None for unknown
    # Between reports of those that report most often: of a tenth it is less [s].
    quick_pause: float
    slow_pause: float  # Of those that report most seldom: of a tenth it is more [s]
    standing: float  # Share of the objects' time for which they stand still
    # Share and scale of reports that are wild; None where none tell, or nothing says of whom.
    tail: tuple[float, float] | None = None


def middle_of(reports: ReportTable, sensor: int) -> IntArray:
    """Return a sensor's rows in order of time, of many those in the middle."""
    rows = np.flatnonzero(reports.sensor == sensor)
    rows = rows[np.argsort(reports.time[rows], kind="stable")]
    skip = max(0, (rows.size - MOST_REPORTS) // 2)
    return np.asarray(rows[skip : skip + MOST_REPORTS])


def judged(
    reports: ReportTable, sensor: int, known: Threads | None = None
) -> tuple[Looking, Threads, IntArray]:
    """Return whether a sensor looks, the threads that tell, and the rows that they thread."""
    # The rows in threads count in those. Threads that are ``known`` are told so.
    rows = middle_of(reports, sensor)
    time, position = reports.time[rows], reports.measurement[rows]
    if known is not None:
        return looking(time, known.rows), known, rows
    heard = once(time, position)
    named = identity_threads(reports, rows[heard])
    if named is None:
        threads = threads_of(time, position)
        if is_filled_evenly(time) and (
            are_even_steps(time, position) or line_up(time, position) is not None
        ):
            # Threads speak of places that objects come back to, not of who reports.
            return Looking(0.0, 0.0, 1.0, 0), threads, rows
    else:
        # What is under a name that several share, or has none, may be of objects as well.
        assert reports.identity is not None
        own = reports.identity[rows[heard]]
        is_told = np.isin(own, [own[each[0]] for each in named])
        count = int(np.count_nonzero(is_told))
        threads = Threads([heard[each] for each in named], count, is_whole=True)
    return looking(reports.time[rows], threads.rows), threads, rows


class _Reports(NamedTuple):
    """When and where reports are, and how many times the usual noise each has."""

    time: FloatArray
    position: FloatArray
    scale: FloatArray | None  # None where nothing tells that it is another than usual


def lone_reports(
    time: FloatArray,
    position: FloatArray,
    threads: Threads,
    sigma: float | None,
    own: FloatArray | None = None,
) -> LoneReports:
    """Return what threads tell of a sensor that does not look; sigma [m] where it is known."""
    # ``own`` is the noise along each axis that reports tell themselves [m], shape (reports, dim),
    # NaN for none.
    reports = _Reports(time, position, _scales(own, sigma))
    tail = None
    if threads.is_whole:
        # Where it is told whose reports are, what is far beside its own way is no start or turn.
        is_wild, tail = there_and_back(time, position, threads.lasting(LASTING))
        threads = replace(threads, rows=[rows[~is_wild[rows]] for rows in threads.rows])
    span = max(float(np.ptp(time)), 1e-9)
    objects = threads.lasting(OF_OBJECTS)
    lived = sum(float(time[rows[-1]] - time[rows[0]]) for rows in objects)
    pauses = [float(np.median(np.diff(time[rows]))) for rows in objects]
    pause = float(np.median(pauses)) if pauses else span
    n_false = threads.n_reports - sum(rows.size for rows in objects)
    rate = n_false / span
    lasting = threads.lasting(LASTING)
    if sigma is None and threads.is_whole:
        sigma = _of_places(position, objects)
    # At a quay the seldom are taken for one another; those that report often are sure, unless they
    # are few, and false alarms on short threads only seem to report oftener.
    waits = [float(np.median(np.diff(time[rows]))) for rows in lasting]
    often = max(pause, float(np.median(waits))) if waits else pause
    quick = [rows for rows, wait in zip(lasting, waits, strict=True) if wait <= often]
    if sum(rows.size for rows in quick) < LEAST_REPORTS:
        quick = lasting
    told = sigma
    sigma, process = _told_noise(reports, quick, told, rate)
    rest = noise_at_rest(time, position, quick) if threads.is_whole and told is None else None
    if sigma is not None and rest is not None and UNTOLD * sigma < rest:
        # What moves as no process noise says can make a noise of next to none the likeliest.
        sigma, process = _noise(reports, quick, rest, rate)
    speed = _speed(time, position, lasting, USUALLY if not threads.is_whole else AT_MOST)
    if threads.is_whole and speed is not None:
        speed = max(speed, fastest_step(time, position, lasting, sigma or 0.0, pause))
    moving = [rows for rows in quick if not _stands(time[rows], position[rows], sigma, speed)]
    if sigma is not None and len(moving) < len(quick):
        # Of those that stand, the noise of movement is none.
        of = _noise if told is None else _told_noise
        moved = of(reports, moving, sigma, rate)[1]
        process = process if moved is None else AGILE * moved
    if threads.is_whole and process is not None and sigma is not None:
        # Who is known by name is followed however seldom it sets out.
        starts = process_of_starts(time, position, lasting, sigma, 0.5 * pause)
        process = starts if starts > STARTED * process else process
    if speed is not None and process is not None:
        speed = max(speed, _wandering_speed(speed, process, pause))
    return LoneReports(
        pause=pause,
        rate=1.0 / float(np.mean(pauses)) if pauses else 1.0 / span,
        false_rate=max(n_false, LEAST_FALSE * threads.n_reports, 0.5) / span,
        n_objects=max(lived / span, 1.0),
        new_rate=(_begun(time, objects) + 0.5) / (0.5 * span),
        sigma=sigma,
        process_noise=process,
        max_speed=speed,
        quick_pause=float(np.quantile(pauses, 0.1)) if pauses else span,
        slow_pause=float(np.quantile(pauses, 0.9)) if pauses else span,
        standing=_standing(time, position, threads.lasting(TOLD), sigma, speed),
        tail=tail,
    )


def _wandering_speed(speed: float, process: float, pause: float) -> float:
    """Return what hardly any object exceeds whose velocity turns from report to report [m/s]."""
    # Over a piece of a thread such turns even out: who circles seems to go at the mean of a loop.
    turned, usual = float(np.sqrt(process * pause)), speed / FASTER
    return FASTER * float(np.hypot(usual, WANDERS * turned)) if turned > TURNS * usual else 0.0


def _of_places(position: FloatArray, threads: list[IntArray]) -> float | None:
    """Return how exact reports are that name one of some places [m], None of those anywhere."""
    before = np.concatenate([rows[:-1] for rows in threads] or [np.empty(0, dtype=np.int64)])
    after = np.concatenate([rows[1:] for rows in threads] or [before])
    spacing = spacing_of_places(position[before], position[after])
    return AS_NOISE * spacing if spacing > 0.0 else None


def _begun(time: FloatArray, objects: list[IntArray]) -> float:
    """Return how many objects came in the second half of the time."""
    middle = 0.5 * (time.min() + time.max())
    begun = sum(time[rows[0]] > middle for rows in objects)
    ended = sum(time[rows[-1]] < middle for rows in objects)
    return float(max(begun - ended, TORN * begun))


def _standing(
    time: FloatArray,
    position: FloatArray,
    threads: list[IntArray],
    sigma: float | None,
    speed: float | None,
) -> float:
    """Return for which share of the threads' time they stand: what moves is torn into many."""
    stands = [_stands(time[rows], position[rows], sigma, speed) for rows in threads]
    lasted = [float(np.ptp(time[rows])) for rows in threads]
    return float(np.average(stands, weights=lasted)) if threads else 0.0


def _stands(
    time: FloatArray, position: FloatArray, sigma: float | None, speed: float | None
) -> bool:
    """Tell whether an object's speed is none, but for its noise and beside the fastest."""
    centred = time - time.mean()
    square = float(np.dot(centred, centred))
    moved = float(np.linalg.norm(centred @ position / square))
    return bool(moved < STANDING * ((sigma or 0.0) / square**0.5 + SLOW * (speed or 0.0)))


def _scales(own: FloatArray | None, sigma: float | None) -> FloatArray | None:
    """Return how many times the usual noise each report has; None where all have the usual."""
    if own is None or sigma is None:
        return None
    level = np.sqrt(np.mean(own**2, axis=1))
    scale = np.nan_to_num(level / sigma, nan=1.0)
    return scale if np.any(scale != 1.0) else None


def _told_noise(
    reports: _Reports, threads: list[IntArray], told: float | None, false_rate: float
) -> tuple[float | None, float | None]:
    """Return sigma, that told where there is one, and process noise along threads."""
    sigma, process = _noise(reports, threads, None, false_rate)
    most = _scatter(reports.time, reports.position, threads) if reports.scale is None else None
    if sigma is not None and most is not None and sigma > most:
        # Threads that change from one object to another lie off by more than noise.
        sigma, process = _noise(reports, threads, most, false_rate)
    if told is None:
        return sigma, process
    # Beside a noise that is told, such changes would seem to be turns.
    beside = _noise(reports, threads, told, false_rate)[1]
    known = [each for each in (process, beside) if each is not None]
    return told, min(known, default=None)


def _noise(
    reports: _Reports, threads: list[IntArray], sigma: float | None, false_rate: float
) -> tuple[float | None, float | None]:
    """Return sigma and process noise along threads, as they are where these are too few."""
    time, position, scale = reports
    chains = [_without_wild_ends(time, position, rows) for rows in threads[:MOST_CHAINS]]
    if sum(rows.size for rows in chains) < LEAST_REPORTS:
        return sigma, None
    times, places = arrays_of((time[rows], position[rows]) for rows in chains)
    scales = np.ones(times.shape)
    if scale is not None:
        scales = arrays_of((time[rows], scale[rows, None]) for rows in chains)[1][..., 0]
    start = sigma
    if start is None:
        bends = places[:, 2:] - 2 * places[:, 1:-1] + places[:, :-2]
        along = np.nanmedian(np.abs(bends), axis=(0, 1)) / 1.65
        # Where one axis tells none, the middle of all is next to nothing.
        start = max(float(np.nanmedian(np.abs(bends))) / 1.65, HALF * _mean(along))
    spread = float(np.prod(np.maximum(np.ptp(position, axis=0), 1e-9)))
    density, fixed = max(false_rate, 1e-6) / spread, sigma is not None
    found = noise_of_chains(
        times, places, max(start, 1e-9), density, fixed=fixed, follows_turns=False, scale=scales
    )
    return noise_of_longer_steps((times, places, scales), found, density, fixed=fixed)


def _without_wild_ends(time: FloatArray, position: FloatArray, rows: IntArray) -> IntArray:
    """Return a thread but for ends that are another's: a filter that begins there is lost."""
    if rows.size <= PIECE:
        return rows
    step = np.linalg.norm(np.diff(position[rows], axis=0), axis=1)
    speed = step / np.maximum(np.diff(time[rows]), SHORTEST)
    between = slice(1, -1)
    is_wild = (speed > WILD_END * speed[between].max()) & (step > WILD_END * np.median(step))
    return rows[int(is_wild[0]) : rows.size - int(is_wild[-1])]


def _scatter(time: FloatArray, position: FloatArray, threads: list[IntArray]) -> float | None:
    """Return the noise [m] with which reports lie off the line between their neighbours."""
    # Movement adds to it, and takes nothing. It is the median of all threads along an axis; None
    # without any.
    found, least = [], []
    for rows in threads:
        least.append(least_noise(position[rows][None]))
        span = time[rows[2:]] - time[rows[:-2]]
        share = ((time[rows[1:-1]] - time[rows[:-2]]) / np.maximum(span, 1e-9))[:, None]
        off = (
            position[rows[1:-1]] - (1.0 - share) * position[rows[:-2]] - share * position[rows[2:]]
        )
        off /= np.sqrt(1.0 + share**2 + (1.0 - share) ** 2)
        # Each axis has its own: of one that tells no noise the other's is not.
        along = np.median(np.abs(off), axis=0) / MEDIAN_OF_NORMAL
        found.append(_mean(along))
    return max(float(np.median(found)), float(np.median(least))) or None if found else None


def _mean(along: FloatArray) -> float:
    """Return the noise of an axis, of that along each."""
    return float(np.sqrt(np.mean(along**2)))


def _speed(
    time: FloatArray, position: FloatArray, threads: list[IntArray], share: float
) -> float | None:
    """Return a speed that hardly any object exceeds, each of which is slower for a share."""
    speeds = _speeds(time, position, threads, share)
    return FASTER * float(np.quantile(speeds, FASTEST_SHARE)) or None if speeds else None


def _speeds(
    time: FloatArray, position: FloatArray, threads: list[IntArray], share: float
) -> list[float]:
    """Return how fast each thread is but for the rest of its time."""
    speeds = []
    for rows in threads:
        pieces = []
        for start in range(0, rows.size - PIECE + 1, 2):
            piece = rows[start : start + PIECE]
            centred = time[piece] - time[piece].mean()
            velocity = centred @ position[piece] / np.dot(centred, centred)
            pieces.append(float(np.linalg.norm(velocity)))
        speeds.append(float(np.quantile(pieces, share)))
    return speeds


def fastest_below(reports: ReportTable, sensors: Iterable[int], most: float) -> float | None:
    """Return a speed that hardly any object exceeds of those that are no faster than ``most``."""
    # [m/s], of ``sensors`` that do not look; threads that go from one object to another seem to be
    # faster.
    found: list[float] = []
    for sensor in sensors:
        threads = judged(reports, sensor)[1].lasting(LASTING)
        speeds = _speeds(reports.time, reports.measurement, threads, USUALLY)
        for rows, speed in zip(threads, speeds, strict=True):
            # Each report counts: such threads are short.
            found += [speed] * rows.size if 0.0 < FASTER * speed <= most else []
    return FASTER * float(np.quantile(found, FASTEST_SHARE)) if found else None
