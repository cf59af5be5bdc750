"""Which sequences of a tree stay. Nothing here checks or raises."""

import math
from typing import NamedTuple

import numpy as np

from trackweave._loops import kth_least
from trackweave.arrays import FloatArray, IntArray
from trackweave.association._nodes import Candidates, Nodes
from trackweave.jit import jit


@jit
def accumulate_prices(nodes: Nodes, n_nodes: int, priced_out: FloatArray) -> None:
    """Write the sum of the prices along each sequence."""
    for node in range(n_nodes):
        above = nodes.parent[node]
        priced_out[node] = nodes.price[node] + (priced_out[above] if above >= 0 else 0.0)


@jit
def rank_offer(
    nodes: Nodes, candidates: Candidates, tail: FloatArray, is_new: np.ndarray, end_cost: float
) -> tuple[IntArray, IntArray, FloatArray, FloatArray, FloatArray]:
    """Return the columns of ``pruning.Offer``."""
    n_old, n_new = tail.shape[0], candidates.node.shape[0]
    family, parent = np.empty(n_old + n_new, dtype=np.int64), np.empty(n_old + n_new, np.int64)
    alive, rank, priced = np.empty(n_old), np.empty(n_old + n_new), np.empty(n_old)
    accumulate_prices(nodes, n_old, priced)
    # No beliefs speak of the scan's own reports yet. Without a price two objects beside each
    # other both rank best with the same report, and forget how it is to go without.
    without = np.empty(is_new.shape[0])
    for own in range(is_new.shape[0]):
        without[own] = 0.0 if is_new[own] else math.inf
    for node in range(n_old):
        own = family[node] = nodes.family[node]
        parent[node] = nodes.parent[node]
        alive[node] = nodes.cost[node] + tail[node] + priced[node]
        rank[node] = nodes.cost[node] + min(tail[node], end_cost) + priced[node]
        without[own] = min(without[own], rank[node])
    n_reports = 0
    for entry in range(n_new):
        above = candidates.node[entry]
        family[n_old + entry], parent[n_old + entry] = nodes.family[above], above
        rank[n_old + entry] = candidates.cost[entry] + priced[above]
        n_reports = max(n_reports, candidates.report[entry] + 1)
    worth = second_gains(family[n_old:], candidates.report, rank[n_old:], without, n_reports)
    price = np.empty(n_new)
    for entry in range(n_new):
        price[entry] = worth[candidates.report[entry]]
        rank[n_old + entry] += price[entry]
    return family, parent, alive, rank, price


@jit
def hold_out(
    group: IntArray, family: IntArray, parent: IntArray, alive: FloatArray, rank: FloatArray,
    bound: FloatArray, room: IntArray, believed: np.ndarray,
) -> tuple[FloatArray, np.ndarray, np.ndarray]:  # fmt: skip
    """Return by how much each ranks behind its group's bound, if it stays, and may live unseen."""
    n_old = alive.shape[0]
    excess, is_open = np.empty(rank.shape[0]), np.empty(n_old, dtype=np.bool_)
    for entry in range(rank.shape[0]):
        excess[entry] = rank[entry] - bound[group[entry]]
    part_ties(group, excess, room)
    # What begins stays whatever the cap, and of each track how it may live on unseen.
    for node in range(n_old):
        is_open[node] = alive[node] <= bound[group[node]]
        if parent[node] < 0:
            excess[node] = -math.inf
    best = best_of(family[:n_old], alive, believed.shape[0])
    for own in range(believed.shape[0]):
        if believed[own] and best[own] >= 0:
            excess[best[own]], is_open[best[own]] = -math.inf, True
    kept = excess <= 0.0
    keep_ancestors(parent, kept.shape[0], kept)
    return excess, kept, is_open


@jit
def rank_bounds(
    family: IntArray, rank: FloatArray, margin: FloatArray, keep: IntArray, ceiling: FloatArray
) -> FloatArray:
    """Return for each family the worst rank that it keeps.

    That is its best plus its margin, or its k-th best rank if that is less, and never more than
    its ceiling.
    """
    n_families = margin.shape[0]
    start = np.zeros(n_families + 1, dtype=np.int64)
    for entry in range(family.shape[0]):
        start[family[entry] + 1] += 1
    for index in range(n_families):
        start[index + 1] += start[index]
    fill = start[:-1].copy()
    grouped = np.empty(rank.shape[0])
    for entry in range(family.shape[0]):
        grouped[fill[family[entry]]] = rank[entry]
        fill[family[entry]] += 1
    bound = np.empty(n_families)
    for index in range(n_families):
        own = grouped[start[index] : start[index + 1]]
        best = math.inf
        for value in own:
            best = min(best, value)
        bound[index] = min(best + margin[index], ceiling[index])
        if own.shape[0] > keep[index]:
            bound[index] = min(bound[index], kth_least(own, keep[index] - 1))
    return bound


@jit
def part_ties(group: IntArray, excess: FloatArray, keep: IntArray) -> None:
    """Give excess to the later of those at their group's bound that are too many, in place.

    Without it a thousand equal reports would all be kept: no rank tells them apart.
    """
    room = keep.copy()
    for entry in range(group.shape[0]):
        if excess[entry] < 0.0:
            room[group[entry]] -= 1
    for entry in range(group.shape[0]):
        if excess[entry] == 0.0:
            room[group[entry]] -= 1
            if room[group[entry]] < 0:
                excess[entry] = math.inf


@jit
def behind_best(group: IntArray, rank: FloatArray, is_new: np.ndarray) -> FloatArray:
    """Return how far each rank lies behind the best of its group.

    An object that begins in the window may also not exist, which ranks 0.
    """
    best = np.full(is_new.shape[0], math.inf)
    for number in range(is_new.shape[0]):
        if is_new[number]:
            best[number] = 0.0
    for entry in range(group.shape[0]):
        best[group[entry]] = min(best[group[entry]], rank[entry])
    behind = np.empty(group.shape[0])
    for entry in range(group.shape[0]):
        behind[entry] = rank[entry] - best[group[entry]]
    return behind


@jit
def best_of(family: IntArray, rank: FloatArray, count: int) -> IntArray:
    """Return the entry of the least rank of each family, the first of equals.

    -1 for a family that has no entry with a finite one.
    """
    best = np.full(count, -1)
    for entry in range(family.shape[0]):
        own = family[entry]
        if rank[entry] < (rank[best[own]] if best[own] >= 0 else math.inf):
            best[own] = entry
    return best


@jit
def second_gains(
    family: IntArray, report: IntArray, rank: FloatArray, without: FloatArray, n_reports: int
) -> FloatArray:
    """Return what each report is worth to the family that gains second most by it, at least 0.

    A family gains by how much its best rank ``without`` a report lies above that with this one.
    """
    most, second = np.zeros(n_reports), np.zeros(n_reports)
    winner = np.full(n_reports, -1)
    for entry in range(family.shape[0]):
        own, index = family[entry], report[entry]
        gain = without[own] - rank[entry]
        if own == winner[index]:
            most[index] = max(most[index], gain)
        elif gain > most[index]:
            second[index], most[index], winner[index] = most[index], gain, own
        else:
            second[index] = max(second[index], gain)
    return second


@jit
def keep_ancestors(parent: IntArray, n_nodes: int, keep: np.ndarray) -> None:
    """Mark every ancestor of a marked node."""
    for node in range(n_nodes - 1, -1, -1):
        if keep[node] and parent[node] >= 0:
            keep[parent[node]] = True


@jit
def sum_below(parent: IntArray, value: FloatArray) -> FloatArray:
    """Return for each node the sum of its own value and those of all its descendants."""
    total = value.copy()
    for node in range(parent.shape[0] - 1, -1, -1):
        if parent[node] >= 0:
            total[parent[node]] += total[node]
    return total


@jit
def forget_least(
    order: IntArray, parent: IntArray, family: IntArray, probability: FloatArray,
    kept: np.ndarray, forgotten: FloatArray, most: float,
) -> None:  # fmt: skip
    """Mark as kept, besides those marked, all but the least probable nodes of each family.

    In ``order`` every node stands before its parent, and a parent stays if a child does. How
    much of each family is ``forgotten``, at most ``most``, is written.
    """
    for node in order:
        own = family[node]
        gone = forgotten[own] + probability[node]
        if not kept[node] and gone <= most:
            forgotten[own] = gone
        else:
            kept[node] = True
            if parent[node] >= 0:
                kept[parent[node]] = True


@jit
def raise_ancestors(parent: IntArray, value: FloatArray) -> None:
    """Give every ancestor at most the value of its descendants, in place."""
    for node in range(parent.shape[0] - 1, -1, -1):
        if parent[node] >= 0:
            value[parent[node]] = min(value[parent[node]], value[node])


@jit
def keep_below(nodes: Nodes, n_nodes: int, root: IntArray, n_fixed: int) -> np.ndarray:
    """Mark what goes on when the slots below ``n_fixed`` are fixed.

    Below a family's root, what takes only later reports; of a family without a root, everything
    if its first report is later.
    """
    keep = np.zeros(n_nodes, dtype=np.bool_)
    for node in range(n_nodes):
        own = root[nodes.family[node]]
        above = nodes.parent[node]
        if own >= 0:
            keep[node] = node == own or (
                above >= 0 and keep[above] and nodes.report[node] >= n_fixed
            )
        else:
            keep[node] = keep[above] if above >= 0 else nodes.report[node] >= n_fixed
    return keep


@jit
def crossings(parent: IntArray, is_line: IntArray, family: IntArray, n_families: int) -> IntArray:
    """Return the group of each sequence: its family, or a new number below each child of a line.

    ``is_line`` is of the first sequences; those after them are nobody's parents.
    """
    group = family.copy()
    count = n_families
    for node in range(parent.shape[0]):
        above = parent[node]
        if above < 0:
            continue
        if is_line[above] == 1:
            group[node] = count
            count += 1
        else:
            group[node] = group[above]
    return group


class Cut(NamedTuple):
    """What a tree left out at its last scan.

    ``above`` is the node that a sequence goes on from, or ~k where that is the k-th of these
    itself, and ``report`` the slot of its own report beyond it, -1 for none. ``log_weight`` is of
    the sequence without any prices, or of the part of it that was left out.
    """

    family: IntArray
    above: IntArray
    report: IntArray
    log_weight: FloatArray


@jit
def add_above(above: IntArray, priced: FloatArray, along: FloatArray) -> None:
    """Add to the price of each sequence's own report those of the reports before it, in place."""
    for entry in range(above.shape[0]):
        before = above[entry]
        along[entry] += priced[before] if before >= 0 else along[~before]
