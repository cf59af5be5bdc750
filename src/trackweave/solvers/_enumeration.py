"""Enumeration of the cheapest selections of a component. Nothing here checks or raises.

For prices π ≥ 0 a selection costs exactly L(π) + Σ_family (reduced cost − the family's least) +
Σ π over uncovered items, with L as in ``_pricing``. So only sequences whose excess fits the gap
can be in a selection that cheap.
"""

import math
from typing import NamedTuple

import numpy as np

from trackweave._loops import ascending, largest, overwrite, with_label
from trackweave.arrays import FloatArray, IntArray
from trackweave.association._clusters import find
from trackweave.jit import jit
from trackweave.solvers._kernels import Component, is_free, selection_cost, set_owner
from trackweave.solvers._pricing import bound_at, choices_at


class Options(NamedTuple):
    """What each family can take within a gap.

    The options of family f, in order of excess, are ``node[start[f]:start[f + 1]]``, -1 for
    none, and ``excess`` likewise; only those of families that have a choice. ``fixed`` is what
    the others take. ``group`` tells which families that have a choice can be in each other's
    way: numbered from 0, -1 for the others. ``least`` is each family's least reduced cost, and
    ``further`` the least excess that did not fit the gap.
    """

    start: IntArray
    node: IntArray
    excess: FloatArray
    fixed: IntArray
    group: IntArray
    least: FloatArray
    further: float


class Walk(NamedTuple):
    """Where the enumeration of a group stands.

    ``order`` are the group's families. At each depth: ``pointer`` to the next option,
    ``taken`` node, and ``spent`` excess and ``cost`` before it. The items that no family after
    the one at depth d can cover are ``closing[closing_start[d]:closing_start[d + 1]]``.
    ``kept`` holds a row of nodes for each selection kept, ``kept_cost`` what it costs. ``count``
    holds the depth, the visits so far and the number kept; ``limit`` the bound of the group, the
    greatest cost of interest, and the greatest kept once the rows are full.
    """

    order: IntArray
    pointer: IntArray
    taken: IntArray
    spent: FloatArray
    cost: FloatArray
    closing: IntArray
    closing_start: IntArray
    owner: IntArray
    kept: IntArray
    kept_cost: FloatArray
    tally: IntArray
    limit: FloatArray


MANY = 2_000
"""More families are not arranged by who is in whose way: it takes the square of their number."""


@jit
def open_options(component: Component, price: FloatArray, gap: float) -> Options:
    """Return what each family can take in a selection that costs at most L(π) + gap."""
    n_nodes, n_families = component.parent.shape[0], component.must.shape[0]
    reduced, _, best = choices_at(component, price)
    start = np.zeros(n_families + 1, dtype=np.int64)
    node, excess = np.empty(n_nodes + n_families, dtype=np.int64), np.empty(n_nodes + n_families)
    fill, further = 0, math.inf
    for family in range(n_families):
        first = fill
        if not component.must[family]:
            if -best[family] <= gap:
                node[fill], excess[fill] = -1, -best[family]
                fill += 1
            else:
                further = min(further, -best[family])
        for entry in range(component.start[family], component.start[family + 1]):
            member = component.members[entry]
            if component.total[member] == math.inf:
                continue
            if reduced[member] - best[family] <= gap:
                node[fill], excess[fill] = member, reduced[member] - best[family]
                fill += 1
            else:
                further = min(further, reduced[member] - best[family])
        ranks = ascending(excess[first:fill])
        overwrite(node[first:fill], node[first:fill][ranks])
        overwrite(excess[first:fill], excess[first:fill][ranks])
        start[family + 1] = fill
    fixed = _fix(component, start, node, excess)
    group = _group(component, start, node)
    return Options(start, node, excess, fixed, group, best, further)


@jit
def _fix(component: Component, start: IntArray, node: IntArray, excess: FloatArray) -> IntArray:
    """Take out families with one option, and what is in their way; return what they take.

    Rewrites the options in place.
    """
    n_families = start.shape[0] - 1
    fixed = np.full(n_families, -1, dtype=np.int64)
    is_fixed = np.zeros(n_families, dtype=np.bool_)
    holder = np.full(component.n_items, -1, dtype=np.int64)
    end = start[1:].copy()
    changed = True
    while changed:
        changed = False
        for family in range(n_families):
            if is_fixed[family]:
                continue
            fill = start[family]
            for entry in range(start[family], end[family]):
                if node[entry] < 0 or is_free(component, node[entry], family, holder):
                    node[fill], excess[fill] = node[entry], excess[entry]
                    fill += 1
            end[family] = fill
            if fill - start[family] == 1:
                is_fixed[family] = changed = True
                fixed[family] = node[start[family]]
                set_owner(component, fixed[family], family, holder)
    fill = 0
    for family in range(n_families):
        first = fill
        if not is_fixed[family]:
            for entry in range(start[family], end[family]):
                node[fill], excess[fill] = node[entry], excess[entry]
                fill += 1
        start[family] = first
    start[n_families] = fill
    return fixed


@jit
def _group(component: Component, start: IntArray, node: IntArray) -> IntArray:
    """Return each family's group, those without a choice -1."""
    n_families = start.shape[0] - 1
    leader = np.arange(n_families)
    wants = np.full(component.n_items, -1, dtype=np.int64)
    for family in range(n_families):
        for entry in range(start[family], start[family + 1]):
            climb = node[entry]
            while climb >= 0:
                item = component.item[climb]
                if wants[item] < 0:
                    wants[item] = family
                one, other = find(leader, wants[item]), find(leader, family)
                leader[max(one, other)] = min(one, other)
                climb = component.parent[climb]
    group = np.full(n_families, -1, dtype=np.int64)
    n_groups = 0
    for family in range(n_families):
        if start[family + 1] > start[family]:
            top = find(leader, family)
            if top == family:
                group[family] = n_groups
                n_groups += 1
            group[family] = group[top]
    return group


@jit
def begin_walk(
    component: Component,
    price: FloatArray,
    options: Options,
    families: IntArray,
    most: int,
    by_count: bool = False,
) -> Walk:
    """Return the enumeration of a group's ``most`` cheapest selections before its first step.

    The families come in order of their number of options, or each soon after those in its way.
    """
    n = families.shape[0]
    room = 1.0
    for family in families:
        room = min(room * (options.start[family + 1] - options.start[family]), float(most))
    if by_count:
        count = options.start[families + 1] - options.start[families]
        order = families[ascending(count)]
    else:
        order = _arrange(component, options, families)
    last = np.full(component.n_items, -1, dtype=np.int64)
    for depth in range(n):
        for entry in range(options.start[order[depth]], options.start[order[depth] + 1]):
            climb = options.node[entry]
            while climb >= 0:
                last[component.item[climb]] = depth
                climb = component.parent[climb]
    closing_start = np.zeros(n + 1, dtype=np.int64)
    bound = 0.0
    for family in order:
        bound += options.least[family]
    for item in range(component.n_items):
        if last[item] >= 0:
            closing_start[last[item] + 1] += 1
            bound -= price[item]
    for depth in range(n):
        closing_start[depth + 1] += closing_start[depth]
    closing = np.empty(closing_start[n], dtype=np.int64)
    fill = closing_start[:-1].copy()
    for item in range(component.n_items):
        if last[item] >= 0:
            closing[fill[last[item]]] = item
            fill[last[item]] += 1
    n_rows = int(room)
    return Walk(
        order,
        options.start[order],
        np.full(n, -1, dtype=np.int64),
        np.zeros(n + 1),
        np.zeros(n + 1),
        closing,
        closing_start,
        np.full(component.n_items, -1, dtype=np.int64),
        np.empty((n_rows, n), dtype=np.int64),
        np.empty(n_rows),
        np.zeros(3, dtype=np.int64),
        np.array([bound, math.inf, math.inf]),
    )


@jit
def _arrange(component: Component, options: Options, families: IntArray) -> IntArray:
    """Return the families so that each comes soon after those in its way.

    First the one with fewest options, then always the one of whose items most are wanted before.
    """
    n = families.shape[0]
    start = np.zeros(component.n_items + 1, dtype=np.int64)
    for family in families:
        for entry in range(options.start[family], options.start[family + 1]):
            climb = options.node[entry]
            while climb >= 0:
                start[component.item[climb] + 1] += 1
                climb = component.parent[climb]
    for item in range(component.n_items):
        start[item + 1] += start[item]
    wanting, fill = np.empty(start[-1], dtype=np.int64), start[:-1].copy()
    total, met = np.zeros(n), np.zeros(n)
    for index in range(n):
        for entry in range(options.start[families[index]], options.start[families[index] + 1]):
            climb = options.node[entry]
            while climb >= 0:
                item = component.item[climb]
                wanting[fill[item]] = index
                fill[item] += 1
                total[index] += 1.0
                climb = component.parent[climb]
    order, is_placed = np.empty(n, dtype=np.int64), np.zeros(n, dtype=np.bool_)
    is_met = np.zeros(component.n_items, dtype=np.bool_)
    for place in range(n):
        best, best_score = -1, -math.inf
        for index in range(n):
            score = met[index] / total[index] if place else -total[index]
            if not is_placed[index] and score > best_score:
                best, best_score = index, score
        order[place] = families[best]
        is_placed[best] = True
        for entry in range(options.start[families[best]], options.start[families[best] + 1]):
            climb = options.node[entry]
            while climb >= 0:
                item = component.item[climb]
                if not is_met[item]:
                    is_met[item] = True
                    for index in wanting[start[item] : start[item + 1]]:
                        met[index] += 1.0
                climb = component.parent[climb]
    return order


@jit
def go_on(
    component: Component, price: FloatArray, options: Options, walk: Walk, more: int
) -> bool:
    """Visit up to so many more options depth first; return whether that was all."""
    n = walk.order.shape[0]
    depth, last = walk.tally[0], walk.tally[1] + more
    bound = walk.limit[0]
    while depth >= 0:
        if depth == n:
            _keep(walk, float(walk.cost[n]))
            depth -= 1
            continue
        family = walk.order[depth]
        if walk.taken[depth] >= 0:
            set_owner(component, walk.taken[depth], -1, walk.owner)
            walk.taken[depth] = -1
        entry = walk.pointer[depth]
        ceiling = min(walk.limit[1], walk.limit[2])
        is_over = entry == options.start[family + 1]
        # Options are in order of excess, so when one does not fit the rest do not either.
        if is_over or bound + walk.spent[depth] + options.excess[entry] > ceiling:
            walk.pointer[depth] = options.start[family]
            depth -= 1
            continue
        if walk.tally[1] == last:
            walk.tally[0] = depth
            return False
        walk.tally[1] += 1
        walk.pointer[depth] += 1
        node = options.node[entry]
        total = 0.0
        if node >= 0:
            if not is_free(component, node, family, walk.owner):
                continue
            set_owner(component, node, family, walk.owner)
            total = component.total[node]
        walk.taken[depth] = node
        spent = walk.spent[depth] + options.excess[entry]
        for place in range(walk.closing_start[depth], walk.closing_start[depth + 1]):
            if walk.owner[walk.closing[place]] < 0:
                spent += price[walk.closing[place]]
        if bound + spent <= ceiling:
            walk.spent[depth + 1] = spent
            walk.cost[depth + 1] = walk.cost[depth] + total
            depth += 1
    walk.tally[0] = depth
    return True


@jit
def _keep(walk: Walk, cost: float) -> None:
    """Keep the selection as it stands, in the place of the dearest once the rows are full."""
    n_rows = walk.kept_cost.shape[0]
    row = walk.tally[2]
    if row == n_rows:
        if cost >= walk.limit[2]:
            return
        row = largest(walk.kept_cost)
    else:
        walk.tally[2] += 1
    walk.kept_cost[row] = cost
    overwrite(walk.kept[row], walk.taken)
    if walk.tally[2] == n_rows:
        walk.limit[2] = walk.kept_cost[largest(walk.kept_cost)]


@jit
def enumerate_open(
    component: Component, price: FloatArray, selection: IntArray, upper: float, max_visits: int
) -> tuple[float, bool, int]:
    """Search all selections that the prices do not exclude; write a better one if there is any.

    Returns its cost, whether the search was complete (the cost is then optimal), and how many
    options it visited.
    """
    floor = bound_at(component, price)
    options = open_options(component, price, upper - floor)
    n_groups = 0
    for group in options.group:
        n_groups = max(n_groups, group + 1)
    found, visits, complete, known = options.fixed.copy(), 0, True, math.inf
    # What the groups cost at least is known better with each that is done.
    for group in range(n_groups):
        families = with_label(options.group, group)
        is_over, known = False, math.inf
        for attempt in range(2):
            if is_over or (attempt == 1 and families.shape[0] > MANY):
                break
            # In order of options a good answer comes soon; by who is in whose way, the proof.
            walk = begin_walk(component, price, options, families, 1, attempt == 0)
            walk.limit[1] = walk.limit[0] + upper - floor
            walk.limit[1] = min(walk.limit[1], known)
            share = (max_visits - visits) // 4 if attempt == 0 else max_visits - visits
            is_over = go_on(component, price, options, walk, share)
            visits += walk.tally[1]
            if walk.tally[2] > 0:
                known = walk.kept_cost[0]
                for place in range(families.shape[0]):
                    found[walk.order[place]] = walk.kept[0, place]
        complete = complete and is_over
        if known == math.inf:
            # Nothing within the gap: what is known is best, if that was all.
            return upper, complete, visits
        floor += known - walk.limit[0]
    cost = selection_cost(component, found)
    if cost < upper:
        overwrite(selection, found)
        upper = cost
    return upper, complete, visits
