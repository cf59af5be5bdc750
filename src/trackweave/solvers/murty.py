"""Murty's partitioning: the cheapest selections of a component by solving parts of it."""

import heapq
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.association.problem import AssignmentProblem, Status
from trackweave.solvers._kernels import Component
from trackweave.solvers._pricing import beyond, excesses
from trackweave.solvers.components import Components
from trackweave.solvers.partial_solutions import PartialSolutions, Piece
from trackweave.solvers.protocol import Hint, Solver, Stop

__all__ = ["Partitioning"]


class _Part(NamedTuple):
    """The selections that begin with a prefix and do not take what is barred next.

    ``prefix`` are the nodes of the first families; ``barred`` are those that the family after
    them may not take, -1 for none. They cost at least ``lower``. ``selection`` is the cheapest
    known and ``key`` its cost; before the part is solved they are None and the bound. ``number``
    settles ties.
    """

    key: float
    number: int
    lower: float
    prefix: IntArray
    barred: frozenset[int]
    selection: IntArray | None


@dataclass(frozen=True, slots=True, eq=False)
class Partitioning:
    """The ranking of a component's selections by partitioning [1]_ [2]_.

    The best selection splits the others into parts: those that share its choices for the first
    families and differ in the next one's. Each part's best is found by a solver, up to ``solves``
    of them; the cheapest is the next selection, and splits its own part.

    References
    ----------
    .. [1] K. G. Murty, *An algorithm for ranking all the assignments in order of increasing
       cost*, 1968. doi:10.1287/opre.16.3.682
    .. [2] E. L. Lawler, *A procedure for computing the K best solutions to discrete optimization
       problems and its application to the shortest path problem*, 1972.
       doi:10.1287/mnsc.18.7.401
    """

    components: Components
    index: int
    solver: Solver
    solves: int
    rng: np.random.Generator
    stop: Stop | None

    def run(self, most: int) -> tuple[PartialSolutions, int]:
        """Return the cheapest selections, at least the known, and how many evaluations it took."""
        known = self.components.taken[self.components.families(self.index)].copy()
        cost, ceiling = self._cost(known), np.inf
        if not self.components.is_closed(self.index, cost):
            ceiling = float(self.components.lower[self.index])
        heap = [_Part(cost, 0, min(cost, ceiling), known[:0], frozenset(), known)]
        found: list[IntArray] = []
        evaluations, solves, number = 0, 0, 1
        while heap and len(found) < most:
            part = heapq.heappop(heap)
            if part.selection is not None:
                found.append(part.selection)
                for child in self._split(part, part.selection):
                    heapq.heappush(heap, child._replace(number=number))
                    number += 1
                continue
            if solves == self.solves or (self.stop is not None and self.stop()):
                heapq.heappush(heap, part)
                break
            selection, lower, tried = self._solve(part)
            solves, evaluations = solves + 1, evaluations + tried
            if selection is not None:
                cost = self._cost(selection)
                solved = part._replace(key=cost, lower=min(cost, lower), selection=selection)
                heapq.heappush(heap, solved)
            if selection is None or lower < cost:
                ceiling = min(ceiling, lower)
        ceiling = min([ceiling, *(part.lower for part in heap)])
        # What is known besides may be dear, but is better than nothing.
        found += [part.selection for part in sorted(heap) if part.selection is not None]
        return self._pieces(found[:most], ceiling), evaluations

    @property
    def _component(self) -> Component:
        return self.components.component(self.index)

    @property
    def _price(self) -> FloatArray:
        return self.components.price[self.components.items(self.index)]

    def _cost(self, selection: IntArray) -> float:
        return float(self._component.total[selection[selection >= 0]].sum())

    def _pieces(self, found: list[IntArray], ceiling: float) -> PartialSolutions:
        """Return selections, all different, as the pieces of the component."""
        cost = np.array([self._cost(selection) for selection in found])
        ranks = np.argsort(cost, kind="stable")
        families = np.arange(found[0].shape[0])
        piece = Piece(families, np.stack(found)[ranks], cost[ranks])
        return PartialSolutions((piece,), ceiling, bool(np.isinf(ceiling)))

    def _split(self, part: _Part, selection: IntArray) -> Iterator[_Part]:
        """Return the parts into which a selection splits the others of its own part."""
        component = self._component
        spent, excess, none = excesses(component, self._price)
        for family in range(part.prefix.shape[0], selection.shape[0]):
            own = int(selection[family])
            is_first = family == part.prefix.shape[0]
            barred = frozenset({own}) | (part.barred if is_first else frozenset())
            members = component.members[component.start[family] : component.start[family + 1]]
            left = [float(excess[node]) for node in members.tolist() if node not in barred]
            if -1 not in barred:
                left.append(float(none[family]))
            least = spent + min(left, default=np.inf)
            if np.isfinite(least):
                lower = max(least, part.lower)
                yield _Part(lower, 0, lower, selection[:family], barred, None)
            spent += float(excess[own] if own >= 0 else none[family])

    def _solve(self, part: _Part) -> tuple[IntArray | None, float, int]:
        """Return the best found in a part, a bound, and how many evaluations it took."""
        component, first = self._component, part.prefix.shape[0]
        is_left = beyond(component, part.prefix)
        total, offset = component.total.copy(), 0.0
        penalty = 2.0 * float(np.abs(total[np.isfinite(total)]).sum()) + 1.0
        for node in part.barred - {-1}:
            # A track's beginning has to stay, at a price that only who must will pay.
            is_begin = component.must[first] and component.parent[node] < 0
            total[node] = total[node] + penalty if is_begin else np.inf
        if -1 in part.barred:
            total[component.family == first] -= penalty
            offset = penalty
        nodes = np.flatnonzero(is_left)
        problem = self._problem(nodes, total)
        known = self.components.taken[self.components.families(self.index)]
        hint = Hint(self._price, np.flatnonzero(np.isin(nodes, known)))
        answer = self.solver(problem, rng=self.rng, hint=hint, stop=self.stop)
        selection = np.full(component.must.shape[0], -1)
        selection[:first] = part.prefix
        selection[component.family[nodes[answer.nodes]]] = nodes[answer.nodes]
        is_proven = answer.status is Status.OPTIMAL
        if int(selection[first]) in part.barred:
            return None, np.inf if is_proven else part.lower, answer.evaluations
        lower = self._cost(part.prefix) + answer.lower_bound + offset
        return selection, self._cost(selection) if is_proven else lower, answer.evaluations

    def _problem(self, nodes: IntArray, total: FloatArray) -> AssignmentProblem:
        """Return the problem of some of the component's nodes, with other totals."""
        component, whole, parts = self._component, self.components.problem, self.components.parts
        place = np.full(component.parent.shape[0] + 1, -1)
        place[nodes] = np.arange(nodes.shape[0])
        is_begin = (component.parent[nodes] < 0) & component.must[component.family[nodes]]
        must_cover = np.zeros(component.n_items, dtype=np.bool_)
        must_cover[component.item[nodes[is_begin]]] = True
        return AssignmentProblem(
            parent=place[component.parent[nodes]],
            item=component.item[nodes],
            cost=whole.cost[parts.node[parts.node_start[self.index] + nodes]]
            * self.components.scale,
            total=total[nodes],
            must_cover=must_cover,
            instant=whole.instant[parts.item_of[self.components.items(self.index)]],
            unit=1.0,
        )
