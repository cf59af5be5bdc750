"""The dual: bounds, enumeration and what parameters mean."""

import numpy as np
import pytest

from oracles.assignment import in_ones, least_cost, random_problem
from trackweave.association.problem import AssignmentProblem, Status
from trackweave.errors import InvalidInputError
from trackweave.solvers import Dual, Hint
from trackweave.solvers._dual import ascend, begin_ascent
from trackweave.solvers._enumeration import enumerate_open
from trackweave.solvers.components import Components

N_PROBLEMS = 250


@pytest.fixture(scope="module")
def solved() -> list[tuple[AssignmentProblem, float]]:
    problems = [random_problem(np.random.default_rng([1, seed])) for seed in range(N_PROBLEMS)]
    return [(problem, least_cost(problem)) for problem in problems]


@pytest.fixture(scope="module")
def rng() -> np.random.Generator:
    return np.random.default_rng(0)


# A triangle: each two of three sequences share an item, so that the LP takes half of each.
TRIANGLE = in_ones(
    AssignmentProblem.from_tuples([[1, 1, 0], [0, 1, 1], [1, 0, 1]], [-2.1, -2.1, -2.1])
)


@pytest.mark.parametrize("iterations", [1, 3, 30])
def test_the_bound_is_never_above_the_optimum(solved, rng, iterations: int) -> None:
    for problem, optimum in solved:
        answer = Dual(iterations=iterations, visits=0)(problem, rng=rng)
        assert answer.lower_bound <= optimum + 1e-8 * max(1.0, abs(optimum))


def test_more_iterations_never_lower_the_bound(solved, rng) -> None:
    for problem, _ in solved[:60]:
        few, many = (Dual(iterations=n, visits=0)(problem, rng=rng) for n in (2, 60))
        assert many.lower_bound >= few.lower_bound - 1e-9


def test_enumeration_proves_the_optimum(solved, rng) -> None:
    for problem, optimum in solved:
        answer = Dual(iterations=2, visits=1_000_000)(problem, rng=rng)
        assert answer.status is Status.OPTIMAL
        assert answer.cost == pytest.approx(optimum, abs=1e-8)


def test_prices_alone_cannot_prove_a_triangle(rng) -> None:
    without = Dual(visits=0)(TRIANGLE, rng=rng)
    assert (without.cost, without.status) == (-2.1, Status.FEASIBLE)
    assert without.lower_bound == pytest.approx(-3.15, abs=0.05)
    assert without.stop_reason == "bound stalled"
    proven = Dual()(TRIANGLE, rng=rng)
    assert (proven.cost, proven.lower_bound, proven.status) == (-2.1, -2.1, Status.OPTIMAL)


def test_enumeration_out_of_visits_claims_nothing() -> None:
    components = Components.of(TRIANGLE, None)
    component, price = components.component(0), components.price.copy()
    selection = components.taken.copy()
    ascent = begin_ascent(price, np.inf, -np.inf)
    ascend(component, price, selection, ascent, 5, 5, 1e-9)
    upper, lower = ascent.value[:2]
    cost, complete, visits = enumerate_open(component, price, selection, upper, 1)
    assert (complete, visits) == (False, 1)
    assert cost == upper > lower


def test_enumeration_finds_an_answer_from_nothing() -> None:
    components = Components.of(TRIANGLE, None)
    selection = np.full(components.taken.shape[0], -1)
    cost, complete, _ = enumerate_open(
        components.component(0), components.price, selection, np.inf, 1000
    )
    assert (cost, complete, (selection >= 0).sum()) == (-2.1, True, 1)


def test_its_prices_are_a_start_that_saves_work(solved, rng) -> None:
    first_work = second_work = 0
    for problem, _ in solved[:60]:
        first = Dual()(problem, rng=rng)
        second = Dual()(problem, rng=rng, hint=Hint(prices=first.prices))
        assert (first.prices >= 0).all()
        assert second.lower_bound >= first.lower_bound - 1e-9
        first_work += first.evaluations
        second_work += second.evaluations
    assert second_work < 0.7 * first_work


def test_an_item_that_nobody_else_wants_is_worth_nothing(rng) -> None:
    problem = AssignmentProblem.from_tuples([[1, 1], [2, 2]], [-3.0, -1.0])
    assert Dual()(problem, rng=rng).prices.tolist() == [0.0] * 4


def test_a_stop_is_asked_for_between_components(rng) -> None:
    chains = AssignmentProblem(
        parent=np.where(np.arange(6000) % 2, np.arange(6000) - 1, -1),
        item=np.arange(6000),
        cost=np.array([0.0, -1.0] * 3000),
        total=np.array([0.0, -1.0] * 3000),
        must_cover=np.zeros(6000),
        instant=np.arange(6000),
    )
    asked: list[int] = []

    def stop() -> bool:
        asked.append(1)
        return len(asked) > 1

    assert Dual()(chains, rng=rng, stop=stop).cost == -3000.0
    assert len(asked) == 2


def large() -> AssignmentProblem:
    source = np.random.default_rng(5)
    rows = source.integers(1, 25, (1500, 4))
    return AssignmentProblem.from_tuples(rows, source.normal(-5.0, 1.0, 1500))


def test_a_large_component_is_bounded_the_same_with_looks_at_the_clock(rng) -> None:
    problem = large()
    asked: list[int] = []
    blind = Dual()(problem, rng=rng)
    looking = Dual()(problem, rng=rng, stop=lambda: bool(asked.append(1)))
    assert problem.n_nodes > 2000
    assert len(asked) > 1
    assert looking.certificate == blind.certificate
    assert looking.nodes.tolist() == blind.nodes.tolist()
    assert looking.evaluations == blind.evaluations


def test_a_stop_is_seen_inside_a_large_component(rng) -> None:
    answers = []
    for patience in (1, 2, 100):
        asked: list[int] = []

        def stop(asked: list[int] = asked, patience: int = patience) -> bool:
            asked.append(1)
            return len(asked) > patience

        answers.append(Dual(iterations=1000, visits=0)(large(), rng=rng, stop=stop))
    first, second, third = answers
    assert first.stop_reason == second.stop_reason == "stopped"
    assert first.evaluations < second.evaluations < third.evaluations
    assert first.lower_bound <= second.lower_bound <= third.lower_bound


@pytest.mark.parametrize("wrong", [{"iterations": 0}, {"visits": -1}])
def test_refuses_to_do_less_than_nothing(wrong: dict[str, int]) -> None:
    with pytest.raises(InvalidInputError, match="Dual: "):
        Dual(**wrong)
