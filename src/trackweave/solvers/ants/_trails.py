"""Ants that choose one option of each family, and their trails. Nothing here checks or raises."""

import math
from typing import NamedTuple

import numpy as np

from trackweave._loops import ascending, overwrite
from trackweave.arrays import FloatArray, IntArray
from trackweave.jit import jit
from trackweave.solvers._kernels import (
    Component,
    best_free,
    improve,
    selection_cost,
    set_owner,
)


class Options(NamedTuple):
    """What ants choose from: for each family its candidates, and taking none where it may.

    The options of family f are ``node[start[f]:start[f + 1]]``, -1 for none, in order of reduced
    cost; ``excess`` is each one's reduced cost above the family's least.
    """

    start: IntArray
    node: IntArray
    excess: FloatArray


@jit
def list_options(component: Component, reduced: FloatArray, limit: int) -> Options:
    """Return the options: up to ``limit`` nodes of least reduced cost for each family.

    A node that costs more than taking none is no candidate where none may be taken.
    """
    n_families = component.must.shape[0]
    start = np.zeros(n_families + 1, dtype=np.int64)
    room = reduced.shape[0] + n_families
    node, excess = np.empty(room, dtype=np.int64), np.empty(room)
    fill = 0
    for family in range(n_families):
        first, must = fill, component.must[family]
        if not must:
            node[fill], excess[fill] = -1, 0.0
            fill += 1
        for entry in range(component.start[family], component.start[family + 1]):
            member = component.members[entry]
            if component.total[member] < (math.inf if must else 0.0):
                node[fill], excess[fill] = member, reduced[member]
                fill += 1
        order = ascending(excess[first:fill])
        own_node, own_cost = node[first:fill][order], excess[first:fill][order]
        fill, n_nodes = first, 0
        for place in range(order.shape[0]):
            is_node = own_node[place] >= 0
            if is_node and n_nodes == limit:
                continue
            n_nodes += is_node
            node[fill], excess[fill] = own_node[place], own_cost[place] - own_cost[0]
            fill += 1
        start[family + 1] = fill
    return Options(start, node[:fill].copy(), excess[:fill].copy())


@jit
def shuffle(order: IntArray, rng: np.random.Generator) -> None:
    """Bring the entries into random order, in place."""
    for place in range(order.shape[0] - 1, 0, -1):
        other = rng.integers(0, place + 1)
        order[place], order[other] = order[other], order[place]


@jit
def choose_options(
    component: Component,
    options: Options,
    weight: FloatArray,
    order: IntArray,
    rng: np.random.Generator,
    selection: IntArray,
    owner: IntArray,
) -> float:
    """Write one ant's selection; return its cost.

    Families in the given order take one of their free options with probability in proportion to
    its weight; a family that finds nothing of any weight free takes its best free node.
    """
    parent, item = component.parent, component.item
    start, node = options.start, options.node
    sums = np.empty(np.max(start[1:] - start[:-1]))
    selection[:] = -1
    owner[:] = -1
    for family in order:
        first, running = start[family], 0.0
        for entry in range(first, start[family + 1]):
            climb, free = node[entry], True
            while climb >= 0 and free:
                free = owner[item[climb]] < 0
                climb = parent[climb]
            if free:
                running += weight[entry]
            sums[entry - first] = running
        if running > 0.0:
            wanted, place = rng.random() * running, 0
            while sums[place] <= wanted:
                place += 1
            chosen = node[first + place]
        else:
            chosen = best_free(component, family, component.total, owner)
        selection[family] = chosen
        if chosen >= 0:
            set_owner(component, chosen, family, owner)
    return selection_cost(component, selection)


@jit
def send_ants(
    component: Component,
    options: Options,
    weight: FloatArray,
    n_ants: int,
    rng: np.random.Generator,
    best_selection: IntArray,
    best_cost: float,
) -> float:
    """Send so many ants out, each to visit families in random order.

    Writes the best selection where it costs less than ``best_cost``, and returns what it costs.
    """
    selection = np.empty(component.must.shape[0], dtype=np.int64)
    owner = np.empty(component.n_items, dtype=np.int64)
    order = np.empty_like(selection)
    for _ in range(n_ants):
        # From the same order each time, so that it does not matter where a search was stopped.
        for family in range(order.shape[0]):
            order[family] = family
        shuffle(order, rng)
        cost = choose_options(component, options, weight, order, rng, selection, owner)
        if cost < best_cost:
            best_cost = cost
            overwrite(best_selection, selection)
    return best_cost


@jit
def improve_selection(
    component: Component, whole: Component, selection: IntArray, first: int, max_work: int
) -> float:
    """Improve a selection in place by eject, insert and repair; return its cost.

    Families choose from the members of ``component``, which has the nodes of ``whole`` but may
    list fewer of them.
    """
    owner = np.full(component.n_items, -1, dtype=np.int64)
    for family in range(selection.shape[0]):
        if whole.must[family]:
            owner[whole.item[whole.members[whole.start[family]]]] = family
        if selection[family] >= 0:
            set_owner(component, selection[family], family, owner)
    return improve(component, selection, owner, 10, first, max_work)


@jit
def deposit(
    options: Options,
    selection: IntArray,
    persistence: float,
    least: float,
    pheromone: FloatArray,
) -> None:
    """Let pheromone evaporate and lay it on what is selected, in place.

    It stays between ``least`` and 1, to which an option that is selected each time tends.
    """
    for family in range(selection.shape[0]):
        for entry in range(options.start[family], options.start[family + 1]):
            trail = persistence * pheromone[entry]
            if options.node[entry] == selection[family]:
                trail += 1.0 - persistence
            pheromone[entry] = max(trail, least)
