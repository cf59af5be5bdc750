"""A problem taken apart and put together."""

import numpy as np
import pytest

from oracles.assignment import in_ones, random_problem
from trackweave.association.problem import AssignmentProblem, Status
from trackweave.solvers import Dual, Hint
from trackweave.solvers.components import Components


def test_an_answer_taken_apart_is_the_same_answer() -> None:
    for seed in range(30):
        problem = random_problem(np.random.default_rng([7, seed]))
        best = Dual()(problem, rng=np.random.default_rng(0))
        for whole in (True, False):
            components = Components.of(problem, None, whole=whole)
            components.taken[:] = components.selection_of(best.nodes)
            assert components.nodes().tolist() == best.nodes.tolist()


def test_open_components_come_with_the_widest_gap_first() -> None:
    problem = AssignmentProblem.from_tuples([[1, 1], [2, 2], [3, 3]], [-1.0, -1.0, -1.0])
    components = Components.of(problem, None)
    components.cost[:], components.lower[:] = [-1.0, -1.0, -1.0], [-2.0, -1.0, -5.0]
    assert components.open().tolist() == [2, 0]
    answer = components.answer(0, "")
    assert (answer.cost, answer.lower_bound, answer.status) == (0.0, -5.0, "feasible")


def test_nothing_is_proven_before_it_is_bounded() -> None:
    problem = AssignmentProblem.from_tuples([[1, 1]], [-1.0])
    components = Components.of(problem, None)
    assert components.open().tolist() == [0]
    assert components.answer(0, "").lower_bound == -np.inf


def test_prices_go_to_their_items_and_come_back() -> None:
    problem = random_problem(np.random.default_rng(3))
    prices = np.random.default_rng(0).exponential(1.0, problem.n_items)
    components = Components.of(problem, Hint(prices=prices))
    used = np.zeros(problem.n_items, dtype=np.bool_)
    used[problem.item] = True
    back = components.answer(0, "").prices
    assert back == pytest.approx(np.where(used | problem.must_cover, prices, 0.0))


def test_a_copy_changes_apart() -> None:
    components = Components.of(AssignmentProblem.from_tuples([[1, 1]], [-1.0]), None)
    other = components.copy()
    other.taken[:], other.cost[:], other.lower[:] = 0, 5.0, 5.0
    assert components.taken.tolist() == [-1]
    assert np.isinf(components.cost).all()


def pair(cost: float, *others: float) -> Components:
    """Return one component of pairs that share an item, the first of them taken."""
    rows = [[1, number + 1] for number in range(1 + len(others))]
    problem = in_ones(AssignmentProblem.from_tuples(rows, [cost, *others]))
    components = Components.of(problem, None)
    ends = np.flatnonzero(components.component(0).total == cost)
    components.taken[0], components.cost[0] = ends[0], cost
    return components


@pytest.mark.parametrize(
    ("costs", "gap", "is_closed"),
    [
        ((-3.0, 1.0), 0.99, True),
        ((-3.0, 1.0), 1.0, False),
        ((-3.0, 0.5), 0.49, True),
        ((-3.0, 0.5), 0.5, False),
        ((-3e-9, 6e-9), 2e-9, False),
        ((-3.3, 0.5), 2e-9, False),
        ((-3.3, 0.5), 0.5e-9, True),
        ((-3e7 - 0.3, 1.0), 2e-6, True),
        ((-3e7 - 0.3, 1.0), 4e-6, False),
        ((-3.0, 2.0**40), 0.5, False),
    ],
)
def test_a_gap_is_closed_by_rounding_or_by_whole_costs(
    costs: tuple[float, float], gap: float, is_closed: bool
) -> None:
    components = pair(*costs)
    components.lower[0] = costs[0] - gap
    assert components.is_closed(0, costs[0]) == is_closed
    assert (components.open().size == 0) == is_closed
    answer = components.answer(0, "why not")
    assert (answer.status is Status.OPTIMAL) == is_closed
    # What is near enough is closed; only whole costs and rounding make the bound meet the cost.
    is_exact = is_closed and gap != 0.5e-9
    assert answer.lower_bound == (costs[0] if is_exact else costs[0] - gap)


def test_nothing_is_closed_while_there_is_no_answer() -> None:
    components = pair(-3.5, 1.0)
    assert not components.is_closed(0, np.inf)
    components.cost[0], components.lower[0] = np.inf, -4.0
    assert components.open().tolist() == [0]
    assert np.isfinite(components.closing(0))


def test_rounding_that_may_hide_a_better_answer_is_said() -> None:
    # Left alone, each of four items costs a thousand million; the answer costs 5.5.
    rows, costs = [[1, 1], [1, 2], [2, 1], [2, 2]], [1.1, 2.2, 3.3, 4.4]
    problem = AssignmentProblem.from_tuples(rows, costs, alone=1e9)
    answer = Dual()(problem, rng=np.random.default_rng(0))
    assert answer.cost == pytest.approx(5.5, abs=1e-5)
    assert (answer.status, answer.stop_reason) == (Status.FEASIBLE, "rounding")
    assert 5.4 < answer.lower_bound < 5.5
    whole = AssignmentProblem.from_tuples(rows, [1.0, 2.0, 3.0, 4.0], alone=1e9)
    assert Dual()(whole, rng=np.random.default_rng(0)).status is Status.OPTIMAL


def test_an_answer_that_leaves_what_is_required_is_none() -> None:
    problem = AssignmentProblem.from_array([[1.0, np.inf], [np.inf, 2.0]])
    components = Components.of(problem, None)
    nothing = components.answer(0, "stopped")
    assert (nothing.cost, nothing.status) == (np.inf, Status.UNKNOWN)
    assert nothing.lower_bound == -np.inf
    # The bound alone can tell that there is none.
    assert problem.requirement is not None
    components.cost[:] = 0.0
    components.lower[:] = -problem.requirement.penalty / 2.0
    none = components.answer(0, "stopped")
    assert (none.cost, none.lower_bound, none.status) == (np.inf, np.inf, Status.INFEASIBLE)


def test_a_bound_that_an_answer_may_still_reach_is_no_proof_against_it() -> None:
    problem = AssignmentProblem.from_array([[1.0, np.inf], [np.inf, 2.0]])
    assert problem.requirement is not None
    components = Components.of(problem, None)
    components.cost[:] = 0.0
    components.lower[:] = (problem.requirement.ceiling - problem.base_cost) / len(components)
    assert components.answer(0, "stopped").status is Status.UNKNOWN
