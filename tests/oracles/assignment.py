"""Exhaustive optima of small assignment problems, and makers of random ones."""

from dataclasses import replace
from functools import cache

import numpy as np

from trackweave.association.problem import AssignmentProblem

Sequence = tuple[int, ...]


def sequence(problem: AssignmentProblem, node: int) -> Sequence:
    """Return the items of a node's sequence, the first first."""
    items: list[int] = []
    while node >= 0:
        items.insert(0, int(problem.item[node]))
        node = int(problem.parent[node])
    return tuple(items)


def in_ones(problem: AssignmentProblem) -> AssignmentProblem:
    """Return the same problem, of which no cost is scaled when it is taken apart."""
    return replace(problem, unit=1.0)


def least_cost(problem: AssignmentProblem) -> float:
    """Return the optimum, infinite where nothing covers all that has to be covered."""
    needed = set(np.flatnonzero(problem.must_cover).tolist())
    if problem.requirement is not None:
        needed |= set(problem.requirement.item.tolist())
    beginning: dict[int, list[tuple[int, float]]] = {}
    for node in np.flatnonzero(np.isfinite(problem.total)).tolist():
        items = sequence(problem, node)
        mask = sum(1 << item for item in items)
        beginning.setdefault(min(items), []).append((mask, float(problem.total[node])))

    # What the items from one on cost at least, given which are covered already.
    @cache
    def onwards(item: int, covered: int) -> float:
        if item == problem.n_items:
            return 0.0
        if covered >> item & 1:
            return onwards(item + 1, covered)
        best = np.inf if item in needed else onwards(item + 1, covered)
        for mask, cost in beginning.get(item, []):
            if not mask & covered:
                best = min(best, cost + onwards(item + 1, covered | mask))
        return best

    return float(problem.base_cost + onwards(0, 0))


def all_hypotheses(problem: AssignmentProblem) -> list[tuple[float, Sequence]]:
    """Return the cost and the nodes of every answer that keeps the rules, the cheapest first."""
    root = list(range(problem.n_nodes))
    for node in range(problem.n_nodes):
        if problem.parent[node] >= 0:
            root[node] = root[int(problem.parent[node])]
    families = [node for node in range(problem.n_nodes) if root[node] == node]
    required = set(np.flatnonzero(problem.must_cover).tolist())
    if problem.requirement is not None:
        required |= set(problem.requirement.item.tolist())
    found = []

    def descend(index: int, used: frozenset[int], nodes: Sequence) -> None:
        if index == len(families):
            if required <= used:
                cost = problem.base_cost + float(problem.total[list(nodes)].sum())
                found.append((cost, tuple(sorted(nodes))))
            return
        descend(index + 1, used, nodes)
        for node in range(problem.n_nodes):
            if root[node] != families[index] or np.isinf(problem.total[node]):
                continue
            items = frozenset(sequence(problem, node))
            if not items & used:
                descend(index + 1, used | items, (*nodes, node))

    descend(0, frozenset(), ())
    return sorted(found)


def least_cost_of_tuples(
    tuples: np.ndarray, costs: np.ndarray, alone: float | np.ndarray = 0.0
) -> float:
    """Return the optimum of tuples straight from their definition: each item once or alone."""
    items = [(s, v) for s in range(tuples.shape[1]) for v in range(1, tuples[:, s].max() + 1)]
    price = dict(zip(items, np.broadcast_to(alone, len(items)).tolist(), strict=True))
    rows = []
    singles: dict[tuple[int, int], float] = {}
    for row, cost in zip(tuples.tolist(), costs.tolist(), strict=True):
        taken = {(s, v) for s, v in enumerate(row) if v > 0}
        if len(taken) == 1:
            item = taken.pop()
            singles[item] = min(cost, singles.get(item, np.inf))
        else:
            rows.append((taken, cost))
    price.update(singles)
    best = np.inf

    def descend(index: int, free: set[tuple[int, int]], cost: float) -> None:
        nonlocal best
        if index == len(rows):
            best = min(best, cost + sum(price[item] for item in free))
            return
        taken, own = rows[index]
        if taken <= free:
            descend(index + 1, free - taken, cost + own)
        descend(index + 1, free, cost)

    descend(0, set(items), 0.0)
    return float(best)


def random_tuples(
    rng: np.random.Generator, n_rows: int, *, scale: float = 3.0
) -> tuple[np.ndarray, np.ndarray]:
    """Return up to so many tuples over two to four lists of one to four items, with costs."""
    size = rng.integers(1, 5, rng.integers(2, 5))
    table = rng.integers(0, size + 1, (n_rows, size.shape[0]))
    table = table[table.any(axis=1)]
    if not table.shape[0]:
        table = np.ones((1, size.shape[0]), dtype=np.int64)
    return table, scale * rng.normal(-0.6, 1.0, table.shape[0])


def random_window(
    rng: np.random.Generator, *, n_tracks: int = 2, n_reports: int = 7, max_nodes: int = 26
) -> AssignmentProblem:
    """Return a forest such as a tracker's: scans of reports, tracks from before.

    Some instants hold scans of two sensors; their items have one rank and may follow each other
    in the order of their numbers. Costs belong to sets of items; some sequences may not end.
    """
    scan = np.sort(rng.integers(0, 4, n_reports))
    instant = np.array([0, 0, 1, 2])[scan] if rng.random() < 0.5 else scan
    parent, item, cost = [], [], []
    for track in range(n_tracks):
        parent.append(-1)
        item.append(n_reports + track)
        cost.append(float(rng.normal(0.5, 0.5)))
    for report in rng.permutation(n_reports)[: n_reports - 1].tolist():
        parent.append(-1)
        item.append(report)
        cost.append(float(rng.normal(1.5, 1.0)))
    while len(parent) < max_nodes:
        above = int(rng.integers(0, len(parent)))
        later = [
            report
            for report in range(n_reports)
            if item[above] >= n_reports or scan[report] > scan[item[above]]
        ]
        twins = [item[node] for node in range(len(parent)) if parent[node] == above]
        free = [report for report in later if report not in twins]
        if not free:
            max_nodes -= 1
            continue
        parent.append(above)
        item.append(free[int(rng.integers(0, len(free)))])
        cost.append(cost[above] + float(rng.normal(-2.0, 2.0)))
    total = np.array(cost) + rng.exponential(0.3, len(cost))
    is_inner = np.array(parent) >= 0
    total[is_inner & (rng.random(len(cost)) < 0.15)] = np.inf
    return AssignmentProblem(
        parent=np.array(parent),
        item=np.array(item),
        cost=np.array(cost),
        total=total,
        must_cover=np.arange(n_reports + n_tracks) >= n_reports,
        instant=np.concatenate([instant, np.full(n_tracks, -1)]),
        base_cost=float(rng.normal()),
    )


def random_problem(rng: np.random.Generator) -> AssignmentProblem:
    """Return a small problem of either kind."""
    if rng.random() < 0.5:
        return AssignmentProblem.from_tuples(*random_tuples(rng, 14))
    return random_window(rng, n_tracks=int(rng.integers(0, 4)))


def random_required(rng: np.random.Generator, *, whole: bool = False) -> AssignmentProblem:
    """Return a dense problem of two or three lists, most of whose items have to be covered.

    Some entries are not allowed, so that there may be no answer.
    """
    shape = (int(rng.integers(1, 5)),) * int(rng.integers(2, 4))
    if rng.random() < 0.3:
        shape = tuple(rng.integers(1, 4, 3).tolist())
    costs = rng.normal(0.0, 5.0, shape)
    costs = np.round(costs) if whole else costs
    costs[rng.random(shape) < rng.choice([0.0, 0.2, 0.5, 0.8])] = np.inf
    alone = np.full(sum(shape), np.inf)
    if rng.random() < 0.5:
        may_be_left = rng.random(alone.shape[0]) < 0.4
        alone[may_be_left] = np.round(rng.normal(0.0, 4.0, np.count_nonzero(may_be_left)))
    return AssignmentProblem.from_array(costs, alone=alone)


def rounded(problem: AssignmentProblem) -> AssignmentProblem:
    """Return a problem with whole costs."""
    return replace(problem, cost=np.round(problem.cost), total=np.round(problem.total))


def hard_tuples(seed: int, n_rows: int, n_items: int) -> AssignmentProblem:
    """Return a dense problem of four lists whose bound stays open without branching."""
    rng = np.random.default_rng(seed)
    rows = rng.integers(1, n_items + 1, (n_rows, 4))
    return AssignmentProblem.from_tuples(rows, rng.normal(-5.0, 1.0, n_rows))
