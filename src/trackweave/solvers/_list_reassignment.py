"""One list assigned anew to what stands without it. Nothing here checks or raises."""

import math

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.jit import jit
from trackweave.solvers._kernels import (
    IMPROVEMENT_WORK,
    Component,
    improve,
    selection_cost,
    set_owner,
)
from trackweave.solvers.lists import Lists

MAX_CELLS = 1_000_000
"""A list is left as it is where the assignment would have more cells."""
ROUNDS = 20
"""Rounds over all lists at most."""


@jit
def assign_rows(cost: FloatArray) -> IntArray:
    """Return the column of each row, no two the same, so that the costs add up to the least.

    All costs are finite, and there are at least as many columns as rows. Each row in turn is
    added along a shortest augmenting path [1]_.

    References
    ----------
    .. [1] R. Jonker, A. Volgenant, *A shortest augmenting path algorithm for dense and sparse
       linear assignment problems*, 1987. doi:10.1007/BF02278710
    """
    n_rows, n_columns = cost.shape
    row_of = np.full(n_columns, -1, dtype=np.int64)
    column_of = np.full(n_rows, -1, dtype=np.int64)
    row_price, column_price = np.zeros(n_rows), np.zeros(n_columns)
    distance, before = np.empty(n_columns), np.empty(n_columns, dtype=np.int64)
    is_done = np.empty(n_columns, dtype=np.bool_)
    for added in range(n_rows):
        distance[:] = math.inf
        is_done[:] = False
        row, reached, end = added, 0.0, -1
        while end < 0:
            nearest, least = -1, math.inf
            for column in range(n_columns):
                if is_done[column]:
                    continue
                way = reached + cost[row, column] - row_price[row] - column_price[column]
                if way < distance[column]:
                    distance[column], before[column] = way, row
                # Of columns as near, one that is free ends the search.
                tie = distance[column] == least and row_of[column] < 0
                if distance[column] < least or tie:
                    nearest, least = column, distance[column]
            is_done[nearest], reached = True, least
            row = row_of[nearest]
            if row < 0:
                end = nearest
        row_price[added] += reached
        for column in range(n_columns):
            if is_done[column] and column != end:
                shift = reached - distance[column]
                row_price[row_of[column]] += shift
                column_price[column] -= shift
        while True:
            row = before[end]
            row_of[end] = row
            column_of[row], end = end, column_of[row]
            if row == added:
                break
    return column_of


@jit
def find_rests(
    component: Component, of: IntArray, number: int, selection: IntArray
) -> tuple[IntArray, IntArray]:
    """Take a list's items out of all sequences, and number what is left of them.

    An item of another list that no sequence has counts as left alone. Returns the rest of each
    item, -1 for those of the list, and how many items each rest has.
    """
    rest = np.full(component.n_items, -1, dtype=np.int64)
    size = np.zeros(component.n_items, dtype=np.int64)
    n_rests = 0
    for family in range(selection.shape[0]):
        node, count = selection[family], 0
        while node >= 0:
            if of[component.item[node]] != number:
                rest[component.item[node]] = n_rests
                count += 1
            node = component.parent[node]
        if count > 0:
            size[n_rests] = count
            n_rests += 1
    for item in range(component.n_items):
        if of[item] != number and rest[item] < 0:
            rest[item] = n_rests
            size[n_rests] = 1
            n_rests += 1
    return rest, size[:n_rests]


@jit
def match_nodes(
    component: Component, of: IntArray, number: int, rest: IntArray, size: IntArray
) -> tuple[IntArray, IntArray]:
    """Tell of each node which rest its sequence holds as a whole, and which item of the list.

    Either is -1 where it holds none; the rest is -2 where the sequence holds anything else.
    """
    n_nodes = component.parent.shape[0]
    held, listed = np.empty(n_nodes, dtype=np.int64), np.empty(n_nodes, dtype=np.int64)
    count = np.empty(n_nodes, dtype=np.int64)
    for node in range(n_nodes):
        above, item = component.parent[node], component.item[node]
        held[node], listed[node], count[node] = -1, -1, 0
        if above >= 0:
            held[node], listed[node], count[node] = held[above], listed[above], count[above]
        if held[node] == -2:
            continue
        if of[item] == number:
            listed[node] = item
        elif held[node] == -1 or held[node] == rest[item]:
            held[node] = rest[item]
            count[node] += 1
        else:
            held[node] = -2
    for node in range(n_nodes):
        if held[node] >= 0 and count[node] != size[held[node]]:
            held[node] = -2
    return held, listed


@jit
def relist(
    component: Component, lists: Lists, number: int, selection: IntArray, owner: IntArray
) -> bool:
    """Assign a list's items anew to what the selection leaves without them, at least cost.

    Each item joins one rest of a sequence, or an item of another list that stands alone, or
    neither. Tells whether the selection became cheaper; else it stays as it was.
    """
    total, items = component.total, lists.member[lists.start[number] : lists.start[number + 1]]
    rest, size = find_rests(component, lists.of, number, selection)
    n_rows, n_rests = items.shape[0], size.shape[0]
    if n_rows * (n_rests + n_rows) > MAX_CELLS:
        return False
    held, listed = match_nodes(component, lists.of, number, rest, size)
    row_of = np.full(component.n_items, -1, dtype=np.int64)
    row_of[items] = np.arange(n_rows)
    # What may not be is dearer than all that may be together, so that it is used last.
    dear = 1.0
    for node in range(total.shape[0]):
        if held[node] != -2 and total[node] < math.inf:
            dear = max(dear, abs(total[node]))
    dear *= 4.0 * (n_rows + n_rests + 1)
    without, choice = np.zeros(n_rests), np.full(n_rests, -1, dtype=np.int64)
    alone, single = np.zeros(n_rows), np.full(n_rows, -1, dtype=np.int64)
    for family in range(component.must.shape[0]):
        if component.must[family]:
            root = component.item[component.members[component.start[family]]]
            if row_of[root] >= 0:
                alone[row_of[root]] = dear
            else:
                without[rest[root]] = dear
    for node in range(total.shape[0]):
        if held[node] >= 0 and listed[node] < 0 and total[node] < without[held[node]]:
            without[held[node]], choice[held[node]] = total[node], node
        elif held[node] == -1 and total[node] < alone[row_of[listed[node]]]:
            alone[row_of[listed[node]]], single[row_of[listed[node]]] = total[node], node
    cost = np.full((n_rows, n_rests + n_rows), dear)
    joint = np.full((n_rows, n_rests), -1, dtype=np.int64)
    for row in range(n_rows):
        cost[row, n_rests + row] = alone[row]
    for node in range(total.shape[0]):
        if held[node] >= 0 and listed[node] >= 0 and total[node] < math.inf:
            row = row_of[listed[node]]
            added = total[node] - without[held[node]]
            if joint[row, held[node]] < 0 or added < cost[row, held[node]]:
                cost[row, held[node]], joint[row, held[node]] = added, node
    column_of = assign_rows(cost)
    for row in range(n_rows):
        column = column_of[row]
        if column < n_rests:
            choice[column], single[row] = joint[row, column], -1
    return _replace(component, choice, single, selection, owner)


@jit
def _replace(
    component: Component,
    choice: IntArray,
    single: IntArray,
    selection: IntArray,
    owner: IntArray,
) -> bool:
    """Take these nodes, -1 for none, if they cost less than the selection."""
    before = selection_cost(component, selection)
    trial = np.full(selection.shape[0], -1, dtype=np.int64)
    for node in choice:
        if node >= 0:
            trial[component.family[node]] = node
    for node in single:
        if node >= 0:
            trial[component.family[node]] = node
    if selection_cost(component, trial) >= before - 1e-12 * max(1.0, abs(before)):
        return False
    owner[:] = -1
    for family in range(selection.shape[0]):
        selection[family] = trial[family]
        if trial[family] >= 0:
            set_owner(component, trial[family], family, owner)
    return True


@jit
def local_search(
    component: Component,
    lists: Lists,
    selection: IntArray,
    owner: IntArray,
    first: int = 0,
    max_work: int = IMPROVEMENT_WORK,
) -> float:
    """Improve a selection until neither ``improve`` nor another order of any list helps.

    ``first`` is the family that ``improve`` begins with. Looks at some ``max_work`` nodes at
    most. Writes selection and owner; returns the cost.
    """
    n_nodes, n_lists = component.parent.shape[0], lists.start.shape[0] - 1
    cost = improve(component, selection, owner, 10, first, max_work)
    left = max_work // 2
    for _ in range(ROUNDS):
        changed = False
        for number in range(n_lists):
            left -= 4 * n_nodes
            if left < 0:
                return selection_cost(component, selection)
            changed = relist(component, lists, number, selection, owner) or changed
        if not changed:
            break
        cost = improve(component, selection, owner, 10, first, max_work)
    return cost
