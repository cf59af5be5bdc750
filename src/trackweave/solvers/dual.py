"""Prices, a lower bound, and an answer by reduced cost."""

from dataclasses import dataclass

import numpy as np

from trackweave.association.problem import Answer, AssignmentProblem
from trackweave.errors import InvalidInputError
from trackweave.solvers._dual import DualBudget, solve_components
from trackweave.solvers.components import Components
from trackweave.solvers.protocol import Hint, Stop
from trackweave.solvers.reduction import Reduction

__all__ = ["Dual"]


@dataclass(frozen=True, slots=True)
class Dual:
    """Lagrangian relaxation: every item gets a price, and the prices a bound.

    Subgradient ascent on the prices [1]_; at each rise of the bound an answer is made greedily
    by reduced cost and improved locally. Where a gap remains, the sequences that the prices do
    not exclude make a smaller problem, which falls into smaller components; these are bounded
    anew, and enumerated, which proves the answer when it completes.

    Parameters
    ----------
    iterations
        Greatest number of bounds per component, at least 1.
    visits
        Greatest number of steps of the enumeration per component; 0 for none.

    Raises
    ------
    InvalidInputError
        If a number is out of range.

    References
    ----------
    .. [1] M. Held, P. Wolfe, H. Crowder, *Validation of subgradient optimization*, 1974, eq. 4.
       doi:10.1007/BF01580223
    """

    iterations: int = 100
    visits: int = 20_000

    def __post_init__(self) -> None:
        if self.iterations < 1 or self.visits < 0:
            raise InvalidInputError(
                f"Dual: {self.iterations} iterations, {self.visits} visits; expected ≥ 1 and ≥ 0"
            )

    def __call__(
        self,
        problem: AssignmentProblem,
        *,
        rng: np.random.Generator,
        hint: Hint | None = None,
        stop: Stop | None = None,
    ) -> Answer:
        """Return the answer by reduced cost; see ``Solver``."""
        components = Components.of(problem, hint)
        evaluations, stopped = self.bound(components, stop)
        if not stopped and components.open().size:
            reduction = Reduction.of(components)
            rest = Components.of(reduction.problem, Hint(prices=reduction.prices))
            more, stopped = self.bound(rest, stop)
            evaluations += more
            reduction.absorb(components, rest)
        proven = components.open().size == 0
        reason = "gap closed" if proven else "stopped" if stopped else "bound stalled"
        return components.answer(evaluations, reason)

    def bound(self, components: Components, stop: Stop | None) -> tuple[int, bool]:
        """Bound and answer every component, in place.

        Parameters
        ----------
        components
            A problem taken apart. After a stop those that remain get one greedy answer and the
            bound at the prices that they came with.
        stop
            Asked every few milliseconds whether to stop.

        Returns
        -------
        How many bounds were computed and steps of the enumeration taken; whether it was stopped.
        """
        evaluations, first, stopped = 0, 0, False
        starts = components.parts.node_start
        while first < len(components):
            # A slice of components worth a few milliseconds, so that a stop is seen in time.
            last = int(np.searchsorted(starts, starts[first] + 2000, side="right")) - 1
            last = min(max(last, first + 1), len(components))
            stopped = stopped or (stop is not None and stop())
            effort = (1, 0) if stopped else (self.iterations, self.visits)
            budget = DualBudget(*effort, tolerance=1e-9)
            evaluations += solve_components(
                components.parts, first, last, components.price, components.taken,
                components.cost, components.lower, budget,
            )  # fmt: skip
            first = last
        return evaluations, stopped
