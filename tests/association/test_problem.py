"""The assignment problem: what it refuses, and what tuples become."""

from dataclasses import replace
from math import fsum
from typing import Any

import numpy as np
import pytest
from scipy.optimize import linear_sum_assignment

from oracles.assignment import (
    least_cost,
    least_cost_of_tuples,
    random_tuples,
    random_window,
    sequence,
)
from trackweave.association.problem import AssignmentProblem, Certificate, Status
from trackweave.errors import InvalidInputError
from trackweave.solvers import solve


@pytest.fixture
def chain() -> AssignmentProblem:
    """A track from before, item 2, that may take report 0 and then report 1."""
    return AssignmentProblem(
        parent=np.array([-1, 0, 1]),
        item=np.array([2, 0, 1]),
        cost=np.array([0.0, -1.0, -3.0]),
        total=np.array([0.5, -0.5, -2.5]),
        must_cover=np.array([False, False, True]),
        instant=np.array([0, 1, -1]),
    )


@pytest.mark.parametrize(
    ("field", "value", "message"),
    [
        ("parent", [-1, 2, 1], "each parent before its children"),
        ("parent", [-1, 1, 1], "each parent before its children"),
        ("parent", [-2, 0, 1], "each parent before its children"),
        ("parent", [[-1, 0, 1]], "parent: an array of shape"),
        ("item", [2, 0, 3], "item: expected numbers from 0 to 2"),
        ("item", [2, -1, 1], "item: expected numbers from 0 to 2"),
        ("item", [2, 0, 0], "item: a sequence has an item twice"),
        ("item", [2, 0], "item: an array of shape"),
        ("item", [2, 0.5, 1], "item: .* expected whole numbers"),
        ("cost", [0.0, np.nan, 0.0], "cost: NaN"),
        ("total", [0.0, -np.inf, 0.0], "total: NaN or minus infinity"),
        ("total", [np.inf, 0.0, 0.0], "must_cover: expected only items"),
        ("must_cover", [True, False, True], "must_cover: expected only items"),
        (
            "total",
            [0.0, 1e308, 0.0],
            "total: a cost of size 1e[+]308; expected 3 that can be added",
        ),
        ("must_cover", [[False, False, True]], "must_cover: an array of shape"),
        ("must_cover", True, "must_cover: an array of shape"),
        ("must_cover", ["a", "b", "c"], "must_cover: .* expected numbers"),
        ("instant", [0, 1], "instant: an array of shape"),
        ("row", [0, 1], "row: an array of shape"),
        ("base_cost", np.nan, "base_cost: nan; expected a finite number"),
        ("base_cost", None, "base_cost: None; expected a finite number"),
        ("base_cost", "3", "base_cost: '3'; expected a finite number"),
    ],
)
def test_refuses_what_is_no_problem(
    chain: AssignmentProblem, field: str, value: Any, message: str
) -> None:
    with pytest.raises(InvalidInputError, match=message):
        replace(chain, **{field: value})


def test_refuses_an_item_that_must_be_covered_but_begins_nothing(
    chain: AssignmentProblem,
) -> None:
    with pytest.raises(InvalidInputError, match="must_cover"):
        replace(chain, must_cover=[False, False, True, True], instant=[0, 1, -1, -1])


def test_refuses_an_item_that_must_be_covered_and_begins_two_families() -> None:
    with pytest.raises(InvalidInputError, match="at one root"):
        AssignmentProblem([-1, -1], [0, 0], [0.0, 0.0], [0.0, 0.0], [True], [0])


def test_takes_lists_and_keeps_arrays(chain: AssignmentProblem) -> None:
    taken = replace(chain, parent=[-1, 0, 1], total=[1, 2, 3], must_cover=[0, 0, 1])
    assert (taken.parent.dtype, taken.total.dtype) == (np.int64, np.float64)
    assert taken.must_cover.tolist() == [False, False, True]


def test_may_be_empty() -> None:
    problem = AssignmentProblem([], [], [], [], [], [])
    assert (problem.n_nodes, problem.n_items) == (0, 0)


@pytest.mark.parametrize(
    ("cost", "bound", "gap"),
    [
        (-200.0, -220.0, 0.1),
        (0.1, 0.0, 1.0),
        (2e-8, 1e-8, 0.5),
        (-1.0, -3.0, 2.0),
        (1.0, 1.0 + 1e-12, 0.0),
        (0.0, 0.0, 0.0),
        (0.0, -1e-12, np.inf),
        (5.0, -np.inf, np.inf),
        (np.inf, 3.0, np.inf),
        (np.inf, np.inf, np.inf),
    ],
)
def test_gap_is_relative_to_the_cost_however_small(cost: float, bound: float, gap: float) -> None:
    assert Certificate(cost, bound, Status.FEASIBLE).gap == pytest.approx(gap)


@pytest.mark.parametrize(
    ("tuples", "costs", "message"),
    [
        ([[1, 1]], [np.nan], r"costs\[0\]: nan"),
        ([[1, 1]], [np.inf], r"costs\[0\]: inf"),
        ([[1, 1], [1, 2]], [0.0, -np.inf], r"costs\[1\]: -inf"),
        ([[1, -1]], [0.0], "a negative number"),
        ([[1, 1], [0, 0]], [0.0, 0.0], "a row without items"),
        (np.empty((2, 0)), [0.0, 0.0], "a row without items"),
        ([[1, 1]], [0.0, 1.0], "costs: an array of shape"),
        ([[1, 1]], [[0.0]], "costs: an array of shape"),
        ([1, 1], [0.0, 1.0], "tuples: an array of shape"),
        ([[1, 1.5]], [0.0], "expected whole numbers"),
        ([[1, np.nan]], [0.0], "expected whole numbers"),
        ([[True, True]], [0.0], "expected whole numbers"),
        ([[1, 1]], ["cheap"], "costs: .* expected numbers"),
        ([[1, 10**12]], [0.0], "the number 1000000000000"),
    ],
)
def test_refuses_tuples_that_are_none(tuples: Any, costs: Any, message: str) -> None:
    with pytest.raises(InvalidInputError, match=message):
        AssignmentProblem.from_tuples(tuples, costs)


@pytest.mark.parametrize("shape", [(0, 0), (0, 3)])
def test_no_tuples_are_an_empty_problem(shape: tuple[int, int]) -> None:
    problem = AssignmentProblem.from_tuples(np.empty(shape), [])
    assert (problem.n_nodes, problem.n_items, problem.base_cost) == (0, 0, 0.0)


def test_whole_floats_are_numbers_of_items() -> None:
    assert AssignmentProblem.from_tuples([[1.0, 2.0]], [-1]).n_items == 3


def test_nodes_name_their_rows() -> None:
    tuples = [[1, 1, 0], [1, 1, 2], [0, 1, 1], [2, 0, 0]]
    problem = AssignmentProblem.from_tuples(tuples, [-1.0, -2.0, -3.0, 5.0])
    ends = np.flatnonzero(np.isfinite(problem.total))
    offset = {0: 0, 1: 2, 2: 3}
    for node in ends.tolist():
        row = tuples[problem.row[node]]
        items = [offset[s] + v - 1 for s, v in enumerate(row) if v]
        assert list(sequence(problem, node)) == items
    assert sorted(problem.row[ends].tolist()) == [0, 1, 2]
    assert set(problem.row[~np.isfinite(problem.total)].tolist()) <= {-1}


def test_of_equal_tuples_the_cheapest_counts() -> None:
    problem = AssignmentProblem.from_tuples([[1, 1], [1, 1], [1, 1]], [-1.0, -3.0, -2.0])
    end = np.flatnonzero(np.isfinite(problem.total))
    assert problem.row[end].tolist() == [1]
    assert problem.total[end].tolist() == [-3.0]


def test_tuples_of_one_item_are_its_price() -> None:
    tuples = [[1, 0], [0, 1], [0, 1], [1, 1]]
    problem = AssignmentProblem.from_tuples(tuples, [4.0, 7.0, 6.0, 8.0])
    assert problem.base_cost == 10.0
    assert problem.total[np.isfinite(problem.total)].tolist() == [-2.0]
    assert problem.row.max() == 3


def test_tuples_keep_their_meaning() -> None:
    rng = np.random.default_rng(5)
    for _ in range(60):
        tuples, costs = random_tuples(rng, 9)
        problem = AssignmentProblem.from_tuples(tuples, costs)
        assert least_cost(problem) == pytest.approx(least_cost_of_tuples(tuples, costs), abs=1e-9)


def test_a_prefix_that_is_no_tuple_may_not_end() -> None:
    problem = AssignmentProblem.from_tuples([[1, 1, 1]], [-1.0])
    assert problem.total.tolist() == [np.inf, np.inf, -1.0]
    assert problem.cost.tolist() == [-1.0, -1.0, -1.0]


def test_lists_are_instants() -> None:
    problem = AssignmentProblem.from_tuples([[2, 1, 1]], [-1.0])
    assert problem.instant.tolist() == [0, 0, 1, 2]


def test_random_windows_have_tracks_and_sequences_that_may_not_end() -> None:
    problems = [random_window(np.random.default_rng(seed)) for seed in range(20)]
    assert {int(problem.must_cover.sum()) for problem in problems} == {2}
    assert any(np.isinf(problem.total).any() for problem in problems)


@pytest.mark.parametrize("dear", [0.0, 1e4, 1e6])
def test_a_cost_is_the_sum_of_what_its_tuples_cost_beside_far_larger_ones(dear):
    rng = np.random.default_rng(3)
    for _ in range(10):
        costs = rng.random((12, 12)) + dear * np.eye(12)
        answer = solve(AssignmentProblem.from_array(costs), rng=rng)
        assert answer.cost == fsum(costs[tuple(answer.tuples.T)])
        assert answer.lower_bound <= fsum(costs[linear_sum_assignment(costs)])


def test_what_is_left_counts_with_its_price():
    tuples, costs = [[1, 1], [2, 1]], [0.1, 0.2]
    problem = AssignmentProblem.from_tuples(tuples, costs, alone=[0.7, 0.3, 5.0])
    answer = solve(problem, rng=0)
    assert answer.cost == fsum([0.1, 0.3])
    assert problem.cost_of(answer.nodes) == answer.cost
    assert problem.cost_of(answer.nodes[:0]) == fsum([0.7, 0.3, 5.0])


def test_with_other_totals_costs_are_by_these():
    problem = AssignmentProblem.from_tuples([[1, 1], [2, 1]], [0.1, 0.2], alone=1.0)
    dearer = replace(problem, total=2.0 * problem.total)
    nodes = solve(dearer, rng=0).nodes
    assert dearer.cost_of(nodes) == dearer.base_cost + dearer.total[nodes].sum()
