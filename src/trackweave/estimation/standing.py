"""Places that give a sensor false alarms again and again: turbines, towers, a coast.

Their reports lie together and come all the time, and are no object that stands: they scatter more
than its noise would let them, or come far more seldom than objects are seen.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TypeAlias

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.domain.reports import ReportTable
from trackweave.estimation.directions import components
from trackweave.estimation.estimates import Estimates, SensorEstimate, digits
from trackweave.estimation.refine import platform_of

__all__ = ["with_standing"]

# Reports this near one another, in standard deviations of range and azimuth, are of one place.
NEAR = 8.0
# A place gives reports in so many scans and such a share of all, and in each part of the time.
FEWEST, LEAST_SHARE, PARTS, FEWEST_SCANS = 7, 0.06, 4, 30
# An object that stands scatters less than so many times its noise, and is seen in more than this
# share of the scans in which objects are.
WIDER, SELDOM = 1.7, 0.5
# On the plane, so many times as many as there are of false alarms that come everywhere.
DENSER = 4.0
MOST_PLACES = 200

_Places: TypeAlias = tuple[tuple[float, ...], ...]
_Moments: TypeAlias = tuple[FloatArray | IntArray, FloatArray]
"""The number of each report's scan, and its time [s]."""


def with_standing(
    estimates: Estimates,
    reports: ReportTable,
    places: Mapping[str, Sequence[float]],
    looks: Mapping[str, int] | None = None,
) -> Estimates:
    """Return estimates with the places of false alarms of sensors that look."""
    # ``places`` are where those stand that measure ranges [m]. Their reports are of the whole
    # recording, on the plane, with the number of their scan where it is not their time; of others
    # come those that are on no sure track, beside how often they looked.
    sensors = dict(estimates.sensors)
    scan = reports.time if reports.scan is None else reports.scan
    for index, name in enumerate(reports.sensors):
        found, rows = sensors.get(name), np.flatnonzero(reports.sensor == index)
        if found is None or found.scans is False or reports.dim != 2 or not rows.size:
            continue
        moments = scan[rows], reports.time[rows]
        if looks is not None:
            place = reports.measurement[rows]
            places_of = _of_plane(found, place, moments, looks.get(name, 0))
        elif name in places and isinstance(found.sigma, tuple):
            stands = platform_of(reports, rows, places[name])
            if np.any(np.ptp(stands, axis=0) > 1.0):
                continue
            polar = components(reports.measurement[rows] - stands)
            places_of = _of_ranges(found, polar, moments, stands[0])
        else:
            continue
        if places_of:
            others = _others(found.echoes, places_of)
            sensors[name] = replace(found, echoes=(*places_of, *others))
    return replace(estimates, sensors=sensors)


def _of_plane(
    sensor: SensorEstimate, place: FloatArray, moments: _Moments, n_scans: int
) -> _Places:
    """Return x, y, spread [m] and number a scan of places where a sensor reports positions."""
    sigma = sensor.plane_sigma
    # What wags about a place, such as a cell, scatters too: there only its silence tells.
    found = _standing(sensor, place / sigma, moments, n_scans)
    usual = sensor.clutter_density * math.pi * (NEAR * sigma) ** 2
    found = [each for each in found if each[2] > DENSER * usual]
    return tuple(
        _written(middle * sigma, max(float(spread.max()), 1.0) * sigma, count)
        for middle, spread, count in found
    )


def _of_ranges(
    sensor: SensorEstimate, polar: FloatArray, moments: _Moments, place: FloatArray
) -> _Places:
    """Return the same of ranges and azimuths of a sensor that stands at a place."""
    sigma = np.array(sensor.sigma)[:2]
    places = []
    for middle, spread, count in _standing(sensor, polar[:, :2] / sigma, moments):
        distance, azimuth = middle * sigma
        wide = np.maximum(spread, 1.0) * sigma * (1.0, distance)
        way = distance * np.array([np.sin(azimuth), np.cos(azimuth)])
        places.append(_written(place[:2] + way, float(wide.max()), count))
    return tuple(places)


def _written(place: FloatArray, spread: float, count: float) -> tuple[float, ...]:
    x, y = (digits(float(value), 7) for value in place)
    return x, y, digits(spread, 3), digits(count, 3)


def _others(
    dense: Sequence[tuple[float, ...]], standing: Sequence[tuple[float, ...]]
) -> list[tuple[float, ...]]:
    """Return places where false alarms are dense, but those that are known to stand there."""
    return [
        each
        for each in dense
        if all(np.hypot(each[0] - x, each[1] - y) > each[2] + wide for x, y, wide, _ in standing)
    ]


def _standing(
    sensor: SensorEstimate, scaled: FloatArray, moments: _Moments, n_looks: int | None = None
) -> list[tuple[FloatArray, FloatArray, float]]:
    """Return middle, spread and number a scan of each place in deviations, the surest first."""
    # Without ``n_looks`` each scan has a report, and what stands exactly is an object.
    scan, time = moments
    n_scans = np.unique(scan).size if n_looks is None else n_looks
    if n_scans < FEWEST_SCANS:
        return []
    elapsed = (time - time.min()) / max(float(np.ptp(time)), 1e-9)
    part = np.minimum((PARTS * elapsed).astype(np.int64), PARTS - 1)
    # Runs without such sensors need not wait for the import.
    from scipy.spatial import cKDTree

    tree = cKDTree(scaled)
    count = tree.query_ball_point(scaled, NEAR, return_length=True)
    enough = max(FEWEST, LEAST_SHARE * n_scans)
    places: list[tuple[FloatArray, FloatArray, float]] = []
    free = np.ones(time.size, dtype=bool)
    for row in np.argsort(-count, kind="stable"):
        if count[row] < enough or len(places) == MOST_PLACES:
            break
        if not free[row]:
            continue
        near = np.array(tree.query_ball_point(scaled[row], NEAR))
        middle = np.median(scaled[near], axis=0)
        free[row], free[tree.query_ball_point(middle, 2 * NEAR)] = False, False
        near = np.array(tree.query_ball_point(middle, NEAR))
        n_seen = np.unique(scan[near]).size
        if n_seen < enough or np.unique(part[near]).size < PARTS:
            continue
        spread = 1.4826 * np.median(np.abs(scaled[near] - middle), axis=0)
        is_often = n_seen / n_scans > SELDOM * sensor.detection_probability
        if is_often and (spread.max() < WIDER or n_looks is not None):
            continue
        places.append((middle, spread, near.size / n_scans))
    return places
