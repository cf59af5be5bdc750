"""Nodes from one room to another. Nothing here checks or raises."""

import numpy as np

from trackweave.arrays import IntArray
from trackweave.association._nodes import Nodes
from trackweave.jit import jit


@jit
def copy_nodes(source: Nodes, rows: IntArray, target: Nodes, first: int) -> None:
    """Write some nodes to a room from a place on; one room may be both if none moves ahead.

    Parents and families are copied as they are.
    """
    modes, size = source.mean.shape[1:]
    for place in range(rows.shape[0]):
        row, to = rows[place], first + place
        target.parent[to] = source.parent[row]
        target.report[to] = source.report[row]
        target.family[to] = source.family[row]
        target.hits[to] = source.hits[row]
        target.chosen[to] = source.chosen[row]
        target.identity[to] = source.identity[row]
        target.other[to] = source.other[row]
        target.sensor[to] = source.sensor[row]
        target.is_line[to] = source.is_line[row]
        target.cost[to] = source.cost[row]
        target.tail[to] = source.tail[row]
        target.hidden[to] = source.hidden[row]
        target.misses[to] = source.misses[row]
        target.counted[to] = source.counted[row]
        target.chances[to] = source.chances[row]
        target.price[to] = source.price[row]
        target.belief[to] = source.belief[row]
        target.time[to] = source.time[row]
        target.wild[to] = source.wild[row]
        for column in range(source.rhythm.shape[1]):
            target.rhythm[to, column] = source.rhythm[row, column]
        for column in range(source.level.shape[1]):
            target.level[to, column] = source.level[row, column]
        for column in range(source.unseen.shape[1]):
            target.unseen[to, column] = source.unseen[row, column]
        for mode in range(modes):
            target.weight[to, mode] = source.weight[row, mode]
            for axis in range(size):
                target.mean[to, mode, axis] = source.mean[row, mode, axis]
                for other in range(size):
                    target.covariance[to, mode, axis, other] = source.covariance[
                        row, mode, axis, other
                    ]


@jit
def held_slots(report: IntArray, n_nodes: int) -> tuple[IntArray, IntArray]:
    """Return the slots that nodes have, ascending, and each node's place among them."""
    first, last = np.iinfo(np.int64).max, -1
    for node in range(n_nodes):
        if report[node] >= 0:
            first, last = min(first, report[node]), max(last, report[node])
    place = np.full(n_nodes, -1, dtype=np.int64)
    if last < 0:
        return np.empty(0, dtype=np.int64), place
    is_held = np.zeros(last - first + 1, dtype=np.bool_)
    number = np.empty(last - first + 1, dtype=np.int64)
    for node in range(n_nodes):
        if report[node] >= 0:
            is_held[report[node] - first] = True
    # Few are: more of a window's reports are of others than of those a scan concerns.
    slots = np.flatnonzero(is_held)
    for rank in range(slots.shape[0]):
        number[slots[rank]] = rank
        slots[rank] += first
    for node in range(n_nodes):
        if report[node] >= 0:
            place[node] = number[report[node] - first]
    return slots, place


@jit
def paths_up(parent: IntArray, leaf: IntArray) -> IntArray:
    """Return the nodes of sequences, each one's last first: (longest, sequences), -1 below."""
    longest = 1
    for column in range(leaf.shape[0]):
        length, node = 0, leaf[column]
        while node >= 0:
            length, node = length + 1, parent[node]
        longest = max(longest, length)
    path = np.full((longest, leaf.shape[0]), -1, dtype=np.int64)
    for column in range(leaf.shape[0]):
        row, node = 0, leaf[column]
        while node >= 0:
            path[row, column] = node
            row, node = row + 1, parent[node]
    return path
