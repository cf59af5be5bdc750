"""Pydantic's findings in our words: file, key, value, what was expected."""

import difflib
import json
from collections.abc import Mapping, Sequence
from typing import Annotated, Any, get_args, get_origin

from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo

from trackweave.config.fields import Expected

__all__ = ["explain", "show_value", "suggest"]

Model = type[BaseModel]


def explain(err: ValidationError, model: Model, where: Sequence[str], values: Any) -> str:
    """Return what to say of a configuration that pydantic refuses."""
    # The message names the first wrong key and how many others are wrong. ``where`` is the file's
    # name, then the keys that lead to the values checked.
    messages: dict[str, str] = {}
    for finding in err.errors(include_url=False):
        path, message = _message(finding, model, values)
        messages.setdefault(".".join([*where[1:], *path]), message)
    # A union reports once for each of its members: what lies deepest says most.
    keys = [key for key in messages if not any(k.startswith(f"{key}.") for k in messages)]
    first = f"{keys[0]}: {messages[keys[0]]}" if keys[0] else messages[keys[0]]
    more = f" (and {len(keys) - 1} more)" if len(keys) > 1 else ""
    return f"{where[0]}, {first}{more}"


def show_value(value: Any) -> str:
    """Return a value as a configuration file would show it, shortened."""
    if isinstance(value, Mapping):
        text = "{" + ", ".join(f"{key} = {show_value(item)}" for key, item in value.items()) + "}"
    elif isinstance(value, list | tuple):
        text = "[" + ", ".join(show_value(item) for item in value) + "]"
    elif isinstance(value, str | bool) or value is None:
        text = json.dumps(value, ensure_ascii=False)
    else:
        text = str(value)
    return text if len(text) <= 80 else text[:77] + "..."


def suggest(key: str, known: Sequence[str]) -> str:
    """Return what to write instead of an unknown word."""
    small = {word.lower(): word for word in known}
    near = difflib.get_close_matches(key.lower(), small, n=1)
    return f"did you mean {small[near[0]]}?" if near else f"expected one of {', '.join(known)}"


def _message(finding: Any, model: Model, values: Any) -> tuple[list[str], str]:
    """Return the keys that lead to what is wrong, and what to say of it."""
    # A key that is missing has no value: the table without it is what to show.
    place = finding["loc"][:-1] if finding["type"] == "missing" else finding["loc"]
    path, expected, section = _follow(place, model)
    if finding["type"] == "extra_forbidden":
        key = str(finding["loc"][-1])
        known = sorted(_fields(section)) if section else []
        return [*path, key], f"unknown key; {suggest(key, known)}"
    reason = str(finding.get("ctx", {}).get("error", ""))
    value = values
    for key in path:
        value = value[key]
    expected = _with_limit(expected, finding)
    # A section has no words of its own; a rule between its keys brings them as its reason.
    return path, f"{show_value(value)}; expected {expected or reason or 'a table of keys'}"


def _with_limit(expected: str | None, finding: Any) -> str | None:
    """Return the words of a key, with the limit where that is what a value lies beyond."""
    limits = {"less_than_equal": ("le", "at most"), "greater_than_equal": ("ge", "at least")}
    if expected is None or finding["type"] not in limits:
        return expected
    name, words = limits[finding["type"]]
    number = finding["ctx"][name]
    limit = f"{number:g}" if float(f"{number:g}") == number else repr(number)
    return expected if limit in expected else f"{expected}, {words} {limit}"


def _follow(place: Sequence[Any], model: Model) -> tuple[list[str], str | None, Model | None]:
    """Return the keys of a place, what was expected there, and the section it leads into."""
    # Pydantic's places also name members of unions and positions in lists. Those are passed over,
    # because a person wrote the key. There may be no such table.
    path: list[str] = []
    expected: str | None = None
    section: Model | None = model
    entries: Model | None = None
    for step in place:
        if entries is not None:
            path.append(str(step))
            section, entries, expected = entries, None, None
        elif section is not None and step not in _fields(section) and _has_entries(section):
            path.append(str(step))
            section, expected = section.__dict__["entries"], None
        elif section is not None and step in _fields(section):
            path.append(str(step))
            kinds = list(_kinds(_fields(section)[step]))
            expected = next((kind.text for kind in kinds if isinstance(kind, Expected)), None)
            inner = [
                kind for kind in kinds if isinstance(kind, type) and issubclass(kind, BaseModel)
            ]
            is_table = bool(inner) and any(kind is dict for kind in kinds)
            section, entries = (None, inner[0]) if is_table else (next(iter(inner), None), None)
    return path, expected, section


def _fields(section: Model) -> dict[str, FieldInfo]:
    """Return a section's fields by the keys that a file has."""
    return {field.alias or name: field for name, field in section.model_fields.items()}


def _has_entries(section: Model) -> bool:
    """Tell whether a section has tables of any name beside its own keys."""
    return "entries" in section.__dict__


def _kinds(field: FieldInfo) -> list[Any]:
    """Return all that a field's type is made of, outermost first."""
    found = [item for item in reversed(field.metadata) if isinstance(item, Expected)]
    waiting: list[Any] = [field.annotation]
    while waiting:
        kind = waiting.pop(0)
        if get_origin(kind) is Annotated:
            base, *marks = get_args(kind)
            found += reversed(marks)
            waiting.append(base)
        else:
            found.append(get_origin(kind) or kind)
            waiting += get_args(kind)
    return found
