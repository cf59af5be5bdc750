"""Places that give a ranging sensor false alarms again and again: turbines, towers, a coast.

Their reports lie together and come all the time, and are no object that stands: they scatter more
than its noise would let them, or come far more seldom than objects are seen.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

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
MOST_PLACES = 200


def with_standing(
    estimates: Estimates, reports: ReportTable, places: Mapping[str, Sequence[float]]
) -> Estimates:
    """Return estimates with the places of false alarms of sensors that measure ranges."""
    # ``places`` are where those stand [m]. Reports are of the whole recording, on the plane, with
    # the number of their scan where it is not their time.
    sensors = dict(estimates.sensors)
    scan = reports.time if reports.scan is None else reports.scan
    for name, place in places.items():
        found = sensors.get(name)
        if found is None or not isinstance(found.sigma, tuple) or reports.dim != 2:
            continue
        rows = np.flatnonzero(reports.sensor == reports.sensors.index(name))
        stands = platform_of(reports, rows, place)
        if np.any(np.ptp(stands, axis=0) > 1.0):
            continue
        relative = reports.measurement[rows] - stands
        echoes = _echoes(found, components(relative), scan[rows], reports.time[rows])
        if echoes:
            sensors[name] = replace(found, echoes=_on_plane(echoes, stands[0]))
    return replace(estimates, sensors=sensors)


def _echoes(
    sensor: SensorEstimate, polar: FloatArray, scan: FloatArray | IntArray, time: FloatArray
) -> list[tuple[float, ...]]:
    """Return range, azimuth, spread [m] and number a scan of each place, the surest first."""
    assert isinstance(sensor.sigma, tuple)
    sigma = np.array(sensor.sigma[:2])
    n_scans = np.unique(scan).size
    if n_scans < FEWEST_SCANS:
        return []
    elapsed = (time - time.min()) / max(float(np.ptp(time)), 1e-9)
    part = np.minimum((PARTS * elapsed).astype(np.int64), PARTS - 1)
    scaled = polar[:, :2] / sigma
    # Runs without such radars need not wait for the import.
    from scipy.spatial import cKDTree

    tree = cKDTree(scaled)
    count = tree.query_ball_point(scaled, NEAR, return_length=True)
    enough = max(FEWEST, LEAST_SHARE * n_scans)
    echoes: list[tuple[float, ...]] = []
    free = np.ones(time.size, dtype=bool)
    for row in np.argsort(-count, kind="stable"):
        if count[row] < enough or len(echoes) == MOST_PLACES:
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
        share = n_seen / n_scans
        if spread.max() < WIDER and share > SELDOM * sensor.detection_probability:
            continue
        distance, azimuth = middle * sigma
        wide = np.maximum(spread, 1.0) * sigma * (1.0, distance)
        echoes.append((float(distance), float(azimuth), float(wide.max()), near.size / n_scans))
    return echoes


def _on_plane(
    echoes: Sequence[tuple[float, ...]], place: FloatArray
) -> tuple[tuple[float, ...], ...]:
    """Return echoes by x and y [m] instead of range and azimuth."""
    return tuple(
        (
            digits(float(place[0] + distance * np.sin(azimuth)), 7),
            digits(float(place[1] + distance * np.cos(azimuth)), 7),
            digits(spread, 3),
            digits(count, 3),
        )
        for distance, azimuth, spread, count in echoes
    )
