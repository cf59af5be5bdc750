"""Noise of positions that is not the same everywhere, as of a camera on the ground it looks at."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.domain.reports import ReportTable
from trackweave.estimation.estimates import Estimates, SensorEstimate, digits
from trackweave.estimation.neighbours import beside_neighbours
from trackweave.estimation.refine import Followed, Track, sure_tracks

__all__ = ["with_noise_places"]

# So many reports of so many tracks tell of a place, and of so many places there are at most.
FEWEST_REPORTS, FEWEST_TRACKS, MOST_PLACES = 60, 3, 16
# Noise counts as another where the largest is so many times the least, and where half of the
# tracks tell of places what the other half does: at so much of a correlation.
APART, ALIKE = 2.0, 0.7
# … where most places have so many reports of either half.
SOME, FEWEST_OF_HALF = 0.6, 10
# So many reports lie off by no more than so many standard deviations.
MOST, MOST_OF_NORMAL = 0.9, 1.6449


class _Off(NamedTuple):
    """How far reports lie off the curve through their neighbours."""

    place: FloatArray  # [m], shape (reports, dim)
    off: FloatArray  # As that of a single report [m], of the same shape
    track: IntArray


def with_noise_places(estimates: Estimates, reports: ReportTable, followed: Followed) -> Estimates:
    """Return estimates with the noise at places of sensors in which it is not alike everywhere."""
    sensors, tracks = dict(estimates.sensors), sure_tracks(estimates, reports, followed)
    for index, name in enumerate(reports.sensors):
        if name in sensors and sensors[name].scans is not False:
            sensors[name] = _with_places(sensors[name], _beside(reports, tracks, index))
    return replace(estimates, sensors=sensors)


def _with_places(sensor: SensorEstimate, found: _Off) -> SensorEstimate:
    if len(found.off) < 2 * FEWEST_REPORTS:
        return replace(sensor, sigma_at=())
    cells = _cells(found)
    noise = np.array([_noise(found.off[rows]) for rows in cells])
    level = np.sqrt(np.mean(noise**2, axis=1))
    if level.min() <= 0.0 or level.max() < APART * level.min() or not _agree(found, cells):
        return replace(sensor, sigma_at=())
    middles = [found.place[rows].mean(axis=0)[:2] for rows in cells]
    places = tuple(
        (*(digits(float(value), 7) for value in middle), *(digits(float(value)) for value in own))
        for middle, own in zip(middles, noise, strict=True)
    )
    return replace(sensor, sigma_at=places)


def _noise(off: FloatArray) -> FloatArray:
    """Return the standard deviation along each axis, wide enough for nearly all."""
    return np.asarray(np.quantile(np.abs(off), MOST, axis=0) / MOST_OF_NORMAL)


def _beside(reports: ReportTable, tracks: list[Track], index: int) -> _Off:
    """Return how far a sensor's reports lie off the curves through those of their tracks."""
    dim = reports.dim
    parts = [_Off(np.empty((0, dim)), np.empty((0, dim)), np.empty(0, dtype=np.int64))]
    for number, track in enumerate(tracks):
        rows = track.rows[reports.sensor[track.rows] == index]
        place, off = beside_neighbours(reports.time[rows], reports.measurement[rows])
        parts.append(_Off(place, off, np.full(len(off), number)))
    return _Off(*map(np.concatenate, zip(*parts, strict=True)))


def _cells(found: _Off) -> list[IntArray]:
    """Return the rows in each part of the plane, halved along its longer side while many tell."""
    cells, whole = [np.arange(len(found.off))], list[IntArray]()
    while cells and len(cells) + len(whole) < MOST_PLACES:
        cells.sort(key=len)
        rows = cells.pop()
        place = found.place[rows, :2]
        side = int(np.argmax(np.ptp(place, axis=0)))
        order = rows[np.argsort(place[:, side], kind="stable")]
        halves = np.array_split(order, 2)
        if all(_tells(found, half) for half in halves):
            cells += halves
        else:
            whole.append(rows)
    return cells + whole


def _tells(found: _Off, rows: IntArray) -> bool:
    return rows.size >= FEWEST_REPORTS and np.unique(found.track[rows]).size >= FEWEST_TRACKS


def _agree(found: _Off, cells: list[IntArray]) -> bool:
    """Tell whether one half of the tracks has noise where the other half has it."""
    # Or a few objects whose reports are worse than others' would make places of their own.
    halves = [[rows[found.track[rows] % 2 == half] for half in (0, 1)] for rows in cells]
    both = [each for each in halves if min(map(len, each)) >= FEWEST_OF_HALF]
    if len(both) < max(SOME * len(cells), 2):
        return False
    noise = np.array([[_noise(found.off[rows]) for rows in each] for each in both])
    levels = np.log(np.mean(noise**2, axis=2))
    first, second = (levels - levels.mean(axis=0)).T
    spread = float(np.sqrt(np.dot(first, first) * np.dot(second, second)))
    return bool(np.dot(first, second) > ALIKE * spread)
