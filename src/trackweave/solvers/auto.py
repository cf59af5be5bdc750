"""The default: prices first, then a search, then branch and bound."""

from dataclasses import dataclass, field

import numpy as np

from trackweave.association.problem import Answer, AssignmentProblem
from trackweave.errors import InvalidInputError
from trackweave.fields import settle
from trackweave.randomness import RandomSource
from trackweave.solvers.dual import Dual
from trackweave.solvers.exact.exact import Branching, BranchingLimits, begin, branch, go_on
from trackweave.solvers.protocol import Hint, Stop, child_of
from trackweave.solvers.relaxation import Relaxation

__all__ = ["Auto"]

LITTLE = 3_000
"""A component of no more sequences is branched on at once: its linear programs take little."""
MUCH = 30_000
"""Linear programs of components of more sequences take longer than a search that is as good."""
TURN = 30
"""Branches before the search has its turn again."""


@dataclass(frozen=True, slots=True)
class Auto:
    """Prices prove most answers; what they leave open is branched on, or searched first.

    Ends as soon as the gap is closed. In order: the dual with reduction (``Dual``); branch and
    bound of components of which little is left (``Exact``); simulated annealing from the prices
    of the others (``Annealing``), which finds the best answers there in the least time; reduction
    by what it found; then branch and bound, which raises the bound, and annealing by turns, until
    the budget is spent. What is too large for linear programs is annealed alone. The measurements
    behind this order are in the documentation, under "choosing a solver".

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

    Examples
    --------
    >>> import numpy as np
    >>> import trackweave as tw
    >>> problem = tw.AssignmentProblem.from_tuples([[1, 1], [1, 2], [2, 2]], [-4.0, -6.0, -3.0])
    >>> answer = tw.solve(problem, tw.Auto(), rng=np.random.default_rng(1))
    >>> answer.cost, answer.lower_bound
    (-7.0, -7.0)
    >>> answer.tuples
    array([[1, 1],
           [2, 2]])
    """

    evaluations: int = 100_000
    branches: int = 50

    def __post_init__(self) -> None:
        settle(self)
        for name in ("evaluations", "branches"):
            if not getattr(self, name) >= 0:
                raise InvalidInputError(f"{name}: {getattr(self, name)}; expected a number ≥ 0")

    def __call__(
        self,
        problem: AssignmentProblem,
        *,
        rng: RandomSource = 0,
        hint: Hint | None = None,
        stop: Stop | None = None,
    ) -> Answer:
        """Return the best answer found; see ``Solver``."""
        source = child_of(rng)
        relaxation, evaluations, stopped = Dual().relax(Relaxation.of(problem, hint), stop)
        effort = _Effort(relaxation, source, hint, stop, evaluations)
        if not stopped:
            effort.branch_on_little(self.branches)
        moves, branches = self.evaluations, self.branches
        while not (stopped or effort.is_over) and (moves > 0 or branches > 0):
            moves = effort.search(moves) if moves > 0 else 0
            branches = effort.branch(branches) if branches > 0 else 0
        reason = "stopped" if stopped or effort.was_stopped else "budget spent"
        return effort.relaxation.answer(effort.evaluations, reason)


@dataclass(slots=True)
class _Effort:
    """What has been done for a problem, and with which source of randomness it goes on.

    ``searches`` holds the branch and bound of components of the last level, once it has begun.
    """

    relaxation: Relaxation
    rng: np.random.Generator
    hint: Hint | None
    stop: Stop | None
    evaluations: int
    searches: dict[int, Branching] = field(default_factory=dict)
    was_stopped: bool = False

    @property
    def is_over(self) -> bool:
        """Whether nothing is open, or a stop was asked for."""
        return self.was_stopped or not self.relaxation.rest.open().size

    def search(self, moves: int) -> int:
        """Anneal what is open until nothing better comes; return the moves left of a budget."""
        # Prices prove most answers, and what they prove takes no search.
        from trackweave.solvers.local.annealing import Annealing

        method = Annealing(evaluations=moves)
        last = self.relaxation.left_of(self.hint)
        seeds = [self.relaxation.rest.taken.copy(), *([] if last is None else [last])]
        state = method.start_at(self.relaxation, seeds, rng=self.rng)
        n_components = len(state.queue)
        state = method.advance(state, stop=self.stop)
        self.evaluations += state.evaluations
        self.was_stopped = state.stop_reason == "stopped"
        self.relaxation = state.relaxation
        if not self.searches and not self.is_over:
            # What is found later makes the branches fewer, but not the component smaller.
            self.relaxation = self.relaxation.reduced()
        return moves - max(1, state.evaluations // max(1, n_components))

    def branch_on_little(self, branches: int) -> None:
        """Branch on the open components of which little is left."""
        # Whole costs let a gap below one count as closed, which branching soon reaches.
        whole = self.relaxation.rest.step > 0.0
        little = set(self._open(LITTLE))
        # Those of widest gap first, as they are open.
        for index in [i for i in self._open(MUCH) if i in little or whole[i]]:
            limits = BranchingLimits(branches)
            self._count(*branch(self.relaxation.rest, index, limits, self.stop))
            if self.was_stopped:
                break

    def branch(self, branches: int) -> int:
        """Go on branching on the open components for a while; return the branches left."""
        candidates = self._open(MUCH)
        share = min(branches, TURN)
        for index in candidates:
            if self.is_over:
                break
            if index not in self.searches:
                self.searches[index] = begin(self.relaxation.rest, index, self.stop)
            search = self.searches[index]
            self._count(*go_on(self.relaxation.rest, index, search, BranchingLimits(share)))
        return branches - share if candidates else 0

    def _open(self, most: int) -> list[int]:
        rest = self.relaxation.rest
        sizes = np.diff(rest.parts.node_start)
        return [index for index in rest.open().tolist() if sizes[index] <= most]

    def _count(self, ending: str, solved: int) -> None:
        self.evaluations += solved
        self.was_stopped = ending == "stopped"
