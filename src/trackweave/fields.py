"""What a dataclass is given, brought to the kinds that its annotations say, or refused."""

from collections.abc import Callable, Iterable, Mapping, Sequence, Set
from dataclasses import fields
from functools import cache
from types import NoneType, UnionType
from typing import (
    Annotated,
    Any,
    Literal,
    NamedTuple,
    TypeAlias,
    TypeVar,
    Union,
    get_args,
    get_origin,
    get_type_hints,
)

import numpy as np

from trackweave.arrays import is_number, is_whole, require_instance
from trackweave.errors import InvalidInputError
from trackweave.keys import Key

__all__ = [
    "Limit",
    "checked_choice",
    "checked_count",
    "checked_dimension",
    "checked_flag",
    "checked_members",
    "checked_number",
    "plain",
    "settle",
]

_INFINITE = "infinite for none"
Limit: TypeAlias = Annotated[float, _INFINITE]
"""A number that may be infinite."""
LARGEST = 2**63
"""Whole numbers from here on fit no kernel."""
NUMERIC = "biufU"
"""What NumPy's scalars may be to stand for Python's; its dates would become numbers."""
_MISFIT = object()
_Member = TypeVar("_Member")


class _Kind(NamedTuple):
    """What is expected, and what makes it of a value: ``_MISFIT`` where nothing does."""

    expected: str
    take: Callable[[Any], Any]


def plain(value: Any) -> Any:
    """Return one of NumPy's numbers or texts, or an array of no dimension, as Python's."""
    is_single = isinstance(value, np.generic) or (isinstance(value, np.ndarray) and not value.ndim)
    return value.item() if is_single and value.dtype.kind in NUMERIC else value


def settle(value: Any) -> None:
    """Bring each field of a frozen dataclass to the kind of its annotation, or refuse it."""
    # Numbers become Python's, sequences tuples, mappings dictionaries. Numbers are finite, but for
    # a ``Limit``, and within the limits of a ``Key``. Annotations that say nothing plain, such as
    # arrays, protocols and functions, are left to the class. Called in its ``__post_init__``.
    for name, kind in _kinds_of(value.__class__):
        given = getattr(value, name)
        found = kind.take(given)
        if found is _MISFIT:
            raise InvalidInputError(f"{name}: {given!r:.80}; expected {kind.expected}")
        if found is not given:
            object.__setattr__(value, name, found)


def checked_number(value: object, name: str, expected: str = "a finite number") -> float:
    """Return a finite number as a float, or refuse it as ``name``, of which so was expected."""
    return _checked(_NUMBER, value, name, expected)  # type: ignore[no-any-return]


def checked_count(value: object, name: str, least: int = 0) -> int:
    """Return a whole number that is large enough, or refuse it."""
    expected = f"a whole number ≥ {least}"
    found: int = _checked(_WHOLE, value, name, expected)
    if found < least:
        raise InvalidInputError(f"{name}: {value!r:.80}; expected {expected}")
    return found


def checked_flag(value: object, name: str) -> bool:
    """Return True or False; refuse anything else under that name."""
    return _checked(_SIMPLE[bool], value, name)  # type: ignore[no-any-return]


def checked_dimension(value: object) -> int:
    """Return a number of spatial dimensions; refuse what is neither 2 nor 3."""
    found = _whole(value)
    if found not in {2, 3}:
        raise InvalidInputError(f"dim: {value!r:.80}; expected 2 or 3")
    return int(found)


def checked_choice(value: object, name: str, choices: Iterable[str]) -> str:
    """Return a text that is one of some, or refuse it."""
    return _checked(_choice(tuple(choices)), value, name)  # type: ignore[no-any-return]


def checked_members(values: object, kind: type[_Member], name: str) -> list[_Member]:
    """Return what a sequence holds, all of it of one class, or refuse it."""
    members = _items(values)
    if members is None:
        raise InvalidInputError(f"{name}: {values!r:.80}; expected a sequence of {kind.__name__}")
    for place, member in enumerate(members):
        require_instance(member, kind, f"{name}[{place}]")
    return members


def _checked(kind: _Kind, value: object, name: str, expected: str | None = None) -> Any:
    found = kind.take(value)
    if found is _MISFIT:
        raise InvalidInputError(f"{name}: {value!r:.80}; expected {expected or kind.expected}")
    return found


def _number(value: Any) -> Any:
    value = plain(value)
    return float(value) if is_number(value) else _MISFIT


def _limit(value: Any) -> Any:
    value = plain(value)
    is_infinite = isinstance(value, float) and value in {np.inf, -np.inf}
    return value if is_infinite else _number(value)


def _whole(value: Any) -> Any:
    value = plain(value)
    return int(value) if is_whole(value) and -LARGEST <= value < LARGEST else _MISFIT


def _truth(value: Any) -> Any:
    value = plain(value)
    return value if isinstance(value, bool) else _MISFIT


def _text(value: Any) -> Any:
    value = plain(value)
    return str(value) if isinstance(value, str) else _MISFIT


_NUMBER, _LIMIT = _Kind("a finite number", _number), _Kind("a number", _limit)
_WHOLE = _Kind("a whole number", _whole)
_SIMPLE = {
    float: _NUMBER,
    Limit: _LIMIT,
    int: _WHOLE,
    bool: _Kind("True or False", _truth),
    str: _Kind("a text", _text),
    NoneType: _Kind("None", lambda value: None if value is None else _MISFIT),
}


@cache
def _kinds_of(kind: type) -> tuple[tuple[str, _Kind], ...]:
    """Return what each field has to be: looking it up takes longer than solving a little."""
    hints, found = get_type_hints(kind, include_extras=True), []
    for field in fields(kind):
        if not field.init:
            continue
        of = _kind(hints[field.name])
        if of is not None:
            found.append((field.name, of))
    return tuple(found)


def _kind(hint: Any) -> _Kind | None:
    """Return what an annotation asks for, None where that is not plain to see."""
    origin, inner = get_origin(hint), get_args(hint)
    if hint in _SIMPLE:
        return _SIMPLE[hint]
    if origin is Annotated:
        return _marked(_LIMIT if _INFINITE in inner else _kind(inner[0]), inner[1:])
    if origin is Literal:
        return _choice(inner)
    if origin in {Union, UnionType}:
        return _either([_kind(part) for part in inner])
    if origin is tuple and Ellipsis not in inner:
        return _row([_kind(part) for part in inner])
    if origin in {tuple, Sequence}:
        return _several(_kind(inner[0]))
    if origin is Mapping:
        return _by_name(_kind(inner[1]))
    is_checkable = isinstance(hint, type) and hint is not Any and not _is_protocol(hint)
    return _instance(hint) if is_checkable and origin is None else None


def _marked(kind: _Kind | None, marks: Sequence[Any]) -> _Kind | None:
    """Return what takes of a kind only what a ``Key`` allows."""
    key = next((mark for mark in marks if isinstance(mark, Key)), None)
    if kind is None or key is None:
        return kind

    def take(value: Any) -> Any:
        found = kind.take(value)
        if isinstance(found, tuple) and not key.size[0] <= len(found) <= key.size[1]:
            return _MISFIT
        if key.holds is not None and found is not None and found is not _MISFIT:
            return found if key.holds(found) else _MISFIT
        if isinstance(found, str):
            return _MISFIT if key.words and found not in key.words else found
        if not isinstance(found, int | float) or isinstance(found, bool) or abs(found) == np.inf:
            return found
        return found if key.least <= found and (key.is_open or found <= key.most) else _MISFIT

    or_none = " or None" if kind.expected.endswith(" or None") else ""
    return _Kind(key.expected + or_none if key.expected else kind.expected, take)


def _is_protocol(hint: type) -> bool:
    return bool(getattr(hint, "_is_protocol", False))


def _instance(kind: type) -> _Kind:
    word = f"{'an' if kind.__name__[0] in 'AEIOU' else 'a'} {kind.__name__}"
    return _Kind(word, lambda value: value if isinstance(value, kind) else _MISFIT)


def _choice(choices: tuple[str, ...]) -> _Kind:
    def take(value: Any) -> Any:
        value = plain(value)
        return str(value) if isinstance(value, str) and value in choices else _MISFIT

    return _Kind(f"one of {', '.join(choices)}", take)


def _either(kinds: Sequence[_Kind | None]) -> _Kind | None:
    known = [kind for kind in kinds if kind is not None]
    if len(known) < len(kinds):
        return None

    def take(value: Any) -> Any:
        return next((f for f in (kind.take(value) for kind in known) if f is not _MISFIT), _MISFIT)

    return _Kind(" or ".join(dict.fromkeys(kind.expected for kind in known)), take)


def _items(value: Any) -> list[Any] | None:
    """Return what a list, a tuple or an array holds, None where it is something else."""
    if isinstance(value, np.ndarray):
        return list(value) if value.ndim else None
    # Sets have no order, and texts and mappings are no lists.
    is_other = isinstance(value, str | bytes | bytearray | Mapping | Set)
    return list(value) if isinstance(value, Iterable) and not is_other else None


def _row(kinds: Sequence[_Kind | None]) -> _Kind | None:
    known = [kind for kind in kinds if kind is not None]
    if len(known) < len(kinds):
        return None

    def take(value: Any) -> Any:
        items = _items(value)
        if items is None or len(items) != len(known):
            return _MISFIT
        found = tuple(kind.take(item) for kind, item in zip(known, items, strict=True))
        return _MISFIT if any(item is _MISFIT for item in found) else found

    return _Kind(f"({', '.join(kind.expected for kind in known)})", take)


def _several(kind: _Kind | None) -> _Kind:
    """Return what makes a tuple of a sequence, whose entries may be of any kind."""

    def take(value: Any) -> Any:
        items = _items(value)
        if items is None:
            return _MISFIT
        found = tuple(items if kind is None else map(kind.take, items))
        return _MISFIT if any(item is _MISFIT for item in found) else found

    return _Kind("a sequence" + (f", each entry {kind.expected}" if kind else ""), take)


def _by_name(kind: _Kind | None) -> _Kind:
    """Return what makes a dictionary of a mapping from texts."""

    def take(value: Any) -> Any:
        if not isinstance(value, Mapping) or not all(isinstance(name, str) for name in value):
            return _MISFIT
        found = {str(n): item if kind is None else kind.take(item) for n, item in value.items()}
        return _MISFIT if any(item is _MISFIT for item in found.values()) else found

    return _Kind("a mapping from names" + (f", each to {kind.expected}" if kind else ""), take)
