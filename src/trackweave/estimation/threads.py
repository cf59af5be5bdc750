"""Reports threaded on the objects that they seem to be of, whatever the sensor's scans."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trackweave.arrays import FloatArray, IntArray
from trackweave.estimation.pair_ratios import ratio_of_pairs
from trackweave.estimation.trees import tree_of

__all__ = ["SHORTEST", "Threads", "once", "threads_of"]

# Reports are neighbours at some speed: from one that crosses all that is covered in the whole
# time, up by this factor, over so many steps.
FASTER, N_SPEEDS = 4.0, 6
NEIGHBOURS = 8
# A link is sure where so few unrelated reports are as near in space and time.
UNRELATED = 0.2
# The area of the reports is at least so many times as wide as it is long.
NARROWEST = 0.1
# So large a share of the reports at each end of an axis may be far from all others.
STRAY = 0.005
N_PASSES = 4
N_ROUNDS = 3
# Links are likely enough that are as likely as all but this share of those that there are, and so
# many times as many as by chance; then a shorter wait decides, but for this share of the usual.
ENOUGH, SURELY, SOONER = 0.2, 30.0, 0.7
# What is so nearly as likely as the likeliest may be the next as well.
NEARLY = 0.25
# The same position again within so long is one report heard twice [s].
TWICE = 2.0
SHORTEST = 1e-9
"""Shorter waits tell no speed [s]."""


@dataclass(frozen=True, slots=True, eq=False)
class Threads:
    """Threads of a sensor's reports, each of one object as far as can be seen."""

    rows: list[IntArray]  # Of each in order of time; the longest thread first
    n_reports: int  # How many were looked at, those heard twice counted once
    is_whole: bool = False  # Whether each is all of its object, as its reports say

    def lasting(self, hits: int) -> list[IntArray]:
        """Return the threads of at least so many reports."""
        return [rows for rows in self.rows if rows.size >= hits]


def threads_of(time: FloatArray, position: FloatArray) -> Threads:
    """Return reports threaded by what tells them from unrelated ones in space and time."""
    # A link is likely where there are many times as many pairs as far apart as chance makes, by
    # where they are and then by where those go that are linked already. That is told neither noise
    # nor speeds. Those that are likeliest for each other are linked, then those of the rest. A
    # link counts where few unrelated reports would lie between them, in the ball whose radius is
    # their distance and over the time between them, after I. Zaliapin, A. Gabrielov,
    # V. Keilis-Borok, H. Wong, "Clustering analysis of seismicity and aftershock identification",
    # Physical Review Letters 101, 2008.
    rows = once(time, position)
    time, position = time[rows], position[rows]
    extent = float(np.linalg.norm(np.ptp(position, axis=0))) if rows.size else 0.0
    span = float(np.ptp(time)) if rows.size else 0.0
    after = np.full(rows.size, -1, dtype=np.int64)
    if extent > 0 and span > SHORTEST:
        after = _linked(time, position, extent, span)
    return Threads(_chained(after, rows), rows.size)


def once(time: FloatArray, position: FloatArray) -> IntArray:
    """Return the rows in order of time, of those heard twice the first."""
    order = np.lexsort((time, *position.T))
    same = np.all(np.diff(position[order], axis=0) == 0, axis=1)
    same &= np.diff(time[order]) <= TWICE
    first = np.r_[True, ~same]
    rows = order[first[: order.size]]
    return np.asarray(rows[np.argsort(time[rows], kind="stable")])


def _linked(time: FloatArray, position: FloatArray, extent: float, span: float) -> IntArray:
    """Return the report that follows each one, -1 for none."""
    count, dim = position.shape
    pairs = before, behind = _pairs(time, position, extent / span)
    wait = time[behind] - time[before]
    unit = np.pi if dim == 2 else 4.0 / 3.0 * np.pi
    low, high = np.quantile(position, [STRAY, 1.0 - STRAY], axis=0)
    sides = high - low
    # Ships in line astern fill no area; who passes beside them would be unrelated.
    sides[:2] = np.maximum(sides[:2], NARROWEST * sides[:2].max())
    density = count / float(np.prod(np.maximum(sides, 1e-9))) / span
    after = np.full(count, -1, dtype=np.int64)
    velocity, likely, near = (
        np.zeros_like(position),
        np.zeros(wait.size),
        np.full(wait.size, np.inf),
    )
    for _ in range(N_ROUNDS):
        reports = time, position, velocity
        ratio, apart = ratio_of_pairs(reports, pairs, density)
        likely, near = np.maximum(likely, ratio), np.fmin(near, apart)
        sure = np.flatnonzero(density * wait * unit * near**dim < UNRELATED)
        after = _likeliest((before[sure], behind[sure]), wait[sure], likely[sure], after)
        # Then also by where those go that are linked already.
        velocity = _velocities(time, position, after)
    return after


def _likeliest(
    pairs: tuple[IntArray, IntArray], wait: FloatArray, likely: FloatArray, after: IntArray
) -> IntArray:
    """Return which report follows each one, of pairs of which each is so likely."""
    before, behind = pairs
    cost, soonest = 1.0 / likely, _soonest(pairs, wait, likely, after.size)
    for _ in range(N_ROUNDS):
        is_linked = after[before] == behind
        if is_linked.any():
            # Of what rests, the next report but one is as near as the next: among what is likely
            # enough the wait decides, beside that usual of the likeliest.
            linked = likely[is_linked]
            is_likeliest = linked >= np.median(linked)
            pause = min(float(np.median(wait[is_linked][is_likeliest])), soonest)
            enough = max(float(np.quantile(linked, ENOUGH)), SURELY)
            cost = (wait + SOONER * pause) / np.minimum(likely, enough)
        order = np.argsort(cost, kind="stable")
        after = _married(before[order], behind[order], after.size)
    return after


def _soonest(
    pairs: tuple[IntArray, IntArray], wait: FloatArray, likely: FloatArray, count: int
) -> float:
    """Return after how long the next report that may be of the same object usually comes [s]."""
    # Where chance makes next to no pairs at all, how many there are says little of which is the
    # next: every fourth report may seem a little likelier.
    before, best, first = pairs[0], np.zeros(count), np.full(count, np.inf)
    np.maximum.at(best, before, likely)
    fits = (likely >= NEARLY * best[before]) & (likely >= SURELY)
    np.minimum.at(first, before[fits], wait[fits])
    known = first[np.isfinite(first)]
    return float(np.median(known)) if known.size else np.inf


def _velocities(time: FloatArray, position: FloatArray, after: IntArray) -> FloatArray:
    """Return how fast what is linked to a report before it went there, NaN for unknown."""
    velocity = np.full_like(position, np.nan)
    linked = np.flatnonzero(after >= 0)
    behind = after[linked]
    wait = np.maximum(time[behind] - time[linked], SHORTEST)
    velocity[behind] = (position[behind] - position[linked]) / wait[:, None]
    return velocity


def _married(before: IntArray, behind: IntArray, count: int) -> IntArray:
    """Return which report follows each one, of pairs in the order of how near they are."""
    after, has_one = np.full(count, -1, dtype=np.int64), np.zeros(count, dtype=np.bool_)
    for _ in range(N_PASSES):
        left = (after[before] < 0) & ~has_one[behind]
        before, behind = before[left], behind[left]
        mutual = _is_first(before, count) & _is_first(behind, count)
        after[before[mutual]] = behind[mutual]
        has_one[behind[mutual]] = True
    return after


def _pairs(time: FloatArray, position: FloatArray, slowest: float) -> tuple[IntArray, IntArray]:
    """Return pairs of reports that are neighbours at some speed, the earlier one first."""
    count = time.size
    found = []
    for step in range(N_SPEEDS):
        places = np.column_stack([position, time * slowest * FASTER**step])
        some = min(NEIGHBOURS + 1, count)
        near = tree_of(places).query(places, k=some)[1].reshape(count, some)
        own = np.repeat(np.arange(count), some)
        found.append(own * count + near.ravel())
    key = _distinct(np.concatenate(found))
    first, second = key // count, key % count
    wait = time[second] - time[first]
    earlier = np.where(wait > 0, first, second)[wait != 0]
    later = np.where(wait > 0, second, first)[wait != 0]
    key = _distinct(earlier * count + later)
    return key // count, key % count


def _distinct(key: IntArray) -> IntArray:
    """Return each number once, ascending."""
    # Of a million, ``np.unique`` makes a table of hashes, which takes several times as long.
    key = np.sort(key)
    return key[np.r_[np.ones(min(key.size, 1), dtype=np.bool_), key[1:] != key[:-1]]]


def _is_first(number: IntArray, count: int) -> NDArray[np.bool_]:
    """Tell which entries are the first with their number."""
    first = np.full(count, number.size, dtype=np.int64)
    np.minimum.at(first, number, np.arange(number.size))
    return np.asarray(first[number] == np.arange(number.size))


def _chained(after: IntArray, rows: IntArray) -> list[IntArray]:
    """Return the rows of each thread, the longest first."""
    thread = np.arange(after.size)
    for number, following in enumerate(after.tolist()):
        if following >= 0:
            thread[following] = thread[number]
    order = np.argsort(thread, kind="stable")
    starts = np.flatnonzero(np.diff(thread[order])) + 1
    threads = np.split(rows[order], starts) if order.size else []
    return sorted(threads, key=lambda each: -each.size)
