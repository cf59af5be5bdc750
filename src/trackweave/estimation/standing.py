"""Places that give a sensor false alarms again and again: turbines, towers, a coast.

Their reports lie together and come all the time, and are no object that stands: they scatter more
than its noise would let them, or come far more seldom than objects are seen. Where many objects
pass, as on the ways of a holding stack, reports come all the time as well, and are theirs; and
where objects stand for a while, as trains in a station, one is there in scan after scan.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from trackweave.arrays import FloatArray, IntArray
from trackweave.domain.reports import ReportTable
from trackweave.estimation.along_sight import platform_of
from trackweave.estimation.directions import components
from trackweave.estimation.estimates import Estimates, SensorEstimate, digits
from trackweave.estimation.heard_at_rest import REACH, heard_at_rest
from trackweave.estimation.refine import Track
from trackweave.estimation.trees import all_within, n_within, tree_of

__all__ = ["are_in_turn", "looks_of", "with_seldom", "with_standing"]

# Reports this near one another, in standard deviations of range and azimuth, are of one place.
NEAR = 8.0
# A place gives reports in so many scans and such a share of all, and in each part of the time.
FEWEST, LEAST_SHARE, PARTS, FEWEST_SCANS = 7, 0.06, 4, 30
# An object that stands is seen this near its place in more than this share of the scans in which
# objects are; what scatters twice as far as noise does is not.
OWN, SELDOM = 2.5, 0.5
# Where one report follows another from scan to scan as often, but for this share, as objects are
# seen, they stand in turn, unless false alarms stay for a while themselves.
IN_TURN = 0.8
# By chance one follows another in no more than the share of all scans and so many deviations.
FOLLOWING = 3.0
# What moves through a place, by so much at least, scatters about a straight way by noise alone.
MOVED, STEADY = 3.0, 1.5
# Where its width begins to count it is looked at both ways.
OVERLAP = 1.5
# Who passes a place has no more than such a share of its reports there.
OF_PASSERS = 0.5
# So many times as many as there are of false alarms that come everywhere. Of these the half lie
# beyond so much of what is near along an axis; what comes of one place lies closer together.
DENSER, LOOSE = 4.0, 0.4
MOST_PLACES = 200
# No column of elevations is lower [rad].
LOWEST = 0.02

_Places: TypeAlias = tuple[tuple[float, ...], ...]
_Moments: TypeAlias = tuple[IntArray, FloatArray]
"""The number of each report's scan, and its time [s]."""
_Followed: TypeAlias = tuple[ReportTable, Sequence[Track]]
"""A stretch of the reports, and its sure tracks."""


def with_standing(
    estimates: Estimates,
    reports: ReportTable,
    places: Mapping[str, Sequence[float]],
    followed: _Followed,
    *,
    at_rest: bool = False,
) -> Estimates:
    """Return estimates with the places of false alarms of sensors that measure ranges."""
    # With ``at_rest`` whatever stands is one, however often it is seen.
    # ``places`` are where those stand [m]. Reports are of the whole recording, on the plane, with
    # the number of their scan where it is not their time; ``followed`` is a stretch of them with
    # its sure tracks.
    sensors, heard = dict(estimates.sensors), heard_at_rest(estimates, reports)
    for name, place in places.items():
        found = sensors.get(name)
        if found is None or not isinstance(found.sigma, tuple):
            continue
        rows = np.flatnonzero(reports.sensor == reports.sensors.index(name))
        stands = platform_of(reports, rows, place)
        if not np.any(np.ptp(stands, axis=0) > 1.0):
            away = reports.measurement[rows] - stands
            passers = _Passers.of(followed, name, stands[0], np.array(found.sigma)[:2])
            seen_from = _SeenFrom(stands[0], passers, at_rest)
            look = looks_of(reports, rows, np.unique(reports.time[rows]))
            standing = _of_ranges(
                found, components(away[:, :2]), (look, reports.time[rows]), seen_from
            )
            standing = _unheard(standing, heard, found)
            sensors[name] = _with(found, _in_columns(standing, away))
    return replace(estimates, sensors=sensors)


def _in_columns(standing: _Places, away: FloatArray) -> _Places:
    """Return places over which false alarms come from all elevations, a radian's number each."""
    # How high a place reaches a few of its reports hardly tell; what flies over it pays for all
    # of the column alike.
    if away.shape[1] == 2:
        return standing
    elevation = components(away)[:, 2]
    height = max(float(np.ptp(elevation)), LOWEST)
    return tuple((x, y, wide, digits(count / height, 3)) for x, y, wide, count in standing)


def with_seldom(
    estimates: Estimates,
    unexplained: ReportTable,
    looks: Mapping[str, FloatArray],
    reports: ReportTable,
    *,
    at_rest: bool = False,
) -> Estimates:
    """Return estimates with the places where sensors report positions again and again."""
    # ``unexplained`` are the ``reports`` on no sure track, ``looks`` when each sensor looked [s].
    # With ``at_rest`` they are all, and whatever stands is such a place, however often it is seen.
    sensors, heard = dict(estimates.sensors), heard_at_rest(estimates, reports)
    for index, name in enumerate(unexplained.sensors):
        found, rows = sensors.get(name), np.flatnonzero(unexplained.sensor == index)
        if found is None or found.scans is False or unexplained.dim != 2 or not rows.size:
            continue
        look = looks_of(unexplained, rows, looks[name])
        place, moments = unexplained.measurement[rows], (look, unexplained.time[rows])
        standing = _of_plane(found, place, moments, looks[name].size, at_rest=at_rest)
        sensors[name] = _with(found, _unheard(standing, heard, found))
    return replace(estimates, sensors=sensors)


def _unheard(standing: _Places, heard: FloatArray, sensor: SensorEstimate) -> _Places:
    """Return places without those where a sensor sees what reports itself."""
    return tuple(
        each
        for each in standing
        if not np.any(np.hypot(*(heard - each[:2]).T) < REACH * sensor.plane_sigma)
    )


def looks_of(reports: ReportTable, rows: IntArray, looks: FloatArray) -> IntArray:
    """Return in which of its looks a sensor made some reports; ``looks`` are when they were."""
    return (
        reports.scan[rows] if reports.scan is not None else looks.searchsorted(reports.time[rows])
    )


def are_in_turn(look: IntArray, n_looks: int, sensor: SensorEstimate) -> bool:
    """Tell whether reports at a place are of objects that stand there for a while each."""
    seen = np.unique(look)
    share, follow = seen.size / n_looks, float(np.isin(seen + 1, seen).mean())
    by_chance = share + FOLLOWING * math.sqrt(share * max(1.0 - share, 0.0) / seen.size)
    known = IN_TURN * sensor.detection_probability
    return sensor.clutter_persistence == 0.0 and follow >= max(known, by_chance) and share < known


def _with(sensor: SensorEstimate, standing: _Places) -> SensorEstimate:
    """Return a sensor with places beside those where its false alarms are dense anyway."""
    dense = [
        each
        for each in sensor.echoes
        if all(np.hypot(each[0] - x, each[1] - y) > each[2] + wide for x, y, wide, _ in standing)
    ]
    return replace(sensor, echoes=(*standing, *dense))


def _of_plane(
    sensor: SensorEstimate, place: FloatArray, moments: _Moments, n_scans: int, *, at_rest: bool
) -> _Places:
    """Return x, y, spread [m] and number a scan of places where a sensor reports positions."""
    # What wags about a place, such as a cell, scatters too: there only its silence tells.
    sigma = sensor.plane_sigma
    most = SELDOM * sensor.detection_probability
    usual = sensor.clutter_density * math.pi * (NEAR * sigma) ** 2
    return tuple(
        _written(each.middle * sigma, max(float(each.spread.max()), 1.0) * sigma, each.number)
        for each in _repeated(place / sigma, moments, n_scans, at_rest=at_rest)
        if (
            (each.share <= most and (at_rest or not are_in_turn(each.look, n_scans, sensor)))
            or (at_rest and each.moved < MOVED)
        )
        and each.number > DENSER * usual
    )[:MOST_PLACES]


def _of_ranges(
    sensor: SensorEstimate,
    polar: FloatArray,
    moments: _Moments,
    seen_from: "_SeenFrom",
) -> _Places:
    """Return the same of ranges and azimuths of a sensor that stands at a place."""
    stands, passers, at_rest = seen_from
    sigma, (scan, time) = np.array(sensor.sigma)[:2], moments
    scaled, n_scans = polar[:, :2] / sigma, np.unique(scan).size
    seen = max(FEWEST, SELDOM * sensor.detection_probability * n_scans)
    # Near a sensor that measures angles an object's own width is what scatters, in metres.
    metres = max(sensor.across, float(sigma[0]))
    about, border = _plane(polar) / metres, sensor.across / sigma[1]
    is_left = np.ones(scan.size, dtype=np.bool_)
    for where, rows in (
        (about, np.flatnonzero(polar[:, 0] < OVERLAP * border)),
        (scaled, np.flatnonzero(polar[:, 0] > border / OVERLAP)),
    ):
        if not at_rest:
            is_left[rows[_of_objects(where[rows], scan[rows], seen)]] = False
    left = np.flatnonzero(is_left)
    # Where noise is coarse, what comes from anywhere comes near every place, and lies about it.
    cells = float(np.prod(np.maximum(np.ptp(scaled, axis=0), 1.0)))
    holds = DENSER * min(math.pi * NEAR**2 / cells, 1.0)
    places = []
    moments = scan[left], time[left]
    for each in _repeated(scaled[left], moments, n_scans, at_rest=at_rest):
        own = 1.0 - passers.share(each.middle)
        if each.moved >= MOVED and each.rest <= STEADY and each.share * n_scans >= seen:
            # As exact and as often seen as objects are, and moving slowly.
            continue
        if not at_rest and are_in_turn(each.look, n_scans, sensor):
            continue
        others = left.size / n_scans - each.number
        is_loose = float(each.spread.max()) > LOOSE * NEAR and own * each.number <= holds * others
        if own * each.share * n_scans < _enough(n_scans) or is_loose:
            continue
        middle = each.middle * sigma
        wide = np.maximum(each.spread, 1.0) * sigma * (1.0, middle[0])
        places.append(
            _written(stands[:2] + _plane(middle[None])[0], float(wide.max()), own * each.number)
        )
    return tuple(places[:MOST_PLACES])


def _of_objects(scaled: FloatArray, scan: FloatArray | IntArray, seen: float) -> NDArray[np.bool_]:
    """Tell which reports lie where objects stand, seen in so many scans each."""
    # Of what stands more exactly than false alarms do, any number lie side by side.
    tree, is_object = tree_of(scaled), np.zeros(scan.size, dtype=np.bool_)
    count = n_within(tree, scaled, OWN)
    for row in np.argsort(-count, kind="stable"):
        if count[row] < seen:
            break
        near = all_within(tree, scaled[[row]], OWN)[0]
        if not is_object[row] and np.unique(scan[near]).size >= seen:
            is_object[all_within(tree, scaled[[row]], NEAR)[0]] = True
    return is_object


def _plane(polar: FloatArray) -> FloatArray:
    """Return places about a sensor [m] of ranges and azimuths."""
    east, north = polar[:, 0] * np.sin(polar[:, 1]), polar[:, 0] * np.cos(polar[:, 1])
    return np.stack([east, north], axis=1)


def _written(place: FloatArray, spread: float, count: float) -> tuple[float, ...]:
    x, y = (digits(float(value), 7) for value in place)
    return x, y, digits(spread, 3), digits(count, 3)


def _enough(n_scans: int) -> float:
    """Return in how many scans a place gives reports at least."""
    return max(FEWEST, LEAST_SHARE * n_scans)


class _Passers(NamedTuple):
    """Reports of a stretch, and those of objects on sure tracks that may pass a place."""

    scaled: FloatArray  # Of all reports [standard deviations], shape (reports, 2)
    tracks: list[FloatArray]  # The same of each track

    @classmethod
    def of(
        cls, followed: _Followed, name: str, stands: FloatArray, sigma: FloatArray
    ) -> "_Passers":
        """Return those of a sensor that stands at a place, with its noise."""
        stretch, tracks = followed
        own = stretch.sensor == stretch.sensors.index(name)
        scaled = components((stretch.measurement - stands)[:, :2]) / sigma
        return cls(scaled[own], [scaled[each.rows[own[each.rows]]] for each in tracks])

    def share(self, middle: FloatArray) -> float:
        """Return which share of the reports at a place is of objects that pass it."""
        total = _n_near(self.scaled, middle)
        near = [(_n_near(track, middle), track.shape[0]) for track in self.tracks]
        return sum(count for count, size in near if count <= OF_PASSERS * size) / max(total, 1)


class _SeenFrom(NamedTuple):
    """Where a sensor stands, what passes, and whether whatever stands is an echo."""

    stands: FloatArray  # [m]
    passers: _Passers
    at_rest: bool


def _n_near(scaled: FloatArray, middle: FloatArray) -> int:
    return int(np.count_nonzero(np.linalg.norm(scaled - middle, axis=1) <= NEAR))


class _Repeated(NamedTuple):
    """A place that comes again and again; lengths are in standard deviations."""

    middle: FloatArray
    spread: FloatArray
    number: float  # Reports a scan
    share: float  # Of the scans that have one
    look: IntArray  # In which scan each report is
    moved: float  # Along a straight way through it
    rest: float  # Spread about that way


def _way(place: FloatArray, elapsed: FloatArray, part: IntArray) -> tuple[float, float]:
    """Return how far reports at a place move on a straight way, and how they scatter about it."""
    # Through the middles of the parts of the time, which a few reports aside do not draw.
    own = [part == number for number in range(PARTS)]
    middles = np.array([np.median(place[each], axis=0) for each in own])
    times = np.array([np.median(elapsed[each]) for each in own])
    line = np.polynomial.polynomial.polyfit(times, middles, 1)
    off = place - (line[0] + elapsed[:, None] * line[1])
    return float(np.linalg.norm(line[1])), float((1.4826 * np.median(np.abs(off), axis=0)).max())


def _repeated(
    scaled: FloatArray, moments: _Moments, n_scans: int, *, at_rest: bool = False
) -> list[_Repeated]:
    """Return the places with reports all the time, those of most reports first."""
    if n_scans < FEWEST_SCANS or not scaled.size:
        return []
    scan, time = moments
    elapsed = (time - time.min()) / max(float(np.ptp(time)), 1e-9)
    part = np.minimum((PARTS * elapsed).astype(np.int64), PARTS - 1)
    tree = tree_of(scaled)
    count = n_within(tree, scaled, NEAR)
    enough = _enough(n_scans)
    places: list[_Repeated] = []
    free = np.ones(time.size, dtype=bool)
    for row in np.argsort(-count, kind="stable"):
        if count[row] < enough:
            break
        if not free[row]:
            continue
        middle = np.median(scaled[all_within(tree, scaled[[row]], NEAR)[0]], axis=0)
        near = all_within(tree, middle[None], NEAR)[0]
        spread = 1.4826 * np.median(np.abs(scaled[near] - middle), axis=0)
        # What an object's noise scatters about one place is all there; what is wider has a fringe.
        apart = NEAR if at_rest and spread.max() < STEADY else 2.0 * NEAR
        free[row], free[all_within(tree, middle[None], apart)[0]] = False, False
        n_seen = np.unique(scan[near]).size
        if n_seen >= enough and np.unique(part[near]).size == PARTS:
            way = _way(scaled[near], elapsed[near], part[near])
            number, share = near.size / n_scans, n_seen / n_scans
            places.append(_Repeated(middle, spread, number, share, scan[near], *way))
    return places
