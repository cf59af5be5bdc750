"""Solvers by name, with their own options."""

import dataclasses
import types
from functools import cache
from typing import Annotated, Any, Literal, Union, get_args, get_origin, get_type_hints

from pydantic import BaseModel, ConfigDict, ValidationError, create_model

from trackweave.config.fields import Expected
from trackweave.config.fusion_sections import SolverSection
from trackweave.config.messages import explain, show_value, suggest
from trackweave.config.plugins import plugin_class
from trackweave.errors import InvalidInputError

__all__ = ["METHODS", "check_search", "instead_of", "make_solver", "options_model"]

# What ``[search] method`` may name, and the class in trackweave.solvers behind it.
METHODS = {
    "auto": "Auto",
    "greedy": "Greedy",
    "exact": "Exact",
    "dual": "Dual",
    "genetic": "Genetic",
    "list-genetic": "ListGenetic",
    "ant-system": "AntSystem",
    "annealing": "Annealing",
    "islands": "Islands",
    "tabu": "TabuSearch",
    "m-best": "MBest",
}
DEFAULT_METHOD = "auto"
# Searches that are no more.
GONE = ("max-min-ant-system",)


def check_search(search: SolverSection, name: str, key: str = "search") -> None:
    """Refuse an unknown method and options that it does not have."""
    # ``name`` is what the error message calls the file, ``key`` the table that it is.
    options = set(search.model_extra or {})
    if search.method is None and not options:
        return
    is_default = options <= set(_options(DEFAULT_METHOD))
    is_known = any(options <= set(_options(method)) for method in METHODS)
    if search.method is None and is_known and not is_default:
        # Whose options these are, a preset may still say.
        return
    make_solver(search, name, key)


def instead_of(method: str, known: list[str]) -> str:
    """Return what to write instead of a method that is not known."""
    if method in GONE:
        return "it was removed; annealing answers as well or better"
    return suggest(method, known)


def _options(method: str) -> dict[str, Any]:
    return options_model(method).model_fields


def make_solver(search: SolverSection, name: str = "configuration", key: str = "search") -> Any:
    """Return the solver that a section names, with its options, None where it names none."""
    # Then the tracker takes its own. Names are as for ``check_search``.
    options = dict(search.model_extra or {})
    if search.method is None and not options:
        return None
    method = search.method or DEFAULT_METHOD
    if method in METHODS:
        return _made(method, options, name, key)
    if _from_outside(method, f"{name}, {key}") is None:
        raise InvalidInputError(
            f'{name}, {key}.method: "{method}" is not known; {instead_of(method, list(METHODS))}'
        )
    from trackweave.solvers.protocol import require_solver

    solver = _made(method, options, name, key)
    require_solver(solver, f'{name}, {key}.method: "{method}"')
    return solver


def _from_outside(method: str, key: str = "search") -> type | None:
    """Return the solver from outside the package that an entry point names; None for none."""
    return plugin_class("solvers", method, f"{key}.method")


def _made(method: str, options: dict[str, Any], name: str, key: str) -> Any:
    """Return the solver of a known name; ``key`` is the table that its options stand in."""
    model = options_model(method)
    _refuse_others_options(method, options, f"{name}, {key}")
    try:
        model.model_validate(options)
    except ValidationError as err:
        raise InvalidInputError(explain(err, model, [name, key], options)) from None
    hints = get_type_hints(_solver_class(method))
    islands = 1 if "islands" in hints else options.get("islands", 1)
    values = {
        option: _searches(value, f"{key}.{option}", name) if _is_searches(hints[option]) else value
        for option, value in options.items()
        if option in hints
    }
    try:
        solver = _solver_class(method)(**values)
        return solver if islands == 1 else _on_islands(solver, islands)
    except InvalidInputError as err:
        raise InvalidInputError(f"{name}, {key}.{err}") from err


def _on_islands(solver: Any, islands: int) -> Any:
    """Return so many of a search side by side, which end as it does."""
    from trackweave.solvers import Islands

    return Islands((solver,), islands, own_limits=True)


def _refuse_others_options(method: str, options: dict[str, Any], place: str) -> None:
    """Say whose an option is that the method does not have, where another has it."""
    for option in options:
        owners = [] if option in _options(method) else [
            owner for owner in METHODS if option in _options(owner)
        ]  # fmt: skip
        if owners:
            raise InvalidInputError(
                f"{place}.{option}: a key of {', '.join(owners)}, but the method is {method}; "
                f"expected one of {', '.join(sorted(_options(method)))}"
            )


def _searches(entries: list[Any], key: str, name: str) -> tuple[Any, ...]:
    """Return the searches that a list names, by words or by tables with their options."""
    known, found = _search_names(), []
    for entry in entries:
        options = {"method": entry} if isinstance(entry, str) else dict(entry)
        method = str(options.pop("method", ""))
        if method not in known:
            raise InvalidInputError(
                f'{name}, {key}: "{method}" is no search; {instead_of(method, known)}'
            )
        found.append(_made(method, options, name, key))
    return tuple(found)


def _search_names() -> list[str]:
    """Return the methods that can live on islands."""
    from trackweave.solvers.metaheuristic import Metaheuristic

    return [name for name in METHODS if issubclass(_solver_class(name), Metaheuristic)]


def _is_searches(kind: Any) -> bool:
    """Tell whether values of a type are searches, which a file names."""
    from trackweave.solvers.metaheuristic import Metaheuristic

    return get_origin(kind) is tuple and get_args(kind)[0] is Metaheuristic


@cache
def options_model(method: str) -> type[BaseModel]:
    """Return what checks a solver's options, made from the fields that a file can express."""
    from trackweave.solvers.metaheuristic import Metaheuristic

    solver = _solver_class(method)
    hints = get_type_hints(solver)
    fields: dict[str, Any] = {
        field.name: _as_in_a_file(hints[field.name], field.default)
        for field in dataclasses.fields(solver)
        if field.init and _fits_a_file(hints[field.name])
    }
    if "islands" not in hints and issubclass(solver, Metaheuristic):
        fields["islands"] = _as_in_a_file(int, 1)
    config = ConfigDict(strict=True, extra="forbid", allow_inf_nan=False)
    return create_model(f"{solver.__name__}Options", __config__=config, **fields)


def _solver_class(method: str) -> Any:
    # Compiled kernels come with the solvers: a second that nobody else should wait for.
    from trackweave import solvers

    known = METHODS.get(method)
    return _from_outside(method) if known is None else getattr(solvers, known)


def _as_in_a_file(kind: Any, default: Any) -> tuple[Any, Any]:
    """Return a field's type and its default as a file has them."""
    if not _is_searches(kind):
        needed = default is dataclasses.MISSING
        return Annotated[kind, Expected(_words(kind))], ... if needed else default
    names = {_solver_class(name): name for name in METHODS}
    expected = Expected("a list of searches, each a name or a table with method and options")
    entry = str | dict[str, Any]
    return Annotated[list[entry], expected], [names[type(method)] for method in default]


def _words(kind: Any) -> str:
    """Return what a value of a type is called in a message."""
    if get_origin(kind) is Literal:
        return "one of " + ", ".join(show_value(word) for word in get_args(kind))
    members = get_args(kind) or (kind,)
    names = {bool: "true or false", int: "a whole number", float: "a number", str: "text"}
    words = [_words(each) if get_origin(each) is Literal else names.get(each) for each in members]
    return " or ".join(word for word in words if word is not None)


def _fits_a_file(kind: Any) -> bool:
    """Tell whether TOML can express values of a type."""
    if get_origin(kind) in (Union, types.UnionType):
        return all(_fits_a_file(member) for member in get_args(kind))
    if _is_searches(kind):
        return True
    return get_origin(kind) is Literal or kind in (bool, int, float, str, type(None))
