"""Candidates of a component, and what a move does to who holds what."""

import numpy as np
import pytest
from scipy.stats import chisquare

from oracles.assignment import in_ones, least_cost, random_problem, random_window
from trackweave.association.problem import AssignmentProblem
from trackweave.solvers import Dual, Exact
from trackweave.solvers._kernels import Component, selection_cost
from trackweave.solvers._pricing import excesses
from trackweave.solvers.components import Components
from trackweave.solvers.local._moves import (
    Moves,
    begin_holding,
    cost_of,
    draw_item,
    draw_near,
    first_free,
    list_moves,
    log_room,
    move,
    selection_of,
    typical_excess,
    undo,
)

PROBLEMS = [random_problem(np.random.default_rng([14, seed])) for seed in range(60)]


def rng() -> np.random.Generator:
    return np.random.default_rng(9)


def component_of(problem: AssignmentProblem) -> tuple[Component, np.ndarray]:
    """Return a problem as one component, and prices of its items."""
    whole = Components.of(in_ones(problem), None, whole=True)
    prices = Dual(visits=0)(problem, rng=rng()).prices
    return whole.component(0), prices[whole.parts.item_of]


def items_of(component: Component, node: int) -> list[int]:
    items = []
    while node >= 0:
        items.append(int(component.item[node]))
        node = int(component.parent[node])
    return items


def own_items(moves: Moves, candidate: int) -> list[int]:
    return moves.item[moves.start[candidate] : moves.start[candidate + 1]].tolist()


def try_move(moves: Moves, holder: np.ndarray, source: np.random.Generator, links: int):
    """Force some candidate in; return the change of cost, the log, and which it was."""
    forced = int(source.integers(0, moves.node.shape[0]))
    log = log_room(holder.shape[0], links)
    limit = int(source.integers(0, moves.node.shape[0] + 1))
    change, entries = move(
        moves.cost, moves.excess, moves.start, moves.item, moves.list_start, moves.listed,
        moves.anchor, forced, limit, -np.inf, links, 1.0, source, holder,
        np.empty(holder.shape[0], dtype=np.int64), log,
    )  # fmt: skip
    return change, log[:entries], forced


def require_sound(moves: Moves, holder: np.ndarray) -> None:
    for candidate in set(holder[holder >= 0].tolist()):
        assert np.flatnonzero(holder == candidate).tolist() == sorted(own_items(moves, candidate))
    assert (holder[moves.anchor >= 0] >= 0).all()


class TestListMoves:
    def test_candidates_are_nodes_that_may_pay_in_order_of_excess(self) -> None:
        for problem in PROBLEMS:
            component, price = component_of(problem)
            bound, excess, _ = excesses(component, price)
            cost = bound + 1.5
            moves = list_moves(component, price, cost)
            must = component.must[component.family]
            pays = (component.total < 0.0) | must
            pays &= np.isfinite(component.total)
            near = (excess <= 1.5 + 1e-9) | (must & (component.parent < 0))
            assert sorted(moves.node.tolist()) == np.flatnonzero(pays & near).tolist()
            assert moves.excess == pytest.approx(excess[moves.node])
            assert (np.diff(moves.excess) >= 0.0).all()
            assert moves.cost.tolist() == component.total[moves.node].tolist()

    def test_every_item_lists_its_candidates(self) -> None:
        for problem in PROBLEMS:
            component, price = component_of(problem)
            moves = list_moves(component, price, np.inf)
            for candidate, node in enumerate(moves.node.tolist()):
                assert own_items(moves, candidate) == items_of(component, node)
            for item in range(component.n_items):
                listed = moves.listed[moves.list_start[item] : moves.list_start[item + 1]].tolist()
                n = moves.node.shape[0]
                assert listed == [c for c in range(n) if item in own_items(moves, c)]

    def test_items_that_must_be_covered_have_their_own_candidate(self) -> None:
        n_tracks = 0
        for problem in PROBLEMS:
            component, price = component_of(problem)
            moves = list_moves(component, price, -np.inf)
            roots = component.members[component.start[:-1]][component.must]
            assert moves.node[moves.anchor[component.item[roots]]].tolist() == roots.tolist()
            assert (moves.anchor >= 0).sum() == roots.shape[0]
            n_tracks += roots.shape[0]
        assert n_tracks > 10

    def test_an_optimum_is_made_of_candidates_whatever_the_prices(self) -> None:
        source = rng()
        for problem in PROBLEMS:
            component, _ = component_of(problem)
            price = source.exponential(0.5, component.n_items)
            optimum = least_cost(problem) - problem.base_cost
            moves = list_moves(component, price, optimum + 1e-6)
            whole = Components.of(in_ones(problem), None, whole=True)
            best = Exact()(problem, rng=rng()).nodes
            selection = whole.selection_of(best)
            useful = selection[(selection >= 0) & (component.total[selection] != 0.0)]
            assert set(useful.tolist()) <= set(moves.node.tolist())


class TestTypicalExcess:
    def test_is_the_median_of_a_rank(self) -> None:
        component, price = component_of(random_window(np.random.default_rng(1), max_nodes=60))
        moves = list_moves(component, price, np.inf)
        values = []
        for item in range(component.n_items):
            listed = moves.listed[moves.list_start[item] : moves.list_start[item + 1]]
            if listed.shape[0] > 1:
                values.append(moves.excess[listed[min(4, listed.shape[0]) - 1]])
        assert typical_excess(moves, 4) == sorted(values)[len(values) // 2] > 0.0

    def test_is_above_zero_even_where_all_cost_the_same(self) -> None:
        problem = AssignmentProblem.from_tuples([[1, 1], [1, 2], [2, 1]], [-1.0, -1.0, -1.0])
        component, _ = component_of(problem)
        moves = list_moves(component, np.zeros(component.n_items), np.inf)
        assert typical_excess(moves, 10) == 1.0


class TestHolding:
    def test_goes_to_a_selection_and_back(self) -> None:
        for problem in PROBLEMS:
            component, price = component_of(problem)
            moves = list_moves(component, price, np.inf)
            nothing = np.full(component.must.shape[0], -1)
            holder = begin_holding(moves, component, nothing)
            require_sound(moves, holder)
            source = rng()
            for _ in range(10 if moves.node.size else 0):
                try_move(moves, holder, source, 2)
            selection = nothing.copy()
            selection_of(moves, component, holder, selection)
            assert selection_cost(component, selection) == pytest.approx(cost_of(moves, holder))
            assert begin_holding(moves, component, selection).tolist() == holder.tolist()


class TestMove:
    @pytest.mark.parametrize("links", [1, 2, 5])
    def test_keeps_the_rules_and_tells_its_cost(self, links: int) -> None:
        n_chains = 0
        for seed, problem in enumerate(PROBLEMS):
            component, price = component_of(problem)
            moves = list_moves(component, price, np.inf)
            if not moves.node.size:
                continue
            source = np.random.default_rng(seed)
            holder = begin_holding(moves, component, np.full(component.must.shape[0], -1))
            for _ in range(40):
                before, old = cost_of(moves, holder), holder.copy()
                change, log, forced = try_move(moves, holder, source, links)
                require_sound(moves, holder)
                assert cost_of(moves, holder) - before == pytest.approx(change, abs=1e-9)
                held = set(old.tolist()) - {-1}
                for entry in log.tolist():
                    candidate = entry if entry >= 0 else -1 - entry
                    assert (candidate in held) == (entry < 0)
                    held ^= {candidate}
                assert held == set(holder.tolist()) - {-1}
                assert forced in log
                n_chains += (log >= 0).sum() > 2
                if source.random() < 0.5:
                    undo(moves.start, moves.item, holder, log, log.shape[0])
                    assert holder.tolist() == old.tolist()
        assert n_chains > 0

    def test_ends_at_the_first_link_that_is_good_enough(self) -> None:
        problem = AssignmentProblem.from_tuples(
            [[1, 1], [1, 2], [2, 1], [2, 2]], [-3.0, -2.0, -2.0, -0.5]
        )
        component, _ = component_of(problem)
        moves = list_moves(component, np.zeros(component.n_items), np.inf)
        number = {tuple(sorted(own_items(moves, c))): c for c in range(4)}
        for threshold, wanted in ((10.0, -2.0), (-0.25, -4.0)):
            holder = np.full(component.n_items, -1)
            for item in (0, 2):
                holder[item] = number[0, 2]
            idle, log = np.empty(4, dtype=np.int64), log_room(4, 3)
            change, entries = move(
                moves.cost, moves.excess, moves.start, moves.item, moves.list_start,
                moves.listed, moves.anchor, number[0, 3], 0, threshold, 3, 100.0, rng(), holder,
                idle, log,
            )  # fmt: skip
            assert cost_of(moves, holder) == wanted
            assert change == wanted + 3.0
            assert log[:2].tolist() == [-1 - number[0, 2], number[0, 3]]
            assert entries == (2 if threshold > 0 else 3)


class TestDraws:
    def test_a_near_candidate_is_drawn_by_a_window_of_random_width(self) -> None:
        excess, listed = np.array([0.0, 0.5, 9.0, 1.0, 3.0]), np.array([0, 1, 3, 4])
        source, n = rng(), 40_000
        drawn = [draw_near(excess, listed, 0, 4, 2.0, source) for _ in range(n)]
        within = np.exp(-np.array([0.0, 0.5, 1.0, 3.0]) / 2.0)
        width = within - np.append(within[1:], 0.0)
        chance = [(width[i:] / np.arange(i + 1, 5)).sum() for i in range(4)]
        counts = [drawn.count(candidate) for candidate in (0, 1, 3, 4)]
        assert chisquare(counts, n * np.array(chance)).pvalue > 1e-3

    def test_none_is_near_where_all_are_far(self) -> None:
        source = rng()
        assert draw_near(np.array([5.0]), np.array([0]), 0, 1, 1e-3, source) == -1
        assert draw_near(np.array([0.0]), np.array([0]), 0, 0, 1.0, source) == -1

    def test_items_that_lack_something_are_preferred(self) -> None:
        worth, excess = np.array([2.0, 0.0, 0.0, 5.0]), np.array([0.0, 3.0])
        holder, source = np.array([-1, -1, 1, 0]), rng()
        drawn = [draw_item(worth, excess, 1.0, holder, source) for _ in range(2_000)]
        assert set(drawn) == {0, 2}

    def test_any_item_is_drawn_where_none_lacks_anything(self) -> None:
        worth, excess, source = np.zeros(5), np.zeros(1), rng()
        holder, n = np.array([-1, 0, 0, -1, -1]), 5_000
        drawn = [draw_item(worth, excess, 1.0, holder, source) for _ in range(n)]
        assert chisquare(np.bincount(drawn, minlength=5)).pvalue > 1e-3

    def test_the_first_that_is_free_repairs_below_the_limit(self) -> None:
        start, item = np.array([0, 2, 4, 6]), np.array([0, 1, 0, 2, 0, 3])
        listed = np.arange(3)
        holder = np.array([-1, 7, -1, -1])
        assert first_free(start, item, listed, 0, 3, 3, holder) == 1
        assert first_free(start, item, listed, 2, 3, 3, holder) == 2
        assert first_free(start, item, listed, 0, 3, 1, holder) == -1
        holder[0] = 7
        assert first_free(start, item, listed, 0, 3, 3, holder) == -1
