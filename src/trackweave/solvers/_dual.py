"""Prices of items by Lagrangian relaxation, and enumeration of what the bound leaves open.

Every item may be covered once; the dual charges a price for it instead. For prices π ≥ 0,
L(π) = Σ_family min(0, min_node total + Σ π) − Σ π is a lower bound of the optimum (no 0 where
the family must be covered). Nothing here checks or raises.
"""

import math
from typing import NamedTuple

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.association._clusters import Partition
from trackweave.jit import jit
from trackweave.solvers._kernels import (
    Component,
    improve,
    is_free,
    part_of,
    repair,
    selection_cost,
    set_owner,
)

LARGE, FEW = 20_000, 25
"""In a component of more sequences an answer takes longer than so many bounds, so it gets few."""


class DualBudget(NamedTuple):
    """How long to raise the bound and to enumerate what it leaves open, per component."""

    iterations: int
    visits: int
    tolerance: float


@jit
def price_nodes(
    component: Component, price: FloatArray, priced: FloatArray, reduced: FloatArray
) -> None:
    """Write the prices along each sequence to ``priced`` and its reduced cost to ``reduced``."""
    for node in range(component.parent.shape[0]):
        above = component.parent[node]
        total = price[component.item[node]]
        if above >= 0:
            total += priced[above]
        priced[node] = total
        reduced[node] = component.total[node] + total


@jit
def choose(component: Component, reduced: FloatArray, choice: IntArray, best: FloatArray) -> None:
    """Write each family's node of least reduced cost, -1 where taking none is better."""
    n_families = choice.shape[0]
    for family in range(n_families):
        choice[family] = -1
        best[family] = math.inf if component.must[family] else 0.0
    for node in range(component.parent.shape[0]):
        family = component.family[node]
        if reduced[node] < best[family]:
            best[family] = reduced[node]
            choice[family] = node


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
            price[:] = current
            stalled = 0
        else:
            stalled += 1
        norm = 0.0
        for item in range(component.n_items):
            if count[item] > 0.0 or current[item] > 0.0:
                norm += count[item] * count[item]
        due = iteration % FEW == 0 if n_nodes > LARGE else iteration % 4 == 0 or improved
        if due or norm == 0.0:
            cost = repair(component, np.argsort(best), choice, reduced, trial, owner)
            if cost < upper:
                cost = improve(component, trial, owner, 3)
            if cost < upper:
                upper = cost
                selection[:] = trial
        ascent.iteration[0] = iteration + 1
        if upper - lower <= tolerance or norm == 0.0:
            over = True
            break
        if stalled >= 5:
            factor *= 0.5
            stalled = 0
            current[:] = price
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
def answer_at(component: Component, price: FloatArray, selection: IntArray, upper: float) -> float:
    """Make an answer by reduced cost at these prices; keep it where it is better.

    Returns the cost of the better one.
    """
    n_nodes, n_families = component.parent.shape[0], component.must.shape[0]
    priced, reduced = np.empty(n_nodes), np.empty(n_nodes)
    best, choice = np.empty(n_families), np.empty(n_families, dtype=np.int64)
    trial, owner = (
        np.empty(n_families, dtype=np.int64),
        np.empty(component.n_items, dtype=np.int64),
    )
    price_nodes(component, price, priced, reduced)
    choose(component, reduced, choice, best)
    repair(component, np.argsort(best), choice, reduced, trial, owner)
    cost = improve(component, trial, owner, 3)
    if cost < upper:
        selection[:] = trial
        return cost
    return upper


@jit
def enumerate_open(
    component: Component,
    price: FloatArray,
    selection: IntArray,
    upper: float,
    max_visits: int,
) -> tuple[float, bool, int]:
    """Search depth first all selections that the prices do not exclude.

    A selection costs at least L(π) + Σ_family (reduced cost − the family's least) + Σ π over
    uncovered items, so a family need only try the nodes whose excess is below what is left of
    the gap. Writes a better selection if there is one. Returns its cost, whether the search was
    complete (the cost is then optimal), and how many nodes it visited.
    """
    n_nodes, n_families = component.parent.shape[0], component.must.shape[0]
    priced, reduced = np.empty(n_nodes), np.empty(n_nodes)
    best, choice = np.empty(n_families), np.empty(n_families, dtype=np.int64)
    price_nodes(component, price, priced, reduced)
    choose(component, reduced, choice, best)
    lower = best.sum() - price.sum()
    gap = upper - lower
    # Open nodes of each family in order of excess; -1 stands for taking none.
    start = np.zeros(n_families + 1, dtype=np.int64)
    option, excess = np.empty(n_nodes + n_families, dtype=np.int64), np.empty(n_nodes + n_families)
    fill = 0
    for family in range(n_families):
        first = fill
        if not component.must[family] and -best[family] < gap:
            option[fill], excess[fill] = -1, -best[family]
            fill += 1
        for entry in range(component.start[family], component.start[family + 1]):
            node = component.members[entry]
            if reduced[node] - best[family] < gap:
                option[fill], excess[fill] = node, reduced[node] - best[family]
                fill += 1
        order = np.argsort(excess[first:fill])
        option[first:fill] = option[first:fill][order]
        excess[first:fill] = excess[first:fill][order]
        start[family + 1] = fill
    return _depth_first(component, selection, upper, lower, start, option, excess, max_visits)


@jit
def _depth_first(
    component: Component,
    selection: IntArray,
    upper: float,
    lower: float,
    start: IntArray,
    option: IntArray,
    excess: FloatArray,
    max_visits: int,
) -> tuple[float, bool, int]:
    """Walk the options of ``enumerate_open``; families with fewest options first."""
    n_families = component.must.shape[0]
    order = np.argsort(start[1:] - start[:-1])
    owner = np.full(component.n_items, -1, dtype=np.int64)
    current = np.full(n_families, -1, dtype=np.int64)
    pointer = start[order].copy()
    spent = np.zeros(n_families + 1)
    cost = np.zeros(n_families + 1)
    depth, visits = 0, 0
    while depth >= 0:
        if depth == n_families:
            if cost[depth] < upper - 1e-12:
                upper = cost[depth]
                selection[:] = current
            depth -= 1
            continue
        family = order[depth]
        if current[family] >= 0:
            set_owner(component, current[family], -1, owner)
            current[family] = -1
        if pointer[depth] >= start[family + 1]:
            pointer[depth] = start[family]
            depth -= 1
            continue
        entry = pointer[depth]
        pointer[depth] += 1
        visits += 1
        if visits > max_visits:
            return upper, False, visits
        if lower + spent[depth] + excess[entry] >= upper - 1e-12:
            # Options are in order of excess, so the rest of this family is closed too.
            pointer[depth] = start[family]
            depth -= 1
            continue
        node = option[entry]
        if node >= 0:
            if not is_free(component, node, family, owner):
                continue
            set_owner(component, node, family, owner)
            current[family] = node
        spent[depth + 1] = spent[depth] + excess[entry]
        cost[depth + 1] = cost[depth] + (component.total[node] if node >= 0 else 0.0)
        depth += 1
    return upper, True, visits


@jit
def solve_components(
    parts: Partition,
    first: int,
    last: int,
    price: FloatArray,
    taken: IntArray,
    cost: FloatArray,
    lower: FloatArray,
    budget: DualBudget,
) -> int:
    """Bound and answer the components first … last − 1.

    ``price`` is per item of the partition, ``taken`` per family (a node number within the
    component, or -1), ``cost`` and ``lower`` per component. Returns how many bounds it computed
    and steps of the enumeration it took.
    """
    evaluations = 0
    for index in range(first, last):
        component = part_of(parts, index)
        f0, f1 = parts.family_start[index], parts.family_start[index + 1]
        own_price = price[parts.item_start[index] : parts.item_start[index + 1]]
        selection = taken[f0:f1]
        ascent = begin_ascent(own_price, cost[index], lower[index])
        n = (
            budget.iterations
            if component.parent.shape[0] <= LARGE
            else min(budget.iterations, FEW)
        )
        ascend(component, own_price, selection, ascent, n, n, budget.tolerance)
        upper, bound = ascent.value[0], ascent.value[1]
        evaluations += ascent.iteration[0]
        if upper - bound > budget.tolerance and budget.visits > 0:
            upper, complete, tried = enumerate_open(
                component, own_price, selection, upper, budget.visits
            )
            evaluations += tried
            if complete:
                bound = upper
        cost[index], lower[index] = upper, min(bound, upper)
    return evaluations


@jit
def bound_components(
    parts: Partition, price: FloatArray, taken: IntArray, cost: FloatArray, lower: FloatArray
) -> None:
    """Write what each component's selection costs and the bound at its prices.

    The cost is infinite where a family that must be covered has no node.
    """
    for index in range(cost.shape[0]):
        component = part_of(parts, index)
        n_nodes, n_families = component.parent.shape[0], component.must.shape[0]
        own_price = price[parts.item_start[index] : parts.item_start[index + 1]]
        priced, reduced = np.empty(n_nodes), np.empty(n_nodes)
        best, choice = np.empty(n_families), np.empty(n_families, dtype=np.int64)
        price_nodes(component, own_price, priced, reduced)
        choose(component, reduced, choice, best)
        selection = taken[parts.family_start[index] : parts.family_start[index + 1]]
        cost[index] = selection_cost(component, selection)
        lower[index] = min(best.sum() - own_price.sum(), cost[index])
