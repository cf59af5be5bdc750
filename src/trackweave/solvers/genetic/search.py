"""The genetic search of one component, as a value."""

import copy
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.solvers._kernels import Component
from trackweave.solvers.genetic._decoding import Lookup, Trail, begin, evaluate
from trackweave.solvers.genetic._operators import breed, random_population
from trackweave.solvers.genetic.parameters import Parameters
from trackweave.solvers.lists import Lists, lists_of
from trackweave.solvers.polishing import polish
from trackweave.solvers.resumable import Start

__all__ = ["GeneticSearch", "genes_of", "in_time_order", "make_lookup"]


def make_lookup(component: Component, cost: FloatArray, instant: IntArray, settle: bool) -> Lookup:
    """Return what decoding reads of a component; see ``Lookup``."""
    by_item = np.argsort(component.item, kind="stable")
    item_start = np.searchsorted(component.item[by_item], np.arange(component.n_items + 1))
    is_gene = np.ones(component.n_items, dtype=np.bool_)
    roots = component.members[component.start[:-1]]
    is_gene[component.item[roots[component.must]]] = False
    genes = np.flatnonzero(is_gene)
    genes = genes[np.argsort(instant[genes], kind="stable")]
    root_of = np.full(component.n_items, -1, dtype=np.int64)
    root_of[component.item[roots]] = roots
    twin_start, twin = _twins(component, instant)
    return Lookup(by_item, item_start, cost, instant, genes, twin_start, twin, root_of, settle)


def _twins(component: Component, instant: IntArray) -> tuple[IntArray, IntArray]:
    """Return each root's children of its own instant; see ``Lookup``."""
    parent, item = component.parent, component.item
    child = np.flatnonzero(parent >= 0)
    child = child[parent[parent[child]] < 0]
    child = child[instant[item[child]] == instant[item[parent[child]]]]
    child = child[np.argsort(parent[child], kind="stable")]
    return np.searchsorted(parent[child], np.arange(parent.shape[0] + 1)), child


@dataclass(frozen=True, slots=True, eq=False)
class GeneticSearch:
    """Where a search stands; ``advance`` returns where it stands later and leaves this one be.

    ``position`` individuals of ``offspring`` are evaluated; when all are, they become the
    population.
    """

    lists: Lists
    population: IntArray
    cost: FloatArray
    offspring: IntArray
    offspring_cost: FloatArray
    order: IntArray
    position: int
    generation: int
    selection: IntArray
    best: float
    rng: np.random.Generator

    @classmethod
    def begin(
        cls,
        component: Component,
        lookup: Lookup,
        parameters: Parameters,
        start: Start,
    ) -> Self:
        """Return a search before its first evaluation.

        Parameters
        ----------
        component, lookup
            What is searched.
        parameters
            How.
        start
            What is known beforehand.

        Returns
        -------
        The search with its first individuals.
        """
        n_genes = lookup.gene_item.shape[0]
        size, _ = parameters.sizes(n_genes)
        offspring = np.empty((size, n_genes), dtype=np.int64)
        rows = [
            genes_of(component, lookup, parameters.is_permutation, seed)
            for seed in start.seeds[: size // 2]
        ]
        if parameters.seeded:
            rows.append(in_time_order(component, lookup, parameters.is_permutation))
        if parameters.is_permutation and parameters.first == "in-time-order":
            rows += _instants_in_order(lookup, size // 2 - len(rows), start.rng)
        for row, genes in enumerate(rows):
            offspring[row] = genes
        random_population(
            component, lookup, parameters.is_permutation, start.rng, len(rows), offspring
        )
        return cls(
            lists=lists_of(component, lookup.instant),
            population=offspring,
            cost=np.full(size, np.inf),
            offspring=offspring,
            offspring_cost=np.full(size, np.inf),
            order=np.arange(size),
            position=0,
            generation=0,
            selection=start.selection.copy(),
            best=start.cost,
            rng=start.rng,
        )

    def advance(
        self, component: Component, lookup: Lookup, parameters: Parameters, evaluations: int
    ) -> "GeneticSearch":
        """Return the search after so many more evaluations, or at the generation's end.

        Parameters
        ----------
        component, lookup
            What is searched.
        parameters
            How.
        evaluations
            How many individuals to decode at most.

        Returns
        -------
        The search then; this one stays as it is.
        """
        last = min(self.position + evaluations, self.order.shape[0])
        offspring_cost, selection = self.offspring_cost.copy(), self.selection.copy()
        best = evaluate(
            component, lookup, parameters.is_permutation, self.offspring,
            self.order[self.position : last], _fresh_trail(component, self.offspring.shape[1]),
            offspring_cost, selection, self.best,
        )  # fmt: skip
        moved = replace(
            self, offspring_cost=offspring_cost, selection=selection, best=best, position=last
        )
        is_whole = last == self.order.shape[0]
        return _next_generation(moved, component, lookup, parameters) if is_whole else moved

    @property
    def evaluations(self) -> int:
        """How many individuals were decoded."""
        return self.generation * int(self.order.shape[0]) + self.position

    @property
    def at_rest(self) -> bool:
        """Whether a generation is complete."""
        return self.position == 0 and self.generation > 0

    def admit(
        self,
        component: Component,
        lookup: Lookup,
        parameters: Parameters,
        selection: IntArray,
        cost: float,
    ) -> "GeneticSearch":
        """Return the search with another's answer in the place of its worst individual.

        Parameters
        ----------
        component, lookup
            What is searched.
        parameters
            How.
        selection, cost
            The other's answer.

        Returns
        -------
        The search at the same generation, the next one bred anew; this one where the answer is
        no better than the worst individual, or among them already.
        """
        genes = genes_of(component, lookup, parameters.is_permutation, selection)
        worst = int(np.argmax(self.cost))
        if cost >= self.cost[worst] or (self.population == genes).all(axis=1).any():
            return self
        population, costs = self.population.copy(), self.cost.copy()
        population[worst], costs[worst] = genes, cost
        moved = replace(self, population=population, cost=costs)
        if cost < self.best:
            moved = replace(moved, selection=selection, best=cost)
        return _bred(moved, component, lookup, parameters)

    def spread(self) -> float:
        """Return the mean cost of the last whole generation less its best."""
        return float(self.cost.mean() - self.cost.min())


def _next_generation(
    search: GeneticSearch, component: Component, lookup: Lookup, parameters: Parameters
) -> GeneticSearch:
    """Return the search at the beginning of its next generation."""
    population, cost = search.offspring.copy(), search.offspring_cost.copy()
    selection, best = search.selection.copy(), search.best
    if parameters.improvement:
        improved = polish(component, search.lists, selection, search.generation)
        if improved < best - 1e-12 or not np.any(cost <= best):
            best = min(best, improved)
            worst = int(np.argmax(cost))
            population[worst] = genes_of(component, lookup, parameters.is_permutation, selection)
            cost[worst] = best
    moved = replace(
        search,
        population=population,
        cost=cost,
        position=0,
        generation=search.generation + 1,
        selection=selection,
        best=best,
    )
    return _bred(moved, component, lookup, parameters)


def _bred(
    search: GeneticSearch, component: Component, lookup: Lookup, parameters: Parameters
) -> GeneticSearch:
    """Return the search with offspring of its population."""
    population, cost, rng = search.population, search.cost, copy.deepcopy(search.rng)
    offspring, key = np.empty_like(population), np.empty(population.shape[0], dtype=np.int64)
    breed(
        component, lookup, parameters.is_permutation, population, cost,
        np.array([parameters.crossover, parameters.mutation]), parameters.selection_code,
        parameters.elite, rng, offspring, key,
    )  # fmt: skip
    return replace(
        search,
        offspring=offspring,
        offspring_cost=np.full(cost.shape[0], np.inf),
        order=np.argsort(key, kind="stable"),
        rng=rng,
    )


def _fresh_trail(component: Component, n_genes: int) -> Trail:
    current = np.empty(component.must.shape[0], dtype=np.int64)
    begin(component, current)
    room = np.empty((5, n_genes), dtype=np.int64)
    return Trail(room[0], room[1], room[2], room[3], room[4], current, np.zeros(1, dtype=np.int64))


def in_time_order(component: Component, lookup: Lookup, is_permutation: bool) -> IntArray:
    """Return the individual that takes the reports as they came."""
    if is_permutation:
        return lookup.gene_item.copy()
    return genes_of(component, lookup, False, np.full(component.must.shape[0], -1, dtype=np.int64))


def _instants_in_order(lookup: Lookup, count: int, rng: np.random.Generator) -> list[IntArray]:
    """Return individuals that take the instants in order, and the items of each at random."""
    ranks = lookup.instant[lookup.gene_item]
    within = rng.random((max(count, 0), ranks.shape[0]))
    return [lookup.gene_item[np.argsort(ranks + own, kind="stable")] for own in within]


def genes_of(
    component: Component, lookup: Lookup, is_permutation: bool, selection: IntArray
) -> IntArray:
    """Return an individual made from a selection.

    Parameters
    ----------
    component, lookup
        What is searched.
    is_permutation
        Whether to return a permutation or a list of associations.
    selection
        Each family's node, -1 for none. Where sequences share an item the better has it.

    Returns
    -------
    The items of the sequences, the best first, then those that none takes; or each item's
    predecessor, -1 for none.
    """
    taken = selection[selection >= 0]
    taken = taken[np.argsort(component.total[taken], kind="stable")]
    ordered: list[int] = []
    before = np.full(component.n_items, -1, dtype=np.int64)
    for leaf in taken.tolist():
        sequence = []
        node = leaf
        while node >= 0:
            sequence.append(int(component.item[node]))
            node = int(component.parent[node])
        sequence.reverse()
        before[sequence[1:]] = sequence[:-1]
        ordered += sequence
    if not is_permutation:
        return before[lookup.gene_item]
    is_gene = np.zeros(component.n_items, dtype=np.bool_)
    is_gene[lookup.gene_item] = True
    first = [item for item in dict.fromkeys(ordered) if is_gene[item]]
    is_gene[first] = False
    rest = [item for item in lookup.gene_item.tolist() if is_gene[item]]
    return np.array(first + rest, dtype=np.int64)
