"""A reduced problem loses nothing."""

from dataclasses import replace

import numpy as np
import pytest

from oracles.assignment import in_ones, least_cost, random_problem, sequence
from trackweave.association.problem import AssignmentProblem
from trackweave.solvers import Dual, Hint
from trackweave.solvers.components import Components
from trackweave.solvers.relaxation import Reduction


def bounded(problem: AssignmentProblem, iterations: int) -> Components:
    """Return a problem's components after so few bounds that some stay open."""
    components = Components.of(in_ones(problem), None)
    Dual(iterations=iterations, visits=0).bound(components, None)
    return components


def hard_problems() -> list[tuple[AssignmentProblem, Components]]:
    found = []
    for seed in range(400):
        problem = random_problem(np.random.default_rng([2, seed]))
        components = bounded(problem, 1 + seed % 4)
        if components.open().size:
            found.append((problem, components))
    return found


@pytest.fixture(scope="module")
def hard() -> list[tuple[AssignmentProblem, Components]]:
    return hard_problems()


def solve_reduced(components: Components, reduction: Reduction) -> Components:
    rest = Components.of(reduction.problem, Hint(prices=reduction.prices))
    Dual(visits=1_000_000).bound(rest, None)
    whole = components.copy()
    reduction.absorb(whole, rest)
    return whole


def test_there_is_something_to_reduce(hard) -> None:
    sizes = [(problem.n_nodes, Reduction.of(parts).problem.n_nodes) for problem, parts in hard]
    assert len(hard) > 60
    assert sum(after for _, after in sizes) < 0.9 * sum(before for before, _ in sizes)


def test_the_best_of_what_is_left_and_known_is_the_optimum(hard) -> None:
    for problem, components in hard:
        whole = solve_reduced(components, Reduction.of(components))
        answer = whole.answer(0, "")
        assert answer.cost == pytest.approx(least_cost(problem), abs=1e-8)
        assert answer.status == "optimal"


def test_what_it_gives_back_is_feasible_and_costs_what_it_says(hard) -> None:
    for problem, components in hard:
        whole = solve_reduced(components, Reduction.of(components))
        nodes = whole.nodes()
        items = [item for node in nodes.tolist() for item in sequence(problem, node)]
        assert len(items) == len(set(items))
        assert set(np.flatnonzero(problem.must_cover).tolist()) <= set(items)
        assert whole.cost.sum() == pytest.approx(problem.total[nodes].sum(), abs=1e-9)


def test_what_is_known_is_left_or_forced(hard) -> None:
    n_forced = 0
    for _, components in hard:
        reduction = Reduction.of(components)
        parts, left = components.parts, set(reduction.node.tolist())
        n_forced += reduction.forced.shape[0]
        for index in components.open().tolist():
            taken = components.taken[components.families(index)]
            own = set((taken[taken >= 0] + parts.node_start[index]).tolist())
            assert own <= left | set(reduction.forced.tolist())
    assert n_forced > 5


def test_holds_for_any_prices(hard) -> None:
    rng = np.random.default_rng(3)
    for problem, components in hard[:60]:
        priced = replace(components, price=rng.exponential(1.0, components.price.shape[0]))
        whole = solve_reduced(priced, Reduction.of(priced))
        assert whole.cost.sum() + problem.base_cost == pytest.approx(least_cost(problem), abs=1e-8)


def test_what_is_left_is_a_part_of_the_whole(hard) -> None:
    for problem, components in hard:
        reduction = Reduction.of(components)
        nodes = components.parts.node[reduction.node]
        own = components.problem.item[nodes]
        assert reduction.problem.cost.tolist() == problem.cost[nodes].tolist()
        parent = reduction.problem.parent
        above = np.where(parent >= 0, nodes[parent], -1)
        assert above.tolist() == problem.parent[nodes].tolist()
        assert (
            reduction.problem.must_cover[reduction.problem.item] == problem.must_cover[own]
        ).all()


def test_absorbing_nothing_better_keeps_what_was_known(hard) -> None:
    for _, components in hard[:20]:
        reduction = Reduction.of(components)
        rest = Components.of(reduction.problem, None)  # nothing chosen: infinite costs
        whole = components.copy()
        reduction.absorb(whole, rest)
        assert whole.taken.tolist() == components.taken.tolist()
        assert whole.cost.tolist() == components.cost.tolist()


def test_nodes_of_the_whole_are_found_again(hard) -> None:
    problem, components = hard[0]
    reduction = Reduction.of(components)
    left = reduction.nodes_left(components, np.arange(problem.n_nodes))
    assert left.tolist() == list(range(reduction.problem.n_nodes))
    assert reduction.nodes_left(components, np.empty(0, dtype=np.int64)).tolist() == []
