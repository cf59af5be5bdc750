"""From genes to hypotheses. Nothing here checks or raises.

A family holds at most one growing sequence, ``current[family]``, -1 before it begins. Tracks
from before the window begin grown to their root.
"""

import math
from typing import NamedTuple

import numpy as np

from trackweave._loops import overwrite
from trackweave.arrays import FloatArray, IntArray
from trackweave.jit import jit
from trackweave.solvers._kernels import Component


class Lookup(NamedTuple):
    """What decoding reads besides the component.

    The nodes that end with item i are ``by_item[item_start[i]:item_start[i + 1]]``; ``cost`` is
    each node's while it grows; ``gene_item`` lists the items that genes decide, in order of time;
    ``settle`` tells whether a poor new track dissolves into false alarms. The children of root r
    whose item is of the root's own instant are ``twin[twin_start[r]:twin_start[r + 1]]``, and
    ``root_of[i]`` is a root with item i, -1 where there is none.
    """

    by_item: IntArray
    item_start: IntArray
    cost: FloatArray
    instant: IntArray
    gene_item: IntArray
    twin_start: IntArray
    twin: IntArray
    root_of: IntArray
    settle: bool


class Trail(NamedTuple):
    """The last permutation decoded and how to take it back, gene by gene.

    ``length[0]`` genes are decoded. The gene at a place changed ``family`` (-1: none) from the
    node ``before``, and took over the family ``ceded`` (-1: none) that held ``ceded_node``.
    """

    genes: IntArray
    family: IntArray
    before: IntArray
    ceded: IntArray
    ceded_node: IntArray
    current: IntArray
    length: IntArray


@jit
def begin(component: Component, current: IntArray) -> None:
    """Write the state in which nothing is decoded."""
    for family in range(current.shape[0]):
        current[family] = -1
        if component.must[family]:
            current[family] = component.members[component.start[family]]


@jit
def insert(component: Component, lookup: Lookup, node: int, leaf: int) -> int:
    """Return the node for the leaf's items and the node's last one, -1 where there is none.

    The item goes to its canonical place among those of its instant: what stands behind it there
    is taken off and appended again.
    """
    item, parent = component.item, component.parent
    instant = lookup.instant[item[node]]
    depth = 0
    climb = leaf
    while climb >= 0 and climb != parent[node] and lookup.instant[item[climb]] == instant:
        climb = parent[climb]
        depth += 1
    if climb != parent[node] or climb < 0:
        return -1
    return append(component, lookup, node, leaf, depth)


@jit
def append(component: Component, lookup: Lookup, node: int, leaf: int, depth: int) -> int:
    """Return the node that continues ``node`` by the leaf's last items, -1 where there is none."""
    item, parent = component.item, component.parent
    for step in range(depth - 1, -1, -1):
        climb = leaf
        for _ in range(step):
            climb = parent[climb]
        wanted = item[climb]
        found = -1
        for entry in range(lookup.item_start[wanted], lookup.item_start[wanted + 1]):
            if parent[lookup.by_item[entry]] == node:
                found = lookup.by_item[entry]
                break
        if found < 0:
            return -1
        node = found
    return node


@jit
def precede(component: Component, lookup: Lookup, root: int, twin: int, leaf: int) -> int:
    """Return the node for the root's item and then the leaf's, -1 where there is none.

    ``twin`` stands for the root's item and the leaf's first. All must be of one instant.
    """
    if lookup.instant[component.item[leaf]] != lookup.instant[component.item[root]]:
        return -1
    depth, climb = 0, component.parent[leaf]
    while climb >= 0:
        climb = component.parent[climb]
        depth += 1
    return append(component, lookup, twin, leaf, depth)


@jit
def cheapest_place(component: Component, lookup: Lookup, item: int, current: IntArray) -> int:
    """Return the node that the cheapest assignment of an item leads to, -1 where none is allowed.

    The choice is between every growing sequence and a new one. Nodes that go back in time or
    take two reports of one scan do not exist, which is what a prohibitive cost comes to.
    """
    best, best_cost = -1, math.inf
    for entry in range(lookup.item_start[item], lookup.item_start[item + 1]):
        node = lookup.by_item[entry]
        leaf = current[component.family[node]]
        above = component.parent[node]
        if above < 0:
            grown = node if leaf < 0 else -1
            cost = lookup.cost[node]
        elif leaf == above:
            grown = node
            cost = lookup.cost[node] - lookup.cost[above]
        elif leaf >= 0 and lookup.instant[component.item[leaf]] == lookup.instant[item]:
            grown = insert(component, lookup, node, leaf)
            cost = lookup.cost[grown] - lookup.cost[leaf] if grown >= 0 else math.inf
        else:
            continue
        if grown >= 0 and cost < best_cost:
            best, best_cost = grown, cost
    return best


@jit
def cheaper_before(
    component: Component, lookup: Lookup, item: int, current: IntArray, place: int
) -> tuple[int, int]:
    """Return where it costs less than at ``place`` to stand before another sequence's first item.

    The node, and the family whose sequence goes over to the node's own; -1 and -1 where no such
    place is cheaper.
    """
    best, ceded, best_cost = -1, -1, math.inf
    if place >= 0:
        leaf = current[component.family[place]]
        best_cost = lookup.cost[place] - (lookup.cost[leaf] if leaf >= 0 else 0.0)
    for entry in range(lookup.item_start[item], lookup.item_start[item + 1]):
        root = lookup.by_item[entry]
        if component.parent[root] >= 0 or current[component.family[root]] >= 0:
            continue
        for index in range(lookup.twin_start[root], lookup.twin_start[root + 1]):
            twin = lookup.twin[index]
            other = lookup.root_of[component.item[twin]]
            leaf = current[component.family[other]] if other >= 0 else -1
            joint = precede(component, lookup, root, twin, leaf) if leaf >= 0 else -1
            if joint >= 0 and lookup.cost[joint] - lookup.cost[leaf] < best_cost:
                best, ceded = joint, component.family[other]
                best_cost = lookup.cost[joint] - lookup.cost[leaf]
    return best, ceded


@jit
def settle(component: Component, lookup: Lookup, current: IntArray, selection: IntArray) -> float:
    """Write which sequences stand when all items are placed; return their cost.

    A sequence that may not end where it stands is cut back to where it may.
    """
    cost = 0.0
    for family in range(current.shape[0]):
        node = current[family]
        while node >= 0 and component.total[node] == math.inf:
            node = component.parent[node]
        selection[family] = -1
        if node < 0:
            continue
        if component.must[family] or not lookup.settle or component.total[node] < 0.0:
            selection[family] = node
            cost += component.total[node]
    return cost


@jit
def decode_permutation(
    component: Component, lookup: Lookup, genes: IntArray, trail: Trail, selection: IntArray
) -> float:
    """Place the items in the order of the permutation; write what stands, return its cost.

    Only what differs from the last permutation is decoded: the trail is taken back to the end of
    the common beginning.
    """
    has_twins = lookup.twin.shape[0] > 0
    shared = 0
    while shared < trail.length[0] and genes[shared] == trail.genes[shared]:
        shared += 1
    for place in range(trail.length[0] - 1, shared - 1, -1):
        if trail.family[place] >= 0:
            trail.current[trail.family[place]] = trail.before[place]
        if has_twins and trail.ceded[place] >= 0:
            trail.current[trail.ceded[place]] = trail.ceded_node[place]
    for place in range(shared, genes.shape[0]):
        node = cheapest_place(component, lookup, genes[place], trail.current)
        trail.genes[place] = genes[place]
        trail.family[place] = -1
        if has_twins:
            before, ceded = cheaper_before(component, lookup, genes[place], trail.current, node)
            trail.ceded[place] = ceded
            if ceded >= 0:
                node = before
                trail.ceded_node[place] = trail.current[ceded]
                trail.current[ceded] = -1
        if node >= 0:
            family = component.family[node]
            trail.family[place] = family
            trail.before[place] = trail.current[family]
            trail.current[family] = node
    trail.length[0] = genes.shape[0]
    return settle(component, lookup, trail.current, selection)


@jit
def decode_associations(
    component: Component,
    lookup: Lookup,
    genes: IntArray,
    current: IntArray,
    ending: IntArray,
    selection: IntArray,
) -> float:
    """Link the items in order of time, each to the item that its gene names; return the cost.

    ``ending`` is room for the family whose sequence ends with each item. A gene of -1, or one
    whose sequence does not end with the named item any more, begins a new sequence.
    """
    begin(component, current)
    ending[:] = -1
    for family in range(current.shape[0]):
        if current[family] >= 0:
            ending[component.item[current[family]]] = family
    for place in range(genes.shape[0]):
        item = lookup.gene_item[place]
        family = ending[genes[place]] if genes[place] >= 0 else -1
        found = -1
        for entry in range(lookup.item_start[item], lookup.item_start[item + 1]):
            node = lookup.by_item[entry]
            above = component.parent[node]
            if family >= 0 and above == current[family]:
                found = node
                break
            if above < 0 and current[component.family[node]] < 0:
                found = node
        if found >= 0:
            if component.parent[found] >= 0:
                ending[genes[place]] = -1
            current[component.family[found]] = found
            ending[item] = component.family[found]
    return settle(component, lookup, current, selection)


@jit
def evaluate(
    component: Component,
    lookup: Lookup,
    is_permutation: bool,
    population: IntArray,
    order: IntArray,
    trail: Trail,
    cost_out: FloatArray,
    best_selection: IntArray,
    best_cost: float,
) -> float:
    """Decode the individuals in the given order; write their costs and the best selection.

    Returns the least cost, ``best_cost`` where none is less.
    """
    selection = np.empty(component.must.shape[0], dtype=np.int64)
    current = np.empty(component.must.shape[0], dtype=np.int64)
    ending = np.empty(component.n_items, dtype=np.int64)
    for row in order:
        if is_permutation:
            cost = decode_permutation(component, lookup, population[row], trail, selection)
        else:
            cost = decode_associations(
                component, lookup, population[row], current, ending, selection
            )
        cost_out[row] = cost
        if cost < best_cost:
            best_cost = cost
            overwrite(best_selection, selection)
    return best_cost
