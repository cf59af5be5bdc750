"""Simulated annealing."""

from dataclasses import dataclass

import numpy as np

from trackweave.arrays import IntArray
from trackweave.fields import settle
from trackweave.solvers.local.cooling import Cooling, Schedule
from trackweave.solvers.local.starts import CHUNK, lay_ground
from trackweave.solvers.metaheuristic import Metaheuristic
from trackweave.solvers.protocol import refuse_parameters
from trackweave.solvers.resumable import Start, View

__all__ = ["Annealing"]


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

    def _begin(self, view: View, start: Start) -> Cooling:
        price = view.price if self.seeded else np.zeros(view.component.n_items)
        return Cooling.begin(view.component, lay_ground(view, start, price), start.rng)

    def _go_on(self, view: View, search: Cooling, evaluations: int) -> Cooling:
        return search.advance(view.component, self._schedule(), evaluations)

    def admit(self, view: View, search: Cooling, selection: IntArray, cost: float) -> Cooling:
        """Return the search with another's answer taken in; see ``Metaheuristic``."""
        return search.admit(view.component, selection, cost)

    def _chunk(self, view: View) -> int:
        return min(CHUNK, self._schedule().length(view.component.n_items))

    def _why_over(self, search: Cooling) -> str:
        if search.evaluations >= self.evaluations:
            return "evaluations"
        return "converged" if search.unchanged >= self.patience else ""

    def _schedule(self) -> Schedule:
        return Schedule(
            moves_per_item=self.moves_per_item,
            evaluations=self.evaluations,
            hot=self.hot,
            cold=self.cold,
            links=self.links,
            improvement=self.improvement,
        )
