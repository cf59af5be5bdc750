"""What ``solve`` refuses before any solver is called."""

import numpy as np
import pytest

from trackweave.association.problem import AssignmentProblem
from trackweave.errors import InvalidInputError
from trackweave.solvers import Auto, Dual, Genetic, solve
from trackweave.solvers.solving import patient

PROBLEM = AssignmentProblem.from_tuples([(1, 1), (1, 2)], [-1.0, -2.0])


@pytest.mark.parametrize("solver", ["dual", Dual, 3])
def test_refuses_what_is_no_solver(solver) -> None:
    with pytest.raises(InvalidInputError, match=r"solver: .*; expected a solver"):
        solve(PROBLEM, solver, rng=np.random.default_rng(1))


@pytest.mark.parametrize("problem", [[(1, 1)], None, AssignmentProblem])
def test_refuses_what_is_no_problem(problem) -> None:
    with pytest.raises(InvalidInputError, match=r"problem: .*; expected an instance of Assign"):
        solve(problem, Dual(), rng=np.random.default_rng(1))


@pytest.mark.parametrize("rng", [1.0, None, np.random, np.random.RandomState(1)])
def test_refuses_what_is_no_generator(rng) -> None:
    with pytest.raises(InvalidInputError, match=r"rng: .*; expected a numpy\.random\.Generator"):
        solve(PROBLEM, Dual(), rng=rng)


@pytest.mark.parametrize("option", [{"hint": [1]}, {"stop": 0.5}])
def test_refuses_a_hint_or_stop_of_another_kind(option) -> None:
    with pytest.raises(InvalidInputError, match=f"{next(iter(option))}: .*; expected"):
        solve(PROBLEM, Dual(), rng=np.random.default_rng(1), **option)


def test_takes_a_seed_for_a_generator_and_zero_for_none() -> None:
    solver = Genetic(population=20)
    for seed in (0, 5):
        expected = solve(PROBLEM, solver, rng=np.random.default_rng(seed))
        assert solve(PROBLEM, solver, rng=seed).evaluations == expected.evaluations
    assert solve(PROBLEM).cost == -2.0


def test_solves_by_the_genetic_search_unless_told() -> None:
    assert solve(PROBLEM, rng=np.random.default_rng(1)).cost == -2.0


@pytest.mark.parametrize("time_limit", [-1.0, float("nan"), float("inf"), "1", True])
def test_refuses_a_time_limit_that_is_none(time_limit) -> None:
    with pytest.raises(InvalidInputError, match=r"time_limit: .* expected a number"):
        solve(PROBLEM, rng=np.random.default_rng(1), time_limit=time_limit)


class Told:
    """A solver that asks when to stop, and keeps the answer."""

    def __call__(self, problem, *, rng, hint=None, stop=None):
        self.stopped = stop is not None and stop()
        return Dual()(problem, rng=rng)


@pytest.mark.parametrize(("time_limit", "stopped"), [(None, False), (0.0, True), (1e6, False)])
def test_a_time_limit_stops_a_solver(time_limit: float | None, stopped: bool) -> None:
    solver = Told()
    assert solve(PROBLEM, solver, rng=np.random.default_rng(1), time_limit=time_limit).cost == -2.0
    assert solver.stopped == stopped


def test_a_stop_counts_beside_a_time_limit() -> None:
    solver = Told()
    solve(PROBLEM, solver, rng=np.random.default_rng(1), time_limit=1e6, stop=lambda: True)
    assert solver.stopped


def test_time_alone_bounds_what_has_no_solver() -> None:
    assert (patient(Auto()).evaluations, patient(Auto()).branches) == (10**12, 10**12)
    assert patient(Dual()) == Dual()
