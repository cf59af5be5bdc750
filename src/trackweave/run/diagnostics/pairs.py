"""One sensor's reports beside the tracks of the others, under a hypothesis."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.run.diagnostics.case import Case, Path

__all__ = ["Sample", "best_clock", "best_shift", "sample_of"]

# So many reports of a sensor are compared with so many tracks of others.
MOST_REPORTS, MOST_TRACKS = 240, 80
OWN_SHARE, FEWEST_OF_OTHERS = 0.3, 4
# A report is near a track within so many standard deviations, as noise may be told wrongly in no
# less and no more than these shares of the space.
NEAR_SIGMAS, NEAREST, FARTHEST = 3.0, 0.004, 0.02
# Reports moved by so much of the space, in so many directions, are near a track by chance.
AWAY, DIRECTIONS = (0.13, 0.21, 0.29), 5
# Nobody follows with a clock what moves less than so many times what is near.
LEAST_MOVED = 8.0
MOST_STATES = 4000


@dataclass(frozen=True, slots=True, eq=False)
class Sample:
    """Some reports of a sensor, and the tracks that others made."""

    index: int
    time: FloatArray  # [s], shape (reports,)
    place: FloatArray  # Where the reports put their objects [m], shape (reports, 2)
    platform: FloatArray  # Where their sensor was [m], shape (reports, 2)
    paths: Sequence[Path]
    near: float  # How far from a track a report of its object may be [m]
    extent: float  # Diagonal of the space in which the tracks are [m]

    def there(self, later: float = 0.0) -> tuple[IntArray, IntArray, FloatArray]:
        """Return pairs of a report and a track alive then: both numbers, and the track's place."""
        # What is later by so many seconds was made that much earlier.
        report, track, place = [], [], []
        for number, path in enumerate(self.paths):
            at = path.at(self.time - later)
            alive = np.flatnonzero(~np.isnan(at[:, 0]))
            report.append(alive)
            track.append(np.full(alive.size, number))
            place.append(at[alive])
        return np.concatenate(report), np.concatenate(track), np.concatenate(place)

    def hits(
        self, pairs: tuple[IntArray, IntArray, FloatArray], place: FloatArray
    ) -> tuple[float, int]:
        """Return the share of reports near a track, and near how many tracks some are."""
        report, track, there = pairs
        off = there - place[report]
        is_near = np.einsum("ij,ij->i", off, off) <= self.near**2
        near_one = np.unique(track[is_near], return_counts=True)[1]
        share = np.unique(report[is_near]).size / max(self.time.size, 1)
        return share, int(np.count_nonzero(near_one >= 3))

    def chance(self, pairs: tuple[IntArray, IntArray, FloatArray], place: FloatArray) -> float:
        """Return the share of reports that are near a track wherever they are."""
        angle = 0.7 + 2 * np.pi * np.arange(DIRECTIONS) / DIRECTIONS
        steps = self.extent * np.stack([np.sin(angle), np.cos(angle)], axis=1)
        return max(self.hits(pairs, place + away * step)[0] for away in AWAY for step in steps)


def sample_of(case: Case, index: int) -> Sample | None:
    """Return some of a sensor's reports beside the others' tracks, None where there are none."""
    of, rows = case.reports.sensor, case.rows[index]
    paths = []
    for path in case.paths:
        others = int(np.count_nonzero(of[path.rows] != index))
        if others >= max(FEWEST_OF_OTHERS, OWN_SHARE * path.rows.size):
            paths.append(path)
    rows = rows[~np.isnan(case.position[rows, 0])]
    if not paths or rows.size == 0:
        return None
    rows = rows[:: -(-rows.size // MOST_REPORTS)]
    known = np.concatenate([path.place for path in paths[:MOST_TRACKS]])
    extent = max(float(np.linalg.norm(np.ptp(known, axis=0))), 1e-9)
    near = np.clip(NEAR_SIGMAS * case.plane_sigma(index), NEAREST * extent, FARTHEST * extent)
    return Sample(
        index,
        case.reports.time[rows],
        case.position[rows],
        case.platform[rows],
        paths[:MOST_TRACKS],
        float(near),
        extent,
    )


def best_shift(
    sample: Sample, pairs: tuple[IntArray, IntArray, FloatArray], place: FloatArray
) -> FloatArray:
    """Return by how much, east and north [m], to move reports so that most are near a track."""
    # ``pairs`` are reports and tracks alive at their times; ``place`` is where the reports are
    # taken to be [m].
    off = pairs[2] - place[pairs[0]]
    if off.shape[0] == 0:
        return np.zeros(2)
    low = off.min(axis=0)
    cell = np.floor((off - low) / sample.near).astype(np.int64)
    width = int(cell[:, 1].max()) + 3
    # Whatever lies about a corner is near in one of four cells; a square of them counts.
    key = (cell[:, 0] + 1) * width + cell[:, 1] + 1
    square = np.concatenate([key, key - 1, key - width, key - width - 1])
    found, count = np.unique(square, return_counts=True)
    corner = np.array(divmod(int(found[np.argmax(count)]), width), dtype=float)
    middle = low + corner * sample.near
    for _ in range(3):
        close = np.linalg.norm(off - middle, axis=1) <= 1.5 * sample.near
        middle = np.median(off[close], axis=0) if close.any() else middle
    return np.asarray(middle)


def best_clock(sample: Sample) -> float:
    """Return by how much a sensor's clock is ahead of the others' if it is [s]."""
    # Reports are compared with places where tracks were at any time: the times between vote. It is
    # 0 where nothing moves, so that nobody can tell.
    moved = [
        path
        for path in sample.paths
        if np.linalg.norm(np.ptp(path.place, axis=0)) > LEAST_MOVED * sample.near
    ]
    if not moved:
        return 0.0
    time = np.concatenate([path.time for path in moved])
    place = np.concatenate([path.place for path in moved])
    speed = float(np.median(np.concatenate([path.speed for path in moved])))
    some = slice(None, None, -(-time.size // MOST_STATES))
    report, state = _beside(sample.place, place[some], 1.5 * sample.near)
    if report.size == 0 or speed <= 0:
        return 0.0
    width = sample.near / speed
    steps = np.round((sample.time[report] - time[some][state]) / width)
    # Of each report, each moment counts once, however many states are near.
    votes = np.unique(np.stack([report, steps]), axis=1)[1]
    found, count = np.unique(np.concatenate([votes, votes + 1]), return_counts=True)
    around = (float(found[np.argmax(count)]) - 0.5) * width
    tried = around + width * np.linspace(-1.5, 1.5, 7)
    shares = [sample.hits(sample.there(later), sample.place)[0] for later in tried]
    best = np.flatnonzero(np.array(shares) >= 0.98 * max(shares))
    return float(tried[best].mean())


def _beside(one: FloatArray, other: FloatArray, radius: float) -> tuple[IntArray, IntArray]:
    """Return the pairs of rows of two tables of points that are this near."""
    # SciPy's trees take longer to import than all of this.
    low = np.minimum(one.min(axis=0), other.min(axis=0)) - 2 * radius
    cells = [np.floor((points - low) / radius).astype(np.int64) for points in (one, other)]
    width = int(max(cells[0][:, 1].max(), cells[1][:, 1].max())) + 2
    keys = [cell[:, 0] * width + cell[:, 1] for cell in cells]
    order = np.argsort(keys[1], kind="stable")
    ordered = keys[1][order]
    first, second = [], []
    for step in (-width, 0, width):
        # Three cells of a column follow one another.
        begin = np.searchsorted(ordered, keys[0] + step - 1, "left")
        count = np.searchsorted(ordered, keys[0] + step + 1, "right") - begin
        first.append(np.repeat(np.arange(len(one)), count))
        within = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)
        second.append(order[np.repeat(begin, count) + within])
    rows, others = np.concatenate(first), np.concatenate(second)
    is_near = np.linalg.norm(one[rows] - other[others], axis=1) <= radius
    return rows[is_near], others[is_near]
