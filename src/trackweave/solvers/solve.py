"""Solving a problem in one call."""

import numpy as np

from trackweave.association.problem import Answer, AssignmentProblem
from trackweave.solvers.genetic import Genetic
from trackweave.solvers.protocol import Hint, Solver, Stop

__all__ = ["solve"]


def solve(
    problem: AssignmentProblem,
    solver: Solver | None = None,
    *,
    rng: np.random.Generator,
    hint: Hint | None = None,
    stop: Stop | None = None,
) -> Answer:
    """Choose disjoint sequences of least total cost.

    Parameters
    ----------
    problem
        What to choose from.
    solver
        How; None for the genetic search with its defaults.
    rng
        The only source of randomness.
    hint
        What is known beforehand.
    stop
        Asked every few milliseconds whether to stop with the best answer so far.

    Returns
    -------
    The answer with its certificate.
    """
    chosen = Genetic() if solver is None else solver
    return chosen(problem, rng=rng, hint=hint, stop=stop)
