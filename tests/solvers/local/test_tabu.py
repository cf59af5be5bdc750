"""Tabu search: what is forbidden, what is done all the same, where it starts anew."""

from dataclasses import replace

import numpy as np
import pytest

from oracles.assignment import hard_tuples, in_ones, least_cost, random_problem
from trackweave.errors import InvalidInputError
from trackweave.solvers import Greedy, TabuSearch
from trackweave.solvers.components import Components
from trackweave.solvers.local._moves import Moves, begin_holding, cost_of, list_moves
from trackweave.solvers.local._tabu import is_tabu, seek
from trackweave.solvers.local.tabu import ELITE, TabuState

UNSEEDED = TabuSearch(
    evaluations=20_000, moves_per_item=50, seeded=False, improvement=False, decompose=False
)
HARD = hard_tuples(0, 300, 10)


def rng() -> np.random.Generator:
    return np.random.default_rng(9)


class Walk:
    """A tabu search that is led by the hand."""

    def __init__(self, tenure: int, sample: int = 20) -> None:
        component = Components.of(in_ones(HARD), None, whole=True).component(0)
        self.moves: Moves = list_moves(component, np.zeros(component.n_items), np.inf)
        self.holder = begin_holding(self.moves, component, np.full(component.must.shape[0], -1))
        self.until = np.zeros(self.moves.node.shape[0], dtype=np.int64)
        self.best_holder, self.rng = self.holder.copy(), rng()
        self.current = self.best = cost_of(self.moves, self.holder)
        self.iteration, self.tenure, self.sample = 0, tenure, sample

    def step(self) -> set[int]:
        """Make one iteration; return the candidates that came or went."""
        before = set(self.holder.tolist())
        self.current, self.best = seek(
            self.moves, np.array([0.5, 2.0]), 2, self.sample, self.tenure,
            (self.iteration, self.iteration + 1), self.rng, self.until, self.holder,
            self.current, self.best_holder, self.best,
        )  # fmt: skip
        self.iteration += 1
        return before ^ set(self.holder.tolist()) - {-1}


class TestSeek:
    def test_what_came_or_went_stays_so_but_for_a_new_best(self) -> None:
        walk, changed_at, n_checked = Walk(tenure=6), dict[int, int](), 0
        for iteration in range(3_000):
            best = walk.best
            changed = walk.step() - {-1}
            for candidate in changed:
                if candidate in changed_at and walk.best == best:
                    assert iteration - changed_at[candidate] > 6
                    n_checked += 1
                changed_at[candidate] = iteration
        assert n_checked > 100

    def test_goes_on_where_nothing_is_better(self) -> None:
        walk, costs = Walk(tenure=5), []
        for _ in range(1_000):
            walk.step()
            costs.append(walk.current)
            assert walk.current == pytest.approx(cost_of(walk.moves, walk.holder), abs=1e-9)
            assert walk.best == cost_of(walk.moves, walk.best_holder)
        assert (np.diff(costs) > 0.1).sum() > 50
        assert walk.best == pytest.approx(min(costs))

    def test_makes_the_best_move_of_its_sample(self) -> None:
        first = [np.mean([self.first_gain(sample, seed) for seed in range(30)])
                 for sample in (1, 5, 50)]  # fmt: skip
        assert first[0] > first[1] > first[2]

    @staticmethod
    def first_gain(sample: int, seed: int) -> float:
        walk = Walk(tenure=5, sample=sample)
        walk.rng = np.random.default_rng(seed)
        walk.step()
        return float(walk.current)

    def test_a_move_is_tabu_for_any_part_of_it(self) -> None:
        until, log = np.array([0, 4, 0]), np.array([-1 - 0, 2, -1 - 1])
        assert not is_tabu(until, 3, log, 2)
        assert is_tabu(until, 3, log, 3)
        assert not is_tabu(until, 4, log, 3)
        assert is_tabu(until, 3, np.array([1]), 1)


class TestTabuSearch:
    @pytest.mark.parametrize(
        "solver", [UNSEEDED, replace(UNSEEDED, improvement=True, decompose=True)]
    )
    def test_finds_the_optimum_of_small_problems_without_prices(self, solver) -> None:
        for seed in range(30):
            problem = random_problem(np.random.default_rng([15, seed]))
            answer = solver(problem, rng=rng())
            assert answer.cost == pytest.approx(least_cost(problem), abs=1e-8)

    def test_is_better_than_greedy(self) -> None:
        answer = UNSEEDED(HARD, rng=rng())
        assert answer.cost < Greedy()(HARD, rng=rng()).cost - 1.0

    def test_ends_after_a_number_of_moves_to_whole_steps(self) -> None:
        answer = replace(UNSEEDED, evaluations=12_345, sample=30)(HARD, rng=rng())
        assert (answer.evaluations, answer.stop_reason) == (13 * 1_020, "evaluations")

    def test_ends_when_starts_find_nothing_better(self) -> None:
        solver = replace(UNSEEDED, evaluations=10**7, patience=3)
        answer = solver(HARD, rng=rng())
        assert answer.stop_reason == "converged"
        longer = replace(solver, patience=6)(HARD, rng=rng())
        assert longer.evaluations > answer.evaluations
        assert longer.cost <= answer.cost

    def test_starts_in_turn_with_nothing_the_best_and_a_part_of_an_elite(self) -> None:
        solver = replace(UNSEEDED, evaluations=60_000)
        state = solver.start(HARD, rng=rng())
        starts: dict[int, TabuState] = {}
        while not state.done:
            state = solver.advance(state, evaluations=1_000)
            if state.search is not None:
                starts.setdefault(state.search.starts, state.search)
        assert len(starts) > 7
        for number, search in list(starts.items())[1:]:
            assert search.found == search.iteration
            assert not search.until.any()
            if number % 3 == 1:
                assert search.current == 0.0
            elif number % 3 == 2:
                assert search.current == search.best
            else:
                assert 0.0 > search.current >= search.best
            costs = [cost_of(search.ground.moves, holder) for holder in search.elite]
            assert costs == sorted(costs)
            assert len(costs) <= ELITE
            assert costs[0] == search.best

    @pytest.mark.parametrize(
        ("name", "value"),
        [
            ("evaluations", 0),
            ("sample", 0),
            ("tenure", -1),
            ("links", 0),
            ("moves_per_item", 0),
            ("patience", 0),
        ],
    )
    def test_refuses_parameters_out_of_range(self, name: str, value: int) -> None:
        with pytest.raises(InvalidInputError, match=rf"{name}: {value}; expected"):
            TabuSearch(**{name: value})
