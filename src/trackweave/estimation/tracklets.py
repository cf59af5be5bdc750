"""Tracks of one sensor that need neither its noise nor its rates to be known."""

from typing import NamedTuple

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.estimation.trees import tree_of

__all__ = ["FEWEST_REPORTS", "SensorReports", "tracklets_of"]

FEWEST_REPORTS = 6
"""Shorter tracks are mostly chance, and tell nothing of their own noise."""
# A track that misses more than so many scans is over, and so soon after its last nothing comes.
LONGEST_GAP, SHORTEST_GAP = 3.6, 0.3
# Of so many reports near where a track leads one is its own.
NEIGHBOURS = 4
# At the greatest speed nothing turns faster than 3 degrees a second [1/s].
TURN = 0.05
# How far off a report may be [standard deviations], where its track's velocity is known or not.
FAR, NEAR = 6.0, 3.0
# A velocity that is known comes first, by so much of a gate.
UNKNOWN_VELOCITY = 0.5
# Nothing climbs faster [m/s], and heights are so exact [m].
CLIMB, HEIGHT_STEP = 30.0, 60.0


class SensorReports(NamedTuple):
    """The reports of one sensor on the plane."""

    time: FloatArray  # [s]
    place: FloatArray  # [m], shape (reports, 2)
    noise: FloatArray  # About how exact each place is [m]
    height: FloatArray  # [m]; NaN where not told
    scan: IntArray  # Number of the scan or turn of each
    period: float  # From scan to scan [s]


class _Open:
    """Tracks that may go on: rows of their last three reports, -1 for none, and their numbers."""

    def __init__(self) -> None:
        self.rows = np.empty((0, 3), dtype=np.int64)
        self.number = np.empty(0, dtype=np.int64)

    def keep(self, is_kept: np.ndarray) -> None:
        self.rows, self.number = self.rows[is_kept], self.number[is_kept]

    def begin(self, rows: IntArray, first: int) -> None:
        alone = np.stack([rows, np.full((2, rows.size), -1)[0], np.full(rows.size, -1)], axis=1)
        self.rows = np.concatenate([self.rows, alone])
        self.number = np.concatenate([self.number, first + np.arange(rows.size)])


def tracklets_of(reports: SensorReports, fastest: float) -> IntArray:
    """Return the track of each report of a sensor, -1 for none."""
    # From scan to scan a report goes on the track that leads nearest to it, as seen from both, in
    # units of how far off it could be: by the greatest speed where only one report is known, by a
    # turn and the noise where two are. ``fastest`` is the greatest speed [m/s].
    order = np.argsort(reports.scan, kind="stable")
    cuts = np.flatnonzero(np.diff(reports.scan[order])) + 1
    track = np.full(reports.time.size, -1, dtype=np.int64)
    tracks, begun = _Open(), 0
    for rows in np.split(order, cuts):
        if not rows.size:
            continue
        middle = reports.time[rows].mean()
        tracks.keep(middle - reports.time[tracks.rows[:, 0]] < LONGEST_GAP * reports.period)
        pairs = _pairs(reports, tracks, rows, fastest)
        which, row = pairs[:, 0], rows[pairs[:, 1]]
        track[tracks.rows[which, 0]] = track[row] = tracks.number[which]
        tracks.rows[which] = np.stack([row, *tracks.rows[which, :2].T], axis=1)
        rest = np.delete(rows, pairs[:, 1])
        tracks.begin(rest, begun)
        begun += rest.size
    return _long_ones(track)


def _pairs(reports: SensorReports, tracks: _Open, rows: IntArray, fastest: float) -> IntArray:
    """Return which open track goes on with which report of a scan, shape (pairs, 2)."""
    last, before, earlier = tracks.rows.T
    if not last.size:
        return np.empty((0, 2), dtype=np.int64)
    time, place = reports.time, reports.place
    back = np.where(earlier >= 0, earlier, before)
    is_known = back >= 0
    elapsed = np.where(is_known, time[last] - time[back], 1.0)
    velocity = np.where(is_known, 1.0 / elapsed, 0.0)[:, None] * (place[last] - place[back])
    # A beam comes back to nearly the same azimuth after whole turns.
    ahead = (time[rows].mean() - time[last]) / reports.period
    ahead = np.maximum(1.0, np.round(ahead)) * reports.period
    count = min(NEIGHBOURS, rows.size)
    near = tree_of(place[rows]).query(place[last] + velocity * ahead[:, None], k=count)[1]
    which = np.repeat(np.arange(last.size), count)
    found = near.reshape(-1)
    mine, yours = last[which], rows[found]
    gap = time[yours] - time[mine]
    off = np.linalg.norm(place[yours] - place[mine] - velocity[which] * gap[:, None], axis=1)
    spread = np.hypot(reports.noise[yours], reports.noise[mine])
    gate = np.where(
        is_known[which], TURN * fastest * gap**2 / 2 + FAR * spread, fastest * gap + NEAR * spread
    )
    may = (off < gate) & (gap > SHORTEST_GAP * reports.period)
    may &= ~(np.abs(reports.height[yours] - reports.height[mine]) > CLIMB * gap + HEIGHT_STEP)
    cost = off / gate + np.where(is_known[which], 0.0, UNKNOWN_VELOCITY)
    which, found, cost = which[may], found[may], cost[may]
    # The cheapest first, each track and report once.
    chosen: list[tuple[int, int]] = []
    used, taken = set[int](), set[int]()
    for place_in_order in np.argsort(cost, kind="stable").tolist():
        one, other = int(which[place_in_order]), int(found[place_in_order])
        if one not in used and other not in taken:
            used.add(one)
            taken.add(other)
            chosen.append((one, other))
    return np.array(chosen, dtype=np.int64).reshape(-1, 2)


def _long_ones(track: IntArray) -> IntArray:
    """Return tracks numbered from 0, without those of too few reports."""
    number, place, count = np.unique(track, return_inverse=True, return_counts=True)
    is_long = (count >= FEWEST_REPORTS) & (number >= 0)
    again = np.where(is_long, np.cumsum(is_long) - 1, -1)
    return np.asarray(again[place.reshape(-1)])
