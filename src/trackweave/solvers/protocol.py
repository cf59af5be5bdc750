"""What a solver is, and what it may be told beforehand."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from time import perf_counter
from typing import Any, Protocol, TypeAlias

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.association.problem import Answer, AssignmentProblem
from trackweave.errors import InvalidInputError
from trackweave.plugin_faults import is_ours, told_as_theirs
from trackweave.randomness import RandomSource, generator_of
from trackweave.summaries import summary

__all__ = [
    "Hint",
    "Solver",
    "Stop",
    "answered",
    "child_of",
    "refuse_parameters",
    "require_solver",
    "require_stop",
    "until",
]

Stop: TypeAlias = Callable[[], bool]
"""Tells, every few milliseconds, whether to stop with the best answer so far."""


@dataclass(frozen=True, slots=True, eq=False)
class Hint:
    """What is known of a problem before it is solved; it may help, and never harms.

    Parameters
    ----------
    prices
        What each item was worth in a similar problem [nats], shape (items,), at least 0; None
        when unknown.
    nodes
        An answer to a similar problem: last nodes of sequences, best disjoint; None when unknown.

    Examples
    --------
    >>> import numpy as np
    >>> import trackweave as tw
    >>> problem = tw.AssignmentProblem.from_tuples([[1, 1], [1, 2], [2, 2]], [-4.0, -6.0, -3.0])
    >>> first = tw.solve(problem, rng=np.random.default_rng(1))
    >>> hint = tw.Hint(prices=first.prices, nodes=first.nodes)
    >>> tw.solve(problem, tw.Dual(), rng=np.random.default_rng(1), hint=hint).cost  # nats
    -7.0
    """

    prices: FloatArray | None = None
    nodes: IntArray | None = None

    __repr__ = summary


class Solver(Protocol):
    """Chooses disjoint sequences. Holds parameters only; can be called any number of times."""

    def __call__(
        self,
        problem: AssignmentProblem,
        *,
        rng: np.random.Generator,
        hint: Hint | None = None,
        stop: Stop | None = None,
    ) -> Answer:
        """Return an answer and its certificate; ``problem`` is left as it is.

        Parameters
        ----------
        problem
            What to solve.
        rng
            Source of randomness. A solver that draws advances it, by as much whatever the
            problem: the next call draws other numbers.
        hint
            What is known beforehand.
        stop
            Asked every few milliseconds whether to stop with the best answer so far.

        Returns
        -------
        A feasible answer, however early the stop.
        """
        ...


def require_solver(value: object, name: str) -> None:
    """Refuse what cannot be called as a solver, and a class: its call would make a solver."""
    if isinstance(value, type) or not callable(value):
        its = "; its name is for tracker.toml and the command line" if type(value) is str else ""
        raise InvalidInputError(f"{name}: {value!r:.80}; expected a solver, such as Auto(){its}")


def answered(solver: Solver, problem: AssignmentProblem, **given: Any) -> Answer:
    """Return a solver's answer; what one from outside does wrong is told as its own."""
    with told_as_theirs(solver, "solvers", "__call__"):
        answer: Any = solver(problem, **given)
    if not is_ours(solver) and not isinstance(answer, Answer):
        raise InvalidInputError(
            f"solver {type(solver).__name__}: __call__ returned {answer!r:.60}; expected an Answer"
        )
    found: Answer = answer
    return found


def child_of(rng: RandomSource) -> np.random.Generator:
    """Return a source of randomness of one's own; the given one is advanced by it."""
    return generator_of(rng).spawn(1)[0]


def require_stop(stop: object) -> None:
    """Refuse what is neither None nor can be asked whether to stop."""
    if stop is not None and not callable(stop):
        raise InvalidInputError(f"stop: {stop!r:.80}; expected something to call, or None")


def until(seconds: float, stop: Stop | None) -> Stop:
    """Return a stop that also heeds a time limit from now on."""
    end = perf_counter() + seconds
    return lambda: perf_counter() >= end or (stop is not None and stop())


def refuse_parameters(solver: object, wrong: Iterable[tuple[bool, str, str]]) -> None:
    """Refuse a solver with a parameter out of range: for each, if so, which, what was expected."""
    for is_wrong, name, expected in wrong:
        if is_wrong:
            raise InvalidInputError(f"{name}: {getattr(solver, name)!r:.80}; expected {expected}")
