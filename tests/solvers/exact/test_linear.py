"""The linear programs: their value, and bounds that hold whatever the prices."""

from itertools import combinations

import numpy as np
import pytest
from scipy.optimize import linprog

from oracles.assignment import hard_tuples, in_ones, least_cost, random_problem, random_required
from trackweave.solvers.components import Components
from trackweave.solvers.exact.linear import LinearProgram

PROBLEMS = [random_problem(np.random.default_rng([15, seed])) for seed in range(30)]
PROBLEMS += [hard_tuples(seed, 24, 4) for seed in range(10)]
PROBLEMS += [random_required(np.random.default_rng([4, seed])) for seed in range(12)]


def programs() -> list[tuple[LinearProgram, float]]:
    """Return the program of each problem, and the problem's optimum without its base cost."""
    found = []
    for problem in PROBLEMS:
        components, optimum = (
            Components.of(in_ones(problem), None, whole=True),
            least_cost(problem),
        )
        if len(components) and np.isfinite(optimum):
            program = LinearProgram(components.component(0), None)
            found.append((program, optimum - problem.base_cost))
    return found


def everything(program: LinearProgram) -> np.ndarray:
    return np.ones(program.node.shape[0], dtype=np.bool_)


def matrix(program: LinearProgram) -> np.ndarray:
    covers = np.zeros((program.component.n_items, program.node.shape[0]))
    columns = np.repeat(np.arange(program.node.shape[0]), np.diff(program.start))
    covers[program.items, columns] = 1.0
    return covers


def slack(value: float) -> float:
    return 1e-7 * max(1.0, abs(value))


def test_finds_the_least_fractional_answer_over_the_columns_allowed() -> None:
    rng = np.random.default_rng(1)
    n_infeasible = n_fractional = 0
    for program, _ in programs():
        component, covers = program.component, matrix(program)
        must = np.zeros(component.n_items, dtype=np.bool_)
        must[component.item[component.members[component.start[:-1]][component.must]]] = True
        for allowed in (everything(program), rng.random(program.node.shape[0]) < 0.7):
            bounds = [(0.0, float(upper)) for upper in allowed]
            free = covers[~must] if (~must).any() else None
            wanted = linprog(
                program.total,
                A_ub=free,
                b_ub=None if free is None else np.ones(free.shape[0]),
                A_eq=covers[must] if must.any() else None,
                b_eq=np.ones(must.sum()) if must.any() else None,
                bounds=bounds,
            )
            fraction = program.solve(allowed)
            assert fraction is not None
            if wanted.status == 2:
                n_infeasible += 1
                assert fraction.bound == np.inf
                continue
            value = (program.total[fraction.column] * fraction.value).sum()
            assert value == pytest.approx(wanted.fun, abs=slack(wanted.fun))
            assert fraction.bound == pytest.approx(wanted.fun, abs=slack(wanted.fun))
            assert allowed[fraction.column].all()
            n_fractional += bool((fraction.value < 0.99).any())
    assert n_infeasible > 1
    assert n_fractional > 5


def test_any_prices_of_items_and_cuts_prove_a_bound() -> None:
    rng = np.random.default_rng(2)
    for program, optimum in programs():
        triples = list(combinations(range(program.component.n_items), 3))
        for triple in triples[:: max(1, len(triples) // 5)]:
            program.cut(np.array(triple))
        n_rows = program.component.n_items + len(program._cut_columns)
        for scale in (0.01, 1.0, 10.0):
            dual = -scale * rng.exponential(1.0, n_rows) * rng.choice([0.0, 1.0, -1.0], n_rows)
            none = np.empty(0, dtype=np.int64)
            fraction = program._certified(dual, everything(program), none, np.empty(0))
            assert fraction.bound <= optimum + slack(optimum)


def test_cuts_raise_the_bound_but_never_above_the_optimum() -> None:
    raised = 0
    for program, optimum in programs():
        first = program.solve(everything(program))
        assert first is not None
        for triple in list(combinations(range(program.component.n_items), 3))[:120]:
            program.cut(np.array(triple))
        second = program.solve(everything(program))
        assert second is not None
        assert first.bound - slack(optimum) <= second.bound <= optimum + slack(optimum)
        raised += second.bound > first.bound + 1e-6
    assert raised > 3


def test_what_lies_too_high_above_its_family_is_in_no_better_answer() -> None:
    # Excess is by how much the bound rises when a column is forced in.
    for program, _ in programs()[:25]:
        fraction = program.solve(everything(program))
        assert fraction is not None
        for column in range(program.node.shape[0]):
            with_it = everything(program)
            for item in program.items[program.start[column] : program.start[column + 1]]:
                with_it[program.with_item(int(item))] = False
            with_it &= program.family != program.family[column]
            rest = program.solve(with_it)
            assert rest is not None
            value = rest.bound + program.total[column]
            assert value >= fraction.bound + fraction.excess[column] - slack(value)


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e9])
def test_is_as_right_in_any_unit(scale: float) -> None:
    problem = hard_tuples(3, 40, 5)
    components = Components.of(in_ones(problem), None, whole=True)
    component = components.component(0)
    one = LinearProgram(component, None)
    other = LinearProgram(component._replace(total=component.total * scale), None)
    plain, scaled = one.solve(everything(one)), other.solve(everything(other))
    assert plain is not None
    assert scaled is not None
    assert scaled.bound == pytest.approx(plain.bound * scale, rel=1e-9)


def test_a_stop_leaves_no_answer() -> None:
    component = Components.of(in_ones(hard_tuples(3, 400, 12)), None, whole=True).component(0)
    program = LinearProgram(component, lambda: True)
    assert program.solve(everything(program)) is None


def test_columns_with_an_item_are_found() -> None:
    for program, _ in programs()[:10]:
        covers = matrix(program)
        for item in range(program.component.n_items):
            assert program.with_item(item).tolist() == np.flatnonzero(covers[item]).tolist()


def test_writes_nothing(capfd: pytest.CaptureFixture[str]) -> None:
    for program in (program for program, _ in programs()):
        program.solve(everything(program))
    assert capfd.readouterr() == ("", "")
