"""Solvers by name, with their own options."""

import dataclasses
import types
from functools import cache
from typing import Annotated, Any, Literal, Union, get_args, get_origin, get_type_hints

from pydantic import BaseModel, ConfigDict, ValidationError, create_model

from trackweave.config.fields import Expected
from trackweave.config.messages import explain, show_value, suggest
from trackweave.config.sections import SearchSection
from trackweave.errors import InvalidInputError

__all__ = ["METHODS", "check_search", "make_solver", "options_model"]

# What ``[search] method`` may name, and the class in trackweave.solvers behind it.
METHODS = {
    "auto": "Auto",
    "greedy": "Greedy",
    "exact": "Exact",
    "dual": "Dual",
    "genetic": "Genetic",
    "list-genetic": "ListGenetic",
    "ant-system": "AntSystem",
    "max-min-ant-system": "MaxMinAntSystem",
    "annealing": "Annealing",
    "tabu": "TabuSearch",
    "m-best": "MBest",
}
DEFAULT_METHOD = "auto"


def check_search(search: SearchSection, name: str) -> None:
    """Refuse an unknown method and options that it does not have.

    Parameters
    ----------
    search
        The section as read.
    name
        What the error message calls the file.

    Raises
    ------
    InvalidInputError
        If the method is unknown, or an option is unknown or has a wrong value.
    """
    options = set(search.model_extra or {})
    if search.method is None and any(options <= set(_options(method)) for method in METHODS):
        # Whose options these are, a preset may still say.
        return
    make_solver(search, name)


def _options(method: str) -> dict[str, Any]:
    return options_model(method).model_fields


def make_solver(search: SearchSection, name: str = "configuration") -> Any:
    """Return the solver that a section names, with its options.

    Parameters
    ----------
    search
        The section as read.
    name
        What an error message calls the file.

    Returns
    -------
    The solver, or None where the section says nothing, so that the tracker takes its own.

    Raises
    ------
    InvalidInputError
        If the method is unknown, or an option is unknown or has a wrong value.
    """
    options = dict(search.model_extra or {})
    if search.method is None and not options:
        return None
    method = search.method or DEFAULT_METHOD
    if method not in METHODS:
        raise InvalidInputError(
            f'{name}, search.method: "{method}" is not known; {suggest(method, list(METHODS))}'
        )
    model = options_model(method)
    try:
        model.model_validate(options)
    except ValidationError as err:
        raise InvalidInputError(explain(err, model, [name, "search"], options)) from None
    try:
        return _solver_class(method)(**options)
    except InvalidInputError as err:
        raise InvalidInputError(f"{name}, search.{err}") from err


@cache
def options_model(method: str) -> type[BaseModel]:
    """Return what checks a solver's options, made from the solver's own fields.

    Parameters
    ----------
    method
        Its name in ``METHODS``.

    Returns
    -------
    A model with a key for each field that a file can express.
    """
    solver = _solver_class(method)
    hints = get_type_hints(solver)
    fields: dict[str, Any] = {
        field.name: (
            Annotated[hints[field.name], Expected(_words(hints[field.name]))],
            field.default,
        )
        for field in dataclasses.fields(solver)
        if field.init and _fits_a_file(hints[field.name])
    }
    config = ConfigDict(strict=True, extra="forbid", allow_inf_nan=False)
    return create_model(f"{solver.__name__}Options", __config__=config, **fields)


def _solver_class(method: str) -> Any:
    # Compiled kernels come with the solvers: a second that nobody else should wait for.
    from trackweave import solvers

    return getattr(solvers, METHODS[method])


def _words(kind: Any) -> str:
    """Return what a value of a type is called in a message."""
    if get_origin(kind) is Literal:
        return "one of " + ", ".join(show_value(word) for word in get_args(kind))
    members = get_args(kind) or (kind,)
    names = {bool: "true or false", int: "a whole number", float: "a number", str: "text"}
    return " or ".join(names[member] for member in members if member in names)


def _fits_a_file(kind: Any) -> bool:
    """Tell whether TOML can express values of a type."""
    if get_origin(kind) in (Union, types.UnionType):
        return all(_fits_a_file(member) for member in get_args(kind))
    return get_origin(kind) is Literal or kind in (bool, int, float, str, type(None))
