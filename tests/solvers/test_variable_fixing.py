"""What narrowing leaves out is in no answer that is as good as the one known."""

import numpy as np
import pytest

from oracles.assignment import in_ones, least_cost, random_problem
from trackweave.association.problem import AssignmentProblem
from trackweave.solvers import Dual
from trackweave.solvers._reduction import Narrowed, narrowed, whole, write_taken
from trackweave.solvers.components import Components

Case = tuple[AssignmentProblem, Components, Narrowed]


def problem_of(left: Narrowed) -> AssignmentProblem:
    """Return what is left as a problem of its own."""
    component = left.component
    must = np.zeros(component.n_items, dtype=np.bool_)
    roots = component.members[component.start[:-1][component.must]]
    must[component.item[roots]] = True
    return AssignmentProblem(
        parent=component.parent,
        item=component.item,
        cost=component.total,
        total=component.total,
        must_cover=must,
        instant=np.zeros(component.n_items, dtype=np.int64),
    )


def bounded(seed: int) -> tuple[AssignmentProblem, Components]:
    problem = random_problem(np.random.default_rng([7, seed]))
    components = Components.of(in_ones(problem), None, whole=True)
    Dual(iterations=1 + seed % 6, visits=0).bound(components, None)
    return problem, components


@pytest.fixture(scope="module")
def cases() -> list[Case]:
    found = []
    for seed in range(200):
        problem, parts = bounded(seed)
        if len(parts) == 1 and np.isfinite(parts.cost[0]):
            left = whole(parts.component(0), parts.taken)
            found.append((problem, parts, narrowed(left, parts.price, float(parts.cost[0]))))
    return found


def test_much_is_left_out_and_much_is_not(cases: list[Case]) -> None:
    before = sum(problem.n_nodes for problem, _, _ in cases)
    after = sum(left.row.shape[0] for _, _, left in cases)
    assert len(cases) > 100
    assert 0.1 * before < after < 0.8 * before


def test_the_optimum_stays(cases: list[Case]) -> None:
    for problem, parts, left in cases:
        known = float(parts.cost[0])
        assert min(known, least_cost(problem_of(left))) == pytest.approx(
            min(known, least_cost(problem) - problem.base_cost), abs=1e-9
        )


def test_what_is_taken_stays_and_is_written_as_nodes_of_the_whole(cases: list[Case]) -> None:
    for _, parts, left in cases:
        selection = np.full(parts.taken.shape[0], -2)
        write_taken(left, selection)
        assert selection.tolist() == parts.taken.tolist()
        taken = left.taken[left.taken >= 0]
        assert np.all(np.isfinite(left.component.total[taken]))


def test_nodes_are_those_of_the_whole_and_come_by_family(cases: list[Case]) -> None:
    for _, parts, left in cases:
        old, new = parts.component(0), left.component
        assert new.item.tolist() == old.item[left.row].tolist()
        assert new.family.tolist() == old.family[left.row].tolist()
        is_child = new.parent >= 0
        assert (old.parent[left.row] >= 0).tolist() == is_child.tolist()
        above = left.row[new.parent[is_child]]
        assert above.tolist() == old.parent[left.row[is_child]].tolist()
        same = np.isfinite(new.total)
        assert new.total[same].tolist() == old.total[left.row[same]].tolist()
        sizes = np.bincount(new.family, minlength=new.must.shape[0])
        assert np.diff(new.start).tolist() == sizes.tolist()
        assert new.family[new.members].tolist() == np.repeat(np.arange(sizes.size), sizes).tolist()


def test_twice_is_as_good_as_once(cases: list[Case]) -> None:
    for problem, parts, left in cases:
        known = float(parts.cost[0])
        twice = narrowed(left, np.zeros_like(parts.price), known)
        assert twice.row.shape[0] <= left.row.shape[0]
        assert min(known, least_cost(problem_of(twice))) == pytest.approx(
            min(known, least_cost(problem) - problem.base_cost), abs=1e-9
        )


def test_without_a_known_answer_nothing_is_left_out() -> None:
    _, parts = bounded(0)
    left = narrowed(whole(parts.component(0), np.full_like(parts.taken, -1)), parts.price, np.inf)
    assert left.row.tolist() == list(range(parts.component(0).parent.shape[0]))
