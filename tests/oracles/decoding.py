"""The patent's decoding, slow and obvious: tracks are sets of items."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from oracles.assignment import in_ones, sequence
from trackweave.association.problem import AssignmentProblem
from trackweave.solvers._kernels import Component
from trackweave.solvers.components import Components
from trackweave.solvers.genetic._decoding import Lookup, Trail, begin, decode_permutation
from trackweave.solvers.genetic.report_genes import make_lookup

Hypothesis = set[tuple[int, ...]]


@dataclass(frozen=True)
class Decoder:
    """A problem taken as one component, and the way back from its numbers."""

    problem: AssignmentProblem
    parts: Components
    component: Component
    lookup: Lookup

    @classmethod
    def of(cls, problem: AssignmentProblem, *, settle: bool) -> "Decoder":
        parts = Components.of(in_ones(problem), None, whole=True)
        component = parts.component(0)
        node, item = parts.parts.node, parts.parts.item_of
        lookup = make_lookup(component, problem.cost[node], problem.instant[item], settle)
        return cls(problem, parts, component, lookup)

    def genes(self, items: Sequence[int]) -> np.ndarray:
        """Return the problem's items by their numbers in the component."""
        place = {int(item): index for index, item in enumerate(self.parts.parts.item_of)}
        return np.array([place[item] for item in items], dtype=np.int64)

    def items(self) -> list[int]:
        """Return the problem's items that genes decide, in order of time."""
        return self.parts.parts.item_of[self.lookup.gene_item].tolist()

    def trail(self) -> Trail:
        current = np.empty(self.component.must.shape[0], dtype=np.int64)
        begin(self.component, current)
        room = np.full((5, self.lookup.gene_item.shape[0]), -7)
        return Trail(*room, current, np.zeros(1, dtype=np.int64))

    def hypothesis(self, selection: np.ndarray) -> Hypothesis:
        nodes = self.parts.parts.node[selection[selection >= 0]]
        return {sequence(self.problem, int(node)) for node in nodes}

    def decode(self, items: Sequence[int], trail: Trail | None = None) -> tuple[float, Hypothesis]:
        """Return the cost and the tracks of a permutation."""
        selection = np.empty(self.component.must.shape[0], dtype=np.int64)
        cost = decode_permutation(
            self.component, self.lookup, self.genes(items), trail or self.trail(), selection
        )
        return cost, self.hypothesis(selection)


def decode(
    problem: AssignmentProblem, items: Sequence[int], *, settle: bool
) -> tuple[float, Hypothesis]:
    """Return what the permutation stands for: each item joins or begins what is cheapest."""
    node_of = {frozenset(sequence(problem, node)): node for node in range(problem.n_nodes)}
    tracks = [frozenset([item]) for item in np.flatnonzero(problem.must_cover).tolist()]
    for item in items:
        lone = node_of.get(frozenset([item]))
        options = [] if lone is None else [(problem.cost[lone], None)]
        for track in tracks:
            joined = track | {item}
            if joined in node_of and problem.instant[item] >= problem.instant[list(track)].max():
                increment = problem.cost[node_of[joined]] - problem.cost[node_of[track]]
                options.append((increment, track))
        if options:
            _, track = min(options, key=lambda option: option[0])
            tracks = [other for other in tracks if other != track]
            tracks.append((track or frozenset()) | {item})
    cost, standing = 0.0, set()
    for track in tracks:
        node = node_of[track]
        while node >= 0 and np.isinf(problem.total[node]):
            node = int(problem.parent[node])
        must = problem.must_cover[list(track)].any()
        if node >= 0 and (must or not settle or problem.total[node] < 0):
            cost += float(problem.total[node])
            standing.add(sequence(problem, node))
    return cost, standing
