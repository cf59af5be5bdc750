"""Both climbs: bounds that hold, prices that prove them, and pieces that make a whole."""

from collections.abc import Callable
from typing import NamedTuple

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
from trackweave.solvers._ascent import Climb, _expect, begin_climb, deflect, smooth
from trackweave.solvers._dual import bound_components
from trackweave.solvers._kernels import Component, cheapest_first
from trackweave.solvers.components import Components


class Case(NamedTuple):
    components: Components
    component: Component
    upper: float
    optimum: float


def make_cases() -> list[Case]:
    problems = [random_problem(np.random.default_rng([11, seed])) for seed in range(50)]
    problems += [hard_tuples(seed, 24, 4) for seed in range(10)]
    problems += [random_required(np.random.default_rng([4, seed])) for seed in range(30)]
    cases = []
    for problem in problems:
        components = Components.of(in_ones(problem), None, whole=True)
        optimum = least_cost(problem) - problem.base_cost
        if len(components) and np.isfinite(optimum):
            component = components.component(0)
            upper, _ = cheapest_first(component, components.taken)
            cases.append(Case(components, component, max(upper, optimum), optimum))
    return cases


CASES = make_cases()
TRIANGLE = AssignmentProblem.from_tuples([[1, 1, 0], [0, 1, 1], [1, 0, 1]], [-2.0, -2.0, -2.0])
Climber = Callable[[Case, np.ndarray, Climb, int, int], bool]


def by_subgradients(case: Case, price: np.ndarray, climb: Climb, more: int, last: int) -> bool:
    return bool(deflect(case.component, price, climb, case.upper, more, last))


def by_smoothing(case: Case, price: np.ndarray, climb: Climb, more: int, last: int) -> bool:
    return bool(smooth(case.component, price, climb, 2.0, 0.06, more, last))


CLIMBERS: list[Climber] = [by_subgradients, by_smoothing]


def bound_at(case: Case, price: np.ndarray) -> float:
    parts = case.components.parts
    cost, lower = np.empty(1), np.empty(1)
    bound_components(parts, price, case.components.taken, cost, lower)
    return float(lower[0])


def begin(case: Case, price: np.ndarray, climber: Climber) -> Climb:
    factor = 0.1 if climber is by_subgradients else 1.0
    return begin_climb(case.component, price, bound_at(case, price), factor)


def prices(case: Case, rng: np.random.Generator) -> np.ndarray:
    return rng.exponential(2.0, case.component.n_items) * (
        rng.random(case.component.n_items) < 0.5
    )


def test_any_prices_prove_a_bound() -> None:
    rng = np.random.default_rng(1)
    for case in CASES:
        for scale in (0.0, 0.1, 1.0, 100.0):
            price = scale * rng.exponential(1.0, case.component.n_items)
            slack = 1e-9 * max(1.0, abs(case.optimum), price.sum())
            assert bound_at(case, price) <= case.optimum + slack


@pytest.mark.parametrize("climber", CLIMBERS)
class TestClimb:
    def test_ends_no_lower_than_it_began_and_never_above_the_optimum(self, climber) -> None:
        rng = np.random.default_rng(2)
        rose = 0
        for case in CASES:
            price = prices(case, rng)
            climb = begin(case, price, climber)
            start = float(climb.value[0])
            climber(case, price, climb, 60, 60)
            assert start <= climb.value[0] <= case.optimum + 1e-9 * max(1.0, abs(case.optimum))
            rose += climb.value[0] > start + 1e-6
        assert rose > len(CASES) // 2

    def test_its_prices_prove_its_bound(self, climber) -> None:
        rng = np.random.default_rng(3)
        for case in CASES:
            price = prices(case, rng)
            climb = begin(case, price, climber)
            climber(case, price, climb, 40, 40)
            assert (price >= 0.0).all()
            assert bound_at(case, price) == pytest.approx(min(climb.value[0], case.upper))

    def test_nears_what_prices_can_prove(self, climber) -> None:
        # Half of each of three pairs: the linear program's bound is −3, the optimum −2.
        case = CASES[0]._replace(components=Components.of(in_ones(TRIANGLE), None, whole=True))
        case = case._replace(component=case.components.component(0), upper=-2.0, optimum=-2.0)
        price = np.zeros(3)
        climb = begin(case, price, climber)
        assert climb.value[0] == -4.0
        climber(case, price, climb, 300, 300)
        assert climb.value[0] == pytest.approx(-3.0, abs=0.05)

    def test_in_pieces_ends_as_in_one_go(self, climber) -> None:
        for case in CASES[:40]:
            first, second = np.zeros((2, case.component.n_items))
            climb = begin(case, first, climber)
            over = climber(case, first, climb, 50, 50)
            pieces = begin(case, second, climber)
            for more in (1, 1, 7, 11, 50):
                if over_in_pieces := climber(case, second, pieces, more, 50):
                    break
            assert over == over_in_pieces
            assert pieces.steps.tolist() == climb.steps.tolist()
            assert pieces.value.tolist() == climb.value.tolist()
            assert second.tolist() == first.tolist()

    def test_leaves_prices_that_are_of_no_use_alone(self, climber) -> None:
        for case in CASES[:40]:
            price = np.zeros(case.component.n_items)
            climb = begin(case, price, climber)
            climber(case, price, climb, 40, 40)
            assert (price[~climb.is_inside] == 0.0).all()

    def test_counts_its_bounds_and_ends_with_the_last(self, climber) -> None:
        case = CASES[0]
        price = np.zeros(case.component.n_items)
        climb = begin(case, price, climber)
        assert climber(case, price, climb, 500, 7)
        assert climb.steps[0] <= 7


def test_items_that_more_than_one_sequence_wants_are_inside() -> None:
    for case in CASES[:40]:
        problem, component = case.components.problem, case.component
        climb = begin_climb(component, np.zeros(component.n_items), 0.0, 1.0)
        for local, item in enumerate(case.components.parts.item_of.tolist()):
            holders = [n for n in range(problem.n_nodes) if problem.item[n] == item]
            is_one_root = len(holders) == 1 and problem.parent[holders[0]] < 0
            assert climb.is_inside[local] != (is_one_root or not holders)


def test_expected_cover_is_that_of_the_families_own_distributions() -> None:
    rng = np.random.default_rng(5)
    for case in CASES[:60]:
        component = case.component
        price, temperature = prices(case, rng), float(rng.choice([0.3, 1.0, 5.0]))
        n_nodes = component.parent.shape[0]
        scratch = [np.empty(n_nodes) for _ in range(3)]
        cover = np.empty(component.n_items)
        bound = _expect(component, price, temperature, *scratch, cover)
        item_of = case.components.parts.item_of.tolist()
        local = {item: place for place, item in enumerate(item_of)}
        problem, node_of = case.components.problem, case.components.parts.node
        paths = [[local[i] for i in sequence(problem, int(node))] for node in node_of]
        wanted, least = np.zeros(component.n_items), 0.0
        for family in range(component.must.shape[0]):
            members = np.flatnonzero((component.family == family) & np.isfinite(component.total))
            reduced = [component.total[node] + price[paths[node]].sum() for node in members]
            options = reduced if component.must[family] else [*reduced, 0.0]
            least += min(options)
            weight = np.exp(-(np.array(options) - min(options)) / temperature)
            weight /= weight.sum()
            for node, share in zip(members.tolist(), weight, strict=False):
                wanted[paths[node]] += share
        # What is improbable beyond a millionth or so is left out.
        assert cover == pytest.approx(wanted, abs=1e-5)
        assert bound == pytest.approx(least - price.sum())
