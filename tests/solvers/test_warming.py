"""Compiling beforehand."""

import numpy as np
import pytest
from numba.core.registry import CPUDispatcher

from oracles.assignment import hard_tuples
from trackweave.errors import InvalidInputError
from trackweave.solvers import (
    Annealing,
    Auto,
    Greedy,
    Islands,
    Solver,
    TabuSearch,
    _ascent,
    _list_reassignment,
)
from trackweave.solvers.warming import warm_up


@pytest.mark.slow
@pytest.mark.parametrize("solver", [Auto(), Annealing(), TabuSearch(), Islands(threads=2)])
def test_leaves_nothing_to_compile_for_a_harder_problem(solver: Solver) -> None:
    warm_up(solver, np.random.default_rng(0))
    kernels = [_ascent.smooth, _ascent.deflect, _list_reassignment.local_search]
    if not isinstance(kernels[0], CPUDispatcher):
        pytest.skip("kernels are not compiled here")
    before = [len(kernel.signatures) for kernel in kernels]
    assert min(before) > 0
    solver(hard_tuples(3, 400, 12), rng=np.random.default_rng(1))
    assert [len(kernel.signatures) for kernel in kernels] == before


def test_greed_needs_nothing() -> None:
    rng = np.random.default_rng(0)
    warm_up(Greedy(), rng)
    assert rng.random() == np.random.default_rng(0).random()


@pytest.mark.parametrize("wrong", [1.5, -1, "x", True])
def test_a_search_refuses_a_number_of_evaluations_that_is_none(wrong: object) -> None:
    search = Annealing()
    state = search.start(hard_tuples(0, 60, 8), rng=np.random.default_rng(0))
    with pytest.raises(InvalidInputError, match=r"evaluations: .*; expected a whole number"):
        search.advance(state, evaluations=wrong)


@pytest.mark.parametrize(
    ("name", "wrong"), [("hot", "x"), ("links", 1.5), ("seeded", 1), ("patience", None)]
)
def test_refuses_parameters_of_another_kind(name: str, wrong: object) -> None:
    with pytest.raises(InvalidInputError, match=rf"{name}: .*; expected"):
        Annealing(**{name: wrong})
