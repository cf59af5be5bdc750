"""The optimum, by branch and bound."""

from dataclasses import dataclass

from trackweave.association.problem import Answer, AssignmentProblem
from trackweave.errors import InvalidInputError
from trackweave.fields import settle
from trackweave.randomness import RandomSource
from trackweave.solvers.components import Components
from trackweave.solvers.dual import Dual
from trackweave.solvers.exact.branching import Branching, BranchingLimits
from trackweave.solvers.protocol import Hint, Stop, until
from trackweave.solvers.relaxation import Relaxation

__all__ = ["Exact", "begin", "branch", "go_on"]


@dataclass(frozen=True, slots=True)
class Exact:
    """Branch and bound on linear programs, for what the dual leaves open.

    Prices and reduction come first, as in ``Dual``. Each component that is still open becomes a
    linear program, which HiGHS solves, with cuts; the search then branches on which two items
    stand in one sequence. The bound is reckoned anew from the prices, so that no tolerance of
    HiGHS is in it. Spent limits leave the best answer and its gap.

    Parameters
    ----------
    branches
        Greatest number of branches per component, at least 0.
    max_sequences
        Greatest number of sequences of a component that is branched on; the linear programs of
        larger ones take long.
    time_limit
        Seconds for all components together, None for no limit. Must be positive.

    Raises
    ------
    InvalidInputError
        If a number is out of range.

    Examples
    --------
    >>> import numpy as np
    >>> import trackweave as tw
    >>> problem = tw.AssignmentProblem.from_tuples([[1, 1], [1, 2], [2, 2]], [-4.0, -6.0, -3.0])
    >>> answer = tw.solve(problem, tw.Exact(), rng=np.random.default_rng(1))
    >>> answer.cost, answer.lower_bound
    (-7.0, -7.0)
    >>> answer.tuples
    array([[1, 1],
           [2, 2]])
    """

    branches: int = 10_000
    max_sequences: int = 100_000
    time_limit: float | None = None

    def __post_init__(self) -> None:
        settle(self)
        if self.branches < 0 or self.max_sequences < 1:
            raise InvalidInputError(
                f"branches: {self.branches}, max_sequences: {self.max_sequences}; "
                "expected whole numbers ≥ 0 and ≥ 1"
            )
        if self.time_limit is not None and not self.time_limit > 0:
            raise InvalidInputError(f"time_limit: {self.time_limit}; expected a number > 0")

    def __call__(
        self,
        problem: AssignmentProblem,
        *,
        rng: RandomSource = 0,
        hint: Hint | None = None,
        stop: Stop | None = None,
    ) -> Answer:
        """Return the best answer found; see ``Solver``."""
        stop = stop if self.time_limit is None else until(self.time_limit, stop)
        relaxation, evaluations, stopped = Dual().relax(Relaxation.of(problem, hint), stop)
        reason = "stopped" if stopped else ""
        rest = relaxation.rest
        for index in rest.open().tolist():
            if reason == "stopped":
                break
            if rest.component(index).parent.shape[0] > self.max_sequences:
                reason = "component too large"
                continue
            limits = BranchingLimits(self.branches)
            ending, solved = branch(rest, index, limits, stop)
            evaluations += solved
            reason = reason if ending == "gap closed" else ending
        return relaxation.answer(evaluations, reason)


def branch(
    components: Components, index: int, limits: BranchingLimits, stop: Stop | None
) -> tuple[str, int]:
    """Search a component for its optimum, in place; return why it ended and how many programs."""
    return go_on(components, index, begin(components, index, stop), limits)


def begin(components: Components, index: int, stop: Stop | None) -> Branching:
    """Return the search of a component for its optimum before its first linear program."""
    return Branching(
        components.component(index),
        components.taken[components.families(index)].copy(),
        (float(components.cost[index]), float(components.lower[index])),
        components.closing(index),
        stop,
    )


def go_on(
    components: Components, index: int, search: Branching, limits: BranchingLimits
) -> tuple[str, int]:
    """Go on with a component's search, in place; return why it ended and how many programs."""
    # The component may have a better answer by now.
    families, before = components.families(index), search.solved
    search.learn(components.taken[families], float(components.cost[index]))
    reason = search.run(limits)
    components.taken[families] = search.selection
    components.cost[index] = search.upper
    components.lower[index] = max(float(components.lower[index]), search.lower)
    return reason, search.solved - before
