"""Which sequences stand together in a fractional answer. Nothing here checks or raises."""

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.jit import jit
from trackweave.solvers._kernels import Component

FRACTION = 1e-6
"""Less of a sequence than this is none."""


@jit
def columns_of(component: Component) -> tuple[IntArray, IntArray, IntArray]:
    """Return the nodes that may end, and each one's items in ascending order, row by row."""
    n_columns = size = 0
    for node in range(component.parent.shape[0]):
        if component.total[node] < np.inf:
            n_columns += 1
            climb = node
            while climb >= 0:
                size += 1
                climb = component.parent[climb]
    node_of = np.empty(n_columns, dtype=np.int64)
    start = np.zeros(n_columns + 1, dtype=np.int64)
    items = np.empty(size, dtype=np.int64)
    column = 0
    for node in range(component.parent.shape[0]):
        if component.total[node] < np.inf:
            node_of[column] = node
            fill = start[column]
            climb = node
            while climb >= 0:
                items[fill] = component.item[climb]
                fill += 1
                climb = component.parent[climb]
            items[start[column] : fill].sort()
            start[column + 1] = fill
            column += 1
    return node_of, start, items


@jit
def pair_weights(
    start: IntArray, items: IntArray, column: IntArray, value: FloatArray, n_items: int
) -> FloatArray:
    """Return how much of a fractional answer covers each two items in one sequence."""
    weight = np.zeros((n_items, n_items))
    for entry in range(column.shape[0]):
        first, last = start[column[entry]], start[column[entry] + 1]
        for one in range(first, last):
            for other in range(first, last):
                if one != other:
                    weight[items[one], items[other]] += value[entry]
    return weight


@jit
def violated_triples(
    start: IntArray,
    items: IntArray,
    column: IntArray,
    value: FloatArray,
    weight: FloatArray,
    least: float,
) -> tuple[IntArray, FloatArray]:
    """Return three items each, of which sequences with two or more are taken more than once.

    Any two such sequences share an item. Also returns by how much, at least ``least``.
    """
    n_items = weight.shape[0]
    neighbour_start = np.zeros(n_items + 1, dtype=np.int64)
    for item in range(n_items):
        neighbour_start[item + 1] = neighbour_start[item] + np.sum(weight[item] > FRACTION)
    neighbour = np.empty(neighbour_start[n_items], dtype=np.int64)
    for item in range(n_items):
        neighbour[neighbour_start[item] : neighbour_start[item + 1]] = np.flatnonzero(
            weight[item] > FRACTION
        )
    triple = np.empty((1024, 3), dtype=np.int64)
    excess = np.empty(1024)
    found = 0
    for a in range(n_items):
        for one in range(neighbour_start[a], neighbour_start[a + 1]):
            b = neighbour[one]
            if b <= a:
                continue
            for other in range(one + 1, neighbour_start[a + 1]):
                c = neighbour[other]
                total = weight[a, b] + weight[a, c] + weight[b, c] - 1.0
                if total <= least or weight[b, c] <= FRACTION or found == 1024:
                    continue
                total -= 2.0 * _with_all(start, items, column, value, a, b, c)
                if total > least:
                    triple[found, 0], triple[found, 1], triple[found, 2] = a, b, c
                    excess[found] = total
                    found += 1
    return triple[:found], excess[:found]


@jit
def _with_all(
    start: IntArray, items: IntArray, column: IntArray, value: FloatArray, a: int, b: int, c: int
) -> float:
    """Return how much of the sequences with all three items is taken."""
    total = 0.0
    for entry in range(column.shape[0]):
        hits = 0
        for place in range(start[column[entry]], start[column[entry] + 1]):
            item = items[place]
            hits += item in (a, b, c)
        if hits == 3:
            total += value[entry]
    return total


@jit
def reduced_costs(
    start: IntArray, items: IntArray, total: FloatArray, price: FloatArray
) -> FloatArray:
    """Return each column's cost with the prices of its items."""
    reduced = total.copy()
    for column in range(total.shape[0]):
        for place in range(start[column], start[column + 1]):
            reduced[column] += price[items[place]]
    return reduced


@jit
def bound_of(
    reduced: FloatArray, family: IntArray, must: np.ndarray, allowed: np.ndarray
) -> tuple[float, FloatArray]:
    """Return what the families cost at least at these reduced costs, in all and one by one."""
    best = np.where(must, np.inf, 0.0)
    for column in range(reduced.shape[0]):
        if allowed[column] and reduced[column] < best[family[column]]:
            best[family[column]] = reduced[column]
    return best.sum(), best
