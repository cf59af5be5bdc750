"""Levels of ever smaller problems, none of which loses an answer."""

import numpy as np
import pytest

from oracles.assignment import hard_tuples, least_cost, random_problem, random_required
from trackweave.association.problem import AssignmentProblem, Status
from trackweave.errors import InvalidInputError
from trackweave.solvers import Dual, Hint
from trackweave.solvers._dual import bound_components
from trackweave.solvers.relaxation import Relaxation


def relaxed(problem: AssignmentProblem, levels: int, hint: Hint | None = None) -> Relaxation:
    """Return a problem bounded by a few steps on each level, and not enumerated."""
    dual = Dual(iterations=4, visits=0)
    relaxation = Relaxation.of(problem, hint)
    dual.bound(relaxation.rest, None)
    for _ in range(levels):
        relaxation = relaxation.reduced()
        dual.bound(relaxation.rest, None)
    return relaxation


def problems() -> list[AssignmentProblem]:
    found = [random_problem(np.random.default_rng([13, seed])) for seed in range(60)]
    found += [hard_tuples(seed, 24, 4) for seed in range(12)]
    return found + [random_required(np.random.default_rng([4, seed])) for seed in range(30)]


PROBLEMS = problems()


def test_what_is_left_keeps_the_known_answers() -> None:
    n_left = 0
    for problem in PROBLEMS:
        relaxation = relaxed(problem, 0)
        before = relaxation.answer(0, "")
        after = relaxation.reduced().answer(0, "")
        assert after.nodes.tolist() == before.nodes.tolist()
        assert after.lower_bound >= before.lower_bound - 1e-9
        n_left += before.status is not after.status or before.status is Status.FEASIBLE
    assert n_left > 10


def test_what_is_left_holds_the_optimum_on_every_level() -> None:
    depths: list[int] = []
    for problem in PROBLEMS:
        optimum = least_cost(problem)
        relaxation = relaxed(problem, 3)
        depths.append(len(relaxation.levels))
        Dual(visits=1_000_000).bound(relaxation.rest, None)
        answer = relaxation.answer(0, "")
        assert answer.cost == pytest.approx(optimum, abs=1e-8 * max(1.0, abs(answer.cost)))
        assert answer.status is (Status.INFEASIBLE if np.isinf(optimum) else Status.OPTIMAL)
        assert answer.stop_reason == "gap closed"
    assert (min(depths), max(depths)) == (1, 4)


def test_no_level_makes_the_answer_dearer_or_the_bound_wrong() -> None:
    for problem in PROBLEMS:
        optimum, cost = least_cost(problem), np.inf
        for levels in range(3):
            answer = relaxed(problem, levels).answer(0, "")
            assert answer.cost <= cost
            assert answer.lower_bound <= optimum + 1e-8 * max(1.0, abs(answer.cost))
            cost = min(cost, answer.cost + 1e-9)


def test_the_whole_is_its_own_copy() -> None:
    relaxation = relaxed(PROBLEMS[0], 0)
    whole = relaxation.whole()
    whole.taken[:], whole.cost[:] = -1, np.inf
    assert np.isfinite(relaxation.rest.cost).all()


def test_what_whole_costs_prove_of_a_part_is_proven_of_the_whole() -> None:
    # Five pairs in a ring: prices prove −2.5, so that −2 is best; the dear pair drops out.
    ring = [[1, 1, 0, 0, 0], [0, 1, 1, 0, 0], [0, 0, 1, 1, 0], [0, 0, 0, 1, 1], [1, 0, 0, 0, 1]]
    costs = [-1.0, -1.0, -1.0, -1.0, -1.0, 10.5]
    problem = AssignmentProblem.from_tuples([*ring, [1, 0, 1, 0, 0]], costs)
    answer = Dual(visits=0)(problem, rng=np.random.default_rng(0))
    assert (answer.cost, answer.lower_bound, answer.status) == (-2.0, -2.0, Status.OPTIMAL)


def test_a_better_answer_survives_every_level() -> None:
    n_better = 0
    for problem in PROBLEMS:
        optimum = least_cost(problem)
        relaxation = relaxed(problem, 2)
        known = relaxation.answer(0, "")
        if not optimum < known.cost - 1e-6:
            continue
        n_better += 1
        best = Dual(visits=1_000_000)(problem, rng=np.random.default_rng(0))
        rest = relaxation.rest.copy()
        rest.taken[:] = relaxation.left_of(Hint(nodes=best.nodes))
        bound_components(rest.parts, rest.price, rest.taken, rest.cost, rest.lower)
        answer = relaxation.with_rest(rest).answer(0, "")
        assert answer.cost == pytest.approx(optimum, abs=1e-8)
    assert n_better > 3


def test_without_levels_a_hints_answer_comes_back() -> None:
    for problem in PROBLEMS[:40]:
        known = Dual()(problem, rng=np.random.default_rng(0))
        relaxation = Relaxation.of(problem, None)
        relaxation.rest.taken[:] = relaxation.left_of(Hint(nodes=known.nodes))
        assert relaxation.rest.nodes().tolist() == known.nodes.tolist()


def test_no_hint_or_one_without_an_answer_is_no_selection() -> None:
    relaxation = relaxed(PROBLEMS[0], 1)
    assert relaxation.left_of(None) is None
    assert relaxation.left_of(Hint(prices=np.zeros(PROBLEMS[0].n_items))) is None


@pytest.mark.parametrize("nodes", [[-1], [10**9], [0.5], [[0]]])
def test_refuses_nodes_that_are_none(nodes: list[float]) -> None:
    with pytest.raises(InvalidInputError, match=r"hint\.nodes"):
        Relaxation.of(PROBLEMS[0], Hint(nodes=np.array(nodes)))


def test_levels_get_smaller() -> None:
    sizes = np.zeros(3)
    for problem in PROBLEMS:
        levels = [level.problem.n_nodes for level in relaxed(problem, 2).levels]
        assert levels == sorted(levels, reverse=True)
        # Where nearly everything is left there is no further level.
        sizes += levels + levels[-1:] * (3 - len(levels))
    assert sizes[1] < 0.6 * sizes[0]
    assert sizes[2] < sizes[1]
