"""Tuples of tracks that may be of one object, grown sensor by sensor. Nothing here checks."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from trackweave._loops import ascending
from trackweave.arrays import FloatArray, IntArray
from trackweave.fusion._pairs import Live, price_of
from trackweave.fusion._statistic import CHAIN, Form, Rings, Room, evaluate, make_room, threshold
from trackweave.jit import jit


class Terms(NamedTuple):
    """What tuples cost: the price of a join; for what is held, the threshold and a join's reward.

    ``bound`` is what no statistic of a tuple may exceed, however it still grows; ``breadth`` how
    many tuples of a size are kept per first track.
    """

    price: FloatArray
    held_quantile: FloatArray
    reward: float
    bound: float
    breadth: int


class Tuples(NamedTuple):
    """Tuples, one column per sensor with places in ``Live`` (-1 for none), and what they cost."""

    member: IntArray
    cost: FloatArray
    value: FloatArray
    limit: FloatArray
    is_allowed: NDArray[np.bool_]


@jit
def judge(
    rings: Rings, form: Form, terms: Terms, live: Live, member: IntArray, rows: IntArray,
    room: Room,
) -> tuple[float, float, float]:  # fmt: skip
    """Return a tuple's cost [nats], its statistic and its threshold; write its rings' rows.

    What is held, tracks that already share an object, is worth more together, and where a tuple
    is held as a whole it may be farther apart.
    """
    size, n_held, held = 0, 0, -1
    is_whole = True
    for column in range(member.shape[0]):
        rows[column] = -1
        place = member[column]
        if place >= 0:
            rows[column] = live.row[place]
            number = live.held[place]
            for before in range(column):
                if number >= 0 and member[before] >= 0 and live.held[member[before]] == number:
                    n_held += 1
                    break
            if size == 0:
                held = number
            is_whole = is_whole and number >= 0 and number == held
            size += 1
    if size < 2:
        return 0.0, 0.0, 0.0
    value, first, second, third = evaluate(rings, form, rows, room)
    quantile = terms.held_quantile if is_whole else form.quantile
    limit = threshold(quantile, first, second, third)
    price = price_of(terms.price, first, second, third, size - 1) + n_held * terms.reward
    return (value - price) / 2.0, value, limit


@jit
def judge_all(rings: Rings, form: Form, terms: Terms, live: Live, member: IntArray) -> Tuples:
    """Return given tuples with what they cost."""
    n_rows, n_sensors = member.shape
    cost, value, limit = np.empty(n_rows), np.empty(n_rows), np.empty(n_rows)
    room = make_room(n_sensors, live.mean.shape[1])
    rows = np.empty(n_sensors, dtype=np.int64)
    for row in range(n_rows):
        cost[row], value[row], limit[row] = judge(
            rings, form, terms, live, member[row], rows, room
        )
    return Tuples(member, cost, value, limit, value <= limit)


@jit
def _keep_best(
    member: IntArray, root: IntArray, cost: FloatArray, breadth: int, n_roots: int
) -> IntArray:
    """Return which tuples to keep: the cheapest of each first track and size.

    Of each size, because a large tuple with a wrong track may be cheaper than a right small one.
    """
    n, n_sensors = member.shape
    count = np.zeros((n_roots, n_sensors + 1), dtype=np.int64)
    kept = np.empty(n, dtype=np.int64)
    n_kept = 0
    for place in ascending(cost[:n]):
        size = 0
        for column in range(n_sensors):
            size += member[place, column] >= 0
        if count[root[place], size] < breadth:
            count[root[place], size] += 1
            kept[n_kept] = place
            n_kept += 1
    return np.sort(kept[:n_kept])


@jit
def grow(
    rings: Rings, form: Form, terms: Terms, live: Live, places: IntArray, near: NDArray[np.bool_]
) -> tuple[Tuples, int]:
    """Return the tuples of a component's tracks, and how many were left out.

    ``places`` are sorted by sensor; ``near[i, j]`` tells whether the i-th and the j-th of them
    are a pair.
    """
    n_tracks, n_sensors = places.shape[0], int(live.sensor.max()) + 1
    room = make_room(n_sensors, live.mean.shape[1])
    rows = np.empty(n_sensors, dtype=np.int64)
    member = np.full((256, n_sensors), -1, dtype=np.int64)
    root = np.zeros(256, dtype=np.int64)
    cost, value, limit = np.zeros(256), np.zeros(256), np.zeros(256)
    # Place of the members within the component, for ``near``.
    local = np.full(live.row.shape[0], -1, dtype=np.int64)
    for place in range(n_tracks):
        local[places[place]] = place
    n_tuples, n_dropped, begin = 0, 0, 0
    while begin < n_tracks:
        sensor = live.sensor[places[begin]]
        end = begin
        while end < n_tracks and live.sensor[places[end]] == sensor:
            end += 1
        n_before = n_tuples
        for old in range(n_before + 1):
            for place in range(begin, end):
                if n_tuples == root.shape[0]:
                    member = np.concatenate((member, np.full_like(member, -1)))
                    root = np.concatenate((root, np.zeros_like(root)))
                    cost = np.concatenate((cost, np.zeros_like(cost)))
                    value = np.concatenate((value, np.zeros_like(value)))
                    limit = np.concatenate((limit, np.zeros_like(limit)))
                if old == n_before:
                    # A tuple that begins with this track.
                    member[n_tuples] = -1
                    member[n_tuples, sensor] = places[place]
                    root[n_tuples], cost[n_tuples] = place, 0.0
                    value[n_tuples] = limit[n_tuples] = 0.0
                    n_tuples += 1
                    continue
                is_near = True
                for column in range(sensor - 1, -1, -1):
                    other = member[old, column]
                    if other >= 0:
                        is_near = near[local[other], place]
                        if not is_near or form.kind == CHAIN:
                            break
                if not is_near:
                    continue
                member[n_tuples] = member[old]
                member[n_tuples, sensor] = places[place]
                cost[n_tuples], value[n_tuples], limit[n_tuples] = judge(
                    rings, form, terms, live, member[n_tuples], rows, room
                )
                if value[n_tuples] <= terms.bound:
                    root[n_tuples] = root[old]
                    n_tuples += 1
        kept = _keep_best(member[:n_tuples], root, cost, terms.breadth, n_tracks)
        n_dropped += n_tuples - kept.shape[0]
        n_tuples = kept.shape[0]
        member[:n_tuples], root[:n_tuples] = member[kept], root[kept]
        cost[:n_tuples], value[:n_tuples], limit[:n_tuples] = cost[kept], value[kept], limit[kept]
        begin = end
    done = Tuples(
        member[:n_tuples].copy(), cost[:n_tuples].copy(), value[:n_tuples].copy(),
        limit[:n_tuples].copy(), value[:n_tuples] <= limit[:n_tuples],
    )  # fmt: skip
    return done, n_dropped
