"""Radars that look at one sky and see hardly an object together."""

from collections.abc import Iterator
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from trackweave.arrays import FloatArray, IntArray
from trackweave.run.diagnostics.case import SURE_HITS, Case, Finding

__all__ = ["unshared_objects"]

# Tracks of so many reports of one of them, where the other looks, tell of both; so few of these
# tracks have so many reports of the other as well.
FEWEST_TRACKS, LEAST_SHARED, BOTH = 5, 0.35, 3
# A radar sees as far as this share of its reports on tracks.
REACH = 0.95
WEIGHT = 60.0


def unshared_objects(case: Case) -> Iterator[Finding]:
    """Yield two radars of which each sees objects where the other looks, but hardly the same."""
    radars = [i for i in case.examined if _measures_ranges(case, i)]
    if len(radars) < 2 or not case.paths:
        return
    count = np.array([
        np.bincount(case.reports.sensor[path.rows], minlength=len(case.reports.sensors))
        for path in case.paths
    ])  # fmt: skip
    is_seen = {index: _in_sight(case, index) for index in radars}
    for one, other in combinations(radars, 2):
        sides = [
            (count[:, own] >= SURE_HITS) & is_seen[beside]
            for own, beside in ((one, other), (other, one))
        ]
        n_least = min(int(side.sum()) for side in sides)
        n_both = int(np.sum((sides[0] | sides[1]) & (count[:, [one, other]] >= BOTH).all(axis=1)))
        if n_least < FEWEST_TRACKS or n_both > LEAST_SHARED * n_least:
            continue
        names = [case.reports.sensors[index] for index in (one, other)]
        yield Finding(
            "unshared",
            names[1],
            f"sensors {names[0]} and {names[1]}: {sides[0].sum()} and {sides[1].sum()} tracks are "
            f"where both look, and {n_both} of them of both; each sees others, or what is told of "
            "one is wrong: where it stands, its north, its clock, its ranges, or heights "
            "(height_m)",
            weight=WEIGHT,
            seen=float(n_both),
        )
        return


def _measures_ranges(case: Case, index: int) -> bool:
    kind = case.reports.kind_of(index)
    return case.tells_place(index) and kind.has_range


def _in_sight(case: Case, index: int) -> NDArray[np.bool_]:
    """Tell of each track whether its middle is where and when a radar sees objects."""
    rows: IntArray = case.rows[index]
    rows = rows[(case.track[rows] >= 0) & np.isfinite(case.position[rows, 0])]
    if not rows.size:
        return np.zeros(len(case.paths), dtype=np.bool_)
    away: FloatArray = np.linalg.norm(case.position[rows] - case.platform[rows], axis=1)
    reach, stands = float(np.quantile(away, REACH)), np.median(case.platform[rows], axis=0)
    begin, end = case.reports.time[rows].min(), case.reports.time[rows].max()
    middles = np.array([path.place[path.time.size // 2] for path in case.paths])
    when = np.array([path.time[path.time.size // 2] for path in case.paths])
    near = np.linalg.norm(middles - stands, axis=1) <= reach
    return np.asarray(near & (when >= begin) & (when <= end))
