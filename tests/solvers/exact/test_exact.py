"""The whole of it: the optimum, and what is said when there is no time or no room for it."""

from pathlib import Path

import numpy as np
import pytest

from oracles.assignment import hard_tuples
from trackweave.association.problem import AssignmentProblem, Status
from trackweave.errors import InvalidInputError
from trackweave.solvers import Dual, Exact

HARD = hard_tuples(2, 110, 8)


def rng() -> np.random.Generator:
    return np.random.default_rng(0)


def axial(folder: Path, n: int, number: int) -> tuple[np.ndarray, float]:
    """Return a published axial problem's costs and its optimum."""
    file = folder / "data" / "ap3" / f"ap3.{n}.{number}.txt"
    if not file.is_file():
        pytest.skip("the axial problems are not beside the checkout")
    values = np.array(file.read_text().split()[-(n**3) :], dtype=np.float64)
    return values.reshape(n, n, n), float(file.with_suffix(".sol").read_text().split()[1])


def test_closes_what_the_dual_leaves_open() -> None:
    relaxed = Dual()(HARD, rng=rng())
    answer = Exact()(HARD, rng=rng())
    assert relaxed.status is Status.FEASIBLE
    assert (answer.status, answer.stop_reason) == (Status.OPTIMAL, "gap closed")
    assert relaxed.lower_bound <= answer.cost <= relaxed.cost
    assert answer.evaluations > relaxed.evaluations


@pytest.mark.shared
@pytest.mark.parametrize("n", [10, 20, 30])
@pytest.mark.parametrize("number", range(1, 11))
def test_solves_the_published_axial_problems(shared: Path, n: int, number: int) -> None:
    costs, optimum = axial(shared, n, number)
    answer = Exact()(AssignmentProblem.from_array(costs), rng=rng())
    assert (answer.cost, answer.status) == (optimum, Status.OPTIMAL)
    assert answer.nodes.shape == (n,)


@pytest.mark.parametrize(
    ("limits", "reason"),
    [
        ({"time_limit": 1e-6}, "stopped"),
        ({"branches": 0}, "branches"),
        ({"branches": 3}, "branches"),
        ({"max_sequences": 10}, "component too large"),
    ],
)
def test_says_which_limit_was_reached(limits: dict[str, float], reason: str) -> None:
    best = Exact()(HARD, rng=rng())
    answer = Exact(**limits)(HARD, rng=rng())
    assert (answer.status, answer.stop_reason) == (Status.FEASIBLE, reason)
    assert -np.inf < answer.lower_bound <= best.cost <= answer.cost


def test_says_that_it_was_stopped() -> None:
    answer = Exact()(HARD, rng=rng(), stop=lambda: True)
    assert (answer.status, answer.stop_reason) == (Status.FEASIBLE, "stopped")


def test_a_time_limit_ends_what_would_take_far_longer() -> None:
    answer = Exact(time_limit=0.2)(hard_tuples(0, 2_000, 24), rng=rng())
    assert (answer.status, answer.stop_reason) == (Status.FEASIBLE, "stopped")


def test_components_are_branched_on_apart() -> None:
    first = np.random.default_rng(3).integers(1, 9, (110, 4))
    costs = np.random.default_rng(4).normal(-5.0, 1.0, 110)
    both = np.concatenate([first, first + 8])
    problem = AssignmentProblem.from_tuples(both, np.concatenate([costs, costs]))
    one = Exact()(AssignmentProblem.from_tuples(first, costs), rng=rng())
    two = Exact()(problem, rng=rng())
    assert two.status is Status.OPTIMAL
    assert two.cost == pytest.approx(2.0 * one.cost)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"time_limit": 0.0}, "time_limit: 0.0; expected a number > 0"),
        ({"time_limit": np.nan}, "time_limit: nan"),
        ({"time_limit": -1.0}, "time_limit: -1.0"),
        ({"max_sequences": 0}, "max_sequences: 0"),
        ({"branches": -1}, "branches: -1"),
    ],
)
def test_refuses_limits_that_allow_nothing(wrong: dict[str, float], message: str) -> None:
    with pytest.raises(InvalidInputError, match=message):
        Exact(**wrong)


@pytest.mark.slow
def test_a_million_tuples_keep_to_a_limit() -> None:
    maker = np.random.default_rng(8)
    table = maker.integers(0, 400, (1_000_000, 4))
    table = table[table.any(axis=1)]
    problem = AssignmentProblem.from_tuples(table, maker.normal(0.0, 3.0, table.shape[0]))
    answer = Exact(time_limit=2.0)(problem, rng=rng())
    assert answer.status is Status.FEASIBLE
    assert answer.lower_bound < answer.cost < 0.0
