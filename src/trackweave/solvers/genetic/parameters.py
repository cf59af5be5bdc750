"""What a genetic search may be told."""

from dataclasses import dataclass, replace
from functools import cache
from typing import Literal

from trackweave.arrays import is_whole
from trackweave.fields import settle
from trackweave.solvers.genetic._list_operators import INVERSION, SHIFT, SWAP
from trackweave.solvers.genetic._operators import RANK, TOURNAMENT
from trackweave.solvers.protocol import refuse_parameters

__all__ = ["ListParameters", "Parameters"]

USUAL_GENES = 20
"""Genes of the problem that ``by_size`` takes the numbers to be for: 3 lists of 10."""
BY_SIZE = "by-size"
GENERATIONS_PER_ITEM, LEAST_BY_SIZE = 2, 20
"""Where sizes grow with the problem: generations for each item that genes decide, and the least
number of individuals and of generations."""
MUTATIONS = {"swap": SWAP, "inversion": INVERSION, "shift": SHIFT}


@dataclass(frozen=True, slots=True)
class Parameters:
    """Parameters of a genetic search; see ``Genetic``, whose defaults these are."""

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
            (
                self.first not in ("random", "in-time-order"),
                "first",
                "'random' or 'in-time-order'",
            ),
            (
                self.genotype not in ("permutation", "association-list"),
                "genotype",
                "'permutation' or 'association-list'",
            ),
            (self.selection not in ("rank", "tournament"), "selection", "'rank' or 'tournament'"),
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


def _is_too_small(value: int | str, least: int) -> bool:
    return value != BY_SIZE and not (is_whole(value) and int(value) >= least)


@dataclass(frozen=True, slots=True)
class ListParameters:
    """Parameters of a genetic search over lists; see ``ListGenetic``, whose defaults these are."""

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
            (self.mutate not in MUTATIONS, "mutate", "'swap', 'inversion' or 'shift'"),
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

    def for_genes(self, genes: int) -> "ListParameters":
        """Return what these numbers become for so many genes: more where ``by_size`` says so."""
        # The population grows as the square of the genes, generations and patience in proportion,
        # evaluations as both.
        return self if not self.by_size or genes <= USUAL_GENES else _grown(self, genes)


@cache
def _grown(parameters: ListParameters, genes: int) -> ListParameters:
    ratio = genes / USUAL_GENES
    return replace(
        parameters,
        population=round(parameters.population * ratio**2),
        generations=round(parameters.generations * ratio),
        patience=round(parameters.patience * ratio),
        evaluations=round(parameters.evaluations * ratio**3),
        by_size=False,
    )
