"""The genetic search of one component over permutations of lists, as a value."""

import copy
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.solvers._kernels import Component
from trackweave.solvers.genetic._columns import Table, evaluate_columns, least_below
from trackweave.solvers.genetic._list_operators import breed_lists, shuffle_lists
from trackweave.solvers.genetic.parameters import ListParameters
from trackweave.solvers.lists import Lists, lists_of
from trackweave.solvers.polishing import polish
from trackweave.solvers.resumable import Start

__all__ = ["ListSearch", "genes_of", "individual_of", "make_table"]


@dataclass(frozen=True, slots=True, eq=False)
class ListSearch:
    """Where a search stands; ``advance`` returns where it stands later and leaves this one be.

    ``position`` individuals of ``offspring`` have a cost; when all have, they become the
    population. The best cost of so many generations as ``unchanged`` counts was, in a row, that
    of the one before.
    """

    lists: Lists
    table: Table
    population: IntArray
    cost: FloatArray
    offspring: IntArray
    offspring_cost: FloatArray
    position: int
    n_kept: int
    generation: int
    unchanged: int
    evaluations: int
    selection: IntArray
    best: float
    rng: np.random.Generator

    @classmethod
    def begin(
        cls, component: Component, instant: IntArray, parameters: ListParameters, start: Start
    ) -> Self:
        """Return a search before its first evaluation.

        Parameters
        ----------
        component
            What is searched.
        instant
            Rank of each item in time.
        parameters
            How.
        start
            What is known beforehand.

        Returns
        -------
        The search with its first individuals. Their permutations are as long as the longest
        list, or longer where something known beforehand has more sequences.
        """
        table = make_table(component, instant)
        size, sizes = parameters.population, np.diff(table.list_start)
        seeds = start.seeds[: size // 2]
        known = max((int(np.count_nonzero(seed >= 0)) for seed in seeds), default=0)
        length = max(int(sizes.max(initial=0)), known)
        offspring = np.empty((size, sizes.shape[0], length), dtype=np.int64)
        for row, seed in enumerate(seeds):
            offspring[row] = individual_of(component, table, seed, length)
        shuffle_lists(start.rng, len(seeds), offspring)
        return cls(
            lists=lists_of(component, instant),
            table=table,
            population=offspring,
            cost=np.full(size, np.inf),
            offspring=offspring,
            offspring_cost=np.full(size, np.inf),
            position=0,
            n_kept=0,
            generation=0,
            unchanged=0,
            evaluations=0,
            selection=start.selection.copy(),
            best=start.cost,
            rng=start.rng,
        )

    def advance(
        self, component: Component, parameters: ListParameters, evaluations: int
    ) -> "ListSearch":
        """Return the search after so many more evaluations, or at the generation's end.

        Parameters
        ----------
        component
            What is searched.
        parameters
            How.
        evaluations
            How many individuals to decode at most.

        Returns
        -------
        The search then; this one stays as it is.
        """
        size = self.offspring.shape[0]
        last = min(self.position + evaluations, size)
        offspring_cost, selection = self.offspring_cost.copy(), self.selection.copy()
        best = evaluate_columns(
            component, self.table, self.offspring, self.position, last, offspring_cost,
            selection, self.best,
        )  # fmt: skip
        moved = replace(
            self,
            offspring_cost=offspring_cost,
            selection=selection,
            best=best,
            position=last,
            evaluations=self.evaluations + last - self.position,
        )
        return _next_generation(moved, component, parameters) if last == size else moved

    @property
    def genes(self) -> int:
        """How many items there are in all lists but the first."""
        return _genes_in(self.table.list_start)

    @property
    def at_rest(self) -> bool:
        """Whether a generation is complete."""
        return self.position == self.n_kept and self.generation > 0

    def admit(
        self, component: Component, parameters: ListParameters, selection: IntArray, cost: float
    ) -> "ListSearch":
        """Return the search with another's answer in the place of its worst individual.

        Parameters
        ----------
        component
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
        genes = individual_of(component, self.table, selection, self.population.shape[2])
        worst = int(np.argmax(self.cost))
        if cost >= self.cost[worst] or (self.population == genes).all(axis=(1, 2)).any():
            return self
        population, costs = self.population.copy(), self.cost.copy()
        population[worst], costs[worst] = genes, cost
        moved = replace(self, population=population, cost=costs)
        if cost < self.best:
            moved = replace(moved, selection=selection, best=cost)
        return _bred(moved, parameters)


def _next_generation(
    search: ListSearch, component: Component, parameters: ListParameters
) -> ListSearch:
    """Return the search at the beginning of its next generation."""
    population, cost = search.offspring.copy(), search.offspring_cost.copy()
    selection, best = search.selection.copy(), search.best
    if parameters.improvement:
        improved = polish(component, search.lists, selection, search.generation)
        if improved < best - 1e-12 or not np.any(cost <= best):
            best = min(best, improved)
            worst = int(np.argmax(cost))
            population[worst] = individual_of(
                component, search.table, selection, population.shape[2]
            )
            cost[worst] = best
    change = abs(float(cost.min()) - float(search.cost.min()))
    moved = replace(
        search,
        population=population,
        cost=cost,
        generation=search.generation + 1,
        unchanged=search.unchanged + 1 if change <= parameters.tolerance else 0,
        selection=selection,
        best=best,
    )
    return _bred(moved, parameters)


def _bred(search: ListSearch, parameters: ListParameters) -> ListSearch:
    """Return the search with offspring of its population."""
    population, cost = search.population, search.cost
    rng, offspring = copy.deepcopy(search.rng), np.empty_like(population)
    n_kept, n_mutated = parameters.shares
    breed_lists(
        population, cost, n_kept, n_mutated, parameters.mutation_code, rng, offspring
    )  # fmt: skip
    offspring_cost = np.full(cost.shape[0], np.inf)
    offspring_cost[:n_kept] = np.sort(cost)[:n_kept]
    return replace(
        search,
        offspring=offspring,
        offspring_cost=offspring_cost,
        position=n_kept,
        n_kept=n_kept,
        rng=rng,
    )


def genes_of(component: Component, instant: IntArray) -> int:
    """Return how many items a component has in all lists but the first, which stays in order."""
    return _genes_in(lists_of(component, instant).start)


def _genes_in(list_start: IntArray) -> int:
    return int(list_start[-1] - list_start[min(1, len(list_start) - 1)])


def make_table(component: Component, instant: IntArray) -> Table:
    """Return what decoding reads of a component.

    Parameters
    ----------
    component
        What is searched.
    instant
        Rank of each item in time.

    Returns
    -------
    Its lists, and where each node's children are.
    """
    lists = lists_of(component, instant)
    parent, item = component.parent, component.item
    root, child = np.flatnonzero(parent < 0), np.flatnonzero(parent >= 0)
    root = root[np.argsort(item[root], kind="stable")]
    child = child[np.lexsort((item[child], parent[child]))]
    return Table(
        member=lists.member,
        list_start=lists.start,
        root=root,
        root_start=np.searchsorted(item[root], np.arange(component.n_items + 1)),
        child=child,
        child_start=np.searchsorted(parent[child], np.arange(parent.shape[0] + 1)),
        least=least_below(component),
    )


def individual_of(
    component: Component, table: Table, selection: IntArray, length: int
) -> IntArray:
    """Return an individual made from a selection.

    Parameters
    ----------
    component, table
        What is searched.
    selection
        Each family's node, -1 for none. Where sequences share an item the better has it.
    length
        Of the permutations; at least that of the longest list. Of more sequences than that the
        worst are left out.

    Returns
    -------
    One permutation per list, of which a column for each sequence holds its items; what is left
    fills the rest in order.
    """
    n_lists = table.list_start.shape[0] - 1
    value, of = np.empty((2, component.n_items), dtype=np.int64)
    of[table.member] = np.repeat(np.arange(n_lists), np.diff(table.list_start))
    value[table.member] = np.arange(component.n_items) - table.list_start[of[table.member]]
    genes = np.full((n_lists, length), -1, dtype=np.int64)
    free = dict.fromkeys(reversed(range(length)))
    is_placed = np.zeros(component.n_items, dtype=np.bool_)
    taken = selection[selection >= 0]
    taken = taken[np.argsort(component.total[taken], kind="stable")]
    sequences = [_items(component, leaf) for leaf in taken.tolist()]
    # Those with an item of list 1, which stays in order, have only one column to be in.
    for items in sorted(sequences, key=lambda items: int(of[items].min()) > 0):
        place = next(iter(free), -1)
        if of[items].min() == 0:
            place = int(value[items[int(np.argmin(of[items]))]])
        if place in free and not is_placed[items].any():
            genes[of[items], place] = value[items]
            is_placed[items] = True
            del free[place]
    genes[:1] = np.arange(length)
    for row in genes[1:]:
        row[row < 0] = np.setdiff1d(np.arange(length), row)
    return genes


def _items(component: Component, node: int) -> list[int]:
    """Return the items of a node's sequence, the last first."""
    items = []
    while node >= 0:
        items.append(int(component.item[node]))
        node = int(component.parent[node])
    return items
