"""Moments at which all objects seem to have jumped together: a stage, a camera, a map's origin."""

from collections.abc import Iterator

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.run.diagnostics.case import SURE_HITS, Case, Finding

__all__ = ["common_jumps"]

# So many of the tracks there, and at least so many, end at a moment and others begin beside them.
SHARE, LEAST = 0.5, 5
# Within so many times a sensor's noise jumps are the same.
ALIKE = 4.0
A_JUMP = 90.0


def common_jumps(case: Case) -> Iterator[Finding]:
    """Find the moment at which most tracks ended and as many began, all equally far aside."""
    for index, sensor in enumerate(case.sensors):
        if sensor.scans is False or not sensor.measurement.is_position:
            continue
        rows = case.rows[index]
        rows = rows[case.track[rows] >= 0]
        first, last = _ends_of(case, rows)
        times = np.unique(case.reports.time[case.rows[index]])
        if first.size < 2 * LEAST or times.size < 2 * SURE_HITS:
            continue
        found = _moment(case.reports.time[first], case.reports.time[last], times)
        if found is None:
            continue
        moment, ended, begun, there = found
        place = case.reports.measurement[:, :2]
        apart = (place[first[begun]][None] - place[last[ended]][:, None]).reshape(-1, 2)
        jump, support = _most_alike(apart, ALIKE * float(max(sensor.sigmas(2))))
        size = float(np.hypot(*jump))
        if support < max(LEAST, SHARE * there) or size < ALIKE * float(max(sensor.sigmas(2))):
            continue
        yield Finding(
            "jump", sensor.name,
            f"at {moment:.10g} s {ended.size} of {there} tracks end and {begun.size} begin, "
            f"{support} of them {size:.4g} m aside ({jump[0]:.4g}, {jump[1]:.4g}): all objects "
            "seem to have jumped at once, as when a stage, a camera or the origin of a map is "
            "moved; take that out of the positions from then on",
            A_JUMP, None, size,
        )  # fmt: skip


def _ends_of(case: Case, rows: IntArray) -> tuple[IntArray, IntArray]:
    """Return the rows of the first and the last report of each track of enough reports."""
    order = rows[np.lexsort((case.reports.time[rows], case.track[rows]))]
    cuts = np.flatnonzero(np.diff(case.track[order])) + 1
    parts = [part for part in np.split(order, cuts) if part.size >= SURE_HITS]
    ends = np.array([(part[0], part[-1]) for part in parts], dtype=np.int64).reshape(-1, 2)
    return ends[:, 0], ends[:, 1]


def _moment(
    begin: FloatArray, end: FloatArray, times: FloatArray
) -> tuple[float, IntArray, IntArray, int] | None:
    """Return when most tracks end and others begin, which, and how many there were before."""
    # A few scans about it may have lost an object, and a few at the recording's ends tell nothing.
    start, stop = np.searchsorted(times, begin), np.searchsorted(times, end)
    begun = np.bincount(start, minlength=times.size + 3)
    ended = np.bincount(stop, minlength=times.size + 3)
    inside = np.arange(3, times.size - 2)
    over = ended[inside - 1] + ended[inside - 2] + ended[inside - 3]
    anew = begun[inside] + begun[inside + 1] + begun[inside + 2]
    if inside.size == 0:
        return None
    best = int(inside[np.argmax(np.minimum(over, anew))])
    gone = np.flatnonzero((stop < best) & (stop >= best - 3))
    come = np.flatnonzero((start >= best) & (start < best + 3))
    there = int(np.count_nonzero((start < best - 3) & (stop >= best - 3)))
    if min(gone.size, come.size) < max(LEAST, SHARE * there):
        return None
    return float(times[best]), gone, come, there


def _most_alike(apart: FloatArray, width: float) -> tuple[FloatArray, int]:
    """Return the difference that most others are near, as their mean, and how many they are."""
    some = apart[:: max(1, apart.shape[0] // 4000)]
    near = np.array([np.sum(np.hypot(*(some - each).T) < width) for each in some])
    best = some[int(np.argmax(near))]
    alike = np.hypot(*(apart - best).T) < width
    return apart[alike].mean(axis=0), int(np.count_nonzero(alike))
