"""A problem under the dual: bounds, answers, and the ever smaller problems they leave open."""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from trackweave.arrays import FloatArray, IntArray, int_array
from trackweave.association.problem import Answer, AssignmentProblem
from trackweave.errors import InvalidInputError
from trackweave.solvers._dual import bound_components
from trackweave.solvers._reduction import DROPPED, FORCED, OPEN, classify
from trackweave.solvers.components import Components
from trackweave.solvers.protocol import Hint

__all__ = ["Reduction", "Relaxation"]


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


WORTHWHILE = 0.9
"""A reduction that leaves more of the nodes than this would cost more time than it saves."""


@dataclass(frozen=True, slots=True, eq=False)
class Relaxation:
    """A problem taken apart, and what reductions left of it.

    ``levels`` are the components of the problem, then those of each of the ``reductions`` of the
    level before, with the best known answers and bounds.
    """

    levels: tuple[Components, ...]
    reductions: tuple[Reduction, ...] = ()

    @classmethod
    def of(cls, problem: AssignmentProblem, hint: Hint | None, *, whole: bool = False) -> Self:
        """Take a problem apart, or take it as one; nothing is chosen yet, no bound is known."""
        components = Components.of(problem, hint, whole=whole)
        if hint is not None and hint.nodes is not None:
            nodes = int_array(hint.nodes, "hint.nodes", (None,))
            if np.any((nodes < 0) | (nodes >= problem.n_nodes)):
                raise InvalidInputError(
                    f"hint.nodes: expected numbers from 0 to {problem.n_nodes - 1}"
                )
        return cls((components,))

    @property
    def rest(self) -> Components:
        """What is left to be solved."""
        return self.levels[-1]

    def reduced(self) -> Self:
        """Return the relaxation with one more level, what bounds leave open, if that is less."""
        # What is left keeps the best known answers: prices never exclude them.
        reduction = Reduction.of(self.rest, WORTHWHILE)
        if reduction is None:
            return self
        rest = Components.of(reduction.problem, Hint(prices=reduction.prices))
        rest.taken[:] = rest.selection_of(reduction.nodes_left(self.rest, self.rest.nodes()))
        bound_components(rest.parts, rest.price, rest.taken, rest.cost, rest.lower)
        return replace(self, levels=(*self.levels, rest), reductions=(*self.reductions, reduction))

    def with_rest(self, rest: Components) -> Self:
        """Return the relaxation with other answers and bounds of the rest."""
        return replace(self, levels=(*self.levels[:-1], rest))

    def left_of(self, hint: Hint | None) -> IntArray | None:
        """Return the selection of the rest that a hint's answer comes to; None without one."""
        if hint is None or hint.nodes is None:
            return None
        nodes = np.asarray(hint.nodes, dtype=np.int64)
        for level, reduction in zip(self.levels, self.reductions, strict=False):
            nodes = reduction.nodes_left(level, nodes)
        return self.rest.selection_of(nodes)

    def whole(self) -> Components:
        """Return the problem's components with the best of all levels."""
        part = self.rest
        pairs = list(zip(self.levels, self.reductions, strict=False))
        for level, reduction in reversed(pairs):
            merged = level.copy()
            reduction.absorb(merged, part)
            part = merged
        return part if pairs else part.copy()

    def answer(self, evaluations: int, stop_reason: str) -> Answer:
        """Return the whole problem's answer; the reason counts where the gap is not closed."""
        whole = self.whole()
        closed = whole.open().size == 0
        return whole.answer(evaluations, "gap closed" if closed else stop_reason)
