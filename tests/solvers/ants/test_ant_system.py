"""Wiranto & Bonok's ants: their equations by hand, their stop rule, and interruption."""

import pickle
from collections import Counter
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.stats import chisquare

from oracles.assignment import in_ones, random_problem
from trackweave.association.problem import AssignmentProblem
from trackweave.errors import InvalidInputError
from trackweave.solvers import AntSystem, Hint
from trackweave.solvers.ants._tours import (
    Points,
    accumulate,
    are_one_route,
    chance_tour,
    draw_starts,
    lay_trails,
    make_tours,
    nearest_tour,
    selection_of,
)
from trackweave.solvers.ants.ant_system import AntSearch, make_points, most_visited
from trackweave.solvers.components import Components
from trackweave.solvers.resumable import Start, View

PROBLEMS = [random_problem(np.random.default_rng([4, seed])) for seed in range(30)]
# Five tuples of two lists of two items, the second item of list 2 twice.
TINY = AssignmentProblem.from_tuples([[1, 1], [1, 2], [2, 1], [2, 2]], [-4.0, -3.0, -3.5, -1.0])


def rng() -> np.random.Generator:
    return np.random.default_rng(9)


def view_of(problem: AssignmentProblem, price: float = 0.0) -> View:
    whole = Components.of(in_ones(problem), None, whole=True)
    component = whole.component(0)
    nodes = whole.parts.node
    prices = np.full(component.n_items, price)
    return View(component, problem.cost[nodes], problem.instant, prices, -np.inf)


def items_of(view: View, points: Points, point: int) -> frozenset[int]:
    node, items = int(points.node[point]), set()
    if node < 0:
        return frozenset([int(points.item[point])])
    while node >= 0:
        items.add(int(view.component.item[node]))
        node = int(view.component.parent[node])
    return frozenset(items)


def chances(view: View, points: Points, start: int, weight: np.ndarray) -> dict[Any, float]:
    """Return the probability of each tour from a start by eq. 4, straight from its words."""
    items = [items_of(view, points, point) for point in range(weight.shape[0])]
    found: dict[Any, float] = {}

    def go(tour: tuple[int, ...], covered: frozenset[int], chance: float) -> None:
        allowed = [point for point in range(len(items)) if not items[point] & covered]
        if not allowed:
            found[tour] = found.get(tour, 0.0) + chance
        total = weight[allowed].sum() if allowed else 1.0
        for point in allowed:
            go((*tour, point), covered | items[point], chance * weight[point] / total)

    go((start,), items[start], 1.0)
    return found


def steps(tour: np.ndarray) -> tuple[int, ...]:
    return tuple(tour[tour >= 0].tolist())


class TestPoints:
    def test_costs_are_above_zero_and_tours_keep_their_order(self) -> None:
        for problem in PROBLEMS:
            view = view_of(problem)
            if view.component.n_items == 0:
                continue
            points = make_points(view, priced=False)
            assert (points.cost > 0.0).all()
            tour = np.empty(view.component.n_items, dtype=np.int64)
            selection = np.empty(view.component.must.shape[0], dtype=np.int64)
            shifts = []
            order = np.arange(points.cost.shape[0])
            for _ in range(6):
                start = int(rng().integers(0, points.cost.shape[0]))
                length = nearest_tour(view.component, points, order, start, tour)
                shifts.append(length - selection_of(view.component, points, tour, selection))
                order = np.roll(order, 3)
            assert shifts == pytest.approx([shifts[0]] * 6, rel=1e-9)

    def test_leaving_an_item_alone_costs_the_shift_and_a_tuple_the_shift_per_item(self) -> None:
        points = make_points(view_of(TINY), priced=False)
        kappa = points.cost[points.node < 0]
        assert points.node.tolist().count(-1) == 4
        assert kappa == pytest.approx(kappa[0])
        assert kappa[0] > 2.0
        wanted = np.array([-4.0, -3.0, -3.5, -1.0]) + 2 * kappa[0]
        assert points.cost[points.node >= 0] == pytest.approx(wanted)

    def test_prices_shift_each_item_by_its_own(self) -> None:
        points = make_points(view_of(TINY, price=1.5), priced=True)
        tuples, alone = points.cost[points.node >= 0], points.cost[points.node < 0]
        assert tuples - 2 * (alone - 1.5)[0] == pytest.approx([-1.0, 0.0, -0.5, 2.0])

    def test_an_item_that_must_be_covered_is_never_left_alone(self) -> None:
        problem = AssignmentProblem([-1, 0], [0, 1], [5.0, 7.0], [5.0, 7.0], [True, False], [0, 1])
        points = make_points(view_of(problem), priced=False)
        assert points.item[points.node < 0].tolist() == [1]

    @pytest.mark.parametrize("cost", [-2.0, 0.0, 3.0])
    def test_equal_costs_still_leave_a_margin(self, cost: float) -> None:
        problem = AssignmentProblem.from_tuples([[1, 1], [2, 2]], [cost, cost])
        assert (make_points(view_of(problem), priced=False).cost > 0.0).all()

    def test_a_unit_scales_costs_and_nothing_else(self) -> None:
        plain = make_points(view_of(TINY), priced=False).cost
        scaled = replace(TINY, cost=TINY.cost * 1024.0, total=TINY.total * 1024.0)
        assert make_points(view_of(scaled), priced=False).cost == pytest.approx(plain * 1024.0)


class TestTours:
    def test_the_first_cycle_goes_to_the_greatest_visibility(self) -> None:
        view = view_of(TINY)
        points = make_points(view, priced=False)
        order, tour = np.argsort(points.cost, kind="stable"), np.empty(4, dtype=np.int64)
        # κ is a little above 2: tuples cost 2κ − 4, − 3, − 3.5, − 1, an item alone κ.
        assert order[:4].tolist() == [0, 2, 1, 4]
        tuples = {point: items_of(view, points, point) for point in range(8)}
        length = nearest_tour(view.component, points, order, 1, tour)
        assert steps(tour) == (1, 2)
        assert length == pytest.approx(points.cost[1] + points.cost[2])
        length = nearest_tour(view.component, points, order, 0, tour)
        # Both items that are left go alone before the dear tuple: 2κ − 1 > κ.
        assert steps(tour)[0] == 0
        assert {point for point in tuples if point >= 4} >= set(steps(tour)[1:])
        assert length == pytest.approx(points.cost[0] + 2 * points.cost[4])

    def test_a_tour_covers_every_item_once(self) -> None:
        source = rng()
        for problem in PROBLEMS:
            view = view_of(problem)
            n_items = view.component.n_items
            points = make_points(view, priced=False)
            attraction = source.normal(0.0, 4.0, points.cost.shape[0])
            cumulative, tour = np.empty_like(attraction), np.empty(n_items, dtype=np.int64)
            accumulate(attraction, np.arange(attraction.shape[0]), cumulative)
            for start in range(min(8, attraction.shape[0])):
                length = chance_tour(
                    view.component, points, attraction, cumulative, start, source, tour
                )
                covered = [i for point in steps(tour) for i in items_of(view, points, point)]
                assert sorted(covered) == list(range(n_items))
                assert length == pytest.approx(points.cost[list(steps(tour))].sum())

    # A start whose rivals have nearly all the weight makes ants list anew what is open.
    @pytest.mark.parametrize("rivals", [1.0, 200.0])
    def test_moves_have_the_probabilities_of_equation_4(self, rivals: float) -> None:
        view = view_of(TINY)
        points = make_points(view, priced=False)
        alpha, beta = 1.5, 0.7
        pheromone = np.array([1.0, rivals, rivals, 0.6, 0.9, 0.3, 1.1, 0.5])
        weight = pheromone**alpha / points.cost**beta
        attraction = alpha * np.log(pheromone) - beta * np.log(points.cost)
        cumulative, tour = np.empty(8), np.empty(4, dtype=np.int64)
        accumulate(attraction, np.arange(8), cumulative)
        source, draws = rng(), 20_000
        seen: Counter[tuple[int, ...]] = Counter()
        for _ in range(draws):
            chance_tour(view.component, points, attraction, cumulative, 0, source, tour)
            seen[steps(tour)] += 1
        wanted = chances(view, points, 0, weight)
        assert set(seen) <= set(wanted)
        assert sum(wanted.values()) == pytest.approx(1.0)
        result = chisquare([seen[key] for key in wanted], [draws * p for p in wanted.values()])
        assert result.pvalue > 0.001

    def test_pheromone_follows_equations_5_to_7(self) -> None:
        pheromone = np.array([1.0, 2.0, 0.5, 4.0])
        tours = np.array([[0, 2, -1], [2, 3, -1]])
        lay_trails(pheromone, tours, np.array([4.0, 8.0]), 0.5)
        wanted = [0.5 + 1 / 4, 1.0, 0.25 + 1 / 4 + 1 / 8, 2.0 + 1 / 8]
        assert pheromone == pytest.approx(wanted)

    def test_one_route_is_the_same_points_in_any_order(self) -> None:
        assert are_one_route(np.array([[0, 3, -1], [3, 0, -1]]), 5)
        assert not are_one_route(np.array([[0, 3, -1], [3, 1, -1]]), 5)
        assert not are_one_route(np.array([[0, 3, 4], [3, 0, -1]]), 5)

    def test_new_ants_start_anywhere_on_the_tour_of_the_one_before(self) -> None:
        tours = np.array([[7, 2, 5], [1, 4, -1], [0, -1, -1]])
        starts, source = np.empty(3, dtype=np.int64), rng()
        seen = []
        for _ in range(3000):
            draw_starts(tours, source, starts)
            seen.append(starts.copy())
        counts = [Counter(column) for column in np.array(seen).T.tolist()]
        assert [set(count) for count in counts] == [{7, 2, 5}, {1, 4}, {0}]
        assert chisquare(list(counts[0].values())).pvalue > 0.001


def search_of(ants: int | None = 6) -> tuple[AntSystem, View, AntSearch]:
    view, colony = view_of(TINY), AntSystem(ants=ants)
    nothing = np.full(view.component.must.shape[0], -1)
    return colony, view, colony._begin(view, Start([], nothing, np.inf, rng()))


class TestSearch:
    def test_pheromone_is_visibility_at_first(self) -> None:
        _, _, search = search_of()
        assert search.pheromone == pytest.approx(1.0 / search.points.cost)

    def test_ants_start_on_different_points_as_far_as_there_are(self) -> None:
        starts = search_of(ants=8)[2].starts
        assert sorted(starts.tolist()) == list(range(8))
        assert Counter(search_of(ants=20)[2].starts.tolist()).most_common(1)[0][1] == 3

    def test_a_tour_visits_at_most_the_documents_n_points_and_ants_grow_with_it(self) -> None:
        _, view, search = search_of(ants=None)
        n = 1 + view.component.n_items
        assert most_visited(view.component.n_items) == n
        assert search.starts.shape == (3 * n,)
        # Every plot left alone, the longest tour that there is; the point of dummies is one more.
        alone = np.flatnonzero(search.points.node < 0)
        tour = np.empty(n - 1, dtype=np.int64)
        order = np.concatenate([alone, np.flatnonzero(search.points.node >= 0)])
        nearest_tour(view.component, search.points, order, int(alone[0]), tour)
        assert 1 + len(list(steps(tour))) == n
        assert (AntSystem().colony(9), AntSystem(ants=7).colony(9)) == (30, 7)

    def test_ends_after_n_cycles_where_none_are_given(self) -> None:
        problem = hard(n_rows=60)
        answer = AntSystem(pheromone_weight=0.0, decompose=False)(problem, rng=rng())
        n = most_visited(problem.n_items)
        assert (answer.stop_reason, answer.evaluations) == ("cycles", 3 * n * n)

    def test_the_second_cycle_moves_by_pheromone_and_visibility(self) -> None:
        colony, view, search = search_of()
        later = colony._go_on(view, search, 100)
        assert (later.cycle, later.position, later.evaluations) == (1, 0, 6)
        wanted = colony.persistence / search.points.cost
        for ant in range(6):
            tour = np.empty(4, dtype=np.int64)
            start = int(search.starts[ant])
            length = nearest_tour(view.component, search.points, search.order, start, tour)
            wanted[list(steps(tour))] += 1.0 / length
            assert int(later.starts[ant]) in steps(tour)
        assert later.pheromone == pytest.approx(wanted)
        weight = np.exp(later.attraction)
        assert weight == pytest.approx(wanted / search.points.cost**colony.visibility_weight)

    def test_ends_in_the_cycle_in_which_all_ants_have_the_same_route(self) -> None:
        colony = AntSystem(ants=4, cycles=10**6, evaluations=10**6)
        _, view, search = search_of(ants=4)
        routes: list[set[frozenset[int]]] = []
        while not colony._why_over(search):
            assert len(routes) == 0 or len(routes[-1]) > 1
            search = colony._go_on(view, search, 4)
            routes.append({frozenset(steps(tour)) for tour in search.tours})
        assert colony._why_over(search) == "converged"
        assert (len(routes[-1]), search.cycle) == (1, len(routes))

    def test_says_which_budget_was_spent(self) -> None:
        problem = hard()
        few = AntSystem(ants=10, cycles=3, decompose=False)
        assert few(problem, rng=rng()).stop_reason == "cycles"
        assert few(problem, rng=rng()).evaluations == 30
        short = AntSystem(ants=10, evaluations=25, decompose=False)(problem, rng=rng())
        assert (short.stop_reason, short.evaluations) == ("evaluations", 30)

    def test_converges_on_a_small_problem(self) -> None:
        colony = AntSystem(ants=10, cycles=2000, evaluations=10**6, decompose=False)
        assert colony(hard(n_rows=60), rng=rng()).stop_reason == "converged"

    def test_best_is_the_best_tour_of_all(self) -> None:
        colony, view, search = search_of()
        n = view.component.must.shape[0]
        guide = (search.order, search.attraction, search.cumulative)
        costs = []
        for ant in range(6):
            cost = make_tours(
                view.component, search.points, guide, True, np.array([ant]), search.starts,
                rng(), search.tours.copy(), search.lengths.copy(), np.empty(n, dtype=np.int64),
                np.inf,
            )  # fmt: skip
            costs.append(cost)
        assert colony._go_on(view, search, 6).best == min(costs)

    def test_to_the_letter_it_reads_no_prices(self) -> None:
        problem = hard()
        hint = Hint(prices=np.arange(problem.n_items, dtype=np.float64))
        plain, hinted = AntSystem()(problem, rng=rng()), AntSystem()(problem, rng=rng(), hint=hint)
        assert plain.nodes.tolist() == hinted.nodes.tolist()
        assert plain.evaluations == hinted.evaluations

    def test_trails_draw_ants_to_the_same_points(self) -> None:
        colony = AntSystem(ants=20, cycles=100, evaluations=2000, decompose=False)
        start = colony.start(hard(1), rng=rng())
        # The second cycle is the first that draws by eq. 4.
        early, late = (colony.advance(start, evaluations=n).search for n in (40, 600))
        points = [np.unique(search.tours[search.tours >= 0]).size for search in (early, late)]
        assert points[1] < 0.7 * points[0]


def hard(seed: int = 0, n_rows: int = 300) -> AssignmentProblem:
    """Return a dense problem whose bound leaves a gap."""
    source = np.random.default_rng(seed)
    rows = source.integers(1, 11, (n_rows, 4))
    return AssignmentProblem.from_tuples(rows, source.normal(-5.0, 1.0, n_rows))


COLONIES = {
    "to the letter": AntSystem(ants=7, cycles=8),
    "seeded": AntSystem(ants=7, cycles=8, seeded=True, decompose=False),
}


@pytest.fixture(params=COLONIES.values(), ids=COLONIES.keys())
def colony(request: pytest.FixtureRequest) -> AntSystem:
    return request.param


class TestState:
    @pytest.mark.parametrize("chunk", [1, 5, 33])
    def test_in_chunks_saved_between_ends_as_uninterrupted(self, colony, chunk: int) -> None:
        whole = colony(hard(), rng=rng())
        state, chunks = colony.start(hard(), rng=rng()), 0
        while not state.done:
            state = pickle.loads(pickle.dumps(state))
            state = colony.advance(state, evaluations=chunk)
            chunks += 1
        answer = colony.answer(state)
        assert chunks > 1
        assert answer.nodes.tolist() == whole.nodes.tolist()
        assert (answer.certificate, answer.evaluations, answer.stop_reason) == (
            whole.certificate, whole.evaluations, whole.stop_reason,
        )  # fmt: skip

    def test_advancing_leaves_the_state_it_came_from(self, colony) -> None:
        state = colony.advance(colony.start(hard(), rng=rng()), evaluations=25)
        before = pickle.dumps(state)
        first, second = colony.advance(state), colony.advance(state)
        assert pickle.dumps(state) == before
        assert colony.answer(first).nodes.tolist() == colony.answer(second).nodes.tolist()

    def test_no_more_ants_go_out_than_was_asked_for(self, colony) -> None:
        state = colony.start(hard(), rng=rng())
        for chunk in (0, 1, 13, 20):
            later = colony.advance(state, evaluations=chunk)
            assert later.evaluations - state.evaluations == chunk
            state = later


@pytest.mark.parametrize(
    "wrong",
    [
        {"ants": 0}, {"pheromone_weight": -1.0}, {"pheromone_weight": np.nan},
        {"visibility_weight": np.inf}, {"persistence": 1.1}, {"persistence": -0.1},
        {"cycles": 0}, {"evaluations": 0},
    ],
    ids=str,
)  # fmt: skip
def test_refuses_parameters_out_of_range(wrong: dict[str, Any]) -> None:
    name = next(iter(wrong))
    with pytest.raises(InvalidInputError, match=f"^{name}: "):
        AntSystem(**wrong)
