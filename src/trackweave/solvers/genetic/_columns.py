"""From permutations of lists to hypotheses. Nothing here checks or raises.

An individual has one permutation per list. Value v of list l is the list's item number v, or a
dummy where the list has no such item. The items of all lists at one place are a column.
"""

from typing import NamedTuple

import numpy as np

from trackweave._loops import overwrite
from trackweave.arrays import FloatArray, IntArray
from trackweave.jit import jit
from trackweave.solvers._kernels import Component


class Table(NamedTuple):
    """What decoding reads besides the component.

    List l has the items ``member[list_start[l]:list_start[l + 1]]``. The roots of item i are
    ``root[root_start[i]:root_start[i + 1]]``; the children of node n, in order of their items,
    are ``child[child_start[n]:child_start[n + 1]]``, and ``least`` is the least total of a node
    and all below it.
    """

    member: IntArray
    list_start: IntArray
    root: IntArray
    root_start: IntArray
    child: IntArray
    child_start: IntArray
    least: FloatArray


@jit
def find_child(component: Component, table: Table, node: int, item: int) -> int:
    """Return the node that continues another by an item, -1 where there is none."""
    low, high = table.child_start[node], table.child_start[node + 1]
    while low < high:
        middle = (low + high) // 2
        if component.item[table.child[middle]] < item:
            low = middle + 1
        else:
            high = middle
    found = low < table.child_start[node + 1] and component.item[table.child[low]] == item
    return table.child[low] if found else -1


@jit
def read_column(table: Table, genes: IntArray, place: int, column: IntArray) -> None:
    """Write the item of each list at a place, -1 for a dummy."""
    for number in range(genes.shape[0]):
        entry = table.list_start[number] + genes[number, place]
        column[number] = table.member[entry] if entry < table.list_start[number + 1] else -1


@jit
def best_in_column(
    component: Component, table: Table, column: IntArray, path: IntArray, turn: IntArray
) -> tuple[int, float]:
    """Return the cheapest sequence of a column's items and what it gains, -1 and 0 for none.

    A root that has to be covered counts as taken already. ``path`` and ``turn`` are room for a
    node and the list to try next, at each depth.
    """
    n_lists = column.shape[0]
    best, best_gain = -1, 0.0
    for first in range(n_lists):
        if column[first] < 0:
            continue
        for entry in range(table.root_start[column[first]], table.root_start[column[first] + 1]):
            root = table.root[entry]
            known = component.total[root] if component.must[component.family[root]] else 0.0
            if component.total[root] - known < best_gain:
                best, best_gain = root, component.total[root] - known
            depth = 0
            path[0], turn[0] = root, first + 1
            while depth >= 0:
                node = path[depth]
                if turn[depth] == n_lists or table.least[node] - known >= best_gain:
                    depth -= 1
                    continue
                item = column[turn[depth]]
                turn[depth] += 1
                child = find_child(component, table, node, item) if item >= 0 else -1
                if child >= 0:
                    if component.total[child] - known < best_gain:
                        best, best_gain = child, component.total[child] - known
                    path[depth + 1], turn[depth + 1] = child, turn[depth]
                    depth += 1
    return best, best_gain


@jit
def decode_columns(
    component: Component, table: Table, genes: IntArray, room: IntArray, selection: IntArray
) -> float:
    """Let each column take its cheapest sequence; write the selection, return its cost.

    ``room`` has three rows of one entry per list, and one more.
    """
    cost = 0.0
    for family in range(selection.shape[0]):
        selection[family] = -1
        if component.must[family]:
            selection[family] = component.members[component.start[family]]
            cost += component.total[selection[family]]
    column = room[0, : genes.shape[0]]
    for place in range(genes.shape[1]):
        read_column(table, genes, place, column)
        node, gain = best_in_column(component, table, column, room[1], room[2])
        if node >= 0:
            selection[component.family[node]] = node
            cost += gain
    return cost


@jit
def evaluate_columns(
    component: Component,
    table: Table,
    population: IntArray,
    first: int,
    last: int,
    cost_out: FloatArray,
    best_selection: IntArray,
    best_cost: float,
) -> float:
    """Decode the individuals first … last − 1; write their costs and the best selection.

    Returns the least cost, ``best_cost`` where none is less.
    """
    selection = np.empty(component.must.shape[0], dtype=np.int64)
    room = np.empty((3, population.shape[1] + 1), dtype=np.int64)
    for row in range(first, last):
        cost = decode_columns(component, table, population[row], room, selection)
        cost_out[row] = cost
        if cost < best_cost:
            best_cost = cost
            overwrite(best_selection, selection)
    return best_cost


@jit
def least_below(component: Component) -> FloatArray:
    """Return the least total of each node and all below it."""
    least = component.total.copy()
    for node in range(least.shape[0] - 1, -1, -1):
        above = component.parent[node]
        if above >= 0 and least[node] < least[above]:
            least[above] = least[node]
    return least
