"""Objects at rest that report themselves, two at a time. Nothing here checks or raises.

A rhythm is the interval at which an object reports [s], 0 for whenever it likes; how much it
varies, as a share of itself; how often a report is lost; and how many come a second of who keeps
none.
A span is when all reports begin and end, and how exact their times are [s].
"""

import math
from typing import TypeAlias

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.jit import jit

Rhythm: TypeAlias = FloatArray
Span: TypeAlias = tuple[float, float, float]
Reports: TypeAlias = tuple[FloatArray, FloatArray]
"""Times [s], ascending, and places [m], shape (reports, dimensions)."""
Objects: TypeAlias = tuple[FloatArray, FloatArray, FloatArray]
"""Where each lies [m], the variance of its noise [m²], its rhythm."""

INTERVAL, JITTER, LOST, RATE = range(4)
SIZE = 4
MOST_LOST, CHANGED, RANGE = 6, 0.03, 5.0
"""So many intervals a wait has at most; how often it is any other, whose logarithm is as likely
over so many powers of e."""
GONE = 7.0
"""What it costs at most that an object is not heard at the beginning or at the end [nats]."""
TOLD = 3.0
"""By so much a rhythm is likelier than none to be believed, as it has more to choose [nats]."""
QUANTILES, PARTS = 8, 3
"""Intervals are tried that are so many waits of all, or up to such a part of them."""
JITTERS = (0.003, 0.01, 0.03, 0.1, 0.3)
LOSSES = (0.05, 0.2, 0.4)
USUAL = 0.02, 0.2
"""How much varies and how often is lost what is tried first."""
NEAR = 0.2  # A wait is of an interval that is so near a whole part of it
FARTHEST = 60.0  # Squares of deviations beyond which nothing is left [nats]


@jit
def wait_density(wait: float, rhythm: Rhythm, grain: float) -> float:
    """Return how probable it is that the next report comes after so long [log of 1/s]."""
    wait = max(wait, grain)
    interval = rhythm[INTERVAL]
    if interval <= 0.0:
        return float(math.log(rhythm[RATE]) - rhythm[RATE] * wait)
    density = CHANGED / (RANGE * wait)
    nearest = int(wait / interval + 0.5)
    for count in range(max(nearest - 1, 1), min(nearest + 1, MOST_LOST) + 1):
        variance = count * (rhythm[JITTER] * interval) ** 2 + grain * grain
        far = (wait - count * interval) ** 2 / variance
        if far < FARTHEST:
            share = (1.0 - CHANGED) * (1.0 - rhythm[LOST]) * rhythm[LOST] ** (count - 1)
            density += share * math.exp(-0.5 * far) / math.sqrt(2.0 * math.pi * variance)
    return math.log(density)


@jit
def absence(silence: float, rhythm: Rhythm) -> float:
    """Return how probable it is that nothing is heard for so long at an end [log]."""
    if rhythm[INTERVAL] <= 0.0:
        return float(-min(rhythm[RATE] * silence, GONE))
    return float(max(silence / rhythm[INTERVAL] * math.log(rhythm[LOST]), -GONE))


@jit
def _likelihood(waits: FloatArray, rhythm: Rhythm, grain: float) -> float:
    total = 0.0
    for wait in waits:
        total += wait_density(wait, rhythm, grain)
    return total


@jit
def _settled(interval: float, waits: FloatArray) -> float:
    """Return an interval as the waits that are about whole numbers of it tell it."""
    for _ in range(2):
        waited, count = 0.0, 0.0
        for wait in waits:
            times = int(wait / interval + 0.5)
            if 1 <= times <= MOST_LOST and abs(wait - times * interval) < NEAR * interval:
                waited += wait
                count += times
        if count > 0.0:
            interval = waited / count
    return interval


@jit
def fit_rhythm(waits: FloatArray, grain: float, rhythm: Rhythm) -> float:
    """Write the likeliest rhythm of an object; return how probable its waits are [log]."""
    count, total = waits.shape[0], 0.0
    for wait in waits:
        total += max(wait, grain)
    rhythm[INTERVAL], rhythm[JITTER], rhythm[LOST] = 0.0, USUAL[0], 0.5
    rhythm[RATE] = count / total if count > 0 else 1.0
    free = _likelihood(waits, rhythm, grain)
    if count < 2:
        return free
    ordered, trial = np.sort(waits), rhythm.copy()
    interval, most = 0.0, -math.inf
    trial[JITTER], trial[LOST] = USUAL
    for quantile in range(QUANTILES):
        wait = ordered[int((quantile + 0.5) * count / QUANTILES)]
        for part in range(1, PARTS + 1):
            if wait / part > 2.0 * grain:
                trial[INTERVAL] = _settled(wait / part, waits)
                value = _likelihood(waits, trial, grain)
                if value > most:
                    interval, most = trial[INTERVAL], value
    if interval == 0.0:
        return free
    trial[INTERVAL], most = interval, free + TOLD
    for jitter in JITTERS:
        for lost in LOSSES:
            trial[JITTER], trial[LOST] = jitter, lost
            value = _likelihood(waits, trial, grain)
            if value > most:
                most = value
                rhythm[:] = trial
    return most - TOLD if rhythm[INTERVAL] > 0.0 else free


@jit
def _fits(place: FloatArray, row: int, objects: Objects, which: int) -> float:
    """Return how probable a report's place is of one of the objects [log]."""
    mean, variance, _ = objects
    dim, off = place.shape[1], 0.0
    for axis in range(dim):
        off += (place[row, axis] - mean[which, axis]) ** 2
    return float(-0.5 * (off / variance[which] + dim * math.log(2.0 * math.pi * variance[which])))


@jit
def part_two(reports: Reports, objects: Objects, span: Span, owner: IntArray) -> None:
    """Write which of two objects each report is of, the likeliest of all ways together.

    After each report all that matters of the past is when each object was heard last: one of them
    just now, the other with one of the reports before, so that Viterbi's way takes as many steps
    as there are pairs of reports. ``value[k, i]`` is of ways whose last report is object k's, and
    the other's is report i - 1, or none for i = 0.
    """
    (time, place), (begin, end, grain) = reports, span
    n, rhythm = time.shape[0], objects[2]
    value = np.full((2, n + 1), -math.inf)
    came_from = np.zeros((n, 2), dtype=np.int64)
    for k in range(2):
        value[k, 0] = _fits(place, 0, objects, k) + absence(time[0] - begin, rhythm[k])
    for row in range(1, n):
        turned = np.empty(2)
        for k in range(2):
            turned[k], came_from[row, k] = (
                value[1 - k, 0] + absence(time[row] - begin, rhythm[k]),
                0,
            )
            for last in range(1, row):
                wait = wait_density(time[row] - time[last - 1], rhythm[k], grain)
                if value[1 - k, last] + wait > turned[k]:
                    turned[k], came_from[row, k] = value[1 - k, last] + wait, last
        for k in range(2):
            here = _fits(place, row, objects, k)
            stay = wait_density(time[row] - time[row - 1], rhythm[k], grain) + here
            for last in range(row):
                value[k, last] += stay
            value[k, row] = turned[k] + here
    best, k, last = -math.inf, 0, 0
    for kind in range(2):
        for before in range(n):
            whole = value[kind, before] + absence(end - time[n - 1], rhythm[kind])
            if before > 0:
                whole += absence(end - time[before - 1], rhythm[1 - kind])
            if whole > best:
                best, k, last = whole, kind, before
    row = n
    while row > 0:
        owner[last:row] = k
        row, last, k = last, came_from[last, k] if last > 0 else 0, 1 - k


@jit
def weigh(
    reports: Reports, owner: IntArray, objects: Objects, span: Span, probability: FloatArray
) -> None:
    """Write how probable each report is of its owner, were all others as they are."""
    (time, place), (begin, end, grain) = reports, span
    rhythm = objects[2]
    n, count = time.shape[0], rhythm.shape[0]
    following = np.full((n + 1, count), n, dtype=np.int64)
    for row in range(n - 1, -1, -1):
        following[row] = following[row + 1]
        following[row, owner[row]] = row
    before = np.full(count, -1, dtype=np.int64)
    for row in range(n):
        own = 0.0
        gains = np.empty(count)
        for k in range(count):
            last, coming = before[k], following[row + 1, k]
            gains[k] = _fits(place, row, objects, k)
            if last >= 0:
                gains[k] += wait_density(time[row] - time[last], rhythm[k], grain)
            else:
                gains[k] += absence(time[row] - begin, rhythm[k])
            if coming < n:
                gains[k] += wait_density(time[coming] - time[row], rhythm[k], grain)
            else:
                gains[k] += absence(end - time[row], rhythm[k])
            if last >= 0 and coming < n:
                gains[k] -= wait_density(time[coming] - time[last], rhythm[k], grain)
            elif last >= 0:
                gains[k] -= absence(end - time[last], rhythm[k])
            elif coming < n:
                gains[k] -= absence(time[coming] - begin, rhythm[k])
            own = gains[k] if k == owner[row] else own
        total = 0.0
        for k in range(count):
            total += math.exp(min(gains[k] - own, 700.0))
        probability[row] = 1.0 / total
        before[owner[row]] = row
