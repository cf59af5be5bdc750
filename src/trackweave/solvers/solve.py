"""Solving a problem in one call."""

from trackweave.arrays import require_instance
from trackweave.association.problem import Answer, AssignmentProblem
from trackweave.errors import InvalidInputError
from trackweave.randomness import RandomSource, generator_of
from trackweave.solvers.auto import Auto
from trackweave.solvers.protocol import Hint, Solver, Stop, require_solver

__all__ = ["solve"]


def solve(
    problem: AssignmentProblem,
    solver: Solver | None = None,
    *,
    rng: RandomSource = 0,
    hint: Hint | None = None,
    stop: Stop | None = None,
) -> Answer:
    """Choose disjoint sequences of least total cost.

    Parameters
    ----------
    problem
        What to choose from.
    solver
        How; None for ``Auto``.
    rng
        The only source of randomness: a generator, or a seed.
    hint
        What is known beforehand.
    stop
        Asked every few milliseconds whether to stop with the best answer so far.

    Returns
    -------
    The answer with its certificate.

    Raises
    ------
    InvalidInputError
        If an argument is of another kind than it has to be.
    """
    chosen = Auto() if solver is None else solver
    _require_arguments(problem, chosen, hint, stop)
    return chosen(problem, rng=generator_of(rng), hint=hint, stop=stop)


def _require_arguments(problem: object, solver: object, hint: object, stop: object) -> None:
    """Refuse arguments of a wrong kind, so that solvers need not."""
    require_instance(problem, AssignmentProblem, "problem")
    require_solver(solver, "solver")
    if hint is not None:
        require_instance(hint, Hint, "hint")
    if stop is not None and not callable(stop):
        raise InvalidInputError(f"stop: {stop!r:.80}; expected something to call, or None")
