"""Cooling: what is accepted, how temperatures fall, when the search ends."""

from dataclasses import replace

import numpy as np
import pytest

from oracles.assignment import hard_tuples, in_ones, least_cost, random_problem
from trackweave.association.problem import AssignmentProblem
from trackweave.errors import InvalidInputError
from trackweave.solvers import Annealing, Greedy, Hint
from trackweave.solvers.components import Components
from trackweave.solvers.local._moves import begin_holding, cost_of, list_moves
from trackweave.solvers.local._tabu import anneal
from trackweave.solvers.local.annealing import LEVELS, AnnealingState

UNSEEDED = Annealing(
    evaluations=20_000, moves_per_item=100, seeded=False, improvement=False, decompose=False
)
HARD = hard_tuples(0, 300, 10)


def rng() -> np.random.Generator:
    return np.random.default_rng(9)


def begun(problem: AssignmentProblem, temperature: float, count: int, links: int = 2):
    """Return costs before, present and best after so many moves, and whether each was dearer."""
    component = Components.of(in_ones(problem), None, whole=True).component(0)
    moves = list_moves(component, np.zeros(component.n_items), np.inf)
    holder = begin_holding(moves, component, np.full(component.must.shape[0], -1))
    best_holder, current, source = holder.copy(), cost_of(moves, holder), rng()
    best, costs = current, [current]
    for _ in range(count):
        current, best = anneal(
            moves, temperature, links, 1, source, holder, current, best_holder, best
        )
        assert current == pytest.approx(cost_of(moves, holder), abs=1e-9)
        assert best == cost_of(moves, best_holder)
        costs.append(current)
    return np.array(costs), best


class TestAnneal:
    def test_accepts_nothing_dearer_when_it_is_cold(self) -> None:
        costs, best = begun(HARD, 1e-9, 2_000)
        assert (np.diff(costs) <= 1e-6).all()
        assert best == pytest.approx(costs[-1])
        assert best < costs[0] - 10.0

    def test_accepts_dearer_answers_when_it_is_hot(self) -> None:
        costs, best = begun(HARD, 10.0, 2_000)
        assert (np.diff(costs) > 0.1).sum() > 200
        assert best == pytest.approx(costs.min())
        assert best < costs[-1]

    def test_accepts_as_metropolis_says(self) -> None:
        # Two pairs that share an item, and cost 1 apart.
        problem = AssignmentProblem.from_tuples([[1, 1], [1, 2]], [-2.0, -1.0])
        component = Components.of(in_ones(problem), None, whole=True).component(0)
        moves = list_moves(component, np.zeros(component.n_items), np.inf)
        n_dearer, n_tries, source = 0, 20_000, rng()
        for _ in range(n_tries):
            holder = np.full(component.n_items, -1)
            holder[moves.item[moves.start[0] : moves.start[1]]] = 0
            now, _ = anneal(moves, 1.0, 1, 1, source, holder, -2.0, holder.copy(), -2.0)
            n_dearer += now > -1.5
        # No item lacks anything, so any may be drawn. The dearer pair, of excess 1, is within a
        # window of mean 1 with probability exp(−1); its own item then has no other to offer, and
        # the shared one offers it half the time.
        proposed = np.exp(-1.0) * (1.0 / 3.0 + 1.0 / 6.0)
        assert n_dearer / n_tries == pytest.approx(proposed * np.exp(-1.0), rel=0.06)


class TestSchedule:
    def test_falls_geometrically_from_hot_to_cold(self) -> None:
        schedule = Annealing(hot=2.0, cold=0.1)
        levels = [schedule.temperature(level, 3.0) for level in range(LEVELS)]
        assert (levels[0], levels[-1]) == pytest.approx((6.0, 0.3))
        ratio = np.array(levels[1:]) / np.array(levels[:-1])
        assert ratio == pytest.approx(ratio[0])

    def test_a_cooling_takes_no_more_than_the_budget(self) -> None:
        for evaluations, moves in ((10**6, 400 * 500), (10_000, 10_000)):
            solver = Annealing(moves_per_item=400, evaluations=evaluations)
            assert solver.length(500) == moves // LEVELS


class TestAnnealing:
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

    def test_ends_after_a_number_of_moves_to_whole_temperatures(self) -> None:
        solver = replace(UNSEEDED, evaluations=12_345, moves_per_item=10**6)
        answer = solver(HARD, rng=rng())
        assert (answer.evaluations, answer.stop_reason) == (50 * 247, "evaluations")

    def test_ends_when_coolings_find_nothing_better(self) -> None:
        solver = replace(UNSEEDED, evaluations=10**7, moves_per_item=50, patience=2)
        answer = solver(HARD, rng=rng())
        assert answer.stop_reason == "converged"
        assert answer.evaluations % (LEVELS * 100) == 0
        longer = replace(solver, patience=4)(HARD, rng=rng())
        assert longer.evaluations > answer.evaluations
        assert longer.cost <= answer.cost

    def test_coolings_begin_in_turn_with_nothing_and_with_the_best(self) -> None:
        solver = replace(UNSEEDED, moves_per_item=50)
        state = solver.start(HARD, rng=rng())
        seen: list[AnnealingState] = []
        while not state.done:
            state = solver.advance(state, evaluations=100)
            search = state.search
            if search is not None and search.level == search.position == 0:
                seen.append(search)
        assert len(seen) > 2
        for search in seen:
            from_best = search.cooling % 2 == 1
            assert (search.current == search.best) == from_best
            assert from_best or search.current == 0.0

    def test_goes_on_from_the_answer_of_a_hint(self) -> None:
        best = replace(UNSEEDED, evaluations=200_000)(HARD, rng=rng())
        solver = Annealing(evaluations=100)
        answer = solver(HARD, rng=rng(), hint=Hint(nodes=best.nodes))
        assert answer.cost <= best.cost + 1e-9

    @pytest.mark.parametrize(
        ("name", "value"),
        [
            ("evaluations", 0),
            ("moves_per_item", 0),
            ("hot", 0.0),
            ("hot", np.inf),
            ("cold", 0.0),
            ("cold", 5.0),
            ("links", 0),
            ("patience", 0),
        ],
    )
    def test_refuses_parameters_out_of_range(self, name: str, value: float) -> None:
        with pytest.raises(InvalidInputError, match=rf"{name}: {value}; expected"):
            Annealing(**{name: value})
