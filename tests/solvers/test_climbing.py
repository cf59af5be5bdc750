"""A stretch of the climb: the bound rises, the answer gets no dearer, the clock is looked at."""

import numpy as np
import pytest

from oracles.assignment import (
    hard_tuples,
    in_ones,
    least_cost,
    random_problem,
    random_required,
    sequence,
)
from trackweave.association.problem import AssignmentProblem
from trackweave.solvers import dual
from trackweave.solvers._kernels import cheapest_first
from trackweave.solvers.components import Components
from trackweave.solvers.dual import STRETCHES, Stretch, climb

SHORT = [Stretch(40, False), Stretch(40, True)]


def answered(problem: AssignmentProblem) -> Components:
    """Return a problem taken apart with greedy answers and bounds."""
    components = Components.of(in_ones(problem), None)
    for index in range(len(components)):
        components.cost[index], components.lower[index] = cheapest_first(
            components.component(index), components.taken[components.families(index)]
        )
    return components


def problems() -> list[AssignmentProblem]:
    found = [random_problem(np.random.default_rng([12, seed])) for seed in range(40)]
    found += [hard_tuples(seed, 24, 4) for seed in range(10)]
    return found + [random_required(np.random.default_rng([4, seed])) for seed in range(30)]


@pytest.mark.parametrize("stretch", SHORT, ids=["subgradients", "smoothed"])
def test_ends_with_a_better_bound_and_an_answer_no_dearer(stretch: Stretch) -> None:
    rose = cheaper = 0
    for problem in problems():
        components = answered(problem)
        before = components.copy()
        for index in components.open().tolist():
            bounds, stopped = climb(components, index, stretch, None)
            assert 0 < bounds <= 40
            assert not stopped
        assert (components.lower >= before.lower).all()
        assert (components.cost <= before.cost).all()
        rose += components.lower.sum() > before.lower.sum() + 1e-6
        cheaper += components.cost.sum() < before.cost.sum() - 1e-6
        optimum = least_cost(problem)
        bound = problem.base_cost + components.lower.sum()
        assert bound <= optimum + 1e-8 * max(1.0, abs(optimum), np.abs(components.cost).sum())
        items = [i for node in components.nodes().tolist() for i in sequence(problem, node)]
        assert len(items) == len(set(items))
        cost = problem.total[components.nodes()].sum()
        assert components.cost.sum() == pytest.approx(cost, abs=1e-9)
    assert rose > 20
    assert cheaper > 5


@pytest.mark.parametrize("stretch", SHORT, ids=["subgradients", "smoothed"])
def test_a_stop_is_seen_between_slices(stretch: Stretch, monkeypatch) -> None:
    problem = hard_tuples(1, 200, 9)
    monkeypatch.setattr(dual, "STRETCH_WORK", 5 * problem.n_nodes)
    components = answered(problem)
    bounds, stopped = climb(components, 0, stretch, lambda: True)
    assert stopped
    assert 0 < bounds < 10
    assert components.cost[0] >= components.lower[0]


@pytest.mark.parametrize("stretch", SHORT, ids=["subgradients", "smoothed"])
def test_looks_at_the_clock_change_nothing(stretch: Stretch, monkeypatch) -> None:
    problem = hard_tuples(2, 200, 9)
    blind, looking = answered(problem), answered(problem)
    climb(blind, 0, stretch, None)
    monkeypatch.setattr(dual, "STRETCH_WORK", 3 * problem.n_nodes)
    climb(looking, 0, stretch, lambda: False)
    assert looking.lower.tolist() == blind.lower.tolist()
    assert looking.taken.tolist() == blind.taken.tolist()
    assert looking.price.tolist() == blind.price.tolist()


def test_both_ways_are_tried_and_the_quick_one_first() -> None:
    assert {stretch.is_smooth for stretch in STRETCHES} == {True, False}
    assert not STRETCHES[0].is_smooth
