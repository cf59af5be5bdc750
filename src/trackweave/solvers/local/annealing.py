"""Simulated annealing."""

import copy
from dataclasses import dataclass, replace

import numpy as np

from trackweave.arrays import IntArray
from trackweave.fields import settle
from trackweave.solvers._kernels import Component
from trackweave.solvers.local._moves import begin_holding, cost_of
from trackweave.solvers.local._tabu import anneal
from trackweave.solvers.local.starts import CHUNK, SearchStart, search_start
from trackweave.solvers.metaheuristic import Metaheuristic, polish
from trackweave.solvers.protocol import refuse_parameters
from trackweave.solvers.resumable import Start, View

__all__ = ["Annealing", "AnnealingState"]

LEVELS = 50
"""Temperatures of one cooling."""
SHORTEST = 100
"""Moves at one temperature at least, so that small components are not all overhead."""


@dataclass(frozen=True, slots=True, eq=False)
class AnnealingState:
    """Where an annealing stands; it is replaced, never changed.

    ``holder`` tells which candidate holds each item at present, and ``best_holder`` in the best
    answer, which is ``selection`` at a cost of ``best``. ``position`` moves were tried at the
    temperature number ``level`` of the cooling. So many coolings as ``unchanged`` counts, in a
    row, found nothing better; the best before the present one cost ``before``.
    """

    ground: SearchStart
    holder: IntArray
    current: float
    best_holder: IntArray
    best: float
    selection: IntArray
    level: int
    position: int
    cooling: int
    unchanged: int
    before: float
    evaluations: int
    rng: np.random.Generator

    @property
    def at_rest(self) -> bool:
        """Whether a temperature is complete."""
        return self.position == 0 and self.evaluations > 0


@dataclass(frozen=True, slots=True)
class Annealing(Metaheuristic):
    """Simulated annealing [1]_ with moves that force a sequence in and repair what it breaks.

    A move picks an item that does not have all it is worth by the prices, and a sequence for it
    whose reduced cost is near its family's least; lets go of those in the way; gives their items
    to other sequences that are free; and forces another in, as a link of an ejection chain [2]_,
    where items remain without. A move that adds d to the cost is accepted with probability
    exp(−d / T), and T falls geometrically. Coolings begin by turns with nothing taken and with
    the best answer.

    Temperatures are in units of what choices typically cost: the median over items of the
    reduced cost of their tenth best sequence, above the least of its family.

    Parameters
    ----------
    evaluations
        How many moves are tried per component, to whole temperatures.
    moves_per_item
        How many of them one cooling has for each item, at most.
    hot, cold
        First and last temperature of a cooling, above 0.
    links
        Greatest number of sequences that a move forces in, at least 1.
    patience
        Coolings without a better answer after which the search ends, at least 1.
    improvement
        Whether the best answer is improved locally when a cooling ends: by ejecting, inserting
        and repairing, and by assigning one list of items anew, exactly.
    seeded
        Whether bounds, prices and answers of the dual start the search. All items count as worth
        nothing where not.
    decompose
        Whether components are searched apart.

    Raises
    ------
    InvalidInputError
        If a parameter is out of range.

    References
    ----------
    .. [1] S. Kirkpatrick, C. D. Gelatt, M. P. Vecchi, *Optimization by simulated annealing*,
       1983. doi:10.1126/science.220.4598.671
    .. [2] F. Glover, *Ejection chains, reference structures and alternating path methods for
       traveling salesman problems*, 1996. doi:10.1016/0166-218X(94)00037-E

    Examples
    --------
    >>> import numpy as np
    >>> import trackweave as tw
    >>> problem = tw.AssignmentProblem.from_tuples([[1, 1], [1, 2], [2, 2]], [-4.0, -6.0, -3.0])
    >>> answer = tw.solve(problem, tw.Annealing(evaluations=1000), rng=np.random.default_rng(1))
    >>> answer.cost, answer.lower_bound
    (-7.0, -7.0)
    >>> answer.tuples
    array([[1, 1],
           [2, 2]])
    """

    evaluations: int = 1_000_000
    moves_per_item: int = 800
    hot: float = 4.0
    cold: float = 0.1
    links: int = 2
    patience: int = 10
    improvement: bool = True
    seeded: bool = True
    decompose: bool = True

    def __post_init__(self) -> None:
        settle(self)
        wrong = [
            (not self.evaluations >= 1, "evaluations", "a whole number ≥ 1"),
            (not self.moves_per_item >= 1, "moves_per_item", "a whole number ≥ 1"),
            (not 0 < self.hot < np.inf, "hot", "a number above 0"),
            (not 0 < self.cold <= self.hot, "cold", "above 0, and at most hot"),
            (not self.links >= 1, "links", "a whole number ≥ 1"),
            (not self.patience >= 1, "patience", "a whole number ≥ 1"),
        ]
        refuse_parameters(self, wrong)

    def length(self, n_items: int) -> int:
        """Return the moves at each temperature: all coolings but the last end in the budget."""
        moves = min(self.moves_per_item * n_items, self.evaluations)
        return max(SHORTEST, -(-moves // LEVELS))

    def temperature(self, level: int, scale: float) -> float:
        """Return the temperature of a level, the first of which is 0 [nats]."""
        return float(scale * self.hot * (self.cold / self.hot) ** (level / (LEVELS - 1)))

    def _begin(self, view: View, start: Start) -> AnnealingState:
        ground = search_start(view, start, seeded=self.seeded)
        holder = ground.holding(view.component, None)
        return AnnealingState(
            ground=ground,
            holder=holder,
            current=cost_of(ground.moves, holder),
            best_holder=ground.holder,
            best=ground.cost,
            selection=ground.selection(view.component, ground.holder),
            level=0,
            position=0,
            cooling=0,
            unchanged=0,
            before=ground.cost,
            evaluations=0,
            rng=start.rng,
        )

    def _go_on(self, view: View, search: AnnealingState, evaluations: int) -> AnnealingState:
        ground, length = search.ground, self.length(view.component.n_items)
        count = min(evaluations, length - search.position)
        holder, best_holder = search.holder.copy(), search.best_holder.copy()
        selection, rng = search.selection, copy.deepcopy(search.rng)
        current, best = anneal(
            ground.moves, self.temperature(search.level, ground.scale), self.links, count, rng,
            holder, search.current, best_holder, search.best,
        )  # fmt: skip
        if best < search.best:
            selection = ground.selection(view.component, best_holder)
        moved = replace(
            search,
            holder=holder,
            current=current,
            best_holder=best_holder,
            best=best,
            selection=selection,
            position=search.position + count,
            evaluations=search.evaluations + count,
            rng=rng,
        )
        return moved if moved.position < length else self._colder(view.component, moved)

    def admit(
        self, view: View, search: AnnealingState, selection: IntArray, cost: float
    ) -> AnnealingState:
        """Return the annealing with another's better answer as its best and its present one."""
        held = search.ground.held(view.component, selection, cost, search.best)
        if held is None:
            return search
        holder, cost = held
        known = search.ground.selection(view.component, holder)
        return replace(
            search, holder=holder, current=cost, best_holder=holder, best=cost, selection=known
        )

    def _colder(self, component: Component, search: AnnealingState) -> AnnealingState:
        """Return the annealing at the beginning of the next temperature, or of a cooling."""
        ground, moves = search.ground, search.ground.moves
        if search.level + 1 < LEVELS:
            current = cost_of(moves, search.holder)
            return replace(search, level=search.level + 1, position=0, current=current)
        selection, best_holder, best = search.selection, search.best_holder, search.best
        if self.improvement:
            trial = selection.copy()
            polish(component, ground.lists, trial, search.cooling)
            polished = begin_holding(moves, component, trial)
            if cost_of(moves, polished) < best:
                selection, best_holder, best = trial, polished, cost_of(moves, polished)
        holder = ground.holding(component, None) if search.cooling % 2 else best_holder
        gained = best < search.before - 1e-9 * abs(search.before)
        return replace(
            search,
            holder=holder,
            current=cost_of(moves, holder),
            best_holder=best_holder,
            best=best,
            selection=selection,
            level=0,
            position=0,
            cooling=search.cooling + 1,
            unchanged=0 if gained else search.unchanged + 1,
            before=best,
        )

    def _chunk(self, view: View) -> int:
        return min(CHUNK, self.length(view.component.n_items))

    def _why_over(self, search: AnnealingState) -> str:
        if search.evaluations >= self.evaluations:
            return "evaluations"
        return "converged" if search.unchanged >= self.patience else ""
