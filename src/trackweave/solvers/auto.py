"""The default: prices first, then a search, then branch and bound."""

from dataclasses import dataclass

import numpy as np

from trackweave.association.problem import Answer, AssignmentProblem
from trackweave.errors import InvalidInputError
from trackweave.solvers.dual import Dual
from trackweave.solvers.exact.branching import BranchingLimits
from trackweave.solvers.exact.exact import branch
from trackweave.solvers.local import Annealing
from trackweave.solvers.protocol import Hint, Stop
from trackweave.solvers.relaxation import Relaxation

__all__ = ["Auto"]

LITTLE = 3_000
"""A component of no more sequences is branched on at once: its linear programs take little."""
MUCH = 30_000
"""Linear programs of components of more sequences take longer than a search that is as good."""


@dataclass(frozen=True, slots=True)
class Auto:
    """Prices prove most answers; what they leave open is branched on, or searched first.

    Ends as soon as the gap is closed. In order: the dual with reduction (``Dual``); branch and
    bound of components of which little is left (``Exact``); simulated annealing from the prices
    of the others (``Annealing``), which finds the best answers there in the least time; reduction
    by what it found; branch and bound again, which raises the bound, except of what is still
    too large. The measurements behind this order are in the documentation, under "choosing a
    solver".

    Parameters
    ----------
    evaluations
        Budget of the annealing per component, at least 0.
    branches
        Greatest number of branches per component, at least 0.

    Raises
    ------
    InvalidInputError
        If a number is negative.
    """

    evaluations: int = 100_000
    branches: int = 50

    def __post_init__(self) -> None:
        for name in ("evaluations", "branches"):
            if not getattr(self, name) >= 0:
                raise InvalidInputError(f"{name}: {getattr(self, name)}; expected a number ≥ 0")

    def __call__(
        self,
        problem: AssignmentProblem,
        *,
        rng: np.random.Generator,
        hint: Hint | None = None,
        stop: Stop | None = None,
    ) -> Answer:
        """Return the best answer found; see ``Solver``."""
        source = rng.spawn(1)[0]
        relaxation, evaluations, stopped = Dual().relax(Relaxation.of(problem, hint), stop)
        reason = "stopped" if stopped else "bound stalled"
        for most in (LITTLE, MUCH):
            if reason == "stopped" or not relaxation.rest.open().size:
                break
            if most == MUCH and self.evaluations:
                method = Annealing(evaluations=self.evaluations)
                last = relaxation.left_of(hint)
                seeds = [relaxation.rest.taken.copy(), *([] if last is None else [last])]
                state = method.start_at(relaxation, seeds, rng=source)
                state = method.advance(state, stop=stop)
                relaxation, reason = state.relaxation, state.stop_reason
                evaluations += state.evaluations
                if reason != "stopped" and relaxation.rest.open().size:
                    relaxation = relaxation.reduced()
            if reason != "stopped":
                done, reason = self._branch(relaxation, most, reason, stop)
                evaluations += done
        return relaxation.answer(evaluations, reason)

    def _branch(
        self, relaxation: Relaxation, most: int, reason: str, stop: Stop | None
    ) -> tuple[int, str]:
        """Branch on the open components of no more sequences; return evaluations and reason."""
        solved, rest = 0, relaxation.rest
        for index in rest.open().tolist():
            if rest.component(index).parent.shape[0] > most:
                continue
            ending, done = branch(rest, index, BranchingLimits(self.branches), stop)
            solved += done
            if ending != "gap closed":
                reason = ending
            if ending == "stopped":
                break
        return solved, reason
