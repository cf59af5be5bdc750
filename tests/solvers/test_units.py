"""Answers do not depend on the unit of costs, nor bounds on what is large beside the small."""

import numpy as np
import pytest

from oracles.assignment import least_cost_of_tuples, random_tuples
from trackweave.association.problem import Answer, AssignmentProblem, Status
from trackweave.errors import InvalidInputError
from trackweave.solvers import Auto, Dual, Exact, Greedy, Solver, solve

SCALES = [1e-300, 1e-12, 1e-8, 1e-3, 1.0, 1e5, 1e12, 1e200]
ROUNDING = 1e-12


def solved(problem: AssignmentProblem, solver: Solver | None = None) -> Answer:
    return solve(problem, solver, rng=np.random.default_rng(0))


def require_true(answer: Answer, optimum: float, size: float) -> None:
    """Refuse a bound above the optimum, and a worse answer that is called optimal."""
    assert answer.lower_bound <= optimum + ROUNDING * size
    assert answer.cost >= optimum - ROUNDING * size
    if answer.status is Status.OPTIMAL:
        assert answer.cost <= optimum + 1e-9 * abs(optimum) + ROUNDING * size


@pytest.mark.parametrize("scale", SCALES)
@pytest.mark.parametrize("solver", [Auto(), Dual(visits=0), Exact(), Greedy()], ids=str)
def test_small_and_large_costs_are_answered_truly(solver: Solver, scale: float) -> None:
    rng = np.random.default_rng(2)
    for _ in range(20):
        tuples, costs = random_tuples(rng, 10, scale=scale)
        alone = scale * rng.normal(0.0, 1.0)
        optimum = least_cost_of_tuples(tuples, costs, alone)
        answer = solved(AssignmentProblem.from_tuples(tuples, costs, alone=alone), solver)
        require_true(answer, optimum, float(np.abs(costs).sum() + abs(alone) * tuples.max() * 4))


@pytest.mark.parametrize("scale", SCALES)
def test_an_array_of_small_costs_is_solved_as_one_of_large_ones(scale: float) -> None:
    costs = np.random.default_rng(5).random((7, 7, 7))
    usual = solved(AssignmentProblem.from_array(costs))
    other = solved(AssignmentProblem.from_array(scale * costs))
    assert other.nodes.tolist() == usual.nodes.tolist()
    assert other.cost == pytest.approx(scale * usual.cost, rel=1e-9)
    assert other.lower_bound == pytest.approx(scale * usual.lower_bound, rel=1e-9)
    assert other.gap == pytest.approx(usual.gap, abs=1e-9)


@pytest.mark.parametrize("large", [1e3, 1e6, 1e9, -1e9])
@pytest.mark.parametrize("share", [0.1, 0.9])
def test_large_costs_among_small_ones_prove_nothing_false(large: float, share: float) -> None:
    rng, n_solved = np.random.default_rng(3), 0
    for _ in range(30):
        tuples, costs = random_tuples(rng, 10, scale=1e-3)
        costs[rng.random(costs.shape[0]) < share] = large
        try:
            problem = AssignmentProblem.from_tuples(tuples, costs)
        except InvalidInputError as error:
            # Only a price that the small costs would be lost beside.
            assert "is lost beside" in str(error)
            continue
        answer, optimum = solved(problem), least_cost_of_tuples(tuples, costs)
        size = abs(answer.cost) + np.abs(problem.total[answer.nodes]).sum()
        require_true(answer, optimum, float(size))
        n_solved += 1
    assert n_solved >= 10


def test_a_cost_that_small_ones_are_lost_beside_is_refused_in_any_unit() -> None:
    costs = np.random.default_rng(4).random((4, 4))
    costs[0, 0] = 1e12
    for factor in (1e-12, 1e-3, 1.0, 1e12):
        with pytest.raises(InvalidInputError, match=r"is lost beside .* infinity where"):
            AssignmentProblem.from_array(factor * costs)


def test_the_gap_is_the_same_in_any_unit() -> None:
    costs = np.random.default_rng(0).random((12, 12, 12))
    gaps = [
        solved(AssignmentProblem.from_array(factor * costs), Dual(visits=0)).gap
        for factor in (1e-6, 1.0, 1e3)
    ]
    assert gaps[0] > 0.01
    assert gaps == pytest.approx([gaps[0]] * 3, rel=1e-3)
