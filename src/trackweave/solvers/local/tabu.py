"""Tabu search."""

from dataclasses import dataclass

import numpy as np

from trackweave.arrays import IntArray
from trackweave.fields import settle
from trackweave.solvers.local.seeking import Habits, Seeking
from trackweave.solvers.local.starts import CHUNK, lay_ground
from trackweave.solvers.metaheuristic import Metaheuristic
from trackweave.solvers.protocol import refuse_parameters
from trackweave.solvers.resumable import Start, View

__all__ = ["TabuSearch"]


@dataclass(frozen=True, slots=True)
class TabuSearch(Metaheuristic):
    """Tabu search [1]_ [2]_ with moves that force a sequence in and repair what it breaks.

    Moves are those of ``Annealing``. Each iteration tries a sample of them and makes the best,
    however much it adds to the cost; but a sequence that came may not be sent off, nor one that
    went come back, for some iterations. A move that leads to a new best may be made all the
    same. When the search gets stuck it starts anew: in turn with nothing taken, with the best
    answer, and with one of the best of earlier starts less a fifth of its sequences.

    Parameters
    ----------
    evaluations
        How many moves are tried per component, to whole steps of some thousand.
    sample
        How many moves an iteration tries, at least 1.
    tenure
        For how many iterations, at least, a sequence stays as it is; at most twice as many.
        At least 0.
    links
        Greatest number of sequences that a move forces in, at least 1.
    moves_per_item
        The search starts anew after so many moves for each item without a better answer.
    patience
        Starts without a better answer after which the search ends, at least 1.
    improvement
        Whether the best answer of a start is improved locally: by ejecting, inserting and
        repairing, and by assigning one list of items anew, exactly.
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
    .. [1] F. Glover, *Tabu search – part I*, 1989. doi:10.1287/ijoc.1.3.190
    .. [2] F. Glover, *Tabu search – part II*, 1990. doi:10.1287/ijoc.2.1.4

    Examples
    --------
    >>> import numpy as np
    >>> import trackweave as tw
    >>> problem = tw.AssignmentProblem.from_tuples([[1, 1], [1, 2], [2, 2]], [-4.0, -6.0, -3.0])
    >>> answer = tw.solve(problem, tw.TabuSearch(evaluations=1000), rng=np.random.default_rng(1))
    >>> answer.cost, answer.lower_bound
    (-7.0, -7.0)
    >>> answer.tuples
    array([[1, 1],
           [2, 2]])
    """

    evaluations: int = 1_000_000
    sample: int = 20
    tenure: int = 5
    links: int = 2
    moves_per_item: int = 100
    patience: int = 30
    improvement: bool = True
    seeded: bool = True
    decompose: bool = True

    def __post_init__(self) -> None:
        settle(self)
        wrong = [
            (not self.evaluations >= 1, "evaluations", "a whole number ≥ 1"),
            (not self.sample >= 1, "sample", "a whole number ≥ 1"),
            (not self.tenure >= 0, "tenure", "a whole number ≥ 0"),
            (not self.links >= 1, "links", "a whole number ≥ 1"),
            (not self.moves_per_item >= 1, "moves_per_item", "a whole number ≥ 1"),
            (not self.patience >= 1, "patience", "a whole number ≥ 1"),
        ]
        refuse_parameters(self, wrong)

    def _begin(self, view: View, start: Start) -> Seeking:
        price = view.price if self.seeded else np.zeros(view.component.n_items)
        return Seeking.begin(view.component, lay_ground(view, start, price), start.rng)

    def _go_on(self, view: View, search: Seeking, evaluations: int) -> Seeking:
        return search.advance(view.component, self._habits(), evaluations)

    def admit(self, view: View, search: Seeking, selection: IntArray, cost: float) -> Seeking:
        """Return the search with another's answer taken in; see ``Metaheuristic``."""
        return search.admit(view.component, selection, cost)

    def _chunk(self, view: View) -> int:
        return min(CHUNK, self.sample * self._habits().iterations)

    def _why_over(self, search: Seeking) -> str:
        if search.evaluations >= self.evaluations:
            return "evaluations"
        return "converged" if search.unchanged >= self.patience else ""

    def _habits(self) -> Habits:
        return Habits(
            sample=self.sample,
            tenure=self.tenure,
            links=self.links,
            moves_per_item=self.moves_per_item,
            improvement=self.improvement,
        )
