"""Single reports far beside the way of an object of which it is known which reports are its own.

Without such a report its neighbours lie on their way as all others do: that tells it from a turn,
a start or a stop, whose neighbours lie beside their own way too.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from trackweave.arrays import FloatArray, IntArray
from trackweave.chi_squared import quantile_of

__all__ = ["Wild", "there_and_back"]

# A report is wild so many times as far off as the middle one is; without it its neighbours are off
# by less than such a part of that.
FAR, BACK = 8.0, 0.35
# So many, and such a share of all, are a tail; fewer are what chance and names do.
FEWEST, LEAST_SHARE = 8, 0.005
N_ROUNDS = 3
# It is no less than this part as far off as those beside it.
PEAK = 0.75
# Of so many before and behind, so many tell where it should be.
ABOUT, LEAST_ABOUT = 4, 4
MOST_SHARE, MOST_SCALE = 0.5, 50.0


class Wild(NamedTuple):
    """Which reports are far off, and what tail of the noise they are; none where they are few."""

    is_wild: NDArray[np.bool_]
    tail: tuple[float, float] | None


def there_and_back(time: FloatArray, position: FloatArray, threads: list[IntArray]) -> Wild:
    """Return which reports on threads are far beside the way, and back with the next."""
    nothing = Wild(np.zeros(time.size, dtype=np.bool_), None)
    is_wild, usual = nothing.is_wild.copy(), 0.0
    # What wild reports and their neighbours seem to be off is no noise: without them it is less.
    for _ in range(N_ROUNDS):
        own = [rows[~is_wild[rows]] for rows in threads]
        off = [_off(time[rows], position[rows]) for rows in own]
        usual = float(np.median(np.concatenate([[0.0], *off])))
        if not usual > 0.0:
            # Such as of badges, each of which is in a room: there is no noise to be beside.
            return nothing
        for rows in own:
            is_wild[_wild_of(time, position, rows, usual)] = True
    count, n_all = int(is_wild.sum()), sum(rows.size for rows in threads)
    if count < max(FEWEST, LEAST_SHARE * n_all):
        return nothing
    # How far they are off tells how wide their noise is, beside that of others.
    dim = position.shape[1]
    square = [_off(time[rows], position[rows])[is_wild[rows[1:-1]]] ** 2 / dim for rows in threads]
    sigma = usual / np.sqrt(quantile_of(dim, 0.5))
    wide = float(np.sqrt(np.mean(np.concatenate(square)))) / sigma
    share = min(count / n_all, MOST_SHARE)
    return Wild(is_wild, (share, float(np.clip(wide, 1.0, MOST_SCALE))))


def _off(time: FloatArray, position: FloatArray) -> FloatArray:
    """Return how far each report but the ends is off the line between its neighbours [m]."""
    # In units in which noise is as far off whatever the neighbours' times.
    if time.size < 3:
        return np.empty(0)
    span = np.maximum(time[2:] - time[:-2], 1e-9)
    share = ((time[1:-1] - time[:-2]) / span)[:, None]
    way = position[1:-1] - (1.0 - share) * position[:-2] - share * position[2:]
    norm = np.sqrt(1.0 + share**2 + (1.0 - share) ** 2)
    return np.asarray(np.linalg.norm(way / norm, axis=1))


def _wild_of(time: FloatArray, position: FloatArray, rows: IntArray, usual: float) -> IntArray:
    """Return the wild reports of a thread."""
    wild, off = [], np.pad(_off(time[rows], position[rows]), 1)
    # A wild one moves its neighbours off as well, by about half as much.
    beside = np.maximum(np.roll(off, 1), np.roll(off, -1))
    is_far = (off >= FAR * usual) & (off >= PEAK * beside)
    for place in np.flatnonzero(is_far).tolist():
        begin = max(place - ABOUT, 0)
        end = min(place + ABOUT + 1, rows.size)
        rest = np.arange(begin, end)[~is_far[begin:end]]
        before, after = rest[rest < place], rest[rest > place]
        if not before.size or not after.size or rest.size < LEAST_ABOUT:
            continue
        three = rows[[before[-1], place, after[0]]]
        (away,) = _off(time[three], position[three])
        if away < FAR * usual:
            continue
        left = _off(time[rows[rest]], position[rows[rest]])
        if left.max() < BACK * away:
            wild.append(int(rows[place]))
    return np.array(wild, dtype=np.int64)
