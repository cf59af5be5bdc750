"""The patent's operators on whole populations. Nothing here checks or raises."""

import numpy as np

from trackweave._loops import ascending
from trackweave.arrays import FloatArray, IntArray
from trackweave.jit import jit
from trackweave.solvers._kernels import Component
from trackweave.solvers.genetic._decoding import Lookup

RANK, TOURNAMENT = 0, 1


@jit
def crossover(
    first: IntArray, second: IntArray, cut: int, seen: np.ndarray, child: IntArray
) -> None:
    """Write the genes of ``first`` up to the cut, then the missing ones as ``second`` has them.

    ``seen`` is room for one flag per item. US 6,055,523, column 5.
    """
    seen[:] = False
    for place in range(cut):
        child[place] = first[place]
        seen[first[place]] = True
    fill = cut
    for gene in second:
        if not seen[gene]:
            child[fill] = gene
            fill += 1


@jit
def move(genes: IntArray, source: int, target: int) -> None:
    """Take the gene at one place and put it at another; those between close up."""
    gene = genes[source]
    if source < target:
        for place in range(source, target):
            genes[place] = genes[place + 1]
    else:
        for place in range(source, target, -1):
            genes[place] = genes[place - 1]
    genes[target] = gene


@jit
def random_population(
    component: Component,
    lookup: Lookup,
    is_permutation: bool,
    rng: np.random.Generator,
    first: int,
    population: IntArray,
) -> None:
    """Fill the rows from ``first`` on with random individuals."""
    n_genes = lookup.gene_item.shape[0]
    for row in range(first, population.shape[0]):
        genes = population[row]
        for place in range(n_genes):
            if is_permutation:
                genes[place] = lookup.gene_item[place]
            else:
                genes[place] = random_association(component, lookup, place, rng)
        if is_permutation:
            for place in range(n_genes - 1, 0, -1):
                other = rng.integers(0, place + 1)
                genes[place], genes[other] = genes[other], genes[place]


@jit
def random_association(
    component: Component, lookup: Lookup, place: int, rng: np.random.Generator
) -> int:
    """Return an item that the item at this place can follow, or -1 for none before it."""
    item = lookup.gene_item[place]
    first, last = lookup.item_start[item], lookup.item_start[item + 1]
    if first == last:
        return -1
    above = component.parent[lookup.by_item[rng.integers(first, last)]]
    return component.item[above] if above >= 0 else -1


@jit
def pick(ranking: IntArray, selection: int, rng: np.random.Generator) -> int:
    """Return a parent: fitter individuals are taken with higher probability.

    By rank, the best is taken twice as often as the middle and the worst never; by tournament,
    the better of two taken at random.
    """
    size = ranking.shape[0]
    if selection == TOURNAMENT:
        return int(ranking[min(rng.integers(0, size), rng.integers(0, size))])
    # The density 2 (1 − u) over ranks u has the distribution 1 − (1 − u)².
    return int(ranking[min(int(size * (1.0 - np.sqrt(rng.random()))), size - 1)])


@jit
def breed(
    component: Component,
    lookup: Lookup,
    is_permutation: bool,
    population: IntArray,
    cost: FloatArray,
    chances: FloatArray,
    selection: int,
    elite: int,
    rng: np.random.Generator,
    offspring: IntArray,
    key: IntArray,
) -> None:
    """Write the next generation, and a key that sorts children of one beginning together.

    ``chances`` are those of crossover and of mutation. The ``elite`` best go on unchanged.
    """
    size, n_genes = population.shape
    ranking = ascending(cost)
    seen = np.zeros(component.n_items, dtype=np.bool_)
    for row in range(elite):
        offspring[row] = population[ranking[row]]
        key[row] = ranking[row] * (n_genes + 1)
    row = elite
    while row < size:
        first, second = pick(ranking, selection, rng), pick(ranking, selection, rng)
        cut = n_genes
        if n_genes > 1 and rng.random() < chances[0]:
            cut = rng.integers(1, n_genes)
        for child in range(2):
            if row == size:
                break
            mother, father = (first, second) if child == 0 else (second, first)
            genes = offspring[row]
            if is_permutation and cut < n_genes:
                crossover(population[mother], population[father], cut, seen, genes)
            else:
                genes[:cut] = population[mother, :cut]
                genes[cut:] = population[father, cut:]
            if n_genes > 0 and rng.random() < chances[1]:
                place = int(rng.integers(0, n_genes))
                if is_permutation:
                    move(genes, place, int(rng.integers(0, n_genes)))
                else:
                    genes[place] = random_association(component, lookup, place, rng)
            key[row] = mother * (n_genes + 1) + n_genes - cut
            row += 1
