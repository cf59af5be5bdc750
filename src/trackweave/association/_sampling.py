"""Drawing partitions of plots by their probability. Nothing here checks or raises.

A partition gives each plot to one set; a set of several plots is a tuple of the table, and a plot
alone is a false alarm, or an object that one sensor saw. A partition's probability is in
proportion to exp(−sum of costs). Each move draws anew what a choice made beforehand, without a
look at the partition, leaves open, from its exact conditional distribution (Gibbs), so that
partitions come as often as they are probable.
"""

import math
from typing import NamedTuple

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.jit import jit

MOST_SWAPPED = 8
"""Sensors whose plots two sets may swap in one move: two to that power are weighed."""

N_EMPTY, STEP = 0, 1


class TupleIndex(NamedTuple):
    """Tuples by their plots, and plots by their tuples.

    ``item`` holds each tuple's plots, one column per sensor, -1 for none, and ``log_weight`` minus
    its cost. ``alone`` is the log weight of each plot in a set of its own, ``sensor`` whose it is.
    A set's key is the exclusive or of its plots' ``mark``: random numbers of 62 bits, so that two
    of a million sets share a key once in millions of runs. ``row`` is the tuple of a ``key`` in a
    table with open addressing, -1 where there is none. From ``row_start`` on ``rows`` lists the
    tuples of each plot, and from ``near_start`` on ``near`` the plots that it shares some with.
    """

    item: IntArray
    log_weight: FloatArray
    alone: FloatArray
    sensor: IntArray
    mark: IntArray
    key: IntArray
    row: IntArray
    row_start: IntArray
    rows: IntArray
    near_start: IntArray
    near: IntArray


class Partition(NamedTuple):
    """The sets of plots. There are as many as plots; unused ones are listed in ``empty``.

    ``member`` holds each set's plot of each sensor, -1 for none, ``size`` how many it has, and
    ``home`` each plot's set. ``counter`` holds how many sets are empty, and a number of moves.
    """

    member: IntArray
    home: IntArray
    key: IntArray
    size: IntArray
    empty: IntArray
    counter: IntArray


class Scratch(NamedTuple):
    """Room for the choices of one move."""

    choice: IntArray
    log_weight: FloatArray
    seen_at: IntArray
    swapped: IntArray


@jit
def fill_keys(item: IntArray, mark: IntArray, key_out: IntArray, row_out: IntArray) -> None:
    """Enter the tuples' keys in the table, of a power of two entries, all rows of it -1."""
    last = key_out.shape[0] - 1
    for row in range(item.shape[0]):
        key = 0
        for column in range(item.shape[1]):
            if item[row, column] >= 0:
                key ^= mark[item[row, column]]
        place = key & last
        while row_out[place] >= 0:
            place = (place + 1) & last
        key_out[place], row_out[place] = key, row


@jit
def list_near(
    item: IntArray, row_start: IntArray, rows: IntArray, near_start_out: IntArray
) -> IntArray:
    """Return the plots that share a tuple with each plot, and write where each one's begin."""
    n_plots = row_start.shape[0] - 1
    seen_for = np.full(n_plots, -1, dtype=np.int64)
    near = np.empty(max(16, n_plots), dtype=np.int64)
    n_near = 0
    for plot in range(n_plots):
        seen_for[plot] = plot
        for entry in range(row_start[plot], row_start[plot + 1]):
            for column in range(item.shape[1]):
                other = item[rows[entry], column]
                if other < 0 or seen_for[other] == plot:
                    continue
                seen_for[other] = plot
                if n_near == near.shape[0]:
                    larger = np.empty(2 * n_near, dtype=np.int64)
                    larger[:n_near] = near
                    near = larger
                near[n_near] = other
                n_near += 1
        near_start_out[plot + 1] = n_near
    return near[:n_near].copy()


@jit
def find(keys: IntArray, rows: IntArray, key: int) -> int:
    """Return the tuple of a key; -1 if there is none."""
    last = keys.shape[0] - 1
    place = key & last
    while rows[place] >= 0:
        if keys[place] == key:
            return int(rows[place])
        place = (place + 1) & last
    return -1


@jit
def _weigh(
    keys: IntArray, rows: IntArray, log_weight: FloatArray, single: float, key: int, size: int
) -> float:
    """Return the log weight of a set; ``single`` is that of a plot alone."""
    if size == 0:
        return 0.0
    if size == 1:
        return single
    row = find(keys, rows, key)
    return -math.inf if row < 0 else float(log_weight[row])


@jit
def take_rows(index: TupleIndex, partition: Partition, chosen: IntArray) -> None:
    """Make sets of disjoint tuples, whose plots are alone so far."""
    for row in chosen:
        first = -1
        for plot in index.item[row]:
            if first < 0:
                first = plot
            elif plot >= 0:
                _move(index, partition, plot, partition.home[first])


@jit
def _move(index: TupleIndex, partition: Partition, plot: int, target: int) -> None:
    """Give a plot to a set; -1 for one of its own. The set that it leaves empty is listed."""
    source, sensor = partition.home[plot], index.sensor[plot]
    if target == source or (target < 0 and partition.size[source] == 1):
        return
    partition.member[source, sensor] = -1
    partition.key[source] ^= index.mark[plot]
    partition.size[source] -= 1
    if target < 0:
        partition.counter[N_EMPTY] -= 1
        target = partition.empty[partition.counter[N_EMPTY]]
    if partition.size[source] == 0:
        partition.empty[partition.counter[N_EMPTY]] = source
        partition.counter[N_EMPTY] += 1
    partition.member[target, sensor] = plot
    partition.key[target] ^= index.mark[plot]
    partition.size[target] += 1
    partition.home[plot] = target


@jit
def sweep(
    index: TupleIndex,
    partition: Partition,
    scratch: Scratch,
    renewal: float,
    rng: np.random.Generator,
) -> None:
    """Make as many moves of each kind as there are plots; renewals only this often."""
    n_plots = index.sensor.shape[0]
    for _ in range(n_plots):
        _place_plot(index, partition, scratch, int(rng.random() * n_plots), rng)
        _swap_between(index, partition, scratch, int(rng.random() * n_plots), rng)
        if rng.random() < renewal:
            _renew(index, partition, scratch, int(rng.random() * n_plots), rng)


@jit
def _draw(log_weight: FloatArray, n: int, rng: np.random.Generator) -> int:
    """Return one of the first n entries, as often as its weight says."""
    largest, total = -math.inf, 0.0
    for entry in range(n):
        largest = max(largest, log_weight[entry])
    for entry in range(n):
        total += math.exp(log_weight[entry] - largest)
    left = rng.random() * total
    for entry in range(n):
        left -= math.exp(log_weight[entry] - largest)
        if left < 0.0:
            return entry
    return n - 1


@jit
def _place_plot(
    index: TupleIndex, partition: Partition, scratch: Scratch, plot: int, rng: np.random.Generator
) -> None:
    """Draw anew which set a plot belongs to, all others staying where they are."""
    keys, rows, weights = index.key, index.row, index.log_weight
    key, size, mark = partition.key, partition.size, index.mark[plot]
    sensor, own = index.sensor[plot], partition.home[plot]
    rest_key, rest_size = key[own] ^ mark, size[own] - 1
    rest = _weigh(keys, rows, weights, 0.0, rest_key, rest_size)
    if rest_size == 1:
        rest = index.alone[_only(partition.member[own], plot)]
    if rest == -math.inf:
        return
    partition.counter[STEP] += 1
    step = partition.counter[STEP]
    scratch.choice[0], scratch.log_weight[0], n = -1, index.alone[plot], 1
    scratch.seen_at[own] = step
    if rest_size > 0:
        whole = _weigh(keys, rows, weights, 0.0, key[own], size[own])
        scratch.choice[1], scratch.log_weight[1], n = own, whole - rest, 2
    for entry in range(index.near_start[plot], index.near_start[plot + 1]):
        other = index.near[entry]
        home = partition.home[other]
        if scratch.seen_at[home] == step or partition.member[home, sensor] >= 0:
            continue
        scratch.seen_at[home] = step
        joined = _weigh(keys, rows, weights, 0.0, key[home] ^ mark, size[home] + 1)
        if joined > -math.inf:
            before = _weigh(keys, rows, weights, index.alone[other], key[home], size[home])
            scratch.choice[n], scratch.log_weight[n] = home, joined - before
            n += 1
    _move(index, partition, plot, scratch.choice[_draw(scratch.log_weight, n, rng)])


@jit
def _only(members: IntArray, but: int) -> int:
    """Return a plot of a set that is not the given one."""
    for plot in members:
        if plot >= 0 and plot != but:
            return int(plot)
    return -1


@jit
def _swap_between(
    index: TupleIndex, partition: Partition, scratch: Scratch, plot: int, rng: np.random.Generator
) -> None:
    """Draw anew how two sets share their plots, sensor by sensor.

    The other set is that of a plot near to one near to this. Both plots stay where they are:
    which sets they are in tells afterwards, too, which two it was.
    """
    n_near = index.near_start[plot + 1] - index.near_start[plot]
    if n_near == 0:
        return
    between = index.near[index.near_start[plot] + int(rng.random() * n_near)]
    n_near = index.near_start[between + 1] - index.near_start[between]
    other = index.near[index.near_start[between] + int(rng.random() * n_near)]
    first, second = partition.home[plot], partition.home[other]
    if first == second:
        return
    n_sensors, n_swapped = partition.member.shape[1], 0
    begin = int(rng.random() * n_sensors)
    for turn in range(n_sensors):
        sensor = (begin + turn) % n_sensors
        is_fixed = sensor == index.sensor[plot] or sensor == index.sensor[other]
        is_there = partition.member[first, sensor] >= 0 or partition.member[second, sensor] >= 0
        if is_there and not is_fixed and n_swapped < MOST_SWAPPED:
            scratch.swapped[n_swapped] = sensor
            n_swapped += 1
    for pattern in range(1 << n_swapped):
        scratch.log_weight[pattern] = _weigh_swap(
            index, partition, scratch.swapped[:n_swapped], pattern, plot, other
        )
    pattern = _draw(scratch.log_weight, 1 << n_swapped, rng)
    for place in range(n_swapped):
        if (pattern >> place) & 1:
            _swap(index, partition, scratch.swapped[place], first, second)


@jit
def _swap(index: TupleIndex, partition: Partition, sensor: int, first: int, second: int) -> None:
    """Let two sets swap their plots of a sensor; both keep others."""
    for source, target in ((first, second), (second, first)):
        plot = partition.member[source, sensor]
        if plot >= 0:
            partition.key[source] ^= index.mark[plot]
            partition.size[source] -= 1
            partition.key[target] ^= index.mark[plot]
            partition.size[target] += 1
            partition.home[plot] = target
    mine = partition.member[first, sensor]
    partition.member[first, sensor] = partition.member[second, sensor]
    partition.member[second, sensor] = mine


@jit
def _weigh_swap(
    index: TupleIndex,
    partition: Partition,
    swapped: IntArray,
    pattern: int,
    plot: int,
    other: int,
) -> float:
    """Return the log weight of two sets once the sensors of a pattern have swapped sides."""
    first, second = partition.home[plot], partition.home[other]
    key, size = partition.key[first], partition.size[first]
    both, total = key ^ partition.key[second], size + partition.size[second]
    for place in range(swapped.shape[0]):
        if (pattern >> place) & 1:
            mine = partition.member[first, swapped[place]]
            theirs = partition.member[second, swapped[place]]
            if mine >= 0:
                key ^= index.mark[mine]
                size -= 1
            if theirs >= 0:
                key ^= index.mark[theirs]
                size += 1
    keys, rows, weights = index.key, index.row, index.log_weight
    # A set of one plot has the one that stays.
    weight = _weigh(keys, rows, weights, index.alone[plot], key, size)
    if weight == -math.inf:
        return weight
    return weight + _weigh(keys, rows, weights, index.alone[other], both ^ key, total - size)


@jit
def _renew(
    index: TupleIndex, partition: Partition, scratch: Scratch, plot: int, rng: np.random.Generator
) -> None:
    """Dissolve a plot's set, then draw which tuple of plots that are alone it is in, if any."""
    own = partition.home[plot]
    scratch.choice[0], scratch.log_weight[0], n = -1, 0.0, 1
    for entry in range(index.row_start[plot], index.row_start[plot + 1]):
        row = index.rows[entry]
        weight, is_free = index.log_weight[row], True
        for member in index.item[row]:
            if member < 0:
                continue
            home = partition.home[member]
            if home != own and partition.size[home] > 1:
                is_free = False
                break
            # Against all of them being alone.
            weight -= index.alone[member]
        if is_free:
            scratch.choice[n], scratch.log_weight[n] = row, weight
            n += 1
    row = scratch.choice[_draw(scratch.log_weight, n, rng)]
    for sensor in range(partition.member.shape[1]):
        member = partition.member[own, sensor]
        if member >= 0 and member != plot:
            _move(index, partition, member, -1)
    if row >= 0:
        for member in index.item[row]:
            if member >= 0 and member != plot:
                _move(index, partition, member, own)


@jit
def record(
    index: TupleIndex,
    partition: Partition,
    alone_row: IntArray,
    rng: np.random.Generator,
    rows_out: IntArray,
) -> int:
    """Write the tuples of the partition; return how many. Some lone plots are objects."""
    n = 0
    for number in range(partition.size.shape[0]):
        row = -1
        if partition.size[number] > 1:
            row = find(index.key, index.row, partition.key[number])
        elif partition.size[number] == 1:
            plot = _only(partition.member[number], -1)
            # The lone plot's weight is that of a false alarm, 1, and that of an object.
            is_object = rng.random() < 1.0 - math.exp(-index.alone[plot])
            row = alone_row[plot] if is_object else -1
        if row >= 0:
            rows_out[n] = row
            n += 1
    return n
