"""Prefix sharing among tuples. Nothing here checks or raises."""

import math
from typing import NamedTuple

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.jit import jit


class Trie(NamedTuple):
    """Nodes for tuples and their prefixes, parents first; see ``AssignmentProblem``."""

    parent: IntArray
    item: IntArray
    cost: FloatArray
    total: FloatArray
    row: IntArray


@jit
def build_trie(items: IntArray, cost: FloatArray, order: IntArray) -> Trie:
    """Return the nodes of the tuples with these items (-1 for none), taken in sorted order.

    A prefix that is no tuple itself may not end; while it grows it costs as little as the
    cheapest tuple below it, or nothing. Of equal tuples the cheapest counts, of these the first.
    """
    n_lists = items.shape[1]
    n_nodes = 0
    for turn in range(order.shape[0]):
        first = _first_difference(items, order, turn)
        for column in range(first, n_lists):
            n_nodes += items[order[turn], column] >= 0
    parent, item = np.empty(n_nodes, dtype=np.int64), np.empty(n_nodes, dtype=np.int64)
    total, row = np.full(n_nodes, math.inf), np.full(n_nodes, -1, dtype=np.int64)
    # The node that stands for the columns so far, one entry for each column of the last tuple.
    above = np.full(n_lists + 1, -1, dtype=np.int64)
    fill = 0
    for turn in range(order.shape[0]):
        current = order[turn]
        for column in range(_first_difference(items, order, turn), n_lists):
            above[column + 1] = above[column]
            if items[current, column] >= 0:
                parent[fill], item[fill] = above[column], items[current, column]
                above[column + 1] = fill
                fill += 1
        last = above[n_lists]
        if cost[current] < total[last]:
            total[last], row[last] = cost[current], current
    growing = np.minimum(total, 0.0)
    for node in range(n_nodes - 1, -1, -1):
        if parent[node] >= 0:
            growing[parent[node]] = min(growing[parent[node]], growing[node])
    return Trie(parent, item, growing, total, row)


@jit
def _first_difference(items: IntArray, order: IntArray, turn: int) -> int:
    """Return the first column in which a tuple differs from the one before it."""
    if turn == 0:
        return 0
    for column in range(items.shape[1]):
        if items[order[turn], column] != items[order[turn - 1], column]:
            return column
    return int(items.shape[1])


@jit
def cost_shares(
    items: IntArray, cost: FloatArray, least: FloatArray, greatest: FloatArray
) -> None:
    """Lower ``least`` and raise ``greatest`` of each item to its share of its tuples' costs."""
    for row in range(items.shape[0]):
        size = 0
        for column in range(items.shape[1]):
            size += items[row, column] >= 0
        for column in range(items.shape[1]):
            if items[row, column] >= 0:
                share = cost[row] / size
                least[items[row, column]] = min(least[items[row, column]], share)
                greatest[items[row, column]] = max(greatest[items[row, column]], share)
