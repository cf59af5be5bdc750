"""A problem under the dual: bounds, answers, and the ever smaller problems they leave open."""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from trackweave.arrays import IntArray, int_array
from trackweave.association.problem import Answer, AssignmentProblem
from trackweave.errors import InvalidInputError
from trackweave.solvers._dual import bound_components
from trackweave.solvers.components import Components
from trackweave.solvers.protocol import Hint
from trackweave.solvers.reduction import Reduction

__all__ = ["Relaxation"]

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
