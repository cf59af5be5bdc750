"""Prices of items by subgradient steps, and answers made at them.

Nothing here checks or raises.
"""

import math
from typing import NamedTuple

import numpy as np

from trackweave._loops import ascending, overwrite
from trackweave.arrays import FloatArray, IntArray
from trackweave.association._clusters import Partition
from trackweave.jit import jit
from trackweave.solvers._kernels import (
    Component,
    improve,
    part_of,
    repair,
    selection_cost,
)
from trackweave.solvers._pricing import bound_at, choices_at, choose, price_nodes
from trackweave.solvers._reduction import narrowed, whole, write_taken

LARGE, FEW = 20_000, 25
"""In a component of more sequences an answer, which takes long, is made once in so many bounds."""
NARROWING = 20
"""Bounds between two looks at which sequences they leave open."""
LIKELY = 0.1
"""Answers are improved by sequences whose excess is at most this part of the gap."""


class Ascent(NamedTuple):
    """Where the climb of a component's bound stands.

    ``current`` are the prices of the next bound; ``value`` holds the cost of the selection, the
    bound and the factor of the step; ``iteration`` and ``stalled`` hold how many bounds were
    computed, in all and since the last rise.
    """

    current: FloatArray
    value: FloatArray
    iteration: IntArray
    stalled: IntArray


@jit
def _likely(
    component: Component, reduced: FloatArray, best: FloatArray, taken: IntArray, most: float
) -> Component:
    """Return the component with only those sequences free to be taken whose excess is little."""
    total = component.total.copy()
    for node in range(total.shape[0]):
        family = component.family[node]
        if reduced[node] - best[family] > most and taken[family] != node:
            total[node] = math.inf
    return Component(
        component.parent, component.item, component.family, total,
        component.members, component.start, component.must, component.n_items,
    )  # fmt: skip


@jit
def begin_ascent(price: FloatArray, upper: float, lower: float) -> Ascent:
    """Return the climb from these prices before its first bound, with what is known."""
    value = np.array([upper, lower, 1.0])
    return Ascent(price.copy(), value, np.zeros(1, dtype=np.int64), np.zeros(1, dtype=np.int64))


@jit
def ascend(
    component: Component,
    price: FloatArray,
    selection: IntArray,
    ascent: Ascent,
    more: int,
    max_iterations: int,
    tolerance: float,
) -> bool:
    """Raise the bound by subgradient steps; write the best prices and the best selection.

    The step is Polyak's, with the best known cost as the target; its factor is halved when the
    bound has not risen for a while. Takes up to so many more steps, up to the greatest number in
    all, and returns whether the climb is over.
    """
    n_nodes, n_families = component.parent.shape[0], component.must.shape[0]
    priced, reduced = np.empty(n_nodes), np.empty(n_nodes)
    best, choice = np.empty(n_families), np.empty(n_families, dtype=np.int64)
    trial = np.empty(n_families, dtype=np.int64)
    owner = np.empty(component.n_items, dtype=np.int64)
    count = np.empty(component.n_items)
    current, stalled, over = ascent.current, ascent.stalled[0], False
    upper, lower, factor = ascent.value[0], ascent.value[1], ascent.value[2]
    last = min(ascent.iteration[0] + more, max_iterations)
    for iteration in range(ascent.iteration[0], last):
        price_nodes(component, current, priced, reduced)
        choose(component, reduced, choice, best)
        bound = 0.0
        for family in range(n_families):
            bound += best[family]
        count[:] = -1.0
        for item in range(component.n_items):
            bound -= current[item]
        for family in range(n_families):
            node = choice[family]
            while node >= 0:
                count[component.item[node]] += 1.0
                node = component.parent[node]
        improved = bound > lower + 1e-9
        if improved:
            lower = bound
            overwrite(price, current)
            stalled = 0
        else:
            stalled += 1
        norm = 0.0
        for item in range(component.n_items):
            if count[item] > 0.0 or current[item] > 0.0:
                norm += count[item] * count[item]
        due = iteration % FEW == 0 if n_nodes > LARGE else iteration % 4 == 0 or improved
        due = due or iteration % NARROWING == 0
        if due or norm == 0.0:
            cost = repair(component, ascending(best), choice, reduced, trial, owner)
            # Before, few sequences are excluded: improving takes longer than all these bounds.
            again = iteration % NARROWING == 0
            if iteration >= NARROWING and (again or cost < upper):
                likely = _likely(component, reduced, best, trial, LIKELY * (cost - bound))
                cost = improve(likely, trial, owner, 3)
            if cost < upper:
                upper = cost
                overwrite(selection, trial)
        ascent.iteration[0] = iteration + 1
        if upper - lower <= tolerance or norm == 0.0:
            over = True
            break
        if stalled >= 5:
            factor *= 0.5
            stalled = 0
            overwrite(current, price)
            over = factor < 1e-3
            if over:
                break
            continue
        step = factor * (upper - bound) / norm if upper < math.inf else 1.0
        for item in range(component.n_items):
            if count[item] > 0.0 or current[item] > 0.0:
                current[item] = max(0.0, current[item] + step * count[item])
    ascent.stalled[0] = stalled
    ascent.value[0], ascent.value[1], ascent.value[2] = upper, lower, factor
    return over or ascent.iteration[0] >= max_iterations


@jit
def answer_at(
    component: Component, price: FloatArray, selection: IntArray, upper: float, rounds: int
) -> float:
    """Make an answer by reduced cost at these prices, improve it, keep it where it is better.

    Returns the cost of the better one.
    """
    reduced, choice, best = choices_at(component, price)
    trial = np.empty_like(choice)
    owner = np.empty(component.n_items, dtype=np.int64)
    cost = repair(component, ascending(best), choice, reduced, trial, owner)
    if rounds > 0:
        cost = improve(component, trial, owner, rounds)
    if cost < upper:
        overwrite(selection, trial)
        return cost
    return upper


@jit
def solve_components(
    parts: Partition,
    first: int,
    last: int,
    price: FloatArray,
    taken: IntArray,
    cost: FloatArray,
    lower: FloatArray,
    iterations: int,
    tolerance: float,
) -> int:
    """Bound and answer the components first … last − 1, each by so many bounds at most.

    ``price`` is per item of the partition, ``taken`` per family (a node number within the
    component, or -1), ``cost`` and ``lower`` per component. Returns how many bounds it computed.
    """
    evaluations = 0
    for index in range(first, last):
        component = part_of(parts, index)
        own_price = price[parts.item_start[index] : parts.item_start[index + 1]]
        selection = taken[parts.family_start[index] : parts.family_start[index + 1]]
        if selection.shape[0] == 1:
            cost[index], lower[index] = _settle(component, own_price, selection, cost[index])
            evaluations += 1
            continue
        ascent = begin_ascent(own_price, cost[index], lower[index])
        n = iterations
        over = ascend(component, own_price, selection, ascent, NARROWING, n, tolerance)
        left = whole(component, selection)
        while not over:
            left = narrowed(left, own_price, ascent.value[0])
            over = ascend(left.component, own_price, left.taken, ascent, NARROWING, n, tolerance)
        upper, bound = ascent.value[0], ascent.value[1]
        evaluations += ascent.iteration[0]
        write_taken(left, selection)
        cost[index], lower[index] = upper, min(bound, upper)
    return evaluations


@jit
def _settle(
    component: Component, price: FloatArray, selection: IntArray, known: float
) -> tuple[float, float]:
    """Take the least sequence of the only family; its items, which no other wants, cost nothing.

    Returns the cost and the bound, which are equal.
    """
    best, choice = math.inf if component.must[0] else 0.0, -1
    for node in range(component.total.shape[0]):
        if component.total[node] < best:
            best, choice = component.total[node], node
    price[:] = 0.0
    if best < known:
        selection[0] = choice
    return best, best


@jit
def bound_components(
    parts: Partition, price: FloatArray, taken: IntArray, cost: FloatArray, lower: FloatArray
) -> None:
    """Write what each component's selection costs and the bound at its prices.

    The cost is infinite where a family that must be covered has no node.
    """
    for index in range(cost.shape[0]):
        component = part_of(parts, index)
        own_price = price[parts.item_start[index] : parts.item_start[index + 1]]
        selection = taken[parts.family_start[index] : parts.family_start[index + 1]]
        cost[index] = selection_cost(component, selection)
        lower[index] = min(bound_at(component, own_price), cost[index])
