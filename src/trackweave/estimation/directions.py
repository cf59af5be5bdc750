"""Noise of ranges and directions, from tracks that position reports made."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import TypeAlias

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.domain.reports import ReportTable
from trackweave.estimation.along_sight import platform_of, process_along_sight
from trackweave.estimation.estimates import Estimates, SensorEstimate, bounded, digits, positive
from trackweave.estimation.frames import scan_period
from trackweave.estimation.neighbours import LONGEST_SPAN, expected_of
from trackweave.estimation.refine import DETECTION_RANGE, Followed, Track, sure_tracks

__all__ = ["across_of", "bearing_sensor", "components", "with_components"]

FEWEST_RESIDUALS, HALF = 30, 3
FEWEST_OF_TRACK = 2 * HALF + 1
# Beside straight ways an object that turns leaves more than such a part of its usual step.
TURNING = 0.15
SAME_TIME = 1e-6
# Where false alarms come again, what is so many times as noisy as most tracks is made of them.
NOISIEST = 5.0
# Of so many tracks it is told whether noise goes with the distance, at so many of these, where so
# much less is left then.
FEWEST_TRACKS, N_DISTANCES, LESS_OFF = 8, 30, 0.7
# Bearings within this of a track may be of its object [rad].
NEAR = 0.25
N_ROUNDS = 30
# Process noise in the plane and along the line of sight are told within such a factor.
ALIKE = 2.5
LEAST_ANGLE, MOST_ANGLE = 1e-5, 0.2
USUAL_DETECTION, USUAL_CHANCES = 0.7, 10.0


_Beside: TypeAlias = Callable[[FloatArray, FloatArray], tuple[FloatArray, FloatArray, IntArray]]
"""What neighbours say of reports at times, by how much that widens noise, and of which."""


def with_components(
    estimates: Estimates,
    reports: ReportTable,
    followed: Followed,
    ranging: Mapping[str, Sequence[float]],
) -> Estimates:
    """Return estimates in which ranging sensors have the noise of range and angles apart."""
    # ``ranging`` are the places of those sensors [m]; rows that say where one was come first.
    # Sigma is one number for each of range [m], azimuth and elevation [rad] where tracks tell it,
    # and as it was elsewhere.
    sensors, processes = dict(estimates.sensors), list[float]()
    tracks = sure_tracks(estimates, reports, followed)
    for name, place in ranging.items():
        if name in sensors:
            index = reports.sensors.index(name)
            own = _rows_of(reports, tracks, index)
            is_curved = len(ranging) > 1 or _most_turn(reports, own)
            beside = _beside_curves if is_curved else _beside_lines
            most = NOISIEST if sensors[name].clutter_persistence > 0.0 else None
            noise = _component_noise(reports, own, place, beside, most)
            if noise is not None:
                sigma, of_most, across = noise
                sensors[name] = replace(
                    sensors[name], sigma=sigma, sigma_of_most=of_most, across=across
                )
                places = [platform_of(reports, rows, place) for rows in own]
                process = process_along_sight(reports, own, places, of_most)
                processes += [] if process is None else [process]
    # Objects are the same for all sensors; what one sees besides is its own noise.
    known = estimates.process_noise
    along = positive(min(processes, default=known))
    # Where both agree, that in the plane has seen every turn.
    if known / ALIKE < along < known * ALIKE:
        along = known
    return replace(estimates, sensors=sensors, process_noise=along)


def _rows_of(reports: ReportTable, tracks: list[Track], index: int) -> list[IntArray]:
    """Return the rows of each track's reports of one sensor, where they tell of noise."""
    own = [track.rows[reports.sensor[track.rows] == index] for track in tracks]
    own = [rows[np.diff(reports.time[rows], prepend=-np.inf) > SAME_TIME] for rows in own]
    return [rows for rows in own if rows.size >= FEWEST_OF_TRACK]


def _most_turn(reports: ReportTable, tracks: list[IntArray]) -> bool:
    """Tell whether most reports are of objects that turn within a few of them."""
    # In a holding stack, say, of whose turns straight ways make a noise eight times too large.
    n_turning = 0
    for rows in tracks:
        time, place, off = reports.time[rows], reports.measurement[rows], []
        for beside in (_beside_lines, _beside_curves):
            expected, known, usable = beside(time, place)
            left = np.linalg.norm(place[usable] - expected, axis=1) / np.sqrt(known)
            off.append(float(np.median(left)) if left.size else 0.0)
        step = float(np.median(np.linalg.norm(np.diff(place, axis=0), axis=1)))
        n_turning += rows.size * (off[0] ** 2 - off[1] ** 2 > (TURNING * step) ** 2)
    return 2 * n_turning > sum(rows.size for rows in tracks)


def _component_noise(
    reports: ReportTable,
    tracks: list[IntArray],
    place: Sequence[float],
    beside: _Beside,
    most: float | None,
) -> tuple[tuple[float, ...], tuple[float, ...], float] | None:
    """Return what is left of each component beside the tracks, over all and in most of them."""
    # And what is left across the line of sight however near objects are [m]. A track counts as
    # ``most`` times as noisy as most tracks at most; None for as noisy as it is.
    parts, distance = [], []
    for rows in tracks:
        expected, known, usable = beside(reports.time[rows], reports.measurement[rows])
        used = rows[usable]
        seen_from = platform_of(reports, used, place)
        off = components(reports.measurement[used] - seen_from) - components(expected - seen_from)
        if used.size:
            parts.append(_wrapped(off) / np.sqrt(known)[:, None])
            distance.append(float(np.median(components(expected - seen_from)[:, 0])))
    count = np.array([part.shape[0] for part in parts])
    if count.sum() < FEWEST_RESIDUALS:
        return None
    # Robust within a track, and not over tracks: some objects are noisier than most, and theirs
    # have to lie in the gate too.
    spread = np.array([1.4826 * np.median(np.abs(part), axis=0) for part in parts])
    middle = [
        column[order][np.searchsorted(np.cumsum(count[order]), count.sum() / 2)]
        for column, order in zip(spread.T, np.argsort(spread, axis=0).T, strict=True)
    ]
    whole = spread if most is None else np.minimum(spread, most * np.array(middle))
    usual = np.sqrt(np.average(whole**2, axis=0, weights=count))
    found = (tuple(bounded(float(value), 1e-9) for value in each) for each in (usual, middle))
    return next(found), next(found), across_of(np.array(distance), spread[:, 1], count)


def across_of(distance: FloatArray, azimuth: FloatArray, count: IntArray) -> float:
    """Return the noise across the line of sight that is there however near objects are [m]."""
    # Each track has a distance [m], a noise of its azimuths [rad] and a number of reports. Noise
    # goes with a² + (b / distance)², of which the b is told that leaves logarithms the least off,
    # and 0 where most of what an angle alone leaves is left.
    if distance.size < FEWEST_TRACKS or azimuth.min() <= 0.0 or distance.min() <= 0.0:
        return 0.0
    best = 0.0, np.inf
    for near in (0.0, *np.geomspace(distance.min(), 4 * distance.max(), N_DISTANCES)):
        level = np.log(azimuth) - 0.5 * np.log1p((near / distance) ** 2)
        order = np.argsort(level, kind="stable")
        middle = level[order][np.searchsorted(np.cumsum(count[order]), count.sum() / 2)]
        off = float(np.dot(count, np.abs(level - middle)))
        if off < best[1] * (LESS_OFF if best[0] == 0.0 else 1.0):
            best = near * float(np.exp(middle)), off
    return best[0]


def _beside_curves(time: FloatArray, place: FloatArray) -> tuple[FloatArray, FloatArray, IntArray]:
    """Return what neighbours say of reports, by how much that widens noise, and of which."""
    # Beside the curve through two reports before and two after, a turn leaves nothing.
    curve, known = expected_of(time, place)[-1]
    near = time[4:] - time[:-4] < LONGEST_SPAN * float(np.median(np.diff(time)))
    return curve[near], 1.0 + known[near], np.flatnonzero(near) + 2


def _beside_lines(time: FloatArray, place: FloatArray) -> tuple[FloatArray, FloatArray, IntArray]:
    """Return the same of straight lines through each report and three before and after it."""
    # Of a single radar turns that bend them count as noise, as its gate has to hold them.
    fitted, known = np.empty_like(place), np.empty(time.size)
    for middle in range(time.size):
        first = int(np.clip(middle - HALF, 0, time.size - 2 * HALF - 1))
        piece = slice(first, first + 2 * HALF + 1)
        centred = time[piece] - time[piece].mean()
        total = max(float(np.dot(centred, centred)), 1e-12)
        lever = time[middle] - time[piece].mean()
        fitted[middle] = place[piece].mean(axis=0) + lever * (centred @ place[piece]) / total
        known[middle] = max(1 - 1 / (2 * HALF + 1) - lever**2 / total, 0.1)
    return fitted, known, np.arange(time.size)


def components(relative: FloatArray) -> FloatArray:
    """Return range, azimuth and, in space, elevation."""
    distance = np.linalg.norm(relative, axis=1)
    columns = [distance, np.arctan2(relative[:, 0], relative[:, 1])]
    if relative.shape[1] == 3:
        columns.append(np.arctan2(relative[:, 2], np.hypot(relative[:, 0], relative[:, 1])))
    return np.stack(columns, axis=1)


def _wrapped(difference: FloatArray) -> FloatArray:
    wrapped = difference.copy()
    wrapped[:, 1:] = (wrapped[:, 1:] + np.pi) % (2 * np.pi) - np.pi
    return wrapped


def bearing_sensor(
    time: FloatArray,
    bearing: FloatArray,
    seen_from: FloatArray,
    tracks: list[tuple[FloatArray, FloatArray]],
    width: float,
) -> SensorEstimate | None:
    """Return what the bearings of one sensor tell beside tracks of other sensors."""
    # Bearings near the direction of a track are a bell about it over an even ground of others.
    # They are clockwise from north [rad], by ascending time, ``width`` that of the sector from
    # which they come. Tracks are times and places. The noise is one number in a tuple [rad], false
    # alarms are per radian and scan; None where too few bearings are near a track.
    moments = np.unique(time)
    off, chances = _beside(time, bearing, seen_from, tracks)
    if off.size < FEWEST_RESIDUALS:
        return None
    sigma, share = _bell(off)
    hits = share * off.size
    usual = USUAL_DETECTION * USUAL_CHANCES
    detection = (hits + usual) / (chances + USUAL_CHANCES)
    per_scan = bearing.size / moments.size
    seen = hits / moments.size
    return SensorEstimate(
        scan_period=scan_period(moments),
        sigma=(digits(sigma),),
        detection_probability=digits(float(np.clip(detection, *DETECTION_RANGE))),
        clutter_density=digits(max(per_scan - seen, 0.05 * per_scan) / width),
        covered=width,
        n_objects=max(seen / max(detection, 0.1), 0.1),
    )


def _beside(
    time: FloatArray,
    bearing: FloatArray,
    seen_from: FloatArray,
    tracks: list[tuple[FloatArray, FloatArray]],
) -> tuple[FloatArray, int]:
    """Return how far bearings are beside tracks [rad], and how often a track could be seen."""
    off, chances = [], 0
    moments = np.unique(time)
    for known, place in tracks:
        alive = (time >= known[0]) & (time <= known[-1])
        chances += int(np.count_nonzero((moments >= known[0]) & (moments <= known[-1])))
        where = np.stack([np.interp(time[alive], known, axis) for axis in place.T[:2]], axis=1)
        east, north = (where - seen_from[alive, :2]).T
        beside = (bearing[alive] - np.arctan2(east, north) + np.pi) % (2 * np.pi) - np.pi
        off.append(beside[np.abs(beside) < NEAR])
    return np.concatenate(off) if off else np.empty(0), chances


def _bell(off: FloatArray) -> tuple[float, float]:
    """Return the width of a bell over an even ground [rad], and the share that is in it."""
    sigma, share = NEAR / 5, 0.5
    for _ in range(N_ROUNDS):
        bell = share * np.exp(-0.5 * (off / sigma) ** 2) / (np.sqrt(2 * np.pi) * sigma)
        own = bell / (bell + (1 - share) / (2 * NEAR))
        share = float(np.clip(own.mean(), 0.01, 0.99))
        spread = float(np.sqrt(np.sum(own * off**2) / max(float(own.sum()), 1e-9)))
        sigma = float(np.clip(spread, LEAST_ANGLE, MOST_ANGLE))
    return sigma, share
