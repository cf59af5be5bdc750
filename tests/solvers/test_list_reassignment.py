"""A list assigned anew is assigned best, and nothing else is touched."""

import numpy as np
import pytest
from scipy.optimize import linear_sum_assignment

from oracles.assignment import hard_tuples, in_ones, least_cost, random_problem
from trackweave.association.problem import AssignmentProblem
from trackweave.solvers._kernels import Component, improve, repair, selection_cost
from trackweave.solvers._list_reassignment import assign_rows, local_search, relist
from trackweave.solvers.components import Components
from trackweave.solvers.lists import Lists, lists_of
from trackweave.solvers.metaheuristic import owner_of, polish

pytestmark = pytest.mark.slow

PROBLEMS = [random_problem(np.random.default_rng([12, seed])) for seed in range(120)]


class Case:
    """A problem as one component, its lists, and a selection that random values made."""

    def __init__(self, problem: AssignmentProblem, seed: int) -> None:
        rng = np.random.default_rng(seed)
        whole = Components.of(in_ones(problem), None, whole=True)
        self.component: Component = whole.component(0)
        self.lists: Lists = lists_of(self.component, problem.instant[whole.parts.item_of])
        value = rng.normal(-0.5, 1.0, self.component.total.shape[0])
        value[np.isinf(self.component.total)] = np.inf
        n_families = self.component.must.shape[0]
        nothing, self.selection = np.full((2, n_families), -1, dtype=np.int64)
        ends = np.flatnonzero(np.isfinite(self.component.total))
        nothing[self.component.family[ends]] = ends
        self.owner = np.empty(self.component.n_items, dtype=np.int64)
        order = rng.permutation(n_families)
        repair(self.component, order, nothing, value, self.selection, self.owner)

    def items(self, node: int) -> frozenset[int]:
        items = []
        while node >= 0:
            items.append(int(self.component.item[node]))
            node = int(self.component.parent[node])
        return frozenset(items)

    def cost(self) -> float:
        return float(selection_cost(self.component, self.selection))

    def require_sound(self) -> None:
        taken = [self.items(node) for node in self.selection.tolist() if node >= 0]
        assert sum(map(len, taken)) == len(frozenset().union(*taken))
        assert (self.selection[self.component.must] >= 0).all()
        for family, node in enumerate(self.selection.tolist()):
            assert node < 0 or self.component.family[node] == family
        wanted = owner_of(self.component, self.selection)
        assert self.owner.tolist() == wanted.tolist()


def least_with_list(case: Case, number: int) -> float:
    """Return the least cost with the list's items anywhere, trying every place for each."""
    component, of = case.component, case.lists.of
    cost: dict[frozenset[int], float] = {}
    for node in range(component.total.shape[0]):
        items = case.items(node)
        cost[items] = min(cost.get(items, np.inf), float(component.total[node]))
    roots = component.members[component.start[:-1]][component.must]
    must = frozenset(component.item[roots].tolist())
    listed = [item for item in range(component.n_items) if of[item] == number]
    rests = [case.items(node) - set(listed) for node in case.selection.tolist() if node >= 0]
    rests = [rest for rest in rests if rest]
    taken = frozenset().union(*rests)
    rests += [frozenset([i]) for i in range(component.n_items) if i not in {*taken, *listed}]

    def worth(items: frozenset[int]) -> float:
        return min(cost.get(items, np.inf), np.inf if items & must else 0.0)

    def place(index: int, free: tuple[frozenset[int], ...]) -> float:
        if index == len(listed):
            return sum(map(worth, free))
        own = frozenset([listed[index]])
        best = worth(own) + place(index + 1, free)
        for rest in free:
            joint = cost.get(rest | own, np.inf)
            if np.isfinite(joint):
                others = tuple(other for other in free if other != rest)
                best = min(best, joint + place(index + 1, others))
        return best

    return place(0, tuple(rests))


class TestAssignRows:
    @pytest.mark.parametrize("shape", [(1, 1), (1, 4), (3, 3), (4, 7), (30, 50)])
    @pytest.mark.parametrize("kind", ["normal", "ties", "dear"])
    def test_costs_as_little_as_another_implementation(self, shape, kind: str) -> None:
        for seed in range(10):
            rng = np.random.default_rng(seed)
            cost = rng.normal(size=shape)
            if kind == "ties":
                cost = rng.integers(0, 3, shape).astype(float)
            elif kind == "dear":
                cost[rng.random(shape) < 0.4] = 1e6
            columns = assign_rows(cost)
            assert len(set(columns.tolist())) == shape[0]
            rows, best = linear_sum_assignment(cost)
            found = cost[np.arange(shape[0]), columns].sum()
            assert found == pytest.approx(cost[rows, best].sum(), rel=1e-12)

    def test_has_nothing_to_do_without_rows(self) -> None:
        assert assign_rows(np.empty((0, 3))).tolist() == []


class TestRelist:
    def test_is_best_for_its_list_and_keeps_the_rules(self) -> None:
        n_better = 0
        for seed, problem in enumerate(PROBLEMS):
            for number in range(Case(problem, seed).lists.start.shape[0] - 1):
                case = Case(problem, seed)
                before, old = case.cost(), case.selection.copy()
                wanted = least_with_list(case, number)
                better = relist(case.component, case.lists, number, case.selection, case.owner)
                assert case.cost() == pytest.approx(wanted, abs=1e-9)
                assert better == (wanted < before - 1e-9)
                assert better or case.selection.tolist() == old.tolist()
                case.require_sound()
                n_better += better
        assert n_better > 50

    def test_gives_tracks_that_must_be_covered_other_tails(self) -> None:
        # Tracks 0 and 1, reports 2 and 3, each pair joined at some cost.
        problem = AssignmentProblem(
            parent=[-1, -1, 0, 0, 1, 1],
            item=[0, 1, 2, 3, 2, 3],
            cost=np.zeros(6),
            total=[5.0, 5.0, 2.0, 0.0, -3.0, 1.0],
            must_cover=[True, True, False, False],
            instant=[-1, -1, 0, 0],
        )
        case = Case(problem, 0)
        case.selection[:] = [2, 5]
        case.owner[:] = [0, 1, 0, 1]
        assert relist(case.component, case.lists, 0, case.selection, case.owner)
        assert case.selection.tolist() == [3, 4]
        case.require_sound()


class TestLocalSearch:
    def test_ends_where_no_list_can_be_assigned_better(self) -> None:
        for seed, problem in enumerate(PROBLEMS):
            case = Case(problem, seed)
            before = case.cost()
            cost = local_search(case.component, case.lists, case.selection, case.owner)
            case.require_sound()
            assert cost == pytest.approx(case.cost(), abs=1e-9)
            assert cost <= before + 1e-9
            assert cost >= least_cost(problem) - problem.base_cost - 1e-9
            for number in range(case.lists.start.shape[0] - 1):
                assert not relist(case.component, case.lists, number, case.selection, case.owner)

    def test_finds_what_eject_insert_and_repair_do_not(self) -> None:
        gains = []
        for seed in range(10):
            rng = np.random.default_rng(seed)
            rows = np.argwhere(np.ones((8, 8, 8))) + 1
            problem = AssignmentProblem.from_tuples(rows, rng.normal(-5.0, 1.0, 512))
            case = Case(problem, seed)
            alone = improve(case.component, case.selection, case.owner, 10)
            gains.append(alone - polish(case.component, case.lists, case.selection))
        assert min(gains) >= -1e-9
        assert max(gains) > 0.1

    def test_does_no_more_than_it_may(self) -> None:
        problem = hard_tuples(1, 300, 10)
        case, other = Case(problem, 1), Case(problem, 1)
        local_search(case.component, case.lists, case.selection, case.owner, 0, 0)
        improve(other.component, other.selection, other.owner, 10, 0, 0)
        assert case.selection.tolist() == other.selection.tolist()
