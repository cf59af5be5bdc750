"""What every solver promises, whatever its method."""

import pickle
import time
from collections.abc import Callable
from dataclasses import fields, replace

import numpy as np
import pytest

from oracles.assignment import (
    hard_tuples,
    least_cost,
    random_problem,
    random_required,
    random_tuples,
    random_window,
    rounded,
    sequence,
)
from oracles.contenders import SMALL, SOLVERS
from trackweave.association.problem import Answer, AssignmentProblem, Status
from trackweave.errors import InvalidInputError
from trackweave.solvers import Dual, Exact, Genetic, Greedy, Hint, Solver, solve
from trackweave.solvers.resumable import Resumable


def priced(rng: np.random.Generator) -> AssignmentProblem:
    """Return tuples whose items cost something when they are left, or pay."""
    return AssignmentProblem.from_tuples(
        *random_tuples(rng, 14), alone=float(rng.choice([4.0, 1.5, -2.0]))
    )


PROBLEMS = [random_problem(np.random.default_rng(seed)) for seed in range(24)]
# Their bound often lies below an integer that is the optimum.
PROBLEMS += [rounded(random_problem(np.random.default_rng(seed))) for seed in range(30, 36)]
PROBLEMS += [priced(np.random.default_rng([3, seed])) for seed in range(6)]
# Prices alone cannot prove the best answers to these.
PROBLEMS += [hard_tuples(seed, 24, 4) for seed in range(6)]
# There may be no answer to these.
REQUIRED = [
    random_required(np.random.default_rng([4, seed]), whole=seed % 2 == 0) for seed in range(24)
]
OPTIMA = [least_cost(problem) for problem in PROBLEMS]
CASES = [*zip(PROBLEMS, OPTIMA, strict=True)]
CASES += [(problem, least_cost(problem)) for problem in REQUIRED]
# The dual leaves some of it open, too much to enumerate.
HARD = hard_tuples(2, 110, 8)
EMPTY = AssignmentProblem([], [], [], [], [], [], base_cost=3.0)


def tol(cost: float) -> float:
    return 1e-8 * max(1.0, abs(cost))


def require_feasible(problem: AssignmentProblem, answer: Answer) -> None:
    items = [item for node in answer.nodes.tolist() for item in sequence(problem, node)]
    assert len(items) == len(set(items))
    assert set(np.flatnonzero(problem.must_cover).tolist()) <= set(items)
    cost = problem.base_cost + problem.total[answer.nodes].sum()
    if problem.requirement is None or set(problem.requirement.item.tolist()) <= set(items):
        assert answer.cost == pytest.approx(cost, rel=1e-12, abs=1e-12)
        assert np.isfinite(answer.cost)
        assert answer.status in {Status.OPTIMAL, Status.FEASIBLE}
    else:
        assert answer.cost == answer.gap == np.inf
        assert answer.status in {Status.INFEASIBLE, Status.UNKNOWN}
    assert answer.lower_bound <= answer.cost
    assert (np.diff(answer.nodes) > 0).all()
    assert answer.prices.shape == (problem.n_items,)
    assert answer.stop_reason


def require_honest(problem: AssignmentProblem, answer: Answer, optimum: float) -> None:
    """Refuse an answer that breaks a rule, or a claim that is not so."""
    require_feasible(problem, answer)
    slack = tol(optimum) if np.isfinite(optimum) else 0.0
    assert answer.lower_bound <= optimum + slack
    assert answer.cost >= optimum - slack
    assert (answer.status is Status.INFEASIBLE) <= np.isinf(optimum)
    assert (answer.status is Status.INFEASIBLE) == np.isinf(answer.lower_bound)
    if answer.status is Status.OPTIMAL:
        assert answer.cost == pytest.approx(optimum, abs=slack)
        assert answer.cost - answer.lower_bound <= slack
        assert answer.stop_reason == "gap closed"
    elif answer.status is Status.FEASIBLE:
        assert answer.stop_reason != "gap closed"


def require_same(first: Answer, second: Answer) -> None:
    assert first.nodes.tolist() == second.nodes.tolist()
    assert first.certificate == second.certificate
    assert (first.evaluations, first.stop_reason) == (second.evaluations, second.stop_reason)
    assert (first.prices == second.prices).all()


def in_unit(problem: AssignmentProblem, factor: float) -> AssignmentProblem:
    """Return the same problem with other numbers for its costs."""
    return replace(
        problem,
        cost=problem.cost * factor,
        total=problem.total * factor,
        base_cost=problem.base_cost * factor,
        unit=None if problem.unit is None else problem.unit * factor,
    )


def never() -> bool:
    return False


def at_once() -> bool:
    return True


@pytest.fixture(params=SOLVERS.values(), ids=SOLVERS.keys())
def solver(request: pytest.FixtureRequest) -> Solver:
    return request.param


@pytest.fixture
def rng() -> Callable[[], np.random.Generator]:
    return lambda: np.random.default_rng(7)


class TestSolver:
    def test_answers_feasibly_between_its_bound_and_the_optimum(self, solver, rng) -> None:
        for problem, optimum in CASES:
            require_honest(problem, solver(problem, rng=rng()), optimum)

    def test_gives_the_same_answer_for_the_same_seed(self, solver, rng) -> None:
        for problem in [*PROBLEMS[:8], *REQUIRED[:4], HARD]:
            require_same(solver(problem, rng=rng()), solver(problem, rng=rng()))

    def test_takes_a_seed_for_a_generator_and_zero_for_none(self, solver, rng) -> None:
        for problem in [*PROBLEMS[:2], HARD]:
            require_same(solver(problem, rng=7), solver(problem, rng=rng()))
        require_same(solver(HARD), solver(HARD, rng=0))

    def test_leaves_the_problem_as_it_is(self, solver, rng) -> None:
        for problem in [*PROBLEMS[:4], REQUIRED[2]]:
            names = [field.name for field in fields(problem)]
            before = pickle.dumps([getattr(problem, name) for name in names])
            solver(problem, rng=rng())
            assert pickle.dumps([getattr(problem, name) for name in names]) == before

    def test_takes_arrays_that_cannot_be_written(self, solver, rng) -> None:
        problem = PROBLEMS[0]
        frozen = replace(problem)
        for name in ("parent", "item", "cost", "total", "must_cover", "instant"):
            array = np.copy(getattr(problem, name))
            array.flags.writeable = False
            frozen = replace(frozen, **{name: array})
        hint = Hint(prices=np.zeros(problem.n_items))
        hint.prices.flags.writeable = False
        assert solver(frozen, rng=rng(), hint=hint).cost == solver(problem, rng=rng()).cost

    def test_answers_an_empty_problem(self, solver, rng) -> None:
        answer = solver(EMPTY, rng=rng())
        assert answer.nodes.tolist() == []
        assert (answer.cost, answer.lower_bound, answer.status) == (3.0, 3.0, Status.OPTIMAL)

    def test_answers_a_problem_without_anything_worth_taking(self, solver, rng) -> None:
        if getattr(solver, "settle", True) is False:
            pytest.skip("keeps lone reports at any price")
        problem = AssignmentProblem([-1, 0], [0, 1], [1.0, 2.0], [1.0, 2.0], [0, 0], [0, 1])
        answer = solver(problem, rng=rng())
        assert (answer.nodes.tolist(), answer.cost) == ([], 0.0)

    def test_covers_a_track_at_any_price(self, solver, rng) -> None:
        problem = AssignmentProblem([-1], [0], [9.0], [9.0], [True], [-1])
        assert solver(problem, rng=rng()).nodes.tolist() == [0]

    def test_stopped_at_once_still_answers(self, solver, rng) -> None:
        for problem, optimum in CASES:
            require_honest(problem, solver(problem, rng=rng(), stop=at_once), optimum)

    def test_stopped_at_once_is_quick_on_a_large_problem(self, solver, rng) -> None:
        problem = random_window(
            np.random.default_rng(3), n_tracks=60, n_reports=400, max_nodes=3000
        )
        solver(PROBLEMS[0], rng=rng(), stop=at_once)
        begin = time.process_time()
        require_feasible(problem, solver(problem, rng=rng(), stop=at_once))
        assert time.process_time() - begin < 1.0

    def test_a_stop_that_never_comes_changes_nothing(self, solver, rng) -> None:
        for problem in PROBLEMS[:8]:
            stopless = solver(problem, rng=rng())
            require_same(stopless, solver(problem, rng=rng(), stop=never))

    def test_no_hint_makes_it_wrong(self, solver, rng) -> None:
        maker = np.random.default_rng(11)
        for problem, optimum in [*CASES[:10], *CASES[-6:]]:
            n = problem.n_nodes
            hints = [
                Hint(prices=maker.exponential(20.0, problem.n_items)),
                Hint(prices=maker.normal(0.0, 1.0, problem.n_items)),
                Hint(prices=np.full(problem.n_items, 1e300)),
                Hint(nodes=np.arange(n)),
                Hint(nodes=maker.integers(0, n, 3 if n else 0)),
                Hint(nodes=np.empty(0, dtype=np.int64)),
            ]
            for hint in hints:
                require_honest(problem, solver(problem, rng=rng(), hint=hint), optimum)

    def test_a_stopped_answer_is_a_start_that_loses_nothing(self, solver, rng) -> None:
        for problem in [HARD, *PROBLEMS[:4]]:
            whole = solver(problem, rng=rng())
            first = solver(problem, rng=rng(), stop=at_once)
            hint = Hint(first.prices, first.nodes)
            again = solver(problem, rng=rng(), hint=hint)
            is_as_good = again.cost <= whole.cost + tol(whole.cost)
            assert is_as_good or again.stop_reason != "gap closed"

    def test_a_constant_moves_cost_and_bound_alone(self, solver, rng) -> None:
        for problem in [*PROBLEMS[:6], *PROBLEMS[-8:]]:
            plain = solver(problem, rng=rng())
            moved = solver(replace(problem, base_cost=problem.base_cost + 64.0), rng=rng())
            assert moved.nodes.tolist() == plain.nodes.tolist()
            assert moved.status == plain.status
            assert moved.cost == pytest.approx(plain.cost + 64.0, abs=1e-9)
            assert moved.lower_bound == pytest.approx(plain.lower_bound + 64.0, abs=1e-9)

    @pytest.mark.parametrize("factor", [2.0**-30, 2.0**30])
    def test_is_right_in_any_unit(self, solver, rng, factor: float) -> None:
        for problem, optimum in CASES[:12]:
            scaled = in_unit(problem, factor)
            require_honest(scaled, solver(scaled, rng=rng()), optimum * factor)

    @pytest.mark.parametrize("power", [-60, -7, 13, 60])
    def test_a_power_of_two_scales_cost_and_bound_exactly(self, solver, rng, power: int) -> None:
        factor = 2.0**power
        for problem in [*PROBLEMS[:5], *PROBLEMS[-8:-6], *PROBLEMS[-3:]]:
            # By totals both times: what tuples cost as they were given is none of the scaled ones.
            plain = solver(replace(problem, given=None), rng=rng())
            scaled = solver(in_unit(problem, factor), rng=rng())
            assert scaled.nodes.tolist() == plain.nodes.tolist()
            assert (scaled.status, scaled.stop_reason) == (plain.status, plain.stop_reason)
            assert scaled.cost == plain.cost * factor
            assert scaled.lower_bound == plain.lower_bound * factor
            assert (scaled.prices == plain.prices * factor).all()

    def test_new_numbers_for_items_change_no_rule(self, solver, rng) -> None:
        maker = np.random.default_rng(2)
        for problem, optimum in CASES[:12]:
            number = maker.permutation(problem.n_items)
            old = np.argsort(number)
            renamed = replace(
                problem,
                item=number[problem.item],
                must_cover=problem.must_cover[old],
                instant=problem.instant[old],
            )
            require_honest(renamed, solver(renamed, rng=rng()), optimum)

    def test_settles_ties_the_same_way_each_time(self, solver, rng) -> None:
        rows = [[a, b, c] for a in (1, 2) for b in (1, 2) for c in (1, 2)]
        problem = AssignmentProblem.from_tuples(rows, np.full(8, -1.0))
        answers = [solver(problem, rng=rng()) for _ in range(3)]
        for answer in answers:
            require_feasible(problem, answer)
            require_same(answer, answers[0])

    def test_has_no_memory(self, solver, rng) -> None:
        first = solver(PROBLEMS[0], rng=rng())
        for problem in PROBLEMS[1:6]:
            solver(problem, rng=rng())
        require_same(first, solver(PROBLEMS[0], rng=rng()))

    def test_can_go_without_any_particular_bit_generator(self, solver) -> None:
        generator = np.random.Generator(np.random.Philox(3))
        require_feasible(PROBLEMS[1], solver(PROBLEMS[1], rng=generator))

    @pytest.mark.parametrize("prices", [[np.nan], [np.inf], [0.0, 0.0]])
    def test_refuses_prices_that_are_none(self, solver, rng, prices: list[float]) -> None:
        if isinstance(solver, Greedy):
            pytest.skip("reads no hint")
        problem = AssignmentProblem([-1], [0], [-1.0], [-1.0], [0], [0])
        with pytest.raises(InvalidInputError, match=r"hint\.prices"):
            solver(problem, rng=rng(), hint=Hint(prices=np.array(prices)))


def test_the_problems_are_of_all_kinds() -> None:
    assert {np.isinf(least_cost(problem)) for problem in REQUIRED} == {True, False}
    open_ones = [Dual(visits=0)(problem, rng=np.random.default_rng(0)) for problem in PROBLEMS]
    assert sum(answer.status is Status.FEASIBLE for answer in open_ones) >= 4
    assert Dual()(HARD, rng=np.random.default_rng(0)).status is Status.FEASIBLE


RESUMABLE = {name: solver for name, solver in SOLVERS.items() if isinstance(solver, Resumable)}


@pytest.fixture(params=RESUMABLE.values(), ids=RESUMABLE.keys())
def search(request: pytest.FixtureRequest) -> Resumable:
    return request.param


class TestSearch:
    def test_in_pieces_ends_as_in_one_go(self, search, rng) -> None:
        for problem in (HARD, *PROBLEMS[:3], *REQUIRED[:3]):
            whole = search(problem, rng=rng())
            state = search.start(problem, rng=rng())
            for more in (1, 1, 7, 23, None):
                state = search.advance(state, evaluations=more)
            assert state.done
            require_same(search.answer(state), whole)

    def test_stopped_kept_and_taken_up_again_ends_the_same(self, search, rng) -> None:
        for problem in (HARD, *PROBLEMS[:3]):
            whole = search(problem, rng=rng())
            state = search.start(problem, rng=rng())
            for patience in (0, 1, 3):
                calls = iter(range(patience))

                def stop(calls=calls) -> bool:
                    return next(calls, None) is None

                state = pickle.loads(pickle.dumps(search.advance(state, stop=stop)))
                require_feasible(problem, search.answer(state))
            require_same(search.answer(search.advance(state)), whole)

    def test_to_go_on_leaves_the_state_as_it_is(self, search, rng) -> None:
        state = search.start(HARD, rng=rng())
        for more in (1, 20):
            before = pickle.dumps(search.answer(state).nodes), state.evaluations
            first, second = (search.advance(state, evaluations=more) for _ in range(2))
            assert (pickle.dumps(search.answer(state).nodes), state.evaluations) == before
            require_same(search.answer(first), search.answer(second))
            state = first

    def test_more_evaluations_never_make_it_worse(self, search, rng) -> None:
        state, last = search.start(HARD, rng=rng()), np.inf
        while not state.done:
            state = search.advance(state, evaluations=9)
            cost = search.answer(state).cost
            assert cost <= last + tol(cost)
            last = cost


PROVERS = [Exact(), Dual(visits=200_000), Genetic()]


@pytest.mark.parametrize("prover", PROVERS, ids=["exact", "dual", "genetic"])
def test_the_strong_ones_find_the_optimum(prover: Solver) -> None:
    rng = np.random.default_rng(1)
    for problem, optimum in zip(PROBLEMS, OPTIMA, strict=True):
        assert prover(problem, rng=rng).cost == pytest.approx(optimum, abs=tol(optimum))


@pytest.mark.parametrize("name", ["genetic", "genetic to the letter"])
def test_a_search_draws_from_the_generator_it_is_given(name: str) -> None:
    rng = np.random.default_rng(4)
    problem = AssignmentProblem.from_tuples(*random_tuples(np.random.default_rng(8), 14))
    searches = [SOLVERS[name].start(problem, rng=rng) for _ in range(2)]
    draws = [state.rng.random(3).tolist() for state in searches]
    assert draws[0] != draws[1]


def test_a_search_draws_as_much_for_an_easy_problem_as_for_a_hard_one() -> None:
    after = []
    for problem in (EMPTY, PROBLEMS[0], PROBLEMS[3]):
        rng = np.random.default_rng(4)
        Genetic(**SMALL)(problem, rng=rng)
        after.append((rng.spawn(1)[0].random(), rng.random()))
    assert after[0] == after[1] == after[2]


def test_solve_takes_any_solver_and_searches_by_default() -> None:
    problem = PROBLEMS[2]
    for solver in (None, Greedy(), Dual()):
        chosen = Genetic() if solver is None else solver
        answer = solve(problem, solver, rng=np.random.default_rng(1))
        require_same(answer, chosen(problem, rng=np.random.default_rng(1)))


def test_solve_passes_on_hint_and_stop() -> None:
    asked = []
    with pytest.raises(InvalidInputError, match=r"hint\.nodes"):
        solve(PROBLEMS[0], rng=np.random.default_rng(1), hint=Hint(nodes=np.array([9999])))
    solve(PROBLEMS[0], Exact(), rng=np.random.default_rng(1), stop=lambda: bool(asked.append(1)))
    assert asked
