"""What a solver is, and what it may be told beforehand."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, fields
from functools import cache
from typing import Any, Protocol, TypeAlias, get_type_hints

import numpy as np

from trackweave.arrays import FloatArray, IntArray, is_number, is_whole
from trackweave.association.problem import Answer, AssignmentProblem
from trackweave.errors import InvalidInputError
from trackweave.summaries import summary

__all__ = ["Hint", "Solver", "Stop", "refuse_parameters", "require_kinds", "require_solver"]

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
    """Refuse what cannot be called as a solver.

    Parameters
    ----------
    value
        What was given as a solver.
    name
        What the error message calls it.

    Raises
    ------
    InvalidInputError
        If it cannot be called, or is a class: its call would make a solver, not an answer.
    """
    if isinstance(value, type) or not callable(value):
        raise InvalidInputError(f"{name}: {value!r:.80}; expected a solver, such as Auto()")


def refuse_parameters(solver: object, wrong: Iterable[tuple[bool, str, str]]) -> None:
    """Refuse a solver with a parameter out of range.

    Parameters
    ----------
    solver
        The solver.
    wrong
        For each check whether it fails, which parameter it is about, and what was expected.

    Raises
    ------
    InvalidInputError
        If a check fails.
    """
    for is_wrong, name, expected in wrong:
        if is_wrong:
            raise InvalidInputError(f"{name}: {getattr(solver, name)!r:.80}; expected {expected}")


def require_kinds(solver: Any) -> None:
    """Refuse a solver with a parameter of another kind than its field says.

    Parameters
    ----------
    solver
        A dataclass whose fields may be whole numbers, numbers, or true and false; fields of any
        other type are left to the solver.

    Raises
    ------
    InvalidInputError
        If a parameter is of another kind.
    """
    kinds: dict[Any, tuple[Callable[[object], bool], str]] = {
        int: (is_whole, "a whole number"),
        float: (is_number, "a number"),
        bool: (lambda value: isinstance(value, bool), "True or False"),
    }
    kind: Any = type(solver)
    hints = _hints_of(kind)
    for field in fields(solver):
        fits, expected = kinds.get(hints[field.name], (None, ""))
        value = getattr(solver, field.name)
        if fits is not None and not fits(value):
            raise InvalidInputError(f"{field.name}: {value!r:.80}; expected {expected}")


@cache
def _hints_of(kind: type) -> dict[str, Any]:
    """Return the types of a class's fields: looking them up takes longer than solving a little."""
    return get_type_hints(kind)
