"""The patent's own fitness as a problem: each report that joins nothing is a track of its own."""

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from trackweave.arrays import IntArray
from trackweave.association.growth_limits import GrowthLimits
from trackweave.association.problem import Answer, AssignmentProblem
from trackweave.config.search import make_solver
from trackweave.presets import hillis_1997
from trackweave.solvers import Exact, Genetic
from trackweave.solvers.components import Components
from trackweave.solvers.genetic._decoding import decode_permutation
from trackweave.solvers.genetic.report_genes import fresh_trail, make_lookup
from trackweave.solvers.protocol import Hint, Solver, Stop

__all__ = [
    "BestHypothesis",
    "Recorded",
    "alone_as_tracks",
    "decoded",
    "document_growth",
    "document_search",
    "sequence",
]


def document_search() -> Genetic:
    """Return the genetic search of the patent's preset."""
    search: Genetic = make_solver(hillis_1997.CONFIGURATION["search"])
    return search


def document_growth() -> GrowthLimits:
    """Return the preset's bounds on the number of sequences."""
    return GrowthLimits(**hillis_1997.CONFIGURATION["growth"])


def sequence(problem: AssignmentProblem, node: int) -> tuple[int, ...]:
    """Return the items of a sequence in order."""
    items = []
    while node >= 0:
        items.append(int(problem.item[node]))
        node = int(problem.parent[node])
    return tuple(reversed(items))


def _lone(problem: AssignmentProblem) -> IntArray:
    """Return the node that stands for each item as a track of its own, -1 where there is none."""
    lone = np.full(problem.n_items, -1, dtype=np.int64)
    roots = np.flatnonzero((problem.parent < 0) & np.isfinite(problem.total))
    lone[problem.item[roots]] = roots
    lone[problem.must_cover] = -1
    return lone


def alone_as_tracks(problem: AssignmentProblem) -> AssignmentProblem:
    """Return the problem in which an item that no sequence takes is a track of its own."""
    # What such tracks cost is in the base cost, and each sequence saves those of its items: so
    # costs of answers are those of the patent's hypotheses, in which every report is in a track.
    lone = _lone(problem)
    price = np.where(lone >= 0, problem.total[lone], 0.0)
    saved = price[problem.item]
    for node in range(problem.n_nodes):
        above = problem.parent[node]
        if above >= 0:
            saved[node] += saved[above]
    return replace(
        problem,
        cost=problem.cost - saved,
        total=problem.total - saved,
        base_cost=problem.base_cost + float(price.sum()),
    )


@dataclass(frozen=True, slots=True)
class BestHypothesis:
    """The best there is by the patent's own fitness, proven: what its search looks for."""

    def __call__(
        self,
        problem: AssignmentProblem,
        *,
        rng: np.random.Generator,
        hint: Hint | None = None,
        stop: Stop | None = None,
    ) -> Answer:
        """Return the answer, every report in a track; see ``Solver``."""
        answer = Exact()(alone_as_tracks(problem), rng=rng, stop=stop)
        lone = _lone(problem)
        for node in answer.nodes.tolist():
            lone[list(sequence(problem, node))] = -1
        nodes = np.union1d(answer.nodes, lone[lone >= 0])
        return replace(answer, nodes=nodes, prices=np.zeros(problem.n_items))


@dataclass(slots=True)
class Recorded:
    """A solver that keeps what it was asked and what it said."""

    solver: Solver
    problems: list[AssignmentProblem] = field(default_factory=list)
    answers: list[Answer] = field(default_factory=list)

    def __call__(self, problem: AssignmentProblem, **given: Any) -> Answer:
        """Return the solver's answer; see ``Solver``."""
        self.problems.append(problem)
        self.answers.append(self.solver(problem, **given))
        return self.answers[-1]


def decoded(problem: AssignmentProblem, order: list[int]) -> tuple[float, set[tuple[int, ...]]]:
    """Return the hypothesis that a permutation of all items stands for."""
    parts = Components.of(problem, None, whole=True)
    component, node, item = parts.component(0), parts.parts.node, parts.parts.item_of
    lookup = make_lookup(component, problem.cost[node], problem.instant[item], False)
    place = np.empty(problem.n_items, dtype=np.int64)
    place[item] = np.arange(item.shape[0])
    trail = fresh_trail(component, len(order))
    selection = np.empty_like(trail.current)
    cost = decode_permutation(component, lookup, place[order], trail, selection)
    taken = node[selection[selection >= 0]]
    return float(cost) + problem.base_cost, {sequence(problem, last) for last in taken.tolist()}
