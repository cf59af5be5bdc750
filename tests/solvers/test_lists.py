"""Items of one list share no sequence, and lists stand in the order of sequences."""

import numpy as np

from oracles.assignment import in_ones, random_problem, random_tuples, sequence
from trackweave.association.problem import AssignmentProblem
from trackweave.solvers.components import Components
from trackweave.solvers.lists import Lists, lists_of


def lists_of_whole(problem: AssignmentProblem) -> tuple[Lists, np.ndarray]:
    """Return the lists of a problem's used items, and the items' numbers in the problem."""
    components = Components.of(in_ones(problem), None, whole=True)
    items = components.parts.item_of
    return lists_of(components.component(0), problem.instant[items]), items


def test_no_two_items_of_a_list_share_a_sequence() -> None:
    n_simultaneous = 0
    for seed in range(80):
        problem = random_problem(np.random.default_rng([8, seed]))
        lists, items = lists_of_whole(problem)
        of = dict(zip(items.tolist(), lists.of.tolist(), strict=True))
        for node in range(problem.n_nodes):
            own = [of[item] for item in sequence(problem, node)]
            assert (np.diff(own) > 0).all()
            n_simultaneous += (np.diff(problem.instant[list(sequence(problem, node))]) == 0).sum()
    assert n_simultaneous > 20


def test_members_are_each_item_once_in_its_list() -> None:
    for seed in range(20):
        lists, items = lists_of_whole(random_problem(np.random.default_rng([9, seed])))
        assert sorted(lists.member.tolist()) == list(range(items.shape[0]))
        for number, (first, last) in enumerate(zip(lists.start, lists.start[1:], strict=False)):
            assert first < last
            assert (lists.of[lists.member[first:last]] == number).all()
            assert (np.diff(lists.member[first:last]) > 0).all()


def test_lists_of_tuples_are_those_that_they_were_made_of() -> None:
    for seed in range(20):
        problem = AssignmentProblem.from_tuples(*random_tuples(np.random.default_rng(seed), 14))
        if problem.n_nodes:
            lists, items = lists_of_whole(problem)
            _, wanted = np.unique(problem.instant[items], return_inverse=True)
            assert lists.of.tolist() == wanted.tolist()


def test_simultaneous_items_that_share_no_sequence_are_of_one_list() -> None:
    # Sensors A (items 0, 1) and B (2, 3) look at once; 0 and 2 may be one object's.
    problem = AssignmentProblem(
        [-1, -1, -1, -1, 0], [0, 1, 2, 3, 2], np.zeros(5), np.zeros(5), np.zeros(4), np.zeros(4)
    )
    assert lists_of_whole(problem)[0].of.tolist() == [0, 0, 1, 0]
