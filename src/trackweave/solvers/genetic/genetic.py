"""Genetic search over orders of reports, after US patent 6,055,523."""

from dataclasses import dataclass

import numpy as np

from trackweave.arrays import IntArray
from trackweave.solvers.genetic.parameters import Parameters
from trackweave.solvers.genetic.report_genes import ReportGenes, make_lookup
from trackweave.solvers.genetic.search import Evolution
from trackweave.solvers.metaheuristic import Metaheuristic, chunk_of
from trackweave.solvers.resumable import Start, View

__all__ = ["Genetic"]


@dataclass(frozen=True, slots=True)
class Genetic(Parameters, Metaheuristic):
    """Genetic search over the orders in which reports choose their tracks [1]_.

    An individual is a permutation of the reports. It is decoded by taking the reports in that
    order and giving each to the track, or to the new track, where it costs least. Individuals
    are selected, crossed and mutated; the best ever found is the answer. The '931 patent's
    individuals, lists of associations between reports, are the second genotype.

    Beyond the document, and each can be switched off: components are searched apart; Lagrangian
    prices bound the cost, answer what is easy and seed the rest; the best individual is improved
    locally; a new track that costs more than false alarms dissolves. The search ends when the
    bound proves its best.

    Parameters
    ----------
    population
        Number of individuals, at least 2; or "by-size": ``per_item`` for each item that genes
        decide, and 20 at least.
    generations
        Stop rule one: the greatest number of generations per component; or "by-size": 2 for each
        item that genes decide, and 20 at least.
    per_item
        Individuals for each item that genes decide, where the population goes by size.
    evaluations
        How many individuals are decoded per component, to whole generations.
    first
        What the first individuals are, but for those that are known beforehand: random; or, of
        permutations, half of them take the instants in order, and the items of each at random.
    genotype
        What an individual is.
    selection
        By linear rank, or the better of two.
    crossover, mutation
        Probability that a pair is crossed, and that a child is mutated.
    elite
        How many of the best go on unchanged; 0 for non-overlapping generations.
    spread
        Stop rule two: the mean cost less the best of a generation is at most this [nats].
        Stop rule three, the arrival of the next scan, is the ``stop`` of a call.
    seeded
        Whether bounds and answers of the dual, a greedy order and the hint start the search.
    improvement
        Whether the best individual of a generation is improved locally.
    decompose
        Whether components are searched apart.
    settle
        Whether poor new tracks dissolve when all reports are placed.

    Raises
    ------
    InvalidInputError
        If a parameter is out of range.

    References
    ----------
    .. [1] D. B. Hillis, *Method and apparatus for multi-sensor, multi-target tracking using a
       genetic algorithm*, US patent 6,055,523, 2000.

    Examples
    --------
    >>> import numpy as np
    >>> import trackweave as tw
    >>> problem = tw.AssignmentProblem.from_tuples([[1, 1], [1, 2], [2, 2]], [-4.0, -6.0, -3.0])
    >>> answer = tw.solve(problem, tw.Genetic(population=20), rng=np.random.default_rng(1))
    >>> answer.cost, answer.lower_bound
    (-7.0, -7.0)
    >>> answer.tuples
    array([[1, 1],
           [2, 2]])
    """

    def _begin(self, view: View, start: Start) -> Evolution:
        lookup = make_lookup(view.component, view.cost, view.instant, self.settle)
        return Evolution.begin(ReportGenes(view.component, lookup, self), view.instant, start)

    def _go_on(self, view: View, search: Evolution, evaluations: int) -> Evolution:
        return search.advance(ReportGenes(view.component, search.reads, self), evaluations)

    def admit(self, view: View, search: Evolution, selection: IntArray, cost: float) -> Evolution:
        """Return the search with another's answer taken in; see ``Metaheuristic``."""
        return search.admit(ReportGenes(view.component, search.reads, self), selection, cost)

    def _chunk(self, view: View) -> int:
        # Roots of tracks from before the window are nothing that genes decide.
        n_genes = view.component.n_items - int(np.count_nonzero(view.component.must))
        return chunk_of(view, self.sizes(n_genes)[0])

    def _why_over(self, search: Evolution) -> str:
        if search.generation >= self.sizes(search.population.shape[1])[1]:
            return "generations"
        if search.evaluations >= self.evaluations:
            return "evaluations"
        return "converged" if search.spread() <= self.spread else ""
