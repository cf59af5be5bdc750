"""HiGHS: the optimum, and what is said when there is no time or no room for it."""

import numpy as np
import pytest

from oracles.assignment import least_cost, random_problem
from trackweave.association.problem import AssignmentProblem, Status
from trackweave.errors import InvalidInputError
from trackweave.solvers import Exact
from trackweave.solvers.components import Components
from trackweave.solvers.exact import _solve


def hard_tuples(seed: int = 0, n_rows: int = 250) -> AssignmentProblem:
    """Return a dense problem whose bound stays open without an integer program."""
    rng = np.random.default_rng(seed)
    rows = rng.integers(1, 13, (n_rows, 4))
    return AssignmentProblem.from_tuples(rows, rng.normal(-5.0, 1.0, n_rows))


def test_finds_the_optimum_from_nothing() -> None:
    # Around the dual, which proves most small problems by itself.
    for seed in range(80):
        problem = random_problem(np.random.default_rng([3, seed]))
        components = Components.of(problem, None, whole=True)
        if not len(components):
            continue
        taken = components.taken
        roots = components.component(0).members[components.component(0).start[:-1]]
        must = components.parts.must
        taken[must] = roots[must]
        cost, bound = _solve(components.component(0), taken, 10.0)
        optimum = least_cost(problem) - problem.base_cost
        assert cost == pytest.approx(optimum, abs=1e-6)
        assert bound == pytest.approx(cost, abs=1e-6)
        assert problem.total[components.nodes()].sum() == pytest.approx(cost, abs=1e-9)


def test_closes_what_the_dual_leaves_open() -> None:
    answer = Exact()(hard_tuples(), rng=np.random.default_rng(0))
    assert answer.status is Status.OPTIMAL
    assert answer.stop_reason == "gap closed"


def test_says_that_time_was_short() -> None:
    answer = Exact(time_limit=1e-6)(hard_tuples(), rng=np.random.default_rng(0))
    assert (answer.status, answer.stop_reason) == (Status.FEASIBLE, "time limit")
    assert np.isfinite(answer.lower_bound)


def test_an_interrupted_integer_program_claims_nothing_false() -> None:
    best = Exact()(hard_tuples(), rng=np.random.default_rng(0))
    for limit in (0.01, 0.05):
        answer = Exact(time_limit=limit)(hard_tuples(), rng=np.random.default_rng(0))
        assert answer.lower_bound <= best.cost + 1e-6
        assert answer.cost >= best.cost - 1e-6


def test_says_that_a_component_is_too_large() -> None:
    answer = Exact(max_sequences=10)(hard_tuples(), rng=np.random.default_rng(0))
    assert (answer.status, answer.stop_reason) == (Status.FEASIBLE, "component too large")


def test_says_that_it_was_stopped() -> None:
    answer = Exact()(hard_tuples(), rng=np.random.default_rng(0), stop=lambda: True)
    assert (answer.status, answer.stop_reason) == (Status.FEASIBLE, "stopped")


@pytest.mark.parametrize(
    "wrong", [{"time_limit": 0.0}, {"time_limit": np.nan}, {"max_sequences": 0}]
)
def test_refuses_limits_that_allow_nothing(wrong: dict[str, float]) -> None:
    with pytest.raises(InvalidInputError, match="expected both positive"):
        Exact(**wrong)
