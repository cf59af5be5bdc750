"""Genetic search over orders of reports, after US patent 6,055,523."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from trackweave.arrays import IntArray, is_whole
from trackweave.fields import settle
from trackweave.solvers.genetic._operators import RANK, TOURNAMENT
from trackweave.solvers.genetic.report_genes import ReportGenes, make_lookup
from trackweave.solvers.genetic.search import Evolution
from trackweave.solvers.metaheuristic import Metaheuristic, chunk_of
from trackweave.solvers.protocol import refuse_parameters
from trackweave.solvers.resumable import Start, View

__all__ = ["Genetic"]

BY_SIZE = "by-size"
GENERATIONS_PER_ITEM, LEAST_BY_SIZE = 2, 20
"""Where sizes grow with the problem: generations for each item that genes decide, and the least
number of individuals and of generations."""


@dataclass(frozen=True, slots=True)
class Genetic(Metaheuristic):
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

    population: int | Literal["by-size"] = 50
    generations: int | Literal["by-size"] = 40
    per_item: int = 8
    evaluations: int = 4_000
    first: Literal["random", "in-time-order"] = "random"
    genotype: Literal["permutation", "association-list"] = "permutation"
    selection: Literal["rank", "tournament"] = "tournament"
    crossover: float = 0.8
    mutation: float = 0.5
    elite: int = 1
    spread: float = 0.0
    seeded: bool = True
    improvement: bool = True
    decompose: bool = True
    settle: bool = True

    def __post_init__(self) -> None:
        settle(self)
        least = LEAST_BY_SIZE if isinstance(self.population, str) else self.population
        wrong = [
            (_is_too_small(self.population, 2), "population", "a whole number ≥ 2 or 'by-size'"),
            (_is_too_small(self.generations, 1), "generations", "a whole number ≥ 1 or 'by-size'"),
            (not self.per_item >= 1, "per_item", "a whole number ≥ 1"),
            (not self.evaluations >= 1, "evaluations", "a whole number ≥ 1"),
            (not 0 <= self.crossover <= 1, "crossover", "a probability"),
            (not 0 <= self.mutation <= 1, "mutation", "a probability"),
            (not 0 <= self.elite < least, "elite", "less than the population"),
            (not self.spread >= 0, "spread", "a number ≥ 0"),
        ]
        refuse_parameters(self, wrong)

    def sizes(self, n_genes: int) -> tuple[int, int]:
        """Return how many individuals and generations there are for so many genes."""
        by_size = (self.per_item * n_genes, GENERATIONS_PER_ITEM * n_genes)
        ours = [max(LEAST_BY_SIZE, many) for many in by_size]
        population = ours[0] if self.population == BY_SIZE else int(self.population)
        return population, ours[1] if self.generations == BY_SIZE else int(self.generations)

    @property
    def is_permutation(self) -> bool:
        """Whether individuals are permutations of the reports."""
        return self.genotype == "permutation"

    @property
    def selection_code(self) -> int:
        """The number that kernels know the selection by."""
        return TOURNAMENT if self.selection == "tournament" else RANK

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


def _is_too_small(value: int | str, least: int) -> bool:
    return value != BY_SIZE and not (is_whole(value) and int(value) >= least)
