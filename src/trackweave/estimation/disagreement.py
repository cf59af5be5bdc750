"""How far apart two sensors see one object."""

from collections.abc import Mapping
from dataclasses import replace
from itertools import combinations
from typing import TypeAlias

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.domain.reports import ReportTable
from trackweave.estimation.estimates import SensorEstimate, bounded
from trackweave.estimation.frames import Frames
from trackweave.estimation.motion import reach
from trackweave.estimation.trees import tree_of

__all__ = ["disagreements", "reconciled"]

FEWEST_PAIRS = 20
MOST_SCANS = 400
# Pairs of scans within this share of the shorter gap between scans count as of one time.
SAME_TIME = 0.5
# Two sensors' reports of one object are nearer to each other than so much of the way to the next.
NEARER = 0.5

_Scans: TypeAlias = tuple[FloatArray, list[FloatArray]]
"""When a sensor looked [s], and what it reported each time [m]."""


def disagreements(reports: ReportTable, speed: float) -> dict[tuple[int, int], float]:
    """Return the mean squared distance [m²] per axis of two sensors' reports of one object."""
    # Scans that two sensors took at almost one time are laid over one another; distances at which
    # reports are paired more often than chance pairs them are those of one object. Pairs of
    # sensors, by their indices, of which nothing stands out are left out, and those that turn.
    scans = {
        index: _scans(reports, index)
        for index in range(len(reports.sensors))
        if np.any(reports.sensor == index) and not _turns(reports, index)
    }
    found = {}
    for first, second in combinations(scans, 2):
        square = _mean_square(scans[first], scans[second], speed)
        if square is not None:
            found[first, second] = square
    return found


def reconciled(
    sensors: dict[str, SensorEstimate],
    reports: ReportTable,
    speed: float,
    known: Mapping[str, float],
) -> dict[str, SensorEstimate]:
    """Return sensors whose noise lets them agree: each may mark another part of an object."""
    if len(sensors) < 2:
        return sensors
    extra: dict[str, list[float]] = {}
    for pair, square in disagreements(reports, speed).items():
        first, second = (reports.sensors[index] for index in pair)
        if square > _spacing_of_lone(sensors[first], sensors[second]) ** 2:
            continue
        unexplained = square - sensors[first].plane_sigma ** 2 - sensors[second].plane_sigma ** 2
        for name in (first, second):
            extra.setdefault(name, []).append(max(unexplained, 0.0) / 2)
    for name, variances in extra.items():
        if name not in known:
            more = float(np.sqrt(np.mean(variances)))
            sigma = bounded(float(np.hypot(sensors[name].plane_sigma, more)), 1e-9)
            sensors[name] = replace(sensors[name], sigma=sigma, disagreement=more)
    return sensors


def _spacing_of_lone(*sensors: SensorEstimate) -> float:
    """Return how far apart objects are that report by themselves [m]; infinite where one looks."""
    # No two are told at once, so that nothing tells it but how many there are, evenly spread.
    if any(sensor.scans is not False or not sensor.n_objects for sensor in sensors):
        return np.inf
    return min(0.5 * float(np.sqrt(each.covered / each.n_objects)) for each in sensors)


def _turns(reports: ReportTable, index: int) -> bool:
    """Tell whether a sensor's scans hold reports of several times."""
    # What it sees in a turn moves meanwhile: scans of two such are never of one time.
    if reports.scan is None:
        return False
    own = reports.sensor == index
    pairs = np.unique(np.stack([reports.scan[own], reports.time[own]]), axis=1)
    return bool(pairs.shape[1] > np.unique(reports.scan[own]).size)


def _scans(reports: ReportTable, index: int) -> _Scans:
    rows = np.flatnonzero(reports.sensor == index)
    times, starts = np.unique(reports.time[rows], return_index=True)
    return times, np.split(reports.measurement[rows], starts[1:])


def _mean_square(
    first: _Scans,
    second: _Scans,
    speed: float,
) -> float | None:
    """Return the mean squared distance along an axis [m²], None where none stands out."""
    gaps = [np.median(np.diff(times)) for times, _ in (first, second) if times.size > 1]
    if len(gaps) < 2:
        return None
    near = SAME_TIME * float(min(gaps))
    first, second = _where_both_see(first, second)
    if not first[0].size or not second[0].size:
        return None
    blocks, apart = [], []
    for time, position in list(zip(*first, strict=True))[:MOST_SCANS]:
        other = int(np.argmin(np.abs(second[0] - time)))
        if abs(second[0][other] - time) <= near:
            # One second apart, so that a speed is a distance.
            blocks.append(Frames(np.array([0.0, 1.0]), [position, second[1][other]]))
            apart.append(abs(second[0][other] - time))
    if not blocks:
        return None
    found = reach(blocks)
    if found is None or found[1] * len(blocks) < FEWEST_PAIRS:
        return None
    radius, dim = found[0], blocks[0].position[0].shape[1]
    squares = np.concatenate([_nearest(block, radius) for block in blocks])
    if squares.size < FEWEST_PAIRS:
        return None
    if float(np.median(squares)) > (NEARER * _spacing(first[1], second[1])) ** 2:
        # As far apart as objects are, pairs are of two.
        return None
    # Between the two scans objects moved; the median is not drawn by wrong pairs.
    moved = (speed * float(np.mean(apart)) / 2) ** 2
    square = float(np.minimum(squares, 9 * np.median(squares)).mean())
    return float(max(square - moved, 0.0) / dim)


def _spacing(*scans: list[FloatArray]) -> float:
    """Return how far apart reports of one scan usually are [m], infinite for lone ones."""
    near = [
        tree_of(each).query(each, k=2)[0][:, 1]
        for position in scans
        for each in position[:MOST_SCANS]
        if each.shape[0] > 1
    ]
    return float(np.median(np.concatenate(near))) if near else np.inf


def _where_both_see(first: _Scans, second: _Scans) -> tuple[_Scans, _Scans]:
    """Return the scans' reports in the box that both sensors' reports share, no scan empty."""
    # Beyond it one is alone: what is nearest there is another object.
    every = [np.concatenate(position) for _, position in (first, second)]
    low = np.max([each.min(axis=0) for each in every], axis=0)
    high = np.min([each.max(axis=0) for each in every], axis=0)
    return _within(first, low, high), _within(second, low, high)


def _within(scans: _Scans, low: FloatArray, high: FloatArray) -> _Scans:
    inside = [each[np.all((each >= low) & (each <= high), axis=1)] for each in scans[1]]
    kept = np.array([each.shape[0] > 0 for each in inside], dtype=bool)
    return scans[0][kept], [each for each in inside if each.shape[0]]


def _nearest(block: Frames, radius: float) -> FloatArray:
    """Return the squared distances of reports that are each other's nearest [m²]."""
    first, second = block.position
    distance, other = tree_of(second).query(first, distance_upper_bound=radius)
    _, back = tree_of(first).query(second)
    rows = np.flatnonzero(np.isfinite(distance))
    mutual = rows[back[other[rows]] == rows]
    return np.asarray(distance[mutual] ** 2)
