"""A problem taken apart and put together."""

import numpy as np
import pytest

from oracles.assignment import random_problem
from trackweave.association.problem import AssignmentProblem
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
