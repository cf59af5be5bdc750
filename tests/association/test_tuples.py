"""Tables of tuples and dense arrays become problems, or are refused."""

from itertools import permutations
from typing import Any

import numpy as np
import pytest

from oracles.assignment import least_cost, least_cost_of_tuples, random_tuples
from trackweave.association.problem import AssignmentProblem
from trackweave.errors import InvalidInputError

NAN, INF = float("nan"), float("inf")
FOUR = [[1, 1], [1, 2], [2, 1], [2, 2]]


class TestAlone:
    def test_prices_of_leaving_keep_their_meaning(self) -> None:
        rng = np.random.default_rng(1)
        for turn in range(60):
            tuples, costs = random_tuples(rng, 9)
            n_items = int(tuples.max(axis=0).sum())
            alone = float(rng.normal(0.0, 4.0)) if turn % 2 else rng.normal(0.0, 4.0, n_items)
            problem = AssignmentProblem.from_tuples(tuples, costs, alone=alone)
            wanted = least_cost_of_tuples(tuples, costs, alone)
            assert least_cost(problem) == pytest.approx(wanted, abs=1e-9)

    def test_items_that_have_to_be_covered_keep_their_meaning(self) -> None:
        rng = np.random.default_rng(2)
        n_infeasible = 0
        for _ in range(80):
            tuples, costs = random_tuples(rng, 9)
            n_items = int(tuples.max(axis=0).sum())
            alone = np.where(rng.random(n_items) < 0.4, np.inf, rng.normal(0.0, 4.0, n_items))
            problem = AssignmentProblem.from_tuples(tuples, costs, alone=alone)
            wanted = least_cost_of_tuples(tuples, costs, alone)
            n_infeasible += np.isinf(wanted)
            assert least_cost(problem) == pytest.approx(wanted, abs=1e-9)
        assert 10 < n_infeasible < 70

    def test_a_row_of_one_item_is_a_price_that_outranks_the_price_of_all(self) -> None:
        problem = AssignmentProblem.from_tuples([[1, 0], [1, 1]], [4.0, 5.0], alone=np.inf)
        assert problem.requirement is not None
        assert problem.requirement.item.tolist() == [1]
        assert (
            AssignmentProblem.from_tuples([[1, 0], [1, 1]], [4.0, 5.0], alone=9.0).base_cost
            == 13.0
        )

    def test_items_that_pay_to_be_left_are_left(self) -> None:
        problem = AssignmentProblem.from_tuples(FOUR, np.ones(4), alone=-3.0)
        assert least_cost(problem) == -12.0

    def test_an_item_of_no_row_has_its_price_too(self) -> None:
        # Item 2 of the first list stands in no row.
        assert (
            AssignmentProblem.from_tuples([[1, 1], [3, 1]], [1.0, 1.0], alone=5.0).base_cost
            == 20.0
        )
        needed = AssignmentProblem.from_tuples([[1, 1], [3, 2]], [1.0, 1.0], alone=np.inf)
        assert least_cost(needed) == np.inf

    @pytest.mark.parametrize(
        ("alone", "message"),
        [
            (NAN, "alone: NaN or minus infinity"),
            (-INF, "alone: NaN or minus infinity"),
            ([0.0, 0.0, NAN, 0.0], "alone: NaN or minus infinity"),
            ([0.0, 0.0, 0.0], r"alone: an array of shape \(3,\); expected shape \(4\)"),
            ([[0.0, 0.0, 0.0, 0.0]], "alone: an array of shape"),
            ("dear", "alone: .* expected numbers"),
            (1e300, "costs: 1.0 is lost beside 2e[+]300"),
            (-1e300, "costs: 1.0 is lost beside 2e[+]300"),
            (1e14, "costs: 1.0 is lost beside|costs: .* is lost beside"),
            (1.5e308, "costs: too large to be added"),
        ],
    )
    def test_refuses_prices_that_are_none(self, alone: Any, message: str) -> None:
        with pytest.raises(InvalidInputError, match=message):
            AssignmentProblem.from_tuples(FOUR, [1.0, 2.1, 3.2, 4.3], alone=alone)

    def test_a_large_price_takes_no_digit_from_whole_costs(self) -> None:
        problem = AssignmentProblem.from_tuples(FOUR, [1.0, 2.0, 3.0, 5.0], alone=1e12)
        assert least_cost(problem) == 5.0


class TestRequirement:
    def test_its_penalty_exceeds_what_any_two_answers_differ_by(self) -> None:
        rng = np.random.default_rng(3)
        for _ in range(60):
            tuples, costs = random_tuples(rng, 8)
            n_items = int(tuples.max(axis=0).sum())
            alone = np.where(rng.random(n_items) < 0.5, np.inf, rng.normal(0.0, 4.0, n_items))
            requirement = AssignmentProblem.from_tuples(tuples, costs, alone=alone).requirement
            if requirement is None:
                continue
            # Left free of charge, required items allow every answer there is.
            free = np.where(np.isinf(alone), 0.0, alone)
            cheapest = least_cost_of_tuples(tuples, costs, free)
            dearest = -least_cost_of_tuples(tuples, -costs, -free)
            assert requirement.penalty > dearest - cheapest
            optimum = least_cost_of_tuples(tuples, costs, alone)
            assert np.isinf(optimum) or optimum <= requirement.ceiling + 1e-9

    def test_leaves_whole_costs_whole(self) -> None:
        costs = np.random.default_rng(4).integers(-90, 90, (3, 3, 3)).astype(float)
        problem = AssignmentProblem.from_array(costs)
        ends = problem.total[np.isfinite(problem.total)]
        assert (ends == np.floor(ends)).all()

    def test_is_none_where_every_item_may_be_left(self) -> None:
        assert AssignmentProblem.from_tuples(FOUR, np.ones(4), alone=3.0).requirement is None


class TestArray:
    @pytest.mark.parametrize("n", [1, 2, 3, 4])
    def test_of_two_axes_is_the_usual_assignment(self, n: int) -> None:
        costs = np.random.default_rng(n).normal(size=(n, n))
        best = min(sum(costs[range(n), list(p)]) for p in permutations(range(n)))
        assert least_cost(AssignmentProblem.from_array(costs)) == pytest.approx(best)

    def test_of_three_axes_is_the_axial_assignment(self) -> None:
        costs = np.random.default_rng(0).normal(size=(3, 3, 3))
        orders = list(permutations(range(3)))
        best = min(sum(costs[range(3), p, q]) for p in orders for q in orders)
        assert least_cost(AssignmentProblem.from_array(costs)) == pytest.approx(best)

    def test_axes_may_differ_where_items_may_be_left(self) -> None:
        costs = np.array([[-1.0, -5.0, -2.0]])
        assert least_cost(AssignmentProblem.from_array(costs, alone=0.0)) == -5.0
        assert least_cost(AssignmentProblem.from_array(costs)) == np.inf

    def test_an_infinite_entry_is_not_allowed(self) -> None:
        costs = [[-9.0, 1.0], [1.0, np.inf]]
        problem = AssignmentProblem.from_array(costs)
        assert (problem.n_nodes, least_cost(problem)) == (5, 2.0)

    def test_rows_count_the_entries_that_are_allowed(self) -> None:
        costs = np.array([[np.inf, 1.0], [2.0, 3.0]])
        problem = AssignmentProblem.from_array(costs, alone=0.0)
        ends = np.flatnonzero(np.isfinite(problem.total))
        finite = costs[np.isfinite(costs)]
        assert problem.row is not None
        assert problem.total[ends].tolist() == finite[problem.row[ends]].tolist()

    @pytest.mark.parametrize("shape", [(0, 3), (3, 0), (0, 0), (2, 0, 2)])
    def test_without_entries_covers_nothing(self, shape: tuple[int, ...]) -> None:
        free = AssignmentProblem.from_array(np.empty(shape), alone=2.0)
        assert (free.n_nodes, free.n_items, free.base_cost) == (0, sum(shape), 2.0 * sum(shape))
        needed = AssignmentProblem.from_array(np.empty(shape))
        assert least_cost(needed) == (np.inf if sum(shape) else 0.0)

    @pytest.mark.parametrize(
        ("costs", "message"),
        [
            (3.0, "expected one axis per list, at least two"),
            ([1.0, 2.0], "expected one axis per list, at least two"),
            ([[1.0, NAN]], "costs: NaN or minus infinity"),
            ([[1.0, -INF]], "costs: NaN or minus infinity"),
            ([["a", "b"]], "costs: .* expected numbers"),
            ([[1.0, 2.0], [1.0]], "costs: .*rows of several lengths"),
            ([[1.7e308, -1.7e308], [1.0, 2.0]], "costs: too large to be added"),
            ([[4e307, -4e307], [1.0, 2.0]], "costs: too large to be added"),
            ([[1e300, 0.1], [1.0, 2.0]], r"costs: 0\.1 is lost beside"),
        ],
    )
    def test_refuses_what_is_no_array_of_costs(self, costs: Any, message: str) -> None:
        with pytest.raises(InvalidInputError, match=message):
            AssignmentProblem.from_array(costs)

    @pytest.mark.parametrize("scale", [1e300, 1e-3, 1e-300])
    def test_costs_of_any_one_size_are_taken(self, scale: float) -> None:
        costs = np.array([[1.0, 3.0], [7.0, 2.0]]) * scale
        # Below a billionth of a nat everything is equal.
        assert least_cost(AssignmentProblem.from_array(costs)) == pytest.approx(
            3 * scale, rel=1e-9, abs=1e-9
        )


class TestTuples:
    def test_the_order_of_rows_and_of_lists_changes_no_optimum(self) -> None:
        rng = np.random.default_rng(6)
        for _ in range(30):
            tuples, costs = random_tuples(rng, 10)
            rows, lists = rng.permutation(len(costs)), rng.permutation(tuples.shape[1])
            problem = AssignmentProblem.from_tuples(tuples, costs)
            other = AssignmentProblem.from_tuples(tuples[rows][:, lists], costs[rows])
            assert least_cost(other) == pytest.approx(least_cost(problem), abs=1e-9)

    def test_a_prefix_is_one_node(self) -> None:
        tuples = [[1, 1, 1], [1, 1, 2], [1, 2, 1], [2, 1, 1]]
        assert AssignmentProblem.from_tuples(tuples, -np.ones(4)).n_nodes == 1 + 2 + 3 + 1 + 1 + 1

    def test_many_lists_with_large_numbers_are_sorted_too(self) -> None:
        # The product of their sizes is beyond 64 bits.
        rng = np.random.default_rng(7)
        table = rng.integers(0, 3, (12, 10)) * 9_999
        table = table[np.count_nonzero(table, axis=1) > 1]
        costs = rng.normal(-2.0, 1.0, table.shape[0])
        problem = AssignmentProblem.from_tuples(table, costs)
        ends = np.isfinite(problem.total)
        assert problem.row is not None
        assert problem.total[ends].tolist() == costs[problem.row[ends]].tolist()

    @pytest.mark.parametrize("costs", [[-1.7e308, -1.7e308], [1.2e308, -1.7e308]])
    def test_refuses_costs_that_cannot_be_added(self, costs: list[float]) -> None:
        with pytest.raises(InvalidInputError, match=r"total: a cost of size 1\.7e\+308"):
            AssignmentProblem.from_tuples([[1, 1], [2, 2]], costs)


@pytest.mark.slow
def test_a_million_tuples_are_a_problem_in_a_few_seconds() -> None:
    rng = np.random.default_rng(8)
    table = rng.integers(0, 400, (1_000_000, 4))
    table = table[table.any(axis=1)]
    costs = rng.normal(0.0, 3.0, table.shape[0])
    problem = AssignmentProblem.from_tuples(table, costs)
    assert problem.n_nodes > 2_000_000
    ends = np.flatnonzero(np.isfinite(problem.total))
    assert problem.row is not None
    assert np.unique(problem.row[ends]).shape == ends.shape
