"""Solvers by name, with their own options."""

import dataclasses
from collections.abc import Mapping
from functools import cache
from typing import Annotated, Any, get_args, get_origin, get_type_hints

from trackweave.config.plugins import plugin_class
from trackweave.config.tables import Entry, Table, checked, kind_of, meanings_of
from trackweave.errors import InvalidInputError
from trackweave.keys import Key, suggest
from trackweave.solvers import METHODS

__all__ = ["check_search", "instead_of", "make_solver", "options_of"]

DEFAULT_METHOD = "auto"
SEARCHES = Annotated[
    list[str | dict[str, Any]],
    Key("a list of searches, each a name or a table with method and options"),
]
# Searches that are no more.
GONE = ("max-min-ant-system",)


def check_search(search: Mapping[str, Any], name: str, key: str = "search") -> None:
    """Refuse an unknown method and options that it does not have."""
    # ``name`` is what the error message calls the file, ``key`` the table that it is.
    options = set(search) - {"method"}
    if "method" not in search and not options:
        return
    is_default = options <= set(options_of(DEFAULT_METHOD).entries)
    is_known = any(options <= set(options_of(method).entries) for method in METHODS)
    if "method" not in search and is_known and not is_default:
        # Whose options these are, a preset may still say.
        return
    make_solver(search, name, key)


def instead_of(method: str, known: list[str]) -> str:
    """Return what to write instead of a method that is not known."""
    if method in GONE:
        return "it was removed; annealing answers as well or better"
    return suggest(method, known)


def make_solver(
    search: Mapping[str, Any], name: str = "configuration", key: str = "search"
) -> Any:
    """Return the solver that a table names, with its options, None where it names none."""
    # Then the tracker takes its own. Names are as for ``check_search``.
    options = dict(search)
    method = options.pop("method", None)
    if method is None and not options:
        return None
    method = method or DEFAULT_METHOD
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
    _refuse_others_options(method, options, f"{name}, {key}")
    options = checked(options, options_of(method), name, key)
    hints = get_type_hints(_solver_class(method))
    islands = 1 if "islands" in hints else options.get("islands", 1)
    values = {
        option: _searches(value, f"{key}.{option}", name) if _is_searches(hints[option]) else value
        for option, value in options.items()
        if option in hints
    }
    try:
        solver = _solver_class(method)(**values)
        if islands == 1:
            return solver
        from trackweave.solvers import Islands

        # Side by side, ending as the search does.
        return Islands((solver,), islands, own_limits=True)
    except InvalidInputError as err:
        raise InvalidInputError(f"{name}, {key}.{err}") from err


def _refuse_others_options(method: str, options: dict[str, Any], place: str) -> None:
    """Say whose an option is that the method does not have, where another has it."""
    for option in options:
        known = options_of(method).entries
        owners = [owner for owner in METHODS if option in options_of(owner).entries]
        if option not in known and owners:
            raise InvalidInputError(
                f"{place}.{option}: a key of {', '.join(owners)}, but the method is {method}; "
                f"expected one of {', '.join(sorted(known))}"
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
def options_of(method: str) -> Table:
    """Return the options of a solver: those of its fields that a file can say."""
    from trackweave.solvers.metaheuristic import Metaheuristic

    solver = _solver_class(method)
    hints = get_type_hints(solver, include_extras=True)
    meanings = meanings_of(solver)
    found = {
        field.name: _entry(hints[field.name], field.default, meanings.get(field.name, ""))
        for field in dataclasses.fields(solver)
        if field.init
    }
    if "islands" not in hints and issubclass(solver, Metaheuristic):
        found["islands"] = _entry(int, 1, "How many such searches there are, side by side.")
    options = {name: entry for name, entry in found.items() if entry is not None}
    return Table(solver.__name__, "", lambda: options)


def _solver_class(method: str) -> Any:
    # Compiled kernels come with the solvers: a second that nobody else should wait for.
    from trackweave import solvers

    known = METHODS.get(method)
    return _from_outside(method) if known is None else getattr(solvers, known)


def _entry(hint: Any, default: Any, meaning: str) -> Entry | None:
    """Return a field as a key, None for one that a file cannot say."""
    if _is_searches(hint):
        names = {_solver_class(name): name for name in METHODS}
        hint, default = SEARCHES, [names[type(method)] for method in default]
    kind = kind_of(hint)
    return None if kind is None else Entry(kind, meaning, default)
