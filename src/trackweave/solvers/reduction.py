"""The part of a problem that its bound leaves open, as a smaller problem."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.association.problem import AssignmentProblem
from trackweave.solvers._reduction import DROPPED, FORCED, OPEN, classify
from trackweave.solvers.components import Components

__all__ = ["Reduction"]


@dataclass(frozen=True, slots=True, eq=False)
class Reduction:
    """A smaller problem whose best answer, or what is known already, is best for the whole.

    In ``problem`` sequences that cannot be in a better answer are gone, components too that are
    proven; ``prices`` of its items are to start with. ``node`` and ``item`` are the whole's for
    each that is left, ``forced`` the whole's nodes that every better answer takes; nodes are in
    the order of the whole's partition.
    """

    problem: AssignmentProblem
    prices: FloatArray
    node: IntArray
    item: IntArray
    forced: IntArray

    @classmethod
    def of(cls, components: Components, most: float = 1.0) -> Self | None:
        """Return what the bounds leave open; None if it is more than this part of the nodes."""
        parts = components.parts
        kept, forced = [], []
        total = parts.total.copy()
        for index in np.sort(components.open()).tolist():
            start = int(parts.node_start[index])
            state = classify(
                components.component(index),
                components.price[components.items(index)],
                float(components.cost[index]),
            )
            rows = start + np.flatnonzero((state != DROPPED) & (state != FORCED))
            # A track's own beginning stays open: with it alone there always is an answer.
            is_begin = parts.parent[rows] < 0
            is_begin &= parts.must[parts.family[rows] + parts.family_start[index]]
            total[rows[(state[rows - start] != OPEN) & ~is_begin]] = np.inf
            kept.append(rows)
            forced.append(start + np.flatnonzero(state == FORCED))
        empty = [np.empty(0, dtype=np.int64)]
        node = np.concatenate(kept or empty)
        if node.shape[0] > most * parts.node.shape[0]:
            return None
        problem, prices, item = _subproblem(components, node, total)
        return cls(problem, prices, node, item, np.concatenate(forced or empty))

    def absorb(self, whole: Components, part: Components) -> None:
        """Take the answers and bounds of what is left into the whole, where they are better."""
        parts = whole.parts
        cost, lower = np.zeros(len(whole)), np.zeros(len(whole))
        np.add.at(cost, self._component(whole, self.forced), parts.total[self.forced])
        lower += cost
        first = part.parts.node_start[:-1]
        if len(part):
            home = self._component(whole, self.node[part.parts.node[first]])
            np.add.at(cost, home, part.cost)
            # What is proven of a part, perhaps by whole costs, stays proven in the whole.
            np.add.at(lower, home, part.sure())
        taken = self._taken(part)
        self._absorb_prices(whole, part)
        for index in whole.open().tolist():
            if cost[index] < whole.cost[index]:
                families = whole.families(index)
                whole.taken[families] = -1
                start, end = parts.node_start[index], parts.node_start[index + 1]
                own = taken[(taken >= start) & (taken < end)]
                whole.taken[families.start + parts.family[own]] = own - start
                whole.cost[index] = cost[index]
            # The optimum is that of what is left, or else nothing beats what was known.
            bound = min(lower[index], whole.cost[index])
            whole.lower[index] = max(whole.lower[index], bound)

    def _absorb_prices(self, whole: Components, part: Components) -> None:
        """Give the items that are left the prices that they came to."""
        parts = whole.parts
        place = np.empty(whole.problem.n_items, dtype=np.int64)
        place[parts.item_of] = np.arange(parts.item_of.shape[0])
        whole.price[place[self.item[part.parts.item_of]]] = part.price

    def nodes_left(self, whole: Components, nodes: IntArray) -> IntArray:
        """Return those of the whole problem's nodes that are left, as nodes of what is left."""
        of_problem = whole.parts.node[self.node]
        left: IntArray = np.flatnonzero(np.isin(of_problem, nodes))
        return left

    def _taken(self, part: Components) -> IntArray:
        """Return the whole's nodes, in its partition's order, that part and force take."""
        return np.concatenate([self.node[part.nodes()], self.forced])

    @staticmethod
    def _component(whole: Components, node: IntArray) -> IntArray:
        found: IntArray = np.searchsorted(whole.parts.node_start, node, side="right") - 1
        return found


def _subproblem(
    components: Components, node: IntArray, total: FloatArray
) -> tuple[AssignmentProblem, FloatArray, IntArray]:
    """Return the problem of some nodes, which with each node hold its parent; prices; items."""
    parts, problem = components.parts, components.problem
    component = np.searchsorted(parts.node_start, node, side="right") - 1
    place = np.full(parts.node.shape[0], -1, dtype=np.int64)
    place[node] = np.arange(node.shape[0])
    local = parts.parent[node]
    above = np.where(local >= 0, local + parts.node_start[component], -1)
    old_item = parts.item_of[parts.item[node] + parts.item_start[component]]
    items, item = np.unique(old_item, return_inverse=True)
    price_of = np.zeros(problem.n_items)
    price_of[parts.item_of] = components.price
    return (
        AssignmentProblem(
            parent=np.where(above >= 0, place[above], -1),
            item=item.astype(np.int64),
            cost=problem.cost[parts.node[node]] * components.scale,
            total=total[node],
            must_cover=problem.must_cover[items],
            instant=problem.instant[items],
            unit=1.0,
        ),
        price_of[items],
        items,
    )
