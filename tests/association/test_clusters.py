"""Components share no item, and lose nothing."""

import numpy as np
import pytest

from oracles.assignment import random_problem
from trackweave.association._clusters import has_repeats, partition
from trackweave.association.problem import AssignmentProblem


def apart(problem: AssignmentProblem, *, whole: bool = False):
    return partition(problem.parent, problem.item, problem.total, problem.must_cover, whole)


@pytest.fixture(params=range(25))
def problem(request: pytest.FixtureRequest) -> AssignmentProblem:
    return random_problem(np.random.default_rng(request.param))


def slow_components(problem: AssignmentProblem) -> set[frozenset[int]]:
    """Return the items of each component by merging sets."""
    groups = [{int(item)} for item in {*problem.item, *np.flatnonzero(problem.must_cover)}]
    for node in np.flatnonzero(problem.parent >= 0):
        pair = {int(problem.item[node]), int(problem.item[problem.parent[node]])}
        touched = [group for group in groups if group & pair]
        groups = [group for group in groups if not group & pair] + [set().union(*touched)]
    return {frozenset(group) for group in groups}


def test_components_are_those_of_shared_items(problem: AssignmentProblem) -> None:
    parts = apart(problem)
    bounds = zip(parts.item_start[:-1], parts.item_start[1:], strict=True)
    found = {frozenset(parts.item_of[first:last].tolist()) for first, last in bounds}
    assert found == slow_components(problem)


@pytest.mark.parametrize("whole", [False, True])
def test_nodes_keep_parent_item_and_total(problem: AssignmentProblem, whole: bool) -> None:
    parts = apart(problem, whole=whole)
    assert sorted(parts.node.tolist()) == list(range(problem.n_nodes))
    assert (parts.total == problem.total[parts.node]).all()
    for index in range(parts.node_start.shape[0] - 1):
        nodes = parts.node[parts.node_start[index] : parts.node_start[index + 1]]
        local = parts.parent[parts.node_start[index] : parts.node_start[index + 1]]
        items = parts.item_of[parts.item_start[index] : parts.item_start[index + 1]]
        own = parts.item[parts.node_start[index] : parts.node_start[index + 1]]
        assert (items[own] == problem.item[nodes]).all()
        above = np.where(local >= 0, nodes[local], -1)
        assert (above == problem.parent[nodes]).all()
        assert (local < np.arange(local.shape[0])).all()


def test_a_family_is_what_stands_below_one_root(problem: AssignmentProblem) -> None:
    parts = apart(problem)
    for index in range(parts.node_start.shape[0] - 1):
        first_node, first = parts.node_start[index], parts.family_start[index]
        for family in range(parts.family_start[index + 1] - first):
            start = parts.member_start[first + family + index]
            end = parts.member_start[first + family + index + 1]
            members = parts.members[first_node:][start:end]
            assert parts.parent[first_node + members[0]] == -1
            assert (parts.family[first_node + members] == family).all()
            root = parts.node[first_node + members[0]]
            assert parts.must[first + family] == problem.must_cover[problem.item[root]]
    assert parts.must.sum() == problem.must_cover.sum()


def test_the_whole_is_one_component(problem: AssignmentProblem) -> None:
    parts = apart(problem, whole=True)
    assert parts.node_start.tolist() == [0, problem.n_nodes]


def test_nothing_has_no_components() -> None:
    for whole in (False, True):
        parts = apart(AssignmentProblem([], [], [], [], [False], [0]), whole=whole)
        assert parts.node_start.tolist() == [0]


def test_a_repeated_item_is_found_however_far_above() -> None:
    parent, item = np.array([-1, 0, 1, 2]), np.array([3, 1, 2, 3])
    assert has_repeats(parent, item)
    assert not has_repeats(parent[:3], item[:3])
    assert not has_repeats(np.array([-1, 0, 0]), np.array([0, 1, 1]))
