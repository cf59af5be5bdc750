"""Moves between answers, by items that change hands. Nothing here checks or raises.

A *candidate* is a node that an answer may take. Candidates are numbered by excess: reduced cost
above the least of the family, so that a low number costs little beyond what its items and its
family are worth. An answer is the candidate that holds each item, -1 for none.

A move gives a candidate its items, lets go of those in its way, and lets their items find other
free candidates. Where some remain without, it may go on and force another candidate in for one
of them: an ejection chain [1]_.

References
----------
.. [1] F. Glover, *Ejection chains, reference structures and alternating path methods for
   traveling salesman problems*, 1996. doi:10.1016/0166-218X(94)00037-E
"""

import math
from typing import NamedTuple

import numpy as np

from trackweave._loops import ascending, total_of
from trackweave.arrays import FloatArray, IntArray
from trackweave.jit import jit
from trackweave.solvers._kernels import Component
from trackweave.solvers._pricing import choose, price_nodes

FOCUS = 20
"""Draws before an item that has nothing to gain is taken all the same."""
DRAWS = 3
"""Draws of the candidate that a chain goes on with."""


class Moves(NamedTuple):
    """The candidates of a component, in order of excess.

    Candidate c is node ``node[c]`` at ``cost[c]``, and its items are
    ``item[start[c]:start[c + 1]]``. The candidates with item i are
    ``listed[list_start[i]:list_start[i + 1]]``. ``worth`` is what an item is worth that nothing
    holds, ``anchor`` the candidate that covers it alone where it must be covered, else -1.
    """

    node: IntArray
    cost: FloatArray
    excess: FloatArray
    start: IntArray
    item: IntArray
    list_start: IntArray
    listed: IntArray
    worth: FloatArray
    anchor: IntArray


@jit
def list_moves(component: Component, price: FloatArray, cost: float) -> Moves:
    """Return the candidates that an answer better than ``cost`` may have by these prices."""
    n_nodes, n_families = component.parent.shape[0], component.must.shape[0]
    priced, reduced = np.empty(n_nodes), np.empty(n_nodes)
    best, choice = np.empty(n_families), np.empty(n_families, dtype=np.int64)
    price_nodes(component, price, priced, reduced)
    choose(component, reduced, choice, best)
    limit = cost - (total_of(best) - total_of(price))
    limit += 1e-9 * max(1.0, abs(cost))
    worth = price.copy()
    depth = np.empty(n_nodes, dtype=np.int64)
    kept, n_kept, room = np.empty(n_nodes, dtype=np.int64), 0, 0
    for node in range(n_nodes):
        above, family = component.parent[node], component.family[node]
        depth[node] = 1 if above < 0 else depth[above] + 1
        if above < 0:
            worth[component.item[node]] += max(0.0, -best[family])
        total, must = component.total[node], component.must[family]
        pays = total < 0.0 or (must and total < math.inf)
        if pays and (reduced[node] - best[family] <= limit or (must and above < 0)):
            kept[n_kept] = node
            n_kept += 1
            room += depth[node]
    excess = np.empty(n_kept)
    for place in range(n_kept):
        excess[place] = reduced[kept[place]] - best[component.family[kept[place]]]
    order = ascending(excess)
    node_of, start = kept[:n_kept][order], np.zeros(n_kept + 1, dtype=np.int64)
    item, cost_of = np.empty(room, dtype=np.int64), np.empty(n_kept)
    anchor = np.full(component.n_items, -1, dtype=np.int64)
    count = np.zeros(component.n_items + 1, dtype=np.int64)
    fill = 0
    for candidate in range(n_kept):
        node = node_of[candidate]
        cost_of[candidate] = component.total[node]
        if component.parent[node] < 0 and component.must[component.family[node]]:
            anchor[component.item[node]] = candidate
        while node >= 0:
            item[fill] = component.item[node]
            count[component.item[node] + 1] += 1
            fill += 1
            node = component.parent[node]
        start[candidate + 1] = fill
    list_start = np.cumsum(count)
    place_of, listed = list_start.copy(), np.empty(room, dtype=np.int64)
    for candidate in range(n_kept):
        for entry in range(start[candidate], start[candidate + 1]):
            listed[place_of[item[entry]]] = candidate
            place_of[item[entry]] += 1
    return Moves(
        node_of, cost_of, excess[order], start, item, list_start, listed, worth, anchor
    )  # fmt: skip


@jit
def typical_excess(moves: Moves, rank: int) -> float:
    """Return the median over items of the excess of their candidate of this rank, above 0.

    An item with fewer candidates counts with its last. Where that is 0, the mean excess stands
    in, and 1 where all are 0.
    """
    n_items, count = moves.worth.shape[0], 0
    excess = np.empty(n_items)
    for item in range(n_items):
        first, last = moves.list_start[item], moves.list_start[item + 1]
        if last - first > 1:
            excess[count] = moves.excess[moves.listed[min(first + rank, last) - 1]]
            count += 1
    typical = np.sort(excess[:count])[count // 2] if count > 0 else 0.0
    if typical <= 0.0 and moves.excess.shape[0] > 0:
        typical = moves.excess.mean()
    return typical if typical > 0.0 else 1.0


@jit
def begin_holding(moves: Moves, component: Component, selection: IntArray) -> IntArray:
    """Return which candidate holds each item in a selection; -1 for none."""
    candidate_of = np.full(component.parent.shape[0], -1, dtype=np.int64)
    for candidate in range(moves.node.shape[0]):
        candidate_of[moves.node[candidate]] = candidate
    holder = np.full(component.n_items, -1, dtype=np.int64)
    for node in selection:
        if node >= 0 and candidate_of[node] >= 0:
            hold(moves.start, moves.item, candidate_of[node], candidate_of[node], holder)
    for item in range(component.n_items):
        if moves.anchor[item] >= 0 and holder[item] < 0:
            holder[item] = moves.anchor[item]
    return holder


@jit
def selection_of(
    moves: Moves, component: Component, holder: IntArray, selection: IntArray
) -> None:
    """Write the selection in which each item has this holder."""
    selection[:] = -1
    for candidate in holder:
        if candidate >= 0:
            selection[component.family[moves.node[candidate]]] = moves.node[candidate]


@jit
def cost_of(moves: Moves, holder: IntArray) -> float:
    """Return what an answer costs, added in order of items."""
    cost = 0.0
    for item in range(holder.shape[0]):
        candidate = holder[item]
        if candidate >= 0 and moves.item[moves.start[candidate]] == item:
            cost += moves.cost[candidate]
    return cost


# The helpers below take plain arrays: with tuples of arrays they are not compiled into the loops
# that call them, and each call then counts references.
@jit
def hold(start: IntArray, item: IntArray, candidate: int, value: int, holder: IntArray) -> None:
    """Write ``value`` as the holder of each of the candidate's items."""
    for entry in range(start[candidate], start[candidate + 1]):
        holder[item[entry]] = value


@jit
def first_free(
    start: IntArray,
    item: IntArray,
    listed: IntArray,
    first: int,
    last: int,
    limit: int,
    holder: IntArray,
) -> int:
    """Return the first candidate below ``limit`` in a part of a list that is free; -1 for none."""
    for place in range(first, last):
        candidate = listed[place]
        if candidate >= limit:
            return -1
        free = True
        for entry in range(start[candidate], start[candidate + 1]):
            if holder[item[entry]] >= 0:
                free = False
                break
        if free:
            return int(candidate)
    return -1


@jit
def draw_near(
    excess: FloatArray,
    listed: IntArray,
    first: int,
    last: int,
    window: float,
    rng: np.random.Generator,
) -> int:
    """Draw one of the candidates of a part of a list that are within the window; -1 for none.

    How wide the window is, is drawn from the exponential distribution of this mean.
    """
    limit = -window * math.log(1.0 - rng.random())
    low, high = first, last
    while low < high:
        middle = (low + high) // 2
        if excess[listed[middle]] <= limit:
            low = middle + 1
        else:
            high = middle
    if low == first:
        return -1
    return int(listed[first + int((low - first) * rng.random())])


@jit
def limit_of(excess: FloatArray, window: float, rng: np.random.Generator) -> int:
    """Draw a window as ``draw_near`` does; return the number of candidates within it."""
    return int(np.searchsorted(excess, -window * math.log(1.0 - rng.random()), side="right"))


@jit
def draw_item(
    worth: FloatArray,
    excess: FloatArray,
    scale: float,
    holder: IntArray,
    rng: np.random.Generator,
) -> int:
    """Draw an item, preferring those that do not have all they are worth.

    An answer exceeds the bound by the excess of its candidates and the worth of what it does not
    cover, so a better one has to change some of these.
    """
    n_items = holder.shape[0]
    item = int(n_items * rng.random())
    for _ in range(FOCUS):
        lack = worth[item] if holder[item] < 0 else excess[holder[item]]
        if scale * rng.random() < lack:
            break
        item = int(n_items * rng.random())
    return item


@jit
def log_room(n_items: int, links: int) -> IntArray:
    """Return a log long enough for any move: each link may send off and bring every item."""
    return np.empty(links * (2 * n_items + 1), dtype=np.int64)


@jit
def move(
    cost: FloatArray,
    excess: FloatArray,
    start: IntArray,
    item: IntArray,
    list_start: IntArray,
    listed: IntArray,
    anchor: IntArray,
    forced: int,
    limit: int,
    threshold: float,
    links: int,
    window: float,
    rng: np.random.Generator,
    holder: IntArray,
    idle: IntArray,
    log: IntArray,
) -> tuple[float, int]:
    """Force a candidate in and repair, with a chain of so many links at most.

    Ends at the first link whose change of cost is at most ``threshold``. Candidates below
    ``limit`` repair. Writes to ``log`` what came, and as -1 less its number what went; ``idle``
    is room for every item, see ``log_room``. Returns the change of cost, and the number of
    entries of the log.
    """
    change, entries, n_idle, link = 0.0, 0, 0, 0
    while True:
        for entry in range(start[forced], start[forced + 1]):
            holding = holder[item[entry]]
            if holding >= 0:
                change -= cost[holding]
                log[entries] = -1 - holding
                entries += 1
                for other in range(start[holding], start[holding + 1]):
                    idle[n_idle] = item[other]
                    n_idle += 1
                hold(start, item, holding, -1, holder)
        change += cost[forced]
        hold(start, item, forced, forced, holder)
        log[entries] = forced
        entries += 1
        for place in range(n_idle):
            wanting = idle[place]
            if holder[wanting] >= 0:
                continue
            found = first_free(
                start, item, listed, list_start[wanting], list_start[wanting + 1], limit, holder
            )
            if found < 0:
                found = anchor[wanting]
            if found >= 0:
                change += cost[found]
                hold(start, item, found, found, holder)
                log[entries] = found
                entries += 1
        still = 0
        for place in range(n_idle):
            if holder[idle[place]] < 0:
                idle[still] = idle[place]
                still += 1
        n_idle, link = still, link + 1
        if change <= threshold or link >= links or n_idle == 0:
            break
        forced = next_forced(
            excess, start, item, list_start, listed, window, rng, idle, n_idle, holder, log,
            entries,
        )  # fmt: skip
        if forced < 0:
            break
    return change, entries


@jit
def next_forced(
    excess: FloatArray,
    start: IntArray,
    item: IntArray,
    list_start: IntArray,
    listed: IntArray,
    window: float,
    rng: np.random.Generator,
    idle: IntArray,
    n_idle: int,
    holder: IntArray,
    log: IntArray,
    entries: int,
) -> int:
    """Draw a candidate for an idle item, in the way of which nothing stands that came before."""
    for _ in range(DRAWS):
        wanting = idle[int(n_idle * rng.random())]
        candidate = draw_near(
            excess, listed, list_start[wanting], list_start[wanting + 1], window, rng
        )
        if candidate < 0:
            continue
        stands = True
        for entry in range(start[candidate], start[candidate + 1]):
            holding = holder[item[entry]]
            if holding >= 0:
                for place in range(entries):
                    if log[place] == holding:
                        stands = False
        if stands:
            return candidate
    return -1


@jit
def undo(start: IntArray, item: IntArray, holder: IntArray, log: IntArray, entries: int) -> None:
    """Take back the move with this log."""
    for place in range(entries - 1, -1, -1):
        entry = log[place]
        if entry >= 0:
            hold(start, item, entry, -1, holder)
        else:
            hold(start, item, -1 - entry, -1 - entry, holder)
