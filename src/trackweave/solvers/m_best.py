"""The cheapest hypotheses, and how probable each sequence is among them."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import prod

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.association.problem import Answer, AssignmentProblem
from trackweave.fields import settle
from trackweave.randomness import RandomSource
from trackweave.solvers._pricing import bound_at
from trackweave.solvers.components import Components
from trackweave.solvers.dual import STRETCHES, Dual, climb
from trackweave.solvers.murty import Partitioning
from trackweave.solvers.partial_solutions import Enumeration, PartialSolutions, Piece, combine
from trackweave.solvers.protocol import (
    Hint,
    Solver,
    Stop,
    child_of,
    refuse_parameters,
    require_solver,
)
from trackweave.solvers.relaxation import Relaxation
from trackweave.summaries import summary

__all__ = ["MBest", "Ranking"]


@dataclass(frozen=True, slots=True, eq=False)
class Ranking:
    """The cheapest hypotheses of a problem.

    Parameters
    ----------
    answer
        The best of them, with its certificate and the probability of each node.
    hypotheses
        For each hypothesis the last node of each chosen sequence, in ascending order; no two are
        the same.
    cost
        What each costs [nats], ascending.
    n_proven
        How many, from the first on, are proven to be the cheapest that there are.
    is_complete
        Whether there are no others.

    Examples
    --------
    >>> import numpy as np
    >>> import trackweave as tw
    >>> problem = tw.AssignmentProblem.from_tuples([[1, 1], [1, 2], [2, 2]], [-4.0, -6.0, -3.0])
    >>> ranking = tw.MBest(hypotheses=3).rank(problem, rng=np.random.default_rng(1))
    >>> ranking.cost, ranking.is_complete
    (array([-7., -6., -4.]), False)
    >>> ranking.probability.round(2)  # of each node of the problem
    array([0.  , 0.74, 0.26, 0.  , 0.71])
    """

    answer: Answer
    hypotheses: tuple[IntArray, ...]
    cost: FloatArray
    n_proven: int
    is_complete: bool

    __repr__ = summary

    @property
    def probability(self) -> FloatArray:
        """How probable each node is to be chosen, shape (nodes,); see ``MBest``."""
        known = self.answer.node_probability
        assert known is not None
        return known


@dataclass(frozen=True, slots=True)
class MBest:
    """The m cheapest hypotheses and the probability of each association [1]_.

    The dual's prices tell how much each sequence at least adds to the best cost. Within a margin
    few are left: the others are certain, and those left fall into groups that share no report.
    Each group's cheapest selections are enumerated, with the m-th as the bound, and those of all
    groups combined. Where a component's enumeration takes too long, its hypotheses come from
    partitioning.

    A hypothesis of cost c weighs exp(−c). The probability of a sequence is the weight of the
    enumerated selections of its group with it, among all of them: every combination of groups
    counts, though of each group no more than m selections do (``hypotheses=3`` of four makes
    probabilities those of the three). A call enumerates up to the margin alone; a ranking goes on
    until there are m.

    Parameters
    ----------
    hypotheses
        How many are asked for, m, from 1 to 100,000.
    margin
        How much dearer than the best of its group a selection counts for probabilities [nats],
        where m allows. Must be positive.
    visits
        Greatest number of steps of the enumeration per component.
    solves
        Greatest number of parts of a component that are solved in partitioning.
    solver
        Solves them.

    Raises
    ------
    InvalidInputError
        If a parameter is out of range.

    References
    ----------
    .. [1] R. L. Popp, K. R. Pattipati, Y. Bar-Shalom, *m-best S-D assignment algorithm with
       application to multitarget tracking*, 2001. doi:10.1109/7.913661

    Examples
    --------
    >>> import numpy as np
    >>> import trackweave as tw
    >>> problem = tw.AssignmentProblem.from_tuples([[1, 1], [1, 2], [2, 2]], [-4.0, -6.0, -3.0])
    >>> ranking = tw.MBest(hypotheses=3).rank(problem, rng=np.random.default_rng(1))
    >>> ranking.cost, ranking.n_proven  # nats
    (array([-7., -6., -4.]), 3)
    """

    hypotheses: int = 100
    margin: float = 10.0
    visits: int = 2_000_000
    solves: int = 20
    solver: Solver = Dual()  # noqa: RUF009 frozen, so that it can be shared

    def __post_init__(self) -> None:
        settle(self)
        wrong = [
            (not 1 <= self.hypotheses <= 100_000, "hypotheses", "a whole number from 1 to 100000"),
            (not 0 < self.margin < np.inf, "margin", "a number > 0"),
            (not self.visits >= 1, "visits", "a whole number ≥ 1"),
            (not self.solves >= 0, "solves", "a whole number ≥ 0"),
        ]
        refuse_parameters(self, wrong)
        require_solver(self.solver, "solver")

    def __call__(
        self,
        problem: AssignmentProblem,
        *,
        rng: RandomSource = 0,
        hint: Hint | None = None,
        stop: Stop | None = None,
    ) -> Answer:
        """Return the cheapest hypothesis, with probabilities; see ``Solver``."""
        return self._search(problem, 1, child_of(rng), hint, stop)[0]

    def rank(
        self,
        problem: AssignmentProblem,
        *,
        rng: RandomSource = 0,
        hint: Hint | None = None,
        stop: Stop | None = None,
    ) -> Ranking:
        """Return the cheapest hypotheses.

        Parameters
        ----------
        problem
            What to choose from.
        rng
            Source of randomness, for the solver: a generator, or a seed.
        hint
            What is known beforehand.
        stop
            Asked every few milliseconds whether to stop with what is known so far.

        Returns
        -------
        As many hypotheses as were asked for, or as were found; none where not even one covers
        what has to be covered.
        """
        answer, components, found = self._search(
            problem, self.hypotheses, child_of(rng), hint, stop
        )
        if not np.isfinite(answer.cost):
            return Ranking(answer, (), np.empty(0), 0, False)
        pieces = [piece for part in found for piece in part.pieces]
        home = np.repeat(np.arange(len(found)), [len(part.pieces) for part in found])
        rows = combine(pieces, self.hypotheses)
        columns = [
            _of_problem(components, index, piece)[rows[:, place]]
            for place, (index, piece) in enumerate(zip(home.tolist(), pieces, strict=True))
        ]
        nodes = np.concatenate([np.empty((rows.shape[0], 0), dtype=np.int64), *columns], axis=1)
        nodes.sort(axis=1)
        hypotheses = [row[row >= 0] for row in nodes]
        cost = np.array([problem.cost_of(row) for row in hypotheses])
        ranks = np.argsort(cost, kind="stable")
        sure = problem.base_cost + _sure_to(found) / components.scale
        rounding = 1e-9 * max(1.0 / components.scale, abs(float(cost.min())))
        return Ranking(
            answer=answer,
            hypotheses=tuple(hypotheses[rank] for rank in ranks.tolist()),
            cost=cost[ranks],
            n_proven=int(np.count_nonzero(cost <= sure + rounding)),
            is_complete=all(part.is_all for part in found)
            and prod(piece.cost.shape[0] for piece in pieces) <= self.hypotheses,
        )

    def _search(
        self,
        problem: AssignmentProblem,
        least: int,
        rng: np.random.Generator,
        hint: Hint | None,
        stop: Stop | None,
    ) -> tuple[Answer, Components, list[PartialSolutions]]:
        """Return the best answer, the problem's components, and the pieces of each."""
        relaxation, evaluations, stopped = Dual().relax(Relaxation.of(problem, hint), stop)
        components = relaxation.whole()
        found = []
        for index in range(len(components)):
            stopped = stopped or (stop is not None and stop())
            if stopped:
                selection = components.taken[components.families(index)]
                lower = float(components.lower[index])
                found.append(
                    PartialSolutions.single(components.component(index), selection, lower)
                )
                continue
            pieces, tried = self._pieces(components, index, least, rng, stop)
            evaluations += tried
            found.append(pieces)
            if pieces.cost < components.cost[index]:
                components.taken[components.families(index)] = pieces.best
                components.cost[index] = pieces.cost
            bound = min(pieces.ceiling, components.cost[index])
            components.lower[index] = max(components.lower[index], bound)
        stopped = stopped or (stop is not None and stop())
        closed = components.open().size == 0
        reason = "gap closed" if closed else "stopped" if stopped else "bound stalled"
        answer = components.answer(evaluations, reason)
        chance = np.zeros(problem.n_nodes)
        if np.isfinite(answer.cost):
            for index, part in enumerate(found):
                for piece in part.pieces:
                    weight = np.exp((piece.cost[0] - piece.cost) / components.scale)
                    _add_probability(weight, _of_problem(components, index, piece), chance)
        return replace(answer, node_probability=chance), components, found

    def _pieces(
        self,
        components: Components,
        index: int,
        least: int,
        rng: np.random.Generator,
        stop: Stop | None,
    ) -> tuple[PartialSolutions, int]:
        """Return the cheapest selections of a component, and how many evaluations they took."""
        component, price = components.component(index), components.price[components.items(index)]
        known, evaluations = float(components.cost[index]), 0
        requirement, margin = components.problem.requirement, self.margin * components.scale
        # Answers that cover what they have to differ by less; those that do not, by more.
        widest = np.inf if requirement is None else 0.5 * requirement.penalty * components.scale
        if known - bound_at(component, price) > margin / 8.0:
            evaluations += _raise_bound(components, index, stop)
        enumeration = Enumeration(
            component, price, self.hypotheses, least, margin, widest, self.visits, stop
        )
        pieces, visits = enumeration.run(known)
        evaluations += visits
        if pieces is None or not (pieces.is_all or pieces.count() >= least):
            partitioning = Partitioning(components, index, self.solver, self.solves, rng, stop)
            others, tried = partitioning.run(self.hypotheses)
            evaluations += tried
            if pieces is None or others.count() > pieces.count():
                pieces = others
        return pieces.within(widest), evaluations


def _raise_bound(components: Components, index: int, stop: Stop | None) -> int:
    """Improve the prices of a component for its own sake; return how many bounds it took."""
    component, price = components.component(index), components.price[components.items(index)]
    apart, evaluations = components.copy(), 0
    apart.lower[index] = bound_at(component, price)
    for stretch in STRETCHES[:2]:
        done, stopped = climb(apart, index, stretch, stop)
        evaluations += done
        if stopped:
            break
    return evaluations


def _of_problem(components: Components, index: int, piece: Piece) -> IntArray:
    """Return a piece's nodes as the problem numbers them."""
    first = components.parts.node_start[index]
    # One more entry, so that -1 stays -1.
    number = np.append(components.parts.node[first : components.parts.node_start[index + 1]], -1)
    nodes: IntArray = number[piece.node]
    return nodes


def _add_probability(weight: FloatArray, nodes: IntArray, chance: FloatArray) -> None:
    """Add how probable the nodes of a piece's selections are, which have these weights."""
    weight = weight / weight.sum()
    is_taken = nodes >= 0
    np.add.at(chance, nodes[is_taken], np.broadcast_to(weight[:, None], nodes.shape)[is_taken])
    # Sums of many shares of one can come out above it by rounding.
    np.minimum(chance, 1.0, out=chance)


def _sure_to(found: Sequence[PartialSolutions]) -> float:
    """Return up to what cost of the whole nothing is missing from the combinations."""
    least = np.array([min(part.cost, part.ceiling) for part in found])
    ceiling = np.array([part.ceiling for part in found])
    return float(np.min(ceiling - least, initial=np.inf) + least.sum())
