"""The search over lists as a value: stop rules, and what goes on between generations."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from oracles.assignment import least_cost
from trackweave.association.problem import AssignmentProblem
from trackweave.errors import InvalidInputError
from trackweave.solvers import Hint, ListGenetic

LETTER = ListGenetic(
    population=20, generations=6, seeded=False, improvement=False, decompose=False
)  # fmt: skip


def rng() -> np.random.Generator:
    return np.random.default_rng(9)


def dense(size: int = 8, n_lists: int = 3) -> AssignmentProblem:
    """Return an axial problem, every item of which has to be covered once."""
    costs = np.random.default_rng(size).uniform(0.0, 10.0, (size,) * n_lists)
    return AssignmentProblem.from_array(costs)


class TestStopRules:
    def test_after_a_number_of_generations(self) -> None:
        answer = replace(LETTER, generations=3)(dense(), rng=rng())
        # Of 20, 2 are kept from the second generation on.
        assert (answer.evaluations, answer.stop_reason) == (20 + 2 * 18, "generations")

    def test_when_the_best_has_not_changed_for_so_many_generations(self) -> None:
        answer = replace(LETTER, generations=99, tolerance=1e9, patience=4)(dense(), rng=rng())
        # The first generation has none before it.
        assert (answer.evaluations, answer.stop_reason) == (20 + 4 * 18, "converged")

    def test_a_change_starts_the_count_anew(self) -> None:
        solver = replace(LETTER, generations=200, evaluations=10**6, patience=15)
        state = solver.start(dense(), rng=rng())
        best = []
        while not state.done:
            state = solver.advance(state, evaluations=20 if not best else 18)
            if state.search is not None:
                best.append(float(state.search.cost.min()))
        steps = np.diff(best)
        assert (steps <= 0).all()
        assert (steps[:15] < 0).any()
        assert solver.answer(state).stop_reason == "converged"
        # 15 generations without a change, the last of which ended the search.
        assert (steps[-14:] == 0).all()
        assert steps[-15] < 0

    def test_when_so_many_are_decoded_to_whole_generations(self) -> None:
        answer = replace(LETTER, evaluations=50)(dense(), rng=rng())
        assert (answer.evaluations, answer.stop_reason) == (56, "evaluations")

    def test_when_the_bound_proves_the_best(self) -> None:
        easy = AssignmentProblem.from_tuples([[1, 1], [2, 2]], [-1.0, -1.0])
        answer = LETTER(easy, rng=rng())
        assert (answer.stop_reason, answer.status) == ("gap closed", "optimal")


class TestGenerations:
    def test_the_kept_are_the_best_and_are_not_decoded_again(self) -> None:
        state = LETTER.advance(LETTER.start(dense(), rng=rng()), evaluations=20)
        search = state.search
        ranking = np.argsort(search.cost, kind="stable")[:2]
        assert (search.bred.genes[:2] == search.population[ranking]).all()
        assert search.bred.cost[:2].tolist() == search.cost[ranking].tolist()
        assert np.isinf(search.bred.cost[2:]).all()
        assert search.at_rest

    def test_sizes_add_up(self) -> None:
        for population, reproduction, mutation in (
            (2, 0.99, 0.0), (7, 0.5, 0.5), (50, 0.1, 0.9), (3, 0.0, 1.0), (9, 0.33, 0.33),
        ):  # fmt: skip
            solver = ListGenetic(
                population=population, reproduction=reproduction, mutation=mutation
            )
            n_kept, n_mutants = solver.shares
            assert 0 <= n_kept < population
            assert 0 <= n_mutants <= population - n_kept

    def test_sizes_grow_with_the_problem_where_they_are_told_to(self) -> None:
        usual = ListGenetic(population=10, generations=3, evaluations=100, patience=2)
        grown = replace(usual, by_size=True)
        assert usual.for_genes(40) is usual
        assert grown.for_genes(20).population == 10
        twice = grown.for_genes(40)
        assert (twice.population, twice.generations) == (40, 6)
        assert (twice.patience, twice.evaluations) == (4, 800)

    def test_a_search_by_size_runs_as_one_of_the_grown_sizes(self) -> None:
        problem = dense(21)
        asked = replace(LETTER, generations=2, evaluations=10**6, by_size=True)
        plain = replace(asked.for_genes(42), by_size=False)
        assert plain.population > LETTER.population
        found, expected = asked(problem, rng=rng()), plain(problem, rng=rng())
        assert (found.cost, found.evaluations) == (expected.cost, expected.evaluations)

    @pytest.mark.parametrize("mutate", ["swap", "inversion", "shift"])
    def test_finds_the_best_of_a_small_dense_problem(self, mutate: str) -> None:
        problem = dense(4)
        solver = replace(LETTER, population=60, generations=60, mutate=mutate)
        assert solver(problem, rng=rng()).cost == pytest.approx(least_cost(problem))

    def test_evolution_beats_as_many_random_individuals(self) -> None:
        evolved = replace(LETTER, generations=40)(dense(), rng=rng())
        drawn = replace(LETTER, population=evolved.evaluations, generations=1)(dense(), rng=rng())
        assert evolved.cost < drawn.cost - 1.0

    def test_local_improvement_never_hurts(self) -> None:
        for size in (4, 6, 8):
            plain = LETTER(dense(size), rng=rng())
            better = replace(LETTER, improvement=True)(dense(size), rng=rng())
            assert better.cost <= plain.cost

    def test_what_is_known_is_among_the_first(self) -> None:
        problem = dense(6)
        best = replace(LETTER, population=100, generations=100)(problem, rng=rng())
        hint = Hint(nodes=best.nodes)
        solver = ListGenetic(population=4, generations=1, improvement=False)
        assert solver(problem, rng=rng(), hint=hint).cost <= best.cost + 1e-9

    def test_more_known_sequences_than_any_list_has_items_find_room(self) -> None:
        rows = [[1, 1, 0], [2, 0, 1], [0, 2, 2], [3, 3, 0]]
        problem = AssignmentProblem.from_tuples(rows, [-4.0, -3.0, -2.0, -1.0])
        solver = ListGenetic(decompose=False)
        assert solver(problem, rng=rng()).cost == -10.0


@pytest.mark.parametrize(
    "wrong",
    [
        {"population": 1}, {"generations": 0}, {"evaluations": 0}, {"reproduction": 1.0},
        {"reproduction": -0.1}, {"mutation": 0.95}, {"mutation": np.nan}, {"mutate": "turn"},
        {"tolerance": -1.0}, {"patience": 0}, {"reproduction": np.nan},
    ],
    ids=str,
)  # fmt: skip
def test_refuses_parameters_out_of_range(wrong: dict[str, Any]) -> None:
    name = next(iter(wrong))
    with pytest.raises(InvalidInputError, match=f"^{name}: "):
        ListGenetic(**wrong)
