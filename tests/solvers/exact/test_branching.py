"""Branch and bound where the dual has not already done the work."""

from collections.abc import Callable, Iterator
from itertools import combinations
from typing import Any

import numpy as np
import pytest

from oracles.assignment import (
    hard_tuples,
    in_ones,
    least_cost,
    random_problem,
    random_required,
    rounded,
    sequence,
)
from trackweave.association.problem import AssignmentProblem, Status
from trackweave.solvers import Dual
from trackweave.solvers._kernels import cheapest_first
from trackweave.solvers.components import Components
from trackweave.solvers.exact import exact
from trackweave.solvers.exact.exact import Branching, BranchingLimits, _Decision, branch
from trackweave.solvers.exact.linear import Fraction

MANY = 10_000


def answered(problem: AssignmentProblem, *, whole: bool = False) -> Components:
    """Return a problem taken apart with greedy answers and bounds."""
    components = Components.of(in_ones(problem), None, whole=whole)
    for index in range(len(components)):
        components.cost[index], components.lower[index] = cheapest_first(
            components.component(index), components.taken[components.families(index)]
        )
    return components


def searching(components: Components, index: int = 0) -> Branching:
    return Branching(
        components.component(index),
        components.taken[components.families(index)],
        (float(components.cost[index]), float(components.lower[index])),
        components.closing(index),
        None,
    )


def problems() -> list[AssignmentProblem]:
    found = [random_problem(np.random.default_rng([16, seed])) for seed in range(40)]
    found += [rounded(random_problem(np.random.default_rng([17, seed]))) for seed in range(20)]
    found += [hard_tuples(seed, 24, 4) for seed in range(20)]
    found += [rounded(hard_tuples(seed, 24, 4)) for seed in range(10)]
    return found + [random_required(np.random.default_rng([4, seed])) for seed in range(30)]


PROBLEMS = problems()


@pytest.fixture
def branches(monkeypatch) -> Iterator[list[int]]:
    """Count the branches that are looked into."""
    counted: list[int] = []
    whole = Branching._branch

    def counting(self: Branching, *args: Any) -> Any:
        counted.append(1)
        return whole(self, *args)

    monkeypatch.setattr(Branching, "_branch", counting)
    return counted


@pytest.mark.parametrize("cut_rounds", [0, 10])
@pytest.mark.parametrize("whole", [True, False])
def test_finds_and_proves_the_optimum(branches, cut_rounds: int, whole: bool) -> None:
    most = 0
    for problem in PROBLEMS:
        components = answered(problem, whole=whole)
        for index in range(len(components)):
            branches.clear()
            limits = BranchingLimits(MANY, cut_rounds=cut_rounds)
            assert branch(components, index, limits, None)[0] == "gap closed"
            most = max(most, len(branches))
        answer, optimum = components.answer(0, ""), least_cost(problem)
        assert answer.cost == pytest.approx(optimum, abs=1e-8 * max(1.0, abs(answer.cost)))
        assert answer.status is (Status.INFEASIBLE if np.isinf(optimum) else Status.OPTIMAL)
        items = [i for node in answer.nodes.tolist() for i in sequence(problem, node)]
        assert len(items) == len(set(items))
    # Without cuts some take several branches; with them hardly any of this size takes one.
    assert most > (3 if cut_rounds == 0 else -1)


def test_branches_many_times_and_meets_what_enumeration_finds(branches) -> None:
    for seed in range(4):
        problem = hard_tuples(seed, 110, 7)
        best = Dual(visits=20_000_000)(problem, rng=np.random.default_rng(0))
        assert best.status is Status.OPTIMAL
        components = answered(problem, whole=True)
        assert branch(components, 0, BranchingLimits(MANY), None)[0] == "gap closed"
        assert components.answer(0, "").cost == pytest.approx(best.cost, abs=1e-8)
    assert len(branches) > 10


def test_its_bound_rises_with_the_branches_and_never_above_the_optimum() -> None:
    problem = hard_tuples(2, 110, 8)
    best = answered(problem, whole=True)
    branch(best, 0, BranchingLimits(MANY), None)
    last = -np.inf
    for most in (0, 1, 4, 16):
        components = answered(problem, whole=True)
        reason, _ = branch(components, 0, BranchingLimits(most), None)
        assert last <= components.lower[0] <= best.cost[0] <= components.cost[0]
        assert reason == "branches"
        last = float(components.lower[0])


def test_every_answer_goes_with_one_side_of_a_branch() -> None:
    rng = np.random.default_rng(1)
    for problem in PROBLEMS[:80:4]:
        components = answered(problem, whole=True)
        if not len(components):
            continue
        search = searching(components)
        program = search._program
        n_columns = program.node.shape[0]
        own = [
            set(program.items[program.start[column] : program.start[column + 1]].tolist())
            for column in range(n_columns)
        ]
        pairs = list(combinations(range(components.component(0).n_items), 2))
        pairs += [(-1 - column, -1 - column) for column in range(n_columns)]
        for first, second in pairs[:: max(1, len(pairs) // 12)]:
            sides = [search._excluded(_Decision(first, second, side)) for side in (True, False)]
            for _ in range(15):
                answer, used = [], set()
                for column in rng.permutation(n_columns).tolist():
                    if not own[column] & used:
                        answer.append(column)
                        used |= own[column]
                answer = answer[: int(rng.integers(1, len(answer) + 1))] if answer else []
                keeps = [not side[answer].any() for side in sides]
                assert any(keeps)
                if any({first, second} <= own[column] for column in answer):
                    assert keeps == [True, False]


def test_a_known_optimum_is_kept() -> None:
    for problem in PROBLEMS[60:80]:
        best = answered(problem, whole=True)
        branch(best, 0, BranchingLimits(MANY), None)
        again = answered(problem, whole=True)
        again.taken[:], again.cost[:] = best.taken, best.cost
        assert branch(again, 0, BranchingLimits(MANY), None)[0] == "gap closed"
        assert again.taken.tolist() == best.taken.tolist()


def after(patience: int) -> Callable[[], bool]:
    calls = iter(range(patience))
    return lambda: next(calls, None) is None


@pytest.mark.parametrize("patience", [0, 5, 300, 2000])
def test_a_stop_leaves_an_answer_and_a_bound_that_hold(patience: int) -> None:
    problem = hard_tuples(2, 110, 8)
    best = answered(problem, whole=True)
    branch(best, 0, BranchingLimits(MANY), None)
    components = answered(problem, whole=True)
    before = components.copy()
    reason, _ = branch(components, 0, BranchingLimits(MANY), after(patience))
    assert reason == "stopped"
    assert before.lower[0] <= components.lower[0] <= best.cost[0] + 1e-9
    assert best.cost[0] - 1e-9 <= components.cost[0] <= before.cost[0]
    assert problem.total[components.nodes()].sum() == pytest.approx(components.cost[0])


def test_a_program_solved_badly_proves_nothing_false(monkeypatch) -> None:
    # As if its prices were off by some thousandths: no such error may end up in a claim.
    rng = np.random.default_rng(4)
    whole = exact.LinearProgram._certified

    def careless(self: Any, dual: np.ndarray, *args: Any) -> Fraction:
        return whole(self, dual * rng.uniform(0.99, 1.01, dual.shape[0]), *args)

    monkeypatch.setattr(exact.LinearProgram, "_certified", careless)
    reasons = set()
    for problem in PROBLEMS[60:80]:
        components, optimum = answered(problem, whole=True), least_cost(problem)
        reason, _ = branch(components, 0, BranchingLimits(500), None)
        reasons.add(reason)
        assert components.lower[0] + problem.base_cost <= optimum + 1e-8
        if reason == "gap closed":
            assert components.answer(0, "").cost == pytest.approx(optimum, abs=1e-8)
        else:
            assert components.answer(0, reason).status is Status.FEASIBLE
    assert "rounding" in reasons
