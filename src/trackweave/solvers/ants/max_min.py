"""Max–min ant system on reduced costs."""

import copy
from dataclasses import dataclass, replace

import numpy as np

from trackweave.arrays import IntArray
from trackweave.fields import settle
from trackweave.solvers.ants._trails import send_ants
from trackweave.solvers.ants.trails import TrailSearch, make_trails
from trackweave.solvers.metaheuristic import Metaheuristic, chunk_of
from trackweave.solvers.protocol import refuse_parameters
from trackweave.solvers.resumable import Start, View

__all__ = ["MaxMinAntSystem"]


@dataclass(frozen=True, slots=True)
class MaxMinAntSystem(Metaheuristic):
    """Max–min ant system [1]_ on reduced costs: ants choose for one family after another.

    An ant visits the families in random order. Each takes one of its free candidates, or none,
    with probability in proportion to τ^α·exp(−excess / T): ``excess`` is the option's reduced
    cost above the family's least, and T the ``temperature`` in units of what the second choice
    typically costs above the first. The best ant of an iteration is improved locally. It and, in
    turn, the best since the last restart lay pheromone, which stays between limits: the upper is
    what it tends to where it is laid each time, scaled to 1 [2]_; the lower follows from the
    probability that a converged colony chooses its best again ([1]_, eq. 11). When the best has
    not improved for a while, trails are laid anew.

    Parameters
    ----------
    ants
        Number of ants per iteration, at least 1.
    pheromone_weight
        α, at least 0.
    temperature
        T, above 0: the higher, the less reduced costs count.
    persistence
        ρ: the share of pheromone that does not evaporate in an iteration, from 0 to below 1.
    candidates
        How many sequences of each family, those of least reduced cost, ants choose from.
    best_probability
        Probability that ants choose the best again once they have converged, between 0 and 1.
    patience
        Iterations without a better answer after which trails are laid anew.
    improvement
        Whether the best of an iteration is improved locally.
    evaluations
        How many ants choose per component, to whole iterations.
    seeded
        Whether bounds, prices and answers of the dual start the search. Costs stand for reduced
        costs where not.
    decompose
        Whether components are searched apart.

    Raises
    ------
    InvalidInputError
        If a parameter is out of range.

    References
    ----------
    .. [1] T. Stützle, H. Hoos, *MAX–MIN Ant System*, 2000. doi:10.1016/S0167-739X(00)00043-1
    .. [2] C. Blum, M. Dorigo, *The hyper-cube framework for ant colony optimization*, 2004.
       doi:10.1109/TSMCB.2003.821450

    Examples
    --------
    >>> import numpy as np
    >>> import trackweave as tw
    >>> problem = tw.AssignmentProblem.from_tuples([[1, 1], [1, 2], [2, 2]], [-4.0, -6.0, -3.0])
    >>> answer = tw.solve(problem, tw.MaxMinAntSystem(ants=5), rng=np.random.default_rng(1))
    >>> answer.cost, answer.lower_bound
    (-7.0, -7.0)
    >>> answer.tuples
    array([[1, 1],
           [2, 2]])
    """

    ants: int = 20
    pheromone_weight: float = 1.0
    temperature: float = 0.3
    persistence: float = 0.9
    candidates: int = 20
    best_probability: float = 0.05
    patience: int = 100
    improvement: bool = True
    evaluations: int = 4_000
    seeded: bool = True
    decompose: bool = True

    def __post_init__(self) -> None:
        settle(self)
        wrong = [
            (not self.ants >= 1, "ants", "a whole number ≥ 1"),
            (not 0 <= self.pheromone_weight < np.inf, "pheromone_weight", "a number ≥ 0"),
            (not 0 < self.temperature < np.inf, "temperature", "a number above 0"),
            (not 0 <= self.persistence < 1, "persistence", "a number from 0 to below 1"),
            (not self.candidates >= 1, "candidates", "a whole number ≥ 1"),
            (not 0 < self.best_probability < 1, "best_probability", "between 0 and 1"),
            (not self.patience >= 1, "patience", "a whole number ≥ 1"),
            (not self.evaluations >= 1, "evaluations", "a whole number ≥ 1"),
        ]
        refuse_parameters(self, wrong)

    def _begin(self, view: View, start: Start) -> TrailSearch:
        price = view.price if self.seeded else np.zeros(view.component.n_items)
        trails = make_trails(
            view.component, price, self.candidates, self.temperature, self.best_probability
        )
        return TrailSearch.begin(trails, start)

    def _go_on(self, view: View, search: TrailSearch, evaluations: int) -> TrailSearch:
        last = min(search.position + evaluations, self.ants)
        weight = search.pheromone**self.pheromone_weight * search.trails.visibility
        present, rng = search.present.copy(), copy.deepcopy(search.rng)
        cost = send_ants(
            view.component, search.trails.options, weight, last - search.position, rng, present,
            search.present_cost,
        )  # fmt: skip
        moved = replace(
            search, position=last, sent=search.sent + last - search.position, present=present,
            present_cost=cost, rng=rng,
        )  # fmt: skip
        if last < self.ants:
            return moved
        if self.improvement:
            moved = moved.improved(view.component)
        return moved.renewed(self.persistence, self.patience)

    def admit(
        self, view: View, search: TrailSearch, selection: IntArray, cost: float
    ) -> TrailSearch:
        """Return the search with another's answer taken in; see ``Metaheuristic``."""
        return search.admit(selection, cost)

    def _chunk(self, view: View) -> int:
        return chunk_of(view, self.ants)

    def _why_over(self, search: TrailSearch) -> str:
        return "evaluations" if search.evaluations >= self.evaluations else ""
