"""What ``solve`` refuses before any solver is called."""

import numpy as np
import pytest

from trackweave.association.problem import AssignmentProblem
from trackweave.errors import InvalidInputError
from trackweave.solvers import Dual, solve

PROBLEM = AssignmentProblem.from_tuples([(1, 1), (1, 2)], [-1.0, -2.0])


@pytest.mark.parametrize("solver", ["dual", Dual, 3])
def test_refuses_what_is_no_solver(solver) -> None:
    with pytest.raises(InvalidInputError, match=r"solver: .*; expected a solver"):
        solve(PROBLEM, solver, rng=np.random.default_rng(1))


@pytest.mark.parametrize("problem", [[(1, 1)], None, AssignmentProblem])
def test_refuses_what_is_no_problem(problem) -> None:
    with pytest.raises(InvalidInputError, match=r"problem: .*; expected an instance of Assign"):
        solve(problem, Dual(), rng=np.random.default_rng(1))


@pytest.mark.parametrize("rng", [1, None, np.random, np.random.RandomState(1)])
def test_refuses_what_is_no_generator(rng) -> None:
    with pytest.raises(InvalidInputError, match=r"rng: .*; expected an instance of Generator"):
        solve(PROBLEM, Dual(), rng=rng)


@pytest.mark.parametrize("option", [{"hint": [1]}, {"stop": 0.5}])
def test_refuses_a_hint_or_stop_of_another_kind(option) -> None:
    with pytest.raises(InvalidInputError, match=f"{next(iter(option))}: .*; expected"):
        solve(PROBLEM, Dual(), rng=np.random.default_rng(1), **option)


def test_solves_by_the_genetic_search_unless_told() -> None:
    assert solve(PROBLEM, rng=np.random.default_rng(1)).cost == -2.0
