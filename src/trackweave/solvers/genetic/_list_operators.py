"""Operators on one permutation per list. Nothing here checks or raises."""

import numpy as np

from trackweave._loops import ascending
from trackweave.arrays import FloatArray, IntArray
from trackweave.jit import jit
from trackweave.solvers.genetic._operators import RANK, move, pick

SWAP, INVERSION, SHIFT = 0, 1, 2


@jit
def match_partially(
    first: IntArray, second: IntArray, begin: int, end: int, place_of: IntArray, child: IntArray
) -> None:
    """Write ``first`` with the genes of ``second`` at the places begin … end − 1, made legal.

    A gene that this would make double becomes the one that it was exchanged for. ``place_of`` is
    room for one place per gene. Partially matched crossover, Goldberg & Lingle 1985.
    """
    place_of[:] = -1
    for place in range(begin, end):
        child[place] = second[place]
        place_of[second[place]] = place
    for place in range(first.shape[0]):
        if begin <= place < end:
            continue
        gene = first[place]
        while place_of[gene] >= 0:
            gene = first[place_of[gene]]
        child[place] = gene


@jit
def mutate(genes: IntArray, first: int, second: int, kind: int) -> None:
    """Swap the genes at two places, turn round what lies between, or move one to the other."""
    if kind == SWAP:
        genes[first], genes[second] = genes[second], genes[first]
    elif kind == INVERSION:
        low, high = min(first, second), max(first, second)
        while low < high:
            genes[low], genes[high] = genes[high], genes[low]
            low += 1
            high -= 1
    else:
        move(genes, first, second)


@jit
def shuffle_lists(rng: np.random.Generator, first: int, population: IntArray) -> None:
    """Fill the individuals from ``first`` on with random permutations; list 1 stays in order."""
    n_lists, length = population.shape[1:]
    for row in range(first, population.shape[0]):
        for number in range(n_lists):
            genes = population[row, number]
            for place in range(length):
                genes[place] = place
            if number == 0:
                continue
            for place in range(length - 1, 0, -1):
                other = rng.integers(0, place + 1)
                genes[place], genes[other] = genes[other], genes[place]


@jit
def breed_lists(
    population: IntArray,
    cost: FloatArray,
    n_kept: int,
    n_mutated: int,
    kind: int,
    rng: np.random.Generator,
    offspring: IntArray,
) -> None:
    """Write the next generation: the best kept, then children, then mutants.

    Parents are taken by rank. Crossover and mutation change one list, never list 1.
    """
    size, n_lists, length = population.shape
    ranking = ascending(cost)
    place_of = np.empty(length, dtype=np.int64)
    for row in range(n_kept):
        offspring[row] = population[ranking[row]]
    row = n_kept
    while row < size - n_mutated:
        first, second = pick(ranking, RANK, rng), pick(ranking, RANK, rng)
        number, begin, end = 0, 0, 0
        if n_lists > 1:
            number = int(rng.integers(1, n_lists))
            one, other = int(rng.integers(0, length)), int(rng.integers(0, length))
            begin, end = min(one, other), max(one, other) + 1
        for child in range(2):
            if row == size - n_mutated:
                break
            mother, father = (first, second) if child == 0 else (second, first)
            offspring[row] = population[mother]
            match_partially(
                population[mother, number], population[father, number], begin, end, place_of,
                offspring[row, number],
            )  # fmt: skip
            row += 1
    while row < size:
        offspring[row] = population[pick(ranking, RANK, rng)]
        if n_lists > 1 and length > 1:
            number = int(rng.integers(1, n_lists))
            one, other = int(rng.integers(0, length)), int(rng.integers(0, length - 1))
            other += int(other >= one)
            mutate(offspring[row, number], one, other, kind)
        row += 1
