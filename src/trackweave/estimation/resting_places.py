"""Where objects that report themselves lie: places from which reports come for long."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackweave.arrays import FloatArray, IntArray

__all__ = ["densest", "grain_of", "places_of"]

WIDE = 3.0  # Reports of one place lie within so many deviations of others
LONG = 10.0  # What lies there still after so many usual waits is at rest
FEWEST, LEAST = 4, 8  # So many others are there then; of so many reports a place is looked at
PIECES, SLOWER, STRAIGHT, FAR, EVENLY = 5, 4, 0.7, 3.0, 0.4
"""Who is on the way goes straight from report to report for so many, or from the middle of some to
that of the next, of so many times more each time: such a share of the way leads anywhere, so many
deviations far; of several reports each time, by such a part of an even step each time."""
GRAINS = 60.0, 10.0, 1.0, 0.1, 0.01, 0.001
SHORT = 10  # Who moves before and after fewer reports, and is elsewhere then, moves meanwhile

SEEDS, DENSE, SEVERAL, SAMPLE = 4, 2.0, 3, 150
"""So many places at most are dense, where within so many squares of sigma so many lie, itself
among them, of a sample of so many."""


def densest(place: FloatArray, variance: float) -> list[FloatArray]:
    """Return where reports lie densest, apart from each other.

    Parameters
    ----------
    place
        Where they are [m], shape (reports, dimensions).
    variance
        Of the usual noise along an axis [m²].

    Returns
    -------
    At most four places, the densest first.
    """
    some = place[:: -(-place.shape[0] // SAMPLE)]
    off = ((some[:, None] - some) ** 2).sum(axis=2) / variance
    density = (off < DENSE).sum(axis=1)
    seeds, far = [], np.full(some.shape[0], np.inf)
    for _ in range(SEEDS):
        left = np.where(far > DENSE, density, 0)
        chosen = int(left.argmax())
        if left[chosen] < SEVERAL:
            break
        seeds.append(some[chosen])
        far = np.minimum(far, off[chosen])
    return seeds


def grain_of(time: FloatArray) -> float:
    """Return how far off times may be for having been rounded [s].

    Parameters
    ----------
    time
        Of reports [s].

    Returns
    -------
    Half the step that all are multiples of, from a minute to a millisecond.
    """
    for grain in GRAINS:
        off = np.abs(time / grain - np.round(time / grain))
        if off.max() < 1e-3:
            return grain / 2.0
    return GRAINS[-1]


def places_of(
    time: FloatArray, place: FloatArray, track: IntArray, sigma: float
) -> list[IntArray]:
    """Return the reports of each place where objects lie, by time.

    Parameters
    ----------
    time
        When, ascending [s], shape (reports,).
    place
        Where [m], shape (reports, dimensions).
    track
        Whose each report was thought to be, -1 for nobody's.
    sigma
        Usual standard deviation of a position along an axis [m].

    Returns
    -------
    Row numbers, for each place.
    """
    waits = _waits(time, track)
    if waits.size == 0:
        return []
    long = LONG * float(np.median(waits))
    rows = np.flatnonzero(~_on_the_way(place, track, sigma))
    cell = np.floor(place[rows] / (WIDE * sigma)).astype(np.int64)
    cells, number, count = np.unique(cell, axis=0, return_inverse=True, return_counts=True)
    number = number.reshape(-1)
    by_cell = np.split(np.argsort(number, kind="stable"), np.cumsum(count)[:-1])
    beside = _beside(cells)
    still = np.zeros(rows.size, dtype=np.bool_)
    for each in np.flatnonzero(beside @ count > FEWEST).tolist():
        own, others = by_cell[each], beside.indices[beside.indptr[each] : beside.indptr[each + 1]]
        near = np.sort(time[rows[np.concatenate([by_cell[other] for other in others])]])
        soon = np.searchsorted(near, time[rows[own]] + long, "right")
        soon -= np.searchsorted(near, time[rows[own]] - long, "left")
        still[own] = near.size - soon >= FEWEST
    from scipy.sparse.csgraph import connected_components

    used = np.unique(number[still])
    region = np.full(len(cells), -1)
    region[used] = connected_components(beside[used][:, used], directed=False)[1]
    at_rest = np.flatnonzero(still)
    of = region[number[at_rest]]
    parts = [rows[at_rest[of == each]] for each in np.unique(of)]
    return [part for part in parts if part.size >= LEAST]


def _waits(time: FloatArray, track: IntArray) -> FloatArray:
    """Return how long each track waited for each of its reports [s]."""
    order = np.lexsort((time, track))
    is_own = (np.diff(track[order]) == 0) & (track[order][1:] >= 0)
    waits: FloatArray = np.diff(time[order])[is_own]
    return waits[waits > 0.0]


def _on_the_way(place: FloatArray, track: IntArray, sigma: float) -> NDArray[np.bool_]:
    """Tell which reports are of tracks that go straight on there, fast or slowly."""
    moves = np.zeros(track.size, dtype=np.bool_)
    for number in np.unique(track[track >= 0]).tolist():
        rows, together = np.flatnonzero(track == number), 1
        while rows.size >= PIECES * together:
            piece = np.minimum(np.arange(rows.size) // together, rows.size // together - 1)
            total = np.stack([np.bincount(piece, axis) for axis in place[rows].T], axis=1)
            mean: FloatArray = total / np.bincount(piece)[:, np.newaxis]
            way = np.r_[0.0, np.cumsum(np.linalg.norm(np.diff(mean, axis=0), axis=1))]
            first = np.clip(np.arange(len(mean)) - PIECES // 2, 0, len(mean) - PIECES)
            last = first + PIECES - 1
            led = np.linalg.norm(mean[last] - mean[first], axis=1)
            is_straight = (led > STRAIGHT * (way[last] - way[first])) & (led > FAR * sigma)
            if together > 1:
                is_straight &= _go_on(mean, first, last)
            moves[rows[is_straight[piece]]] = True
            together *= SLOWER
        on_way = np.flatnonzero(moves[rows])
        led = np.linalg.norm(np.diff(place[rows[on_way]], axis=0), axis=1)
        for gap in np.flatnonzero((np.diff(on_way) <= SHORT) & (led > FAR * sigma)).tolist():
            moves[rows[on_way[gap] : on_way[gap + 1]]] = True
    return moves


def _go_on(mean: FloatArray, first: IntArray, last: IntArray) -> NDArray[np.bool_]:
    """Tell which ways lead on with each step; of several objects a middle changes by leaps."""
    led = mean[last] - mean[first]
    squared = np.maximum(np.sum(led**2, axis=1), 1e-300)
    steps = np.stack([
        np.sum((mean[first + k + 1] - mean[first + k]) * led, axis=1) / squared
        for k in range(PIECES - 1)
    ])  # fmt: skip
    goes_on: NDArray[np.bool_] = steps.min(axis=0) > EVENLY / (PIECES - 1)
    return goes_on


def _beside(cells: IntArray) -> Any:
    """Return a sparse matrix of which cells touch, each itself among them."""
    from scipy.sparse import coo_matrix, eye
    from scipy.spatial import cKDTree

    one, other = cKDTree(cells).query_pairs(1.5, p=np.inf, output_type="ndarray").T
    touching = coo_matrix((np.ones(one.size, dtype=np.int64), (one, other)), (len(cells),) * 2)
    return (touching + touching.T + eye(len(cells), dtype=np.int64)).tocsr()
