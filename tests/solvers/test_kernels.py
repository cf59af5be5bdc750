"""Repair and improvement keep the rules, and never make an answer dearer."""

import numpy as np
import pytest

from oracles.assignment import in_ones, least_cost, random_problem, sequence
from trackweave.association.problem import AssignmentProblem
from trackweave.solvers._kernels import improve, repair
from trackweave.solvers.components import Components

PROBLEMS = [random_problem(np.random.default_rng([6, seed])) for seed in range(80)]


def repaired(problem: AssignmentProblem, rng: np.random.Generator):
    """Return a component of the whole, a repaired random selection, its owners and cost."""
    components = Components.of(in_ones(problem), None, whole=True)
    component = components.component(0)
    n_families = component.must.shape[0]
    value = rng.normal(size=component.total.shape[0])
    value[np.isinf(component.total)] = np.inf
    ends = np.flatnonzero(np.isfinite(component.total))
    preferred = np.full(n_families, -1)
    preferred[component.family[ends]] = ends
    owner = np.empty(component.n_items, dtype=np.int64)
    cost = repair(
        component, rng.permutation(n_families), preferred, value, components.taken, owner
    )
    return components, component, owner, cost


def require_sound(components: Components, owner: np.ndarray, cost: float) -> None:
    problem = components.problem
    items = [item for node in components.nodes().tolist() for item in sequence(problem, node)]
    assert len(items) == len(set(items))
    assert set(np.flatnonzero(problem.must_cover).tolist()) <= set(items)
    assert cost == pytest.approx(problem.total[components.nodes()].sum(), abs=1e-9)
    assert set(components.parts.item_of[owner >= 0].tolist()) == set(items)


def test_repair_keeps_the_rules() -> None:
    rng = np.random.default_rng(0)
    for problem in PROBLEMS:
        components, _, owner, cost = repaired(problem, rng)
        require_sound(components, owner, cost)


def test_improvement_keeps_the_rules_and_costs_no_more() -> None:
    rng = np.random.default_rng(1)
    gained = 0
    for problem in PROBLEMS:
        components, component, owner, before = repaired(problem, rng)
        after = improve(component, components.taken, owner, 10)
        require_sound(components, owner, after)
        assert after <= before + 1e-12
        assert after >= least_cost(problem) - problem.base_cost - 1e-9
        gained += after < before - 1e-9
    assert gained > len(PROBLEMS) // 4


@pytest.mark.slow
@pytest.mark.parametrize("first", [0, 1])
def test_improvement_ends_when_its_work_is_used_up_and_keeps_the_rules(first) -> None:
    rng = np.random.default_rng(3)
    unfinished = 0
    for problem in PROBLEMS:
        components, component, owner, before = repaired(problem, rng)
        start, taken = owner.copy(), components.taken.copy()
        families = taken.shape[0]
        begin = first % max(families, 1)
        short = improve(component, components.taken, owner, 10, begin, 3)
        require_sound(components, owner, short)
        assert short <= before + 1e-12
        components.taken[:] = taken
        whole = improve(component, components.taken, start, 10, begin)
        require_sound(components, start, whole)
        unfinished += whole < short - 1e-9
    assert unfinished > 0


def test_improvement_of_an_improved_answer_changes_nothing() -> None:
    rng = np.random.default_rng(2)
    for problem in PROBLEMS[:40]:
        components, component, owner, _ = repaired(problem, rng)
        improve(component, components.taken, owner, 100)
        before = components.taken.copy()
        improve(component, components.taken, owner, 100)
        assert components.taken.tolist() == before.tolist()


def test_improvement_ejects_who_stands_in_the_way() -> None:
    # Item 0's pair costs −3 and blocks two pairs that cost −2 each.
    problem = AssignmentProblem.from_tuples([[1, 1], [1, 2], [2, 1]], [-3.0, -2.0, -2.0])
    components = Components.of(in_ones(problem), None, whole=True)
    dear = np.flatnonzero(problem.total == -3.0)
    components.taken[:] = components.selection_of(dear)
    owner = np.full(components.parts.item_of.shape[0], -1)
    owner[components.component(0).item[dear[0]]] = 0
    owner[components.component(0).item[components.component(0).parent[dear[0]]]] = 0
    cost = improve(components.component(0), components.taken, owner, 5)
    assert cost == -4.0
