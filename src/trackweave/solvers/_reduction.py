"""Leaving out what the prices exclude. Nothing here checks or raises."""

import math
from typing import NamedTuple

import numpy as np

from trackweave._loops import overwrite
from trackweave.arrays import FloatArray, IntArray
from trackweave.jit import jit
from trackweave.solvers._kernels import Component
from trackweave.solvers._pricing import excesses

DROPPED, PREFIX, OPEN, FORCED = 0, 1, 2, 3


@jit
def classify(component: Component, price: FloatArray, upper: float) -> IntArray:
    """Tell of each node whether an answer better than ``upper`` can take it.

    A node whose reduced cost exceeds its family's least by more than the gap is DROPPED, or
    PREFIX where an OPEN node stands below it. The only open node of a family that has to take
    one is FORCED, and then whatever shares an item with it is out too.
    """
    bound, excess, none = excesses(component, price)
    n_nodes, n_families = excess.shape[0], none.shape[0]
    gap = upper - bound + 1e-9 * max(1.0, abs(upper))
    state = np.zeros(n_nodes, dtype=np.int64)
    for node in range(n_nodes):
        if excess[node] <= gap:
            state[node] = OPEN
    holder = np.full(component.n_items, -1, dtype=np.int64)
    forced = np.zeros(n_families, dtype=np.bool_)
    changed = True
    while changed:
        changed = False
        count, only = np.zeros(n_families, dtype=np.int64), np.empty(n_families, dtype=np.int64)
        for node in range(n_nodes):
            if state[node] == OPEN:
                count[component.family[node]] += 1
                only[component.family[node]] = node
        for family in range(n_families):
            has_to = component.must[family] or none[family] > gap
            if has_to and count[family] == 1 and not forced[family]:
                forced[family] = changed = True
                climb = only[family]
                while climb >= 0:
                    holder[component.item[climb]] = family
                    climb = component.parent[climb]
        if changed:
            for node in range(n_nodes):
                if state[node] == OPEN:
                    climb = node
                    while climb >= 0:
                        other = holder[component.item[climb]]
                        if other >= 0 and other != component.family[node]:
                            state[node] = DROPPED
                            break
                        climb = component.parent[climb]
    for node in range(n_nodes - 1, -1, -1):
        above = component.parent[node]
        if state[node] != DROPPED and above >= 0 and state[above] == DROPPED:
            state[above] = PREFIX
    for node in range(n_nodes):
        if forced[component.family[node]]:
            state[node] = FORCED if state[node] == OPEN else DROPPED
    return state


class Narrowed(NamedTuple):
    """What is left of a component, with its items and families as they were.

    ``row`` holds the whole's node for each node that is left, ``taken`` each family's node among
    those, -1 for none.
    """

    component: Component
    row: IntArray
    taken: IntArray


@jit
def whole(component: Component, taken: IntArray) -> Narrowed:
    """Return a component of which nothing is excluded yet."""
    return Narrowed(component, np.arange(component.parent.shape[0]), taken.copy())


@jit
def narrowed(left: Narrowed, price: FloatArray, upper: float) -> Narrowed:
    """Return what the bound at these prices leaves open for answers that cost at most ``upper``.

    What only leads to an open sequence stays, but may not be taken; what is taken stays open, and
    so does the beginning of a family that must be covered: with it alone there is an answer.
    """
    component, n_nodes = left.component, left.component.parent.shape[0]
    bound, excess, _ = excesses(component, price)
    gap = upper - bound + 1e-9 * max(1.0, abs(upper))
    is_open, is_kept = np.empty(n_nodes, dtype=np.bool_), np.empty(n_nodes, dtype=np.bool_)
    for node in range(n_nodes):
        is_open[node] = excess[node] <= gap
    for family in range(left.taken.shape[0]):
        if left.taken[family] >= 0:
            is_open[left.taken[family]] = True
        if component.must[family]:
            is_open[component.members[component.start[family]]] = True
    n_left = 0
    overwrite(is_kept, is_open)
    for node in range(n_nodes - 1, -1, -1):
        if is_kept[node]:
            n_left += 1
            if component.parent[node] >= 0:
                is_kept[component.parent[node]] = True
    return _only(left, is_open, is_kept, n_left)


@jit
def _only(left: Narrowed, is_open: np.ndarray, is_kept: np.ndarray, n_left: int) -> Narrowed:
    """Return the nodes that are kept; those not open may not be taken."""
    component = left.component
    number = np.full(is_kept.shape[0], -1, dtype=np.int64)
    row, parent = np.empty(n_left, dtype=np.int64), np.empty(n_left, dtype=np.int64)
    item, family = np.empty(n_left, dtype=np.int64), np.empty(n_left, dtype=np.int64)
    total, members = np.empty(n_left), np.empty(n_left, dtype=np.int64)
    fill = 0
    for node in range(is_kept.shape[0]):
        if is_kept[node]:
            above = component.parent[node]
            number[node] = fill
            row[fill] = left.row[node]
            parent[fill] = number[above] if above >= 0 else -1
            item[fill], family[fill] = component.item[node], component.family[node]
            total[fill] = component.total[node] if is_open[node] else math.inf
            fill += 1
    n_families = left.taken.shape[0]
    start, taken = np.zeros(n_families + 1, dtype=np.int64), left.taken.copy()
    fill = 0
    for index in range(n_families):
        for entry in range(component.start[index], component.start[index + 1]):
            if is_kept[component.members[entry]]:
                members[fill] = number[component.members[entry]]
                fill += 1
        start[index + 1] = fill
        if taken[index] >= 0:
            taken[index] = number[taken[index]]
    narrow = Component(
        parent, item, family, total, members, start, component.must, component.n_items
    )
    return Narrowed(narrow, row, taken)


@jit
def write_taken(left: Narrowed, selection: IntArray) -> None:
    """Write what is taken as nodes of the whole component."""
    for family in range(selection.shape[0]):
        node = left.taken[family]
        selection[family] = left.row[node] if node >= 0 else -1
