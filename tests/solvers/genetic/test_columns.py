"""What an individual of permutations stands for, against a slow and obvious twin."""

import numpy as np
import pytest

from oracles.assignment import in_ones, random_problem, sequence
from trackweave.association.problem import AssignmentProblem
from trackweave.solvers.components import Components
from trackweave.solvers.genetic._columns import decode_columns
from trackweave.solvers.genetic._list_operators import shuffle_lists
from trackweave.solvers.genetic.list_genes import individual_of, make_table
from trackweave.solvers.lists import lists_of

PROBLEMS = [random_problem(np.random.default_rng([4, seed])) for seed in range(60)]


class Whole:
    """A problem as one component, with what decoding reads."""

    def __init__(self, problem: AssignmentProblem) -> None:
        self.problem = problem
        self.components = Components.of(in_ones(problem), None, whole=True)
        self.component = self.components.component(0)
        self.items = self.components.parts.item_of
        self.table = make_table(self.component, problem.instant[self.items])
        self.n_lists = self.table.list_start.shape[0] - 1
        self.longest = int(np.diff(self.table.list_start).max())

    def individuals(self, count: int, length: int) -> np.ndarray:
        population = np.empty((count, self.n_lists, length), dtype=np.int64)
        shuffle_lists(np.random.default_rng(1), 0, population)
        return population

    def decode(self, genes: np.ndarray) -> tuple[list[int], float]:
        room = np.empty((3, self.n_lists + 1), dtype=np.int64)
        cost = decode_columns(self.component, self.table, genes, room, self.components.taken)
        return self.components.nodes().tolist(), cost

    def columns(self, genes: np.ndarray) -> list[set[int]]:
        """Return the items of the problem in each column."""
        start = self.table.list_start
        return [
            {
                int(self.items[self.table.member[start[number] + value]])
                for number, value in enumerate(genes[:, place].tolist())
                if start[number] + value < start[number + 1]
            }
            for place in range(genes.shape[1])
        ]


def cheapest(problem: AssignmentProblem, column: set[int]) -> float:
    """Return the least cost of one sequence of a column's items beside its tracks alone."""
    root_of = {
        int(problem.item[node]): node
        for node in range(problem.n_nodes)
        if problem.parent[node] < 0 and problem.must_cover[problem.item[node]]
    }
    alone = {item: float(problem.total[root_of[item]]) for item in column & root_of.keys()}
    options = [0.0]
    for node in range(problem.n_nodes):
        items = sequence(problem, node)
        if set(items) <= column:
            options.append(float(problem.total[node]) - alone.get(items[0], 0.0))
    return sum(alone.values()) + min(options)


@pytest.mark.parametrize("spare", [0, 2])
def test_each_column_takes_its_cheapest_sequence(spare: int) -> None:
    n_taken = 0
    for problem in PROBLEMS:
        if not problem.n_nodes:
            continue
        whole = Whole(problem)
        for genes in whole.individuals(5, whole.longest + spare):
            nodes, cost = whole.decode(genes)
            columns = whole.columns(genes)
            assert sorted(item for column in columns for item in column) == sorted(whole.items)
            assert cost == pytest.approx(sum(cheapest(problem, column) for column in columns))
            assert cost == pytest.approx(problem.total[nodes].sum(), abs=1e-9)
            items = [item for node in nodes for item in sequence(problem, node)]
            assert len(items) == len(set(items))
            assert set(np.flatnonzero(problem.must_cover)) <= set(items)
            n_taken += len(nodes)
    assert n_taken > 100


def test_where_all_tuples_exist_a_column_is_a_tuple() -> None:
    costs = np.random.default_rng(2).uniform(1.0, 9.0, (4, 4, 4))
    problem = AssignmentProblem.from_array(costs)
    whole = Whole(problem)
    for genes in whole.individuals(20, 4):
        nodes, cost = whole.decode(genes)
        wanted = sum(costs[i, j, k] for i, j, k in genes.T)
        assert len(nodes) == 4
        assert cost + problem.base_cost == pytest.approx(wanted)


def test_an_individual_made_from_a_selection_costs_no_more() -> None:
    for problem in PROBLEMS:
        if not problem.n_nodes:
            continue
        whole = Whole(problem)
        for genes in whole.individuals(3, whole.longest):
            _, cost = whole.decode(genes)
            selection = whole.components.taken.copy()
            again = individual_of(whole.component, whole.table, selection, whole.longest + 3)
            assert (np.sort(again, axis=1) == np.arange(whole.longest + 3)).all()
            assert (again[0] == np.arange(whole.longest + 3)).all()
            assert whole.decode(again)[1] <= cost + 1e-9


def everything_of(whole: Whole) -> np.ndarray:
    """Return the selection in which every family takes one of its nodes."""
    everything = np.full(whole.component.must.shape[0], -1)
    ends = np.flatnonzero(np.isfinite(whole.component.total))
    everything[whole.component.family[ends]] = ends
    return everything


@pytest.mark.parametrize(("length", "cost"), [(3, -8.0), (4, -10.0), (6, -10.0)])
def test_more_sequences_than_columns_lose_the_worst(length: int, cost: float) -> None:
    rows = [[1, 1, 0], [2, 0, 1], [0, 2, 2], [3, 3, 0]]
    whole = Whole(AssignmentProblem.from_tuples(rows, [-4.0, -3.0, -2.0, -1.0]))
    genes = individual_of(whole.component, whole.table, everything_of(whole), length)
    assert (np.sort(genes, axis=1) == np.arange(length)).all()
    # Item 3 of list 1 has its own column, where the sequence without such an item cannot be.
    assert whole.decode(genes)[1] == cost


def test_of_sequences_that_overlap_the_better_is_in_the_individual() -> None:
    whole = Whole(AssignmentProblem.from_tuples([[1, 1], [2, 1]], [-4.0, -3.0]))
    genes = individual_of(whole.component, whole.table, everything_of(whole), 2)
    assert whole.decode(genes)[1] == -4.0


def test_lists_are_those_of_the_component() -> None:
    whole = Whole(PROBLEMS[0])
    lists = lists_of(whole.component, PROBLEMS[0].instant[whole.items])
    assert lists.member.tolist() == whole.table.member.tolist()
    assert lists.start.tolist() == whole.table.list_start.tolist()
