"""The optimum, by branch and bound."""

import heapq
from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from trackweave.arrays import IntArray
from trackweave.association.problem import Answer, AssignmentProblem
from trackweave.errors import InvalidInputError
from trackweave.fields import settle
from trackweave.randomness import RandomSource
from trackweave.solvers._dual import answer_at
from trackweave.solvers._kernels import Component
from trackweave.solvers.components import Components
from trackweave.solvers.dual import Dual
from trackweave.solvers.exact._cuts import pair_weights, violated_triples
from trackweave.solvers.exact.linear import Fraction, LinearProgram
from trackweave.solvers.protocol import Hint, Stop, until
from trackweave.solvers.relaxation import Relaxation

__all__ = ["Branching", "BranchingLimits", "Exact", "begin", "branch", "go_on"]

BoolArray = NDArray[np.bool_]
IMPROVEMENTS = 3
"""How often an answer made from prices is improved locally."""
MAX_ITEMS = 4_000
"""Beyond this many items the table of pairs would be too large."""


@dataclass(frozen=True, slots=True)
class BranchingLimits:
    """How many branches are looked into, pairs tried at each, rounds of cuts before all."""

    branches: int
    candidates: int = 3
    cut_rounds: int = 10


class _Decision(NamedTuple):
    """That two items stand in one sequence, or in none together; or, if equal, a column's fate."""

    first: int
    second: int
    together: bool


_Open: TypeAlias = tuple[float, int, tuple[_Decision, ...], Fraction]
"""A branch to look into: its bound, when it came, what it has decided, its fractional answer."""


class Branching:
    """The search of a component for its optimum.

    Best bound first; a branch is on two items that a fractional answer has in one sequence by half
    (Ryan, Foster 1981), chosen by trying some. ``selection`` is improved in place; ``known`` is
    what it costs and a bound, and it is best when the bound comes as close as ``closing``.
    ``stop`` is asked at every simplex iteration.
    """

    def __init__(
        self,
        component: Component,
        selection: IntArray,
        known: tuple[float, float],
        closing: float,
        stop: Stop | None,
    ) -> None:
        self.component = component
        self.selection = selection
        self.upper, self.lower = known
        self.solved = 0
        self._closing = closing
        self._stop = stop
        self._program = LinearProgram(component, stop)
        self._allowed = np.ones(self._program.node.shape[0], dtype=np.bool_)
        # Best bound first; None until the first linear program is solved.
        self._heap: list[_Open] | None = None
        self._serial, self._least_left = 0, np.inf
        # Of what was passed over for being as good as the answer, the least bound.
        self._passed = np.inf

    def learn(self, selection: IntArray, cost: float) -> None:
        """Take over an answer that was found elsewhere where it is better."""
        if cost < self.upper:
            self.selection[:] = selection
            self.upper = cost

    def run(self, limits: BranchingLimits) -> str:
        """Search on until the bound meets the answer, or to a limit; return why it ended."""
        if self._heap is None:
            root = self._bound_root(limits.cut_rounds)
            if root is None:
                return "stopped"
            self._heap = [(root.bound, 0, (), root)]
        heap = self._heap
        for _ in range(limits.branches):
            if not heap or self.upper - heap[0][0] <= self._closing:
                break
            if not self._expand(heap, limits.candidates):
                return "stopped"
            self._raise(min(self._least_left, heap[0][0] if heap else np.inf))
        if heap and self.upper - heap[0][0] > self._closing:
            return "branches"
        if self.upper - self._least_left > self._closing:
            return "rounding"
        # What is near enough to be closed is no proof yet: it stays to be seen in the bound.
        self._raise(min(self._passed, heap[0][0] if heap else np.inf))
        return "gap closed"

    def _expand(self, heap: list[_Open], candidates: int) -> bool:
        """Put both sides of a branch in the place of the least bound; tell whether it was done."""
        bound, _, path, fraction = heap[0]
        self._round(fraction)
        children = self._branch(path, fraction, candidates)
        if children is None:
            return False
        heapq.heappop(heap)
        if not children:
            # Whole already; what its bound leaves open is rounding, which is not hidden.
            self._least_left = min(self._least_left, bound)
        for decision, child in children:
            if child.bound >= self.upper - self._closing:
                self._passed = min(self._passed, child.bound)
            else:
                self._serial += 1
                inherited = max(bound, child.bound)
                heapq.heappush(heap, (inherited, self._serial, (*path, decision), child))
        return True

    def _raise(self, bound: float) -> None:
        self.lower = max(self.lower, min(bound, self.upper))

    def _bound_root(self, rounds: int) -> Fraction | None:
        """Return the fractional answer with cuts; None when stopped before there is any."""
        fraction = self._solve(self._allowed)
        for _ in range(rounds):
            if fraction is None or self.upper - fraction.bound <= self._closing:
                break
            self._round(fraction)
            self._leave_out(fraction)
            if not self._cut(fraction):
                break
            tighter = self._solve(self._allowed)
            if tighter is None:
                break
            fraction = tighter
        if fraction is not None:
            self._leave_out(fraction)
            self._raise(fraction.bound)
        return fraction

    def _solve(self, allowed: BoolArray) -> Fraction | None:
        """Return a fractional answer, and keep it where it is whole and better."""
        if self._stop is not None and self._stop():
            return None
        fraction = self._program.solve(allowed)
        if fraction is None:
            return None
        self.solved += 1
        if np.isfinite(fraction.bound) and np.all(fraction.value > 1.0 - 1e-6):
            nodes = self._program.node[fraction.column]
            cost = float(self.component.total[nodes].sum())
            if cost < self.upper:
                self.selection[:] = -1
                self.selection[self.component.family[nodes]] = nodes
                self.upper = cost
        return fraction

    def _round(self, fraction: Fraction) -> None:
        """Keep the answer that the prices of a fractional one lead to where it is better."""
        if np.isfinite(fraction.bound):
            self.upper = answer_at(
                self.component, fraction.price, self.selection, self.upper, IMPROVEMENTS
            )

    def _leave_out(self, fraction: Fraction) -> None:
        """Leave out for good the columns that no better answer takes."""
        room = self.upper - self._closing - fraction.bound
        self._allowed &= fraction.excess <= room + 1e-9 * max(1.0, abs(self.upper))

    def _cut(self, fraction: Fraction) -> bool:
        """Add the cuts that a fractional answer breaks most; tell whether there are any."""
        if self.component.n_items > MAX_ITEMS:
            return False
        program = self._program
        where = program.start, program.items, fraction.column, fraction.value
        weight = pair_weights(*where, self.component.n_items)
        triples, excess = violated_triples(*where, weight, 0.05)
        for index in np.argsort(-excess, kind="stable")[:50]:
            program.cut(triples[index])
        return bool(triples.shape[0])

    def _branch(
        self, path: tuple[_Decision, ...], fraction: Fraction, candidates: int
    ) -> list[tuple[_Decision, Fraction]] | None:
        """Return both sides of the branch that raises the bound most; None when stopped."""
        allowed = self._allowed.copy()
        for decision in path:
            allowed &= ~self._excluded(decision)
        best: list[tuple[_Decision, Fraction]] = []
        best_gain = -1.0
        for first, second in self._open_pairs(fraction)[:candidates]:
            sides = []
            for together in (True, False):
                decision = _Decision(first, second, together)
                child = self._solve(allowed & ~self._excluded(decision))
                if child is None:
                    return None
                sides.append((decision, child))
            gains = [min(child.bound, self.upper) - fraction.bound for _, child in sides]
            gain = max(gains[0], 1e-9) * max(gains[1], 1e-9)
            if gain > best_gain:
                best, best_gain = sides, gain
        return best

    def _open_pairs(self, fraction: Fraction) -> list[tuple[int, int]]:
        """Return pairs of items that are in one sequence by a fraction, by half first."""
        program = self._program
        weight = pair_weights(
            program.start, program.items, fraction.column, fraction.value, self.component.n_items
        )
        first, second = np.nonzero(np.triu((weight > 1e-4) & (weight < 1.0 - 1e-4)))
        order = np.argsort(np.abs(weight[first, second] - 0.5), kind="stable")
        pairs = [(int(first[index]), int(second[index])) for index in order]
        if pairs:
            return pairs
        # Sequences of one item are in no pair: such an item is then taken alone, or not.
        part = fraction.column[(fraction.value > 1e-4) & (fraction.value < 1.0 - 1e-4)]
        return [(-1 - int(column), -1 - int(column)) for column in part]

    def _excluded(self, decision: _Decision) -> BoolArray:
        """Return the columns that go against a decision."""
        program = self._program
        excluded = np.zeros(program.node.shape[0], dtype=np.bool_)
        if decision.first < 0:
            column = -1 - decision.first
            if decision.together:
                for item in program.items[program.start[column] : program.start[column + 1]]:
                    excluded[program.with_item(int(item))] = True
            excluded[column] = not decision.together
            return excluded
        has_second = np.zeros(program.node.shape[0], dtype=np.bool_)
        excluded[program.with_item(decision.first)] = True
        has_second[program.with_item(decision.second)] = True
        return excluded ^ has_second if decision.together else excluded & has_second


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
