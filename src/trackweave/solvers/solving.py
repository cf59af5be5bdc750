"""Solving a problem in one call."""

from dataclasses import fields, is_dataclass, replace
from typing import Any

from trackweave.arrays import require_instance
from trackweave.association.problem import Answer, AssignmentProblem
from trackweave.errors import InvalidInputError
from trackweave.fields import checked_number
from trackweave.randomness import RandomSource, generator_of
from trackweave.solvers.auto import Auto
from trackweave.solvers.protocol import (
    Hint,
    Solver,
    Stop,
    answered,
    require_solver,
    require_stop,
    until,
)

__all__ = ["patient", "solve"]

BUDGETS = frozenset({"evaluations", "branches", "epochs"})
WITHOUT_END = 10**12
"""A budget that no time limit leaves anything of."""
BRANCHES = 250
"""Of a problem that somebody waits for: five times those of each step of a tracker."""


def solve(  # noqa: PLR0913 the one function that users call with everything
    problem: AssignmentProblem,
    solver: Solver | None = None,
    *,
    rng: RandomSource = 0,
    hint: Hint | None = None,
    stop: Stop | None = None,
    time_limit: float | None = None,
) -> Answer:
    """Choose disjoint sequences of least total cost.

    Parameters
    ----------
    problem
        What to choose from.
    solver
        How; None for ``Auto`` with 250 branches, or with no other budget than the time where that
        is limited.
    rng
        The only source of randomness: a generator, or a seed.
    hint
        What is known beforehand.
    stop
        Asked every few milliseconds whether to stop with the best answer so far.
    time_limit
        Wall clock after which to stop with the best answer so far [s], at least 0, beside the
        solver's own budgets; None for none. Answers then depend on the machine.

    Returns
    -------
    The answer with its certificate.

    Raises
    ------
    InvalidInputError
        If an argument is of another kind than it has to be.

    Examples
    --------
    >>> import numpy as np
    >>> import trackweave as tw
    >>> problem = tw.AssignmentProblem.from_tuples([[1, 1], [1, 2], [2, 2]], [-4.0, -6.0, -3.0])
    >>> answer = tw.solve(problem, rng=np.random.default_rng(1), time_limit=10.0)  # s
    >>> answer.cost, answer.gap, answer.status.value
    (-7.0, 0.0, 'optimal')
    >>> answer.tuples
    array([[1, 1],
           [2, 2]])
    """
    chosen = Auto(branches=BRANCHES) if solver is None else solver
    _require_arguments(problem, chosen, hint, stop)
    if time_limit is not None:
        expected = "a number ≥ 0 of seconds, or None"
        seconds = checked_number(time_limit, "time_limit", expected)
        if seconds < 0.0:
            raise InvalidInputError(f"time_limit: {seconds}; expected {expected}")
        stop = until(seconds, stop)
        chosen = patient(chosen) if solver is None else chosen
    return answered(chosen, problem, rng=generator_of(rng), hint=hint, stop=stop)


def patient(solver: Any) -> Any:
    """Return a solver with budgets without end, where a time limit counts; others as they are."""
    # What ends a search that finds nothing better stays.
    if not is_dataclass(solver) or isinstance(solver, type):
        return solver
    budgets = {field.name for field in fields(solver)} & BUDGETS
    return replace(solver, **dict.fromkeys(budgets, WITHOUT_END))


def _require_arguments(problem: object, solver: object, hint: object, stop: object) -> None:
    """Refuse arguments of a wrong kind, so that solvers need not."""
    require_instance(problem, AssignmentProblem, "problem")
    require_solver(solver, "solver")
    if hint is not None:
        require_instance(hint, Hint, "hint")
    require_stop(stop)
