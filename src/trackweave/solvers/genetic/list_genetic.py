"""Genetic search over one permutation per list, after Huo and others."""

from dataclasses import dataclass, replace
from functools import cache
from typing import Literal

from trackweave.arrays import IntArray
from trackweave.fields import settle
from trackweave.solvers.genetic._columns import Table
from trackweave.solvers.genetic._list_operators import INVERSION, SHIFT, SWAP
from trackweave.solvers.genetic.list_genes import ListGenes, genes_in, make_table
from trackweave.solvers.genetic.search import Evolution
from trackweave.solvers.metaheuristic import Metaheuristic, chunk_of
from trackweave.solvers.protocol import refuse_parameters
from trackweave.solvers.resumable import Start, View

__all__ = ["ListGenetic"]

USUAL_GENES = 20
"""Genes of the problem that ``by_size`` takes the numbers to be for: 3 lists of 10."""
MUTATIONS = {"swap": SWAP, "inversion": INVERSION, "shift": SHIFT}


@dataclass(frozen=True, slots=True)
class ListGenetic(Metaheuristic):
    """Genetic search over permutations of each list's items [1]_.

    An individual holds one permutation per list, filled up with dummies to one length; that of
    list 1 stays in order. The items at one place, a column, are a candidate tuple: where all
    tuples exist it is taken, elsewhere the cheapest sequence that the column's items make, or
    none. The best individuals are kept; the others are children by partially matched crossover,
    and mutants, of parents that are chosen by rank.

    Beyond the document, and each can be switched off: components are searched apart; Lagrangian
    prices bound the cost, answer what is easy and seed the rest; the best individual is improved
    locally. The search ends when the bound proves its best.

    Parameters
    ----------
    population
        Number of individuals, at least 2.
    generations
        Stop rule one: the greatest number of generations per component.
    evaluations
        How many individuals are decoded per component, to whole generations.
    reproduction
        Share of the population that is kept, below 1. One less it is the generation gap.
    mutation
        Share that are mutants; the rest are children.
    mutate
        A mutant has two genes swapped, what lies between two places inverted, or a gene shifted
        to another place.
    tolerance, patience
        Stop rule two: the best cost changed by at most this [nats] for so many generations.
    seeded
        Whether bounds and answers of the dual, and the hint, start the search.
    improvement
        Whether the best individual of a generation is improved locally.
    decompose
        Whether components are searched apart.
    by_size
        Whether the numbers are those for 20 genes, three lists of ten, and grow with a larger
        component: the population with the square of its genes, the items of all lists but the
        first; generations and patience in proportion; evaluations with the cube.

    Raises
    ------
    InvalidInputError
        If a parameter is out of range.

    References
    ----------
    .. [1] Huo L., Zhang Z., Bai P., Song Y., Xiong X., *A sort of model of multi-sensor
       multi-object flight path connection based on GA*, 2008, section 2.

    Examples
    --------
    >>> import numpy as np
    >>> import trackweave as tw
    >>> problem = tw.AssignmentProblem.from_tuples([[1, 1], [1, 2], [2, 2]], [-4.0, -6.0, -3.0])
    >>> answer = tw.solve(problem, tw.ListGenetic(generations=20), rng=np.random.default_rng(1))
    >>> answer.cost, answer.lower_bound
    (-7.0, -7.0)
    >>> answer.tuples
    array([[1, 1],
           [2, 2]])
    """

    population: int = 50
    generations: int = 100
    evaluations: int = 4_000
    reproduction: float = 0.1
    mutation: float = 0.3
    mutate: Literal["swap", "inversion", "shift"] = "swap"
    tolerance: float = 0.0
    patience: int = 50
    seeded: bool = True
    improvement: bool = True
    decompose: bool = True
    by_size: bool = False

    def __post_init__(self) -> None:
        settle(self)
        wrong = [
            (not self.population >= 2, "population", "a whole number ≥ 2"),
            (not self.generations >= 1, "generations", "a whole number ≥ 1"),
            (not self.evaluations >= 1, "evaluations", "a whole number ≥ 1"),
            (not 0 <= self.reproduction < 1, "reproduction", "a share from 0 to below 1"),
            (
                not 0 <= self.mutation <= 1 - self.reproduction + 1e-12,
                "mutation",
                "a share that with reproduction makes at most 1",
            ),
            (not self.tolerance >= 0, "tolerance", "a number ≥ 0"),
            (not self.patience >= 1, "patience", "a whole number ≥ 1"),
        ]
        refuse_parameters(self, wrong)

    @property
    def shares(self) -> tuple[int, int]:
        """How many individuals are kept and how many are mutants; the rest are children."""
        # One at least is new, or a generation would take no evaluation.
        n_kept = min(round(self.population * self.reproduction), self.population - 1)
        return n_kept, min(round(self.population * self.mutation), self.population - n_kept)

    @property
    def mutation_code(self) -> int:
        """The number that kernels know the mutation by."""
        return MUTATIONS[self.mutate]

    def for_genes(self, genes: int) -> "ListGenetic":
        """Return what these numbers become for so many genes: more where ``by_size`` says so."""
        # The population grows as the square of the genes, generations and patience in proportion,
        # evaluations as both.
        return self if not self.by_size or genes <= USUAL_GENES else _grown(self, genes)

    def _begin(self, view: View, start: Start) -> Evolution:
        coding = self._coding(view, make_table(view.component, view.instant))
        return Evolution.begin(coding, view.instant, start)

    def _go_on(self, view: View, search: Evolution, evaluations: int) -> Evolution:
        return search.advance(self._coding(view, search.reads), evaluations)

    def admit(self, view: View, search: Evolution, selection: IntArray, cost: float) -> Evolution:
        """Return the search with another's answer taken in; see ``Metaheuristic``."""
        return search.admit(self._coding(view, search.reads), selection, cost)

    def _coding(self, view: View, table: Table) -> ListGenes:
        return ListGenes(view.component, table, self.for_genes(genes_in(table)))

    def _chunk(self, view: View) -> int:
        return chunk_of(view, self.population)

    def _why_over(self, search: Evolution) -> str:
        limits = self.for_genes(genes_in(search.reads))
        if search.generation >= limits.generations:
            return "generations"
        if search.evaluations >= limits.evaluations:
            return "evaluations"
        return "converged" if search.unchanged >= limits.patience else ""


@cache
def _grown(search: ListGenetic, genes: int) -> ListGenetic:
    ratio = genes / USUAL_GENES
    return replace(
        search,
        population=round(search.population * ratio**2),
        generations=round(search.generations * ratio),
        patience=round(search.patience * ratio),
        evaluations=round(search.evaluations * ratio**3),
        by_size=False,
    )
