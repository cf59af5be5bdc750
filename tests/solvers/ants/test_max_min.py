"""Max–min ants: their options, choices, limits and restarts."""

from collections import Counter
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.stats import chisquare

from oracles.assignment import in_ones, random_problem, sequence
from trackweave.association.problem import AssignmentProblem
from trackweave.errors import InvalidInputError
from trackweave.solvers import Dual, Greedy, MaxMinAntSystem
from trackweave.solvers._kernels import Component
from trackweave.solvers.ants._trails import (
    Options,
    choose_options,
    deposit,
    improve_selection,
    list_options,
    send_ants,
    shuffle,
)
from trackweave.solvers.ants.trails import Trails, TrailSearch, make_trails, typical_excess
from trackweave.solvers.components import Components
from trackweave.solvers.resumable import Start

PROBLEMS = [random_problem(np.random.default_rng([5, seed])) for seed in range(40)]


def rng() -> np.random.Generator:
    return np.random.default_rng(9)


def component_of(problem: AssignmentProblem) -> tuple[Components, Component]:
    whole = Components.of(in_ones(problem), None, whole=True)
    return whole, whole.component(0)


def hard(seed: int = 0, n_rows: int = 400) -> AssignmentProblem:
    """Return a dense problem whose bound leaves a gap."""
    source = np.random.default_rng(seed)
    rows = source.integers(1, 13, (n_rows, 4))
    return AssignmentProblem.from_tuples(rows, source.normal(-5.0, 1.0, n_rows))


def of_family(options: Options, family: int) -> slice:
    return slice(int(options.start[family]), int(options.start[family + 1]))


class TestOptions:
    @pytest.mark.parametrize("limit", [1, 3, 100])
    def test_are_the_least_of_each_family_and_none(self, limit: int) -> None:
        source = rng()
        for problem in PROBLEMS:
            _, component = component_of(problem)
            reduced = component.total + source.normal(0.0, 1.0, component.total.shape[0])
            options = list_options(component, reduced, limit)
            for family in range(component.must.shape[0]):
                must = bool(component.must[family])
                nodes = [
                    node
                    for node in np.flatnonzero(component.family == family).tolist()
                    if component.total[node] < (np.inf if must else 0.0)
                ]
                kept = sorted(nodes, key=lambda node: reduced[node])[:limit]
                cost = {node: reduced[node] for node in kept} | ({} if must else {-1: 0.0})
                found = options.node[of_family(options, family)].tolist()
                assert sorted(found) == sorted(cost)
                excess = [cost[node] - min(cost.values()) for node in found]
                assert options.excess[of_family(options, family)] == pytest.approx(excess)
                assert excess == sorted(excess)

    def test_a_typical_excess_is_the_median_of_the_second(self) -> None:
        start, node = np.array([0, 3, 5, 6, 8]), np.arange(8)
        excess = np.array([0.0, 1.0, 9.0, 0.0, 2.0, 0.0, 0.0, 4.0])
        assert typical_excess(Options(start, node, excess)) == 2.0
        excess = np.array([0.0, 0.0, 9.0, 0.0, 0.0, 0.0, 0.0, 3.0])
        assert typical_excess(Options(start, node, excess)) == 6.0
        assert typical_excess(Options(start, node, np.zeros(8))) == 1.0

    def test_the_lower_limit_is_that_of_stuetzle_and_hoos(self) -> None:
        rows = [[a, b] for a in range(1, 5) for b in range(1, 8)]
        problem = AssignmentProblem.from_tuples(rows, -1.0 - np.arange(28.0))
        _, component = component_of(problem)
        trails = make_trails(component, np.zeros(component.n_items), 100, 1.0, 0.05)
        # Four choices of eight options each: seven tuples, or none.
        root = 0.05**0.25
        assert trails.least == pytest.approx((1 - root) / ((8 / 2 - 1) * root))

    def test_visibility_has_no_unit(self) -> None:
        problem = hard()
        plain = component_of(problem)[1]
        scaled = component_of(replace(problem, total=problem.total * 1024.0))[1]
        zero = np.zeros(plain.n_items)
        first, second = (make_trails(c, zero, 10, 0.5, 0.05) for c in (plain, scaled))
        assert first.visibility == pytest.approx(second.visibility)


class TestAnts:
    def test_choose_disjoint_sequences_and_cover_what_must_be(self) -> None:
        source = rng()
        for problem in PROBLEMS:
            whole, component = component_of(problem)
            options = list_options(component, component.total, 2)
            weight = source.exponential(1.0, options.node.shape[0])
            weight[source.random(weight.shape[0]) < 0.2] = 0.0
            for _ in range(5):
                cost = send_ants(component, options, weight, 1, source, whole.taken, np.inf)
                items = [item for node in whole.nodes() for item in sequence(problem, int(node))]
                assert len(items) == len(set(items))
                assert set(np.flatnonzero(problem.must_cover).tolist()) <= set(items)
                assert cost == pytest.approx(problem.total[whole.nodes()].sum(), abs=1e-9)

    def test_choose_by_weight_among_what_is_free(self) -> None:
        rows = [[1, 1], [1, 2], [1, 3], [2, 1], [2, 2]]
        _, component = component_of(AssignmentProblem.from_tuples(rows, -np.ones(5)))
        options = list_options(component, component.total, 10)
        weight = np.array([3.0, 1.0, 2.0, 0.5, 1.0, 4.0, 2.0])
        first = options.node[:4].tolist()
        assert options.start.tolist() == [0, 4, 7]
        seen: Counter[tuple[int, int]] = Counter()
        selection, owner = np.empty(2, dtype=np.int64), np.empty(component.n_items, dtype=np.int64)
        source, draws = rng(), 20_000
        for _ in range(draws):
            choose_options(component, options, weight, np.array([0, 1]), source, selection, owner)
            seen[int(selection[0]), int(selection[1])] += 1
        item = component.item
        wanted = {}
        for place, node in enumerate(first):
            free = [
                (other, weight[4 + index])
                for index, other in enumerate(options.node[4:].tolist())
                if node < 0 or other < 0 or item[other] != item[node]
            ]
            total = sum(share for _, share in free)
            for other, share in free:
                wanted[node, other] = weight[place] / weight[:4].sum() * share / total
        assert set(seen) <= set(wanted)
        result = chisquare([seen[key] for key in wanted], [draws * p for p in wanted.values()])
        assert result.pvalue > 0.001

    def test_every_order_of_families_is_as_likely(self) -> None:
        source = rng()
        seen: Counter[tuple[int, ...]] = Counter()
        for _ in range(6000):
            order = np.arange(3)
            shuffle(order, source)
            seen[tuple(order.tolist())] += 1
        assert len(seen) == 6
        assert chisquare(list(seen.values())).pvalue > 0.001

    def test_take_the_best_free_node_where_no_candidate_is_free(self) -> None:
        # Both families want item 1 of list 2; the second has a dearer way out, no candidate.
        problem = AssignmentProblem.from_tuples([[1, 1], [2, 1], [2, 2]], [-5.0, -5.0, -1.0])
        whole, component = component_of(problem)
        options = list_options(component, component.total, 1)
        weight = np.where(options.node >= 0, 1.0, 0.0)
        costs = {
            send_ants(component, options, weight, 1, source, whole.taken, np.inf)
            for source in rng().spawn(20)
        }
        assert costs == {-6.0, -5.0}


class TestTrails:
    def test_pheromone_tends_to_one_where_it_is_laid_and_to_the_limit_elsewhere(self) -> None:
        options = Options(np.array([0, 2, 4]), np.array([-1, 3, 5, 6]), np.zeros(4))
        pheromone = np.array([1.0, 0.5, 0.25, 0.11])
        deposit(options, np.array([3, -1]), 0.8, 0.1, pheromone)
        assert pheromone == pytest.approx([0.8, 0.8 * 0.5 + 0.2, 0.2, 0.1])
        for _ in range(200):
            deposit(options, np.array([3, 6]), 0.8, 0.1, pheromone)
        assert pheromone == pytest.approx([0.1, 1.0, 0.1, 1.0])

    def test_narrowed_families_hold_their_candidates_alone(self) -> None:
        for problem in PROBLEMS:
            _, component = component_of(problem)
            options = list_options(component, component.total, 2)
            narrow = Trails(options, options.excess, 0.1).narrowed(component)
            for family in range(component.must.shape[0]):
                own = options.node[of_family(options, family)]
                found = narrow.members[narrow.start[family] : narrow.start[family + 1]]
                assert found.tolist() == own[own >= 0].tolist()

    def test_improving_among_candidates_keeps_the_rules_and_costs_no_more(self) -> None:
        source, gained = rng(), 0
        for problem in PROBLEMS:
            whole, component = component_of(problem)
            options = list_options(component, component.total, 3)
            narrow = Trails(options, options.excess, 0.1).narrowed(component)
            weight = np.ones(options.node.shape[0])
            before = send_ants(component, options, weight, 1, source, whole.taken, np.inf)
            after = improve_selection(narrow, component, whole.taken, 0, 10**6)
            items = [item for node in whole.nodes() for item in sequence(problem, int(node))]
            assert len(items) == len(set(items))
            assert set(np.flatnonzero(problem.must_cover).tolist()) <= set(items)
            assert after <= before + 1e-12
            gained += after < before - 1e-9
        assert gained > 5

    def search(self, known: float) -> TrailSearch:
        options = Options(np.array([0, 2]), np.array([-1, 0]), np.zeros(2))
        start = Start([], np.array([-1]), known, rng())
        return TrailSearch.begin(Trails(options, np.ones(2), 0.1), start)

    def test_a_better_choice_becomes_the_best_and_lays_pheromone(self) -> None:
        search = replace(self.search(0.0), present=np.array([0]), present_cost=-1.0)
        later = search.renewed(0.5, 10)
        assert (later.best, later.lasting_cost, later.idle) == (-1.0, -1.0, 0)
        assert later.selection.tolist() == later.lasting.tolist() == [0]
        assert later.pheromone.tolist() == [0.5, 1.0]
        assert (search.best, search.pheromone.tolist()) == (0.0, [1.0, 1.0])

    def test_best_of_all_and_best_of_the_iteration_lay_in_turn(self) -> None:
        search = replace(self.search(-5.0), present=np.array([0]), present_cost=-1.0)
        even = search.renewed(0.5, 10)
        odd = replace(even, present=np.array([0]), present_cost=-1.0).renewed(0.5, 10)
        assert even.pheromone.tolist() == [1.0, 0.5]
        assert odd.pheromone.tolist() == [0.5, 0.75]
        assert (odd.best, odd.idle) == (-5.0, 2)

    def test_trails_are_laid_anew_when_nothing_improves(self) -> None:
        search = self.search(-5.0)
        for idle in (1, 2, 0):
            tried = replace(search, present=np.array([0]), present_cost=-1.0)
            search = tried.renewed(0.5, 3)
            assert search.idle == idle
        assert search.pheromone.tolist() == [1.0, 1.0]
        assert search.lasting_cost == np.inf
        assert (search.best, search.selection.tolist()) == (-5.0, [-1])
        after = replace(search, present=np.array([0]), present_cost=-1.0).renewed(0.5, 3)
        assert (after.lasting_cost, after.best) == (-1.0, -5.0)


class TestAnswers:
    def test_are_better_than_the_greedy_ones_without_prices(self) -> None:
        for seed in range(4):
            problem = hard(seed)
            greedy = Greedy()(problem, rng=rng()).cost
            colony = MaxMinAntSystem(evaluations=1000, seeded=False)
            assert colony(problem, rng=rng()).cost < greedy

    def test_are_no_worse_than_the_duals(self) -> None:
        for seed in range(4):
            problem = hard(seed)
            dual = Dual()(problem, rng=rng()).cost
            assert MaxMinAntSystem(evaluations=500)(problem, rng=rng()).cost <= dual + 1e-9

    def test_improvement_helps(self) -> None:
        plain = MaxMinAntSystem(evaluations=200, seeded=False, improvement=False)
        better = replace(plain, improvement=True)
        pairs = [
            (better(hard(s), rng=rng()).cost, plain(hard(s), rng=rng()).cost) for s in range(4)
        ]
        assert all(first <= second + 1e-9 for first, second in pairs)
        assert sum(first < second - 1e-9 for first, second in pairs) > 1

    def test_find_what_has_to_be_covered(self) -> None:
        source = np.random.default_rng(1)
        costs = source.integers(0, 100, (7, 7, 7)).astype(float)
        problem = AssignmentProblem.from_array(costs)
        answer = MaxMinAntSystem(seeded=False)(problem, rng=rng())
        best = Dual()(problem, rng=rng())
        assert best.status == "optimal"
        assert answer.cost == pytest.approx(best.cost)

    def test_say_that_the_budget_is_spent_after_whole_iterations(self) -> None:
        colony = MaxMinAntSystem(ants=20, evaluations=50, seeded=False, decompose=False)
        answer = colony(hard(), rng=rng())
        assert (answer.evaluations, answer.stop_reason) == (60, "evaluations")


@pytest.mark.parametrize(
    "wrong",
    [
        {"ants": 0}, {"pheromone_weight": -1.0}, {"temperature": 0.0}, {"temperature": np.nan},
        {"persistence": 1.0}, {"persistence": -0.1}, {"candidates": 0},
        {"best_probability": 0.0}, {"best_probability": 1.0}, {"patience": 0},
        {"evaluations": 0},
    ],
    ids=str,
)  # fmt: skip
def test_refuses_parameters_out_of_range(wrong: dict[str, Any]) -> None:
    name = next(iter(wrong))
    with pytest.raises(InvalidInputError, match=f"^{name}: "):
        MaxMinAntSystem(**wrong)
