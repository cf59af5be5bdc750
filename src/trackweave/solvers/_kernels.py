"""What solvers share: selections of one node per family, their repair and improvement.

A *family* is all nodes below one root, so at most one of them can be taken. A selection holds
for each family the taken node, or -1; ``owner`` holds for each item the family that covers it,
or -1. Kernels work on one component whose nodes, families and items are numbered from 0.
Nothing here checks or raises.
"""

import math
from typing import NamedTuple

import numpy as np

from trackweave._loops import ascending, total_of
from trackweave.arrays import FloatArray, IntArray
from trackweave.association._clusters import Partition
from trackweave.jit import jit

IMPROVEMENT_WORK = 10_000_000
"""How many nodes one improvement looks at: some 20 ms, more than most windows ask for."""


class Component(NamedTuple):
    """Nodes of a problem that share items with each other and with nobody else.

    ``parent`` (-1 at roots), ``item`` and ``total`` (cost of the sequence that ends here,
    infinite where none may) have one entry per node, parents first. The nodes of family f are
    ``members[start[f]:start[f + 1]]``. ``must`` tells for each family whether one of its nodes
    has to be taken.
    """

    parent: IntArray
    item: IntArray
    family: IntArray
    total: FloatArray
    members: IntArray
    start: IntArray
    must: np.ndarray
    n_items: int


@jit
def part_of(parts: Partition, index: int) -> Component:
    """Return one component of a partition, as views."""
    n0, n1 = parts.node_start[index], parts.node_start[index + 1]
    f0, f1 = parts.family_start[index], parts.family_start[index + 1]
    return Component(
        parts.parent[n0:n1],
        parts.item[n0:n1],
        parts.family[n0:n1],
        parts.total[n0:n1],
        parts.members[n0:n1],
        parts.member_start[f0 + index : f1 + index + 1],
        parts.must[f0:f1],
        parts.item_start[index + 1] - parts.item_start[index],
    )


@jit
def is_free(component: Component, node: int, family: int, owner: IntArray) -> bool:
    """Tell whether no other family covers an item of the node's sequence."""
    while node >= 0:
        holder = owner[component.item[node]]
        if holder >= 0 and holder != family:
            return False
        node = component.parent[node]
    return True


@jit
def set_owner(component: Component, node: int, family: int, owner: IntArray) -> None:
    """Write ``family`` (or -1) as the holder of each item of the node's sequence."""
    while node >= 0:
        owner[component.item[node]] = family
        node = component.parent[node]


@jit
def best_free(component: Component, family: int, value: FloatArray, owner: IntArray) -> int:
    """Return the family's node of least value whose items are free; -1 when none is below 0.

    A family that must be covered takes its least node whatever its sign; -1 then means that
    nothing is free.
    """
    best, best_value = -1, math.inf if component.must[family] else 0.0
    for entry in range(component.start[family], component.start[family + 1]):
        node = component.members[entry]
        if value[node] < best_value and is_free(component, node, family, owner):
            best, best_value = node, value[node]
    return best


@jit
def selection_cost(component: Component, selection: IntArray) -> float:
    """Return the sum of the taken nodes' totals."""
    cost = 0.0
    for family in range(selection.shape[0]):
        if selection[family] >= 0:
            cost += component.total[selection[family]]
        elif component.must[family]:
            return math.inf
    return cost


@jit
def repair(
    component: Component,
    order: IntArray,
    preferred: IntArray,
    value: FloatArray,
    selection: IntArray,
    owner: IntArray,
) -> float:
    """Write a selection: each family in order takes its preferred node, else its best free one.

    Returns the cost; infinite where a family that must be covered found nothing.
    """
    owner[:] = -1
    # What a track that must be covered owns at its root is held for it from the start.
    for family in range(selection.shape[0]):
        selection[family] = -1
        if component.must[family]:
            owner[component.item[component.members[component.start[family]]]] = family
    for family in order:
        node = preferred[family]
        if node >= 0 and not is_free(component, node, family, owner):
            node = best_free(component, family, value, owner)
        selection[family] = node
        if node >= 0:
            set_owner(component, node, family, owner)
    return selection_cost(component, selection)


@jit
def improve(
    component: Component,
    selection: IntArray,
    owner: IntArray,
    max_rounds: int,
    first: int = 0,
    max_work: int = IMPROVEMENT_WORK,
) -> float:
    """Improve a selection by eject, insert and repair until nothing helps; return its cost.

    Each family in turn, from ``first`` on, is given up and takes its best free node; failing
    that, each of its nodes is tried at the price of ejecting the families in its way, which then
    take their best free nodes. Only strict gains are taken. Ends early once so many nodes were
    looked at.
    """
    total = component.total
    n_families = selection.shape[0]
    work = np.zeros(1, dtype=np.int64)
    blockers = np.empty(64, dtype=np.int64)
    before = np.empty(64, dtype=np.int64)
    for _ in range(max_rounds):
        changed = False
        for turn in range(n_families):
            if work[0] > max_work:
                return selection_cost(component, selection)
            family = (first + turn) % n_families
            work[0] += component.start[family + 1] - component.start[family]
            old = selection[family]
            old_cost = total[old] if old >= 0 else 0.0
            if old >= 0:
                set_owner(component, old, -1, owner)
            best = best_free(component, family, total, owner)
            if component.must[family] and best < 0:
                best = old
            best_cost = total[best] if best >= 0 else 0.0
            if best_cost < old_cost - 1e-12:
                selection[family], old, old_cost, changed = best, best, best_cost, True
            if old >= 0:
                set_owner(component, old, family, owner)
            for entry in range(component.start[family], component.start[family + 1]):
                node = component.members[entry]
                if total[node] >= old_cost - 1e-12:
                    continue
                if work[0] > max_work:
                    break
                if _eject(component, family, node, selection, owner, blockers, before, work):
                    changed = True
                    old, old_cost = node, total[node]
        if not changed:
            break
    return selection_cost(component, selection)


@jit
def _eject(
    component: Component,
    family: int,
    node: int,
    selection: IntArray,
    owner: IntArray,
    blockers: IntArray,
    before: IntArray,
    work: IntArray,
) -> bool:
    """Give ``node`` to ``family`` and let those in its way choose again; undo without gain.

    Adds to ``work`` how many nodes they choose from.
    """
    total = component.total
    n_blockers = 0
    climb = node
    while climb >= 0:
        holder = owner[component.item[climb]]
        if holder >= 0 and holder != family:
            known = False
            for index in range(n_blockers):
                known = known or blockers[index] == holder
            if not known:
                if n_blockers == blockers.shape[0]:
                    return False
                blockers[n_blockers] = holder
                before[n_blockers] = selection[holder]
                n_blockers += 1
        climb = component.parent[climb]
    old = selection[family]
    gain = (total[old] if old >= 0 else 0.0) - total[node]
    if old >= 0:
        set_owner(component, old, -1, owner)
    for index in range(n_blockers):
        set_owner(component, before[index], -1, owner)
        gain += total[before[index]]
    set_owner(component, node, family, owner)
    selection[family] = node
    done = 0
    for index in range(n_blockers):
        holder = blockers[index]
        work[0] += component.start[holder + 1] - component.start[holder]
        choice = best_free(component, holder, total, owner)
        if choice < 0 and component.must[holder]:
            gain = -math.inf
            break
        selection[holder] = choice
        if choice >= 0:
            set_owner(component, choice, holder, owner)
            gain -= total[choice]
        done += 1
    if gain > 1e-12:
        return True
    for index in range(done):
        if selection[blockers[index]] >= 0:
            set_owner(component, selection[blockers[index]], -1, owner)
    set_owner(component, node, -1, owner)
    for index in range(n_blockers):
        selection[blockers[index]] = before[index]
        set_owner(component, before[index], blockers[index], owner)
    selection[family] = old
    if old >= 0:
        set_owner(component, old, family, owner)
    return False


@jit
def cheapest_first(component: Component, selection: IntArray) -> tuple[float, float]:
    """Write the greedy selection; return its cost and the bound without any exclusion."""
    total = component.total
    n_families = selection.shape[0]
    least = np.zeros(n_families)
    for family in range(n_families):
        if component.must[family]:
            least[family] = math.inf
    for node in range(total.shape[0]):
        family = component.family[node]
        least[family] = min(least[family], total[node])
    selection[:] = -1
    owner = np.full(component.n_items, -1, dtype=np.int64)
    for family in range(n_families):
        if component.must[family]:
            owner[component.item[component.members[component.start[family]]]] = family
    for node in ascending(total):
        family = component.family[node]
        wanted = total[node] < 0.0 or component.must[family]
        if not wanted or selection[family] >= 0 or total[node] == math.inf:
            continue
        if is_free(component, node, family, owner):
            selection[family] = node
            set_owner(component, node, family, owner)
    return selection_cost(component, selection), total_of(least)


@jit
def layers(component: Component, instant: IntArray) -> IntArray:
    """Return for each item one more than the most of any item of its instant before it.

    Before it: one of a lower number with which it shares a sequence. So items of one layer and
    instant share none.
    """
    item, parent = component.item, component.parent
    n_pairs = 0
    for node in range(item.shape[0]):
        climb = parent[node]
        while climb >= 0:
            n_pairs += instant[item[climb]] == instant[item[node]]
            climb = parent[climb]
    lower, higher = np.empty(n_pairs, dtype=np.int64), np.empty(n_pairs, dtype=np.int64)
    fill = 0
    for node in range(item.shape[0]):
        climb = parent[node]
        while climb >= 0:
            if instant[item[climb]] == instant[item[node]]:
                lower[fill] = min(item[climb], item[node])
                higher[fill] = max(item[climb], item[node])
                fill += 1
            climb = parent[climb]
    layer = np.zeros(component.n_items, dtype=np.int64)
    for pair in ascending(higher):
        layer[higher[pair]] = max(layer[higher[pair]], layer[lower[pair]] + 1)
    return layer
