"""Individuals that are orders of reports, or lists of associations between them."""

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.solvers._kernels import Component
from trackweave.solvers.genetic._decoding import Lookup, Trail, begin, evaluate
from trackweave.solvers.genetic._operators import breed, random_population
from trackweave.solvers.genetic.search import Coding, Offspring, items_of
from trackweave.solvers.resumable import Start

__all__ = ["ReportGenes", "fresh_trail", "genes_of", "in_time_order", "make_lookup"]


class ReportGenes(Coding):
    """A gene for each report: its place in the order, or the report that it follows."""

    __slots__ = ()

    def first(self, start: Start) -> IntArray:
        """Return the first individuals; see ``Coding``."""
        component, lookup, parameters = self.component, self.reads, self.parameters
        n_genes = lookup.gene_item.shape[0]
        size, _ = parameters.sizes(n_genes)
        genes = np.empty((size, n_genes), dtype=np.int64)
        rows = [self.individual(seed, n_genes) for seed in start.seeds[: size // 2]]
        if parameters.seeded:
            rows.append(in_time_order(component, lookup, parameters.is_permutation))
        if parameters.is_permutation and parameters.first == "in-time-order":
            rows += _instants_in_order(lookup, size // 2 - len(rows), start.rng)
        for row, own in enumerate(rows):
            genes[row] = own
        random_population(
            component, lookup, parameters.is_permutation, start.rng, len(rows), genes
        )
        return genes

    def individual(self, selection: IntArray, length: int) -> IntArray:
        """Return the individual that stands for a selection; see ``Coding``."""
        return genes_of(self.component, self.reads, self.parameters.is_permutation, selection)

    def evaluate(
        self, bred: Offspring, rows: IntArray, cost: FloatArray, selection: IntArray, best: float
    ) -> float:
        """Write the costs of some individuals; see ``Coding``."""
        trail = fresh_trail(self.component, bred.genes.shape[1])
        return evaluate(
            self.component, self.reads, self.parameters.is_permutation, bred.genes, rows, trail,
            cost, selection, best,
        )  # fmt: skip

    def breed(self, population: IntArray, cost: FloatArray, rng: np.random.Generator) -> Offspring:
        """Return the next generation, children of one beginning decoded one after the other."""
        parameters = self.parameters
        genes, key = np.empty_like(population), np.empty(population.shape[0], dtype=np.int64)
        breed(
            self.component, self.reads, parameters.is_permutation, population, cost,
            np.array([parameters.crossover, parameters.mutation]), parameters.selection_code,
            parameters.elite, rng, genes, key,
        )  # fmt: skip
        return Offspring.unknown(genes, np.argsort(key, kind="stable"))


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


def fresh_trail(component: Component, n_genes: int) -> Trail:
    """Return room for decoding permutations of so many genes, none of them decoded."""
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
    """Return an individual made from a selection: an order of the items, or their predecessors."""
    # In the order the sequences' items come first, those of the best before all; where sequences
    # share an item the better has it.
    taken = selection[selection >= 0]
    taken = taken[np.argsort(component.total[taken], kind="stable")]
    ordered: list[int] = []
    before = np.full(component.n_items, -1, dtype=np.int64)
    for leaf in taken.tolist():
        sequence = items_of(component, leaf)[::-1]
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
