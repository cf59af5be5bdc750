"""Pairs of tracks that may be of one object, and what hangs together by them.

Nothing here checks or raises.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from trackweave._loops import ascending
from trackweave.arrays import FloatArray, IntArray
from trackweave.association._clusters import find
from trackweave.fusion._statistic import Form, Rings, evaluate, make_room, threshold
from trackweave.jit import jit


class Live(NamedTuple):
    """The live tracks: their rows in the rings, sensors, objects (-1 for none) and states now."""

    row: IntArray
    sensor: IntArray
    held: IntArray
    mean: FloatArray
    spread: FloatArray


class Pairs(NamedTuple):
    """Pairs of places in ``Live``: their statistic, and by how much it stays below its price."""

    first: IntArray
    second: IntArray
    value: FloatArray
    gain: FloatArray


@jit
def sweep(live: Live, reach: FloatArray, most: float) -> tuple[IntArray, IntArray]:
    """Return the pairs of tracks of two sensors that are near along each axis of their states.

    ``reach`` is how far each is felt along the first axis: two tracks whose intervals do not
    overlap are too far apart. ``most`` bounds the squared distance along each axis.
    """
    n_tracks, n = live.mean.shape
    low = live.mean[:, 0] - reach
    order = ascending(low)
    first, second = np.empty(1024, dtype=np.int64), np.empty(1024, dtype=np.int64)
    n_pairs = 0
    for turn in range(n_tracks):
        a = order[turn]
        high = live.mean[a, 0] + reach[a]
        for later in range(turn + 1, n_tracks):
            b = order[later]
            if low[b] > high:
                break
            if live.sensor[a] == live.sensor[b]:
                continue
            is_near = True
            for axis in range(n - 1, -1, -1):
                apart = live.mean[a, axis] - live.mean[b, axis]
                if apart * apart > most * (
                    live.spread[a, axis, axis] + live.spread[b, axis, axis]
                ):
                    is_near = False
                    break
            if not is_near:
                continue
            if n_pairs == first.shape[0]:
                first = np.concatenate((first, np.empty_like(first)))
                second = np.concatenate((second, np.empty_like(second)))
            first[n_pairs], second[n_pairs] = min(a, b), max(a, b)
            n_pairs += 1
    return first[:n_pairs].copy(), second[:n_pairs].copy()


@jit
def price_of(
    quantile: FloatArray, first: float, second: float, third: float, n_joins: int
) -> float:
    """Return what so many joins are worth for a statistic of these moments.

    With the moments that its threshold has: otherwise correlated errors, which make a statistic
    vary more, would pay for leaving out a member of what passes its test as a whole.
    """
    if n_joins <= 0 or first <= 0.0:
        return 0.0
    return n_joins * threshold(quantile, first / n_joins, second / n_joins, third / n_joins)


@jit
def weigh_pairs(
    rings: Rings, form: Form, price: FloatArray, live: Live, first: IntArray, second: IntArray,
    bound: float,
) -> Pairs:  # fmt: skip
    """Return the pairs that were compared and whose statistic is within the bound."""
    room = make_room(2, live.mean.shape[1])
    members = np.empty(2, dtype=np.int64)
    value, gain = np.empty(first.shape[0]), np.empty(first.shape[0])
    keep = np.zeros(first.shape[0], dtype=np.bool_)
    for pair in range(first.shape[0]):
        a, b = first[pair], second[pair]
        if live.sensor[a] > live.sensor[b]:
            a, b = b, a
        members[0], members[1] = live.row[a], live.row[b]
        value[pair], mean, square, cube = evaluate(rings, form, members, room)
        gain[pair] = price_of(price, mean, square, cube, 1) - value[pair]
        keep[pair] = mean > 0.0 and value[pair] <= bound
    return Pairs(first[keep], second[keep], value[keep], gain[keep])


@jit
def thin(live: Live, pairs: Pairs, n_sensors: int, margin: float) -> NDArray[np.bool_]:
    """Tell which pairs are of use: those that one of the two can hardly better.

    A pair goes where both tracks have another partner of that sensor that is better by more than
    the margin. What is held stays.
    """
    n_tracks = live.row.shape[0]
    best = np.full((n_tracks, n_sensors), -np.inf)
    for pair in range(pairs.first.shape[0]):
        a, b = pairs.first[pair], pairs.second[pair]
        best[a, live.sensor[b]] = max(best[a, live.sensor[b]], pairs.gain[pair])
        best[b, live.sensor[a]] = max(best[b, live.sensor[a]], pairs.gain[pair])
    keep = np.empty(pairs.first.shape[0], dtype=np.bool_)
    for pair in range(pairs.first.shape[0]):
        a, b = pairs.first[pair], pairs.second[pair]
        worst = pairs.gain[pair] + margin
        is_held = live.held[a] >= 0 and live.held[a] == live.held[b]
        keep[pair] = is_held or not (
            worst < best[a, live.sensor[b]] and worst < best[b, live.sensor[a]]
        )
    return keep


@jit
def label_components(n_tracks: int, first: IntArray, second: IntArray) -> IntArray:
    """Return each track's component, numbered by their first tracks."""
    leader = np.arange(n_tracks)
    for pair in range(first.shape[0]):
        a, b = find(leader, first[pair]), find(leader, second[pair])
        if a != b:
            leader[max(a, b)] = min(a, b)
    label = np.empty(n_tracks, dtype=np.int64)
    n_labels = 0
    for track in range(n_tracks):
        top = find(leader, track)
        if top == track:
            label[track] = n_labels
            n_labels += 1
        else:
            label[track] = label[top]
    return label
