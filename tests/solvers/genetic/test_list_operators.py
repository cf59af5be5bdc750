"""Huo's operators: legal permutations, and what they do by hand."""

import numpy as np
import pytest

from trackweave.solvers.genetic._list_operators import (
    INVERSION,
    SHIFT,
    SWAP,
    breed_lists,
    match_partially,
    mutate,
    shuffle_lists,
)


def matched(first: list[int], second: list[int], begin: int, end: int) -> list[int]:
    child, room = np.empty((2, len(first)), dtype=np.int64)
    match_partially(np.array(first), np.array(second), begin, end, room, child)
    return child.tolist()


def rng() -> np.random.Generator:
    return np.random.default_rng(3)


def bred(population: np.ndarray, cost: np.ndarray, n_kept: int, n_mutated: int) -> np.ndarray:
    offspring = np.full_like(population, -1)
    breed_lists(population, cost, n_kept, n_mutated, SWAP, rng(), offspring)
    return offspring


def population_of(size: int, n_lists: int, length: int) -> np.ndarray:
    population = np.empty((size, n_lists, length), dtype=np.int64)
    shuffle_lists(rng(), 0, population)
    return population


def test_partially_matched_crossover_by_hand() -> None:
    # Michalewicz, Genetic Algorithms + Data Structures = Evolution Programs, section 10.
    first, second = [0, 1, 2, 3, 4, 5, 6, 7, 8], [3, 4, 1, 0, 7, 6, 5, 8, 2]
    assert matched(first, second, 3, 7) == [3, 1, 2, 0, 7, 6, 5, 4, 8]
    assert matched(second, first, 3, 7) == [0, 7, 1, 3, 4, 5, 6, 8, 2]


def test_partially_matched_crossover_gives_permutations_with_the_segment_of_the_other() -> None:
    maker = rng()
    for _ in range(300):
        length = int(maker.integers(1, 12))
        first, second = maker.permutation(length).tolist(), maker.permutation(length).tolist()
        begin, end = sorted(maker.integers(0, length + 1, 2).tolist())
        child = matched(first, second, begin, end)
        assert sorted(child) == list(range(length))
        assert child[begin:end] == second[begin:end]
        # What need not give way stays where it was.
        kept = [p for p in range(length) if not begin <= p < end]
        free = [p for p in kept if first[p] not in second[begin:end]]
        assert [child[p] for p in free] == [first[p] for p in free]


@pytest.mark.parametrize(
    ("kind", "first", "second", "expected"),
    [
        (SWAP, 1, 4, [0, 4, 2, 3, 1, 5]),
        (SWAP, 4, 1, [0, 4, 2, 3, 1, 5]),
        (INVERSION, 1, 4, [0, 4, 3, 2, 1, 5]),
        (INVERSION, 5, 2, [0, 1, 5, 4, 3, 2]),
        (SHIFT, 1, 4, [0, 2, 3, 4, 1, 5]),
        (SHIFT, 4, 1, [0, 4, 1, 2, 3, 5]),
        (SHIFT, 2, 2, [0, 1, 2, 3, 4, 5]),
    ],
)
def test_mutations_by_hand(kind: int, first: int, second: int, expected: list[int]) -> None:
    genes = np.arange(6)
    mutate(genes, first, second, kind)
    assert genes.tolist() == expected


def test_random_individuals_are_permutations_and_list_one_stays_in_order() -> None:
    population = population_of(40, 3, 7)
    assert (np.sort(population, axis=2) == np.arange(7)).all()
    assert (population[:, 0] == np.arange(7)).all()
    assert len({individual.tobytes() for individual in population}) == 40


def test_every_place_is_equally_likely_in_random_individuals() -> None:
    population = population_of(6000, 2, 4)
    share = [np.bincount(population[:, 1, place], minlength=4) / 6000 for place in range(4)]
    assert np.array(share) == pytest.approx(0.25, abs=0.03)


@pytest.mark.parametrize("kind", [SWAP, INVERSION, SHIFT])
def test_a_generation_is_the_best_then_children_then_mutants(kind: int) -> None:
    population = population_of(30, 4, 6)
    cost = rng().permutation(30).astype(float)
    offspring = np.full_like(population, -1)
    breed_lists(population, cost, 3, 10, kind, rng(), offspring)
    assert (offspring[:3] == population[np.argsort(cost)[:3]]).all()
    assert (np.sort(offspring, axis=2) == np.arange(6)).all()
    assert (offspring[:, 0] == np.arange(6)).all()
    for child in offspring[3:]:
        # One list at most differs from some parent's.
        assert (child != population).any(axis=2).sum(axis=1).min() <= 1


def test_mutants_have_two_genes_swapped() -> None:
    population = population_of(20, 3, 9)
    for mutant in bred(population, np.arange(20.0), 0, 20):
        assert (mutant != population).sum(axis=(1, 2)).min() == 2


def test_parents_are_chosen_by_linear_rank() -> None:
    population = np.zeros((4000, 1, 1), dtype=np.int64)
    population[:, 0, 0] = np.arange(4000)
    share = np.histogram(bred(population, np.arange(4000.0), 0, 4000), bins=4)[0] / 4000
    # The density 2 (1 − u) over ranks u gives quarters 7, 5, 3, 1 of 16.
    assert share == pytest.approx(np.array([7, 5, 3, 1]) / 16, abs=0.03)


@pytest.mark.parametrize(("n_lists", "length"), [(1, 5), (3, 1), (1, 1), (2, 0), (1, 0)])
def test_lists_too_short_to_change_are_handed_on(n_lists: int, length: int) -> None:
    population = population_of(6, n_lists, length)
    if length:
        assert (bred(population, np.arange(6.0), 1, 2) == population).all()
    else:
        assert population.size == 0
