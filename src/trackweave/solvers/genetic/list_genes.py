"""Individuals of one permutation per list."""

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.solvers._kernels import Component
from trackweave.solvers.genetic._columns import Table, evaluate_columns, least_below
from trackweave.solvers.genetic._list_operators import breed_lists, shuffle_lists
from trackweave.solvers.genetic.search import Coding, Offspring, items_of
from trackweave.solvers.lists import lists_of
from trackweave.solvers.resumable import Start

__all__ = ["ListGenes", "genes_in", "individual_of", "make_table"]


class ListGenes(Coding):
    """A permutation for each list, the items at one place of which are a candidate tuple."""

    __slots__ = ()

    @property
    def tolerance(self) -> float:
        """The greatest change of a generation's best cost that counts as none [nats]."""
        return float(self.parameters.tolerance)

    def first(self, start: Start) -> IntArray:
        """Return the first individuals; see ``Coding``."""
        size, sizes = self.parameters.population, np.diff(self.reads.list_start)
        seeds = start.seeds[: size // 2]
        # As long as the longest list, or longer where what is known has more sequences.
        known = max((int(np.count_nonzero(seed >= 0)) for seed in seeds), default=0)
        length = max(int(sizes.max(initial=0)), known)
        genes = np.empty((size, sizes.shape[0], length), dtype=np.int64)
        for row, seed in enumerate(seeds):
            genes[row] = self.individual(seed, length)
        shuffle_lists(start.rng, len(seeds), genes)
        return genes

    def individual(self, selection: IntArray, length: int) -> IntArray:
        """Return the individual that stands for a selection; see ``Coding``."""
        return individual_of(self.component, self.reads, selection, length)

    def evaluate(
        self, bred: Offspring, rows: IntArray, cost: FloatArray, selection: IntArray, best: float
    ) -> float:
        """Write the costs of some individuals, which stand one after the other."""
        first = int(rows[0]) if rows.size else 0
        return evaluate_columns(
            self.component, self.reads, bred.genes, first, first + rows.size, cost, selection,
            best,
        )  # fmt: skip

    def breed(self, population: IntArray, cost: FloatArray, rng: np.random.Generator) -> Offspring:
        """Return the next generation: the kept, whose costs are known, first."""
        genes, (n_kept, n_mutated) = np.empty_like(population), self.parameters.shares
        breed_lists(
            population, cost, n_kept, n_mutated, self.parameters.mutation_code, rng, genes
        )  # fmt: skip
        bred = Offspring.unknown(genes, np.arange(n_kept, cost.shape[0]))
        bred.cost[:n_kept] = np.sort(cost)[:n_kept]
        return bred


def genes_in(table: Table) -> int:
    """Return how many items there are in all lists but the first, which stays in order."""
    return int(table.list_start[-1] - table.list_start[min(1, len(table.list_start) - 1)])


def make_table(component: Component, instant: IntArray) -> Table:
    """Return what decoding reads of a component: its lists, and where each node's children are."""
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
    """Return the individual in which a column for each sequence of a selection holds its items."""
    # Where sequences share an item the better has it, and of more than there are columns the worst
    # are left out. What is left fills the rest in order.
    n_lists = table.list_start.shape[0] - 1
    value, of = np.empty((2, component.n_items), dtype=np.int64)
    of[table.member] = np.repeat(np.arange(n_lists), np.diff(table.list_start))
    value[table.member] = np.arange(component.n_items) - table.list_start[of[table.member]]
    genes = np.full((n_lists, length), -1, dtype=np.int64)
    free = dict.fromkeys(reversed(range(length)))
    is_placed = np.zeros(component.n_items, dtype=np.bool_)
    taken = selection[selection >= 0]
    taken = taken[np.argsort(component.total[taken], kind="stable")]
    sequences = [items_of(component, leaf) for leaf in taken.tolist()]
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
