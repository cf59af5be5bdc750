"""The tables of a file: which keys they have, all of it read off classes."""

import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache, cached_property
from importlib import import_module
from typing import Annotated, Any, ClassVar, NamedTuple, get_args, get_origin, get_type_hints

from trackweave.config.kinds import Found, Kind, Misfit, kind_of
from trackweave.config.messages import show_value, suggest
from trackweave.errors import InvalidInputError
from trackweave.keys import Key

__all__ = ["Entry", "Section", "Table", "checked", "entries_of"]


class Entry(NamedTuple):
    """One key of a table."""

    kind: Kind
    meaning: str = ""
    default: Any = None  # As the schema tells it; None for nothing


def _agree(values: Mapping[str, Any]) -> str | None:
    return None


@dataclass(frozen=True, eq=False)
class Table:
    """A table of keys: one kind of what stands behind a key."""

    name: str
    meaning: str
    find: Callable[[], Mapping[str, Entry]]  # Its keys, looked for once they are needed
    rule: Callable[[Mapping[str, Any]], str | None] = _agree  # What is expected, if not met
    others: Kind | None = None  # What tables of any name beside the keys are
    is_open: bool = False  # Whether other keys are somebody else's to check
    is_whole: bool = False  # Whether no key may be left out
    expected: str = ""

    @cached_property
    def entries(self) -> Mapping[str, Entry]:
        """Its keys."""
        return self.find()

    def take(self, value: Any, path: str, found: Found) -> Any:
        """Return the keys that are given, None as good as left out; or a misfit."""
        if not isinstance(value, Mapping):
            return Misfit()
        given = {str(name): item for name, item in value.items()}
        known = {name: given.pop(name) for name in self.entries if name in given}
        known = {name: item for name, item in known.items() if item is not None}
        before, taken = len(found), {}
        for name, item in {**known, **given}.items():
            kind = self.entries[name].kind if name in known else self.others
            taken[name] = item if kind is None else self._taken(kind, item, _at(path, name), found)
            if kind is None and not self.is_open:
                hint = suggest(name, sorted(self.entries))
                found[_at(path, name)] = f"unknown key; {hint}"
        if len(found) > before:
            return taken
        if self.is_whole and len(known) < len(self.entries):
            return Misfit()
        reason = self.rule(taken)
        return Misfit(reason=reason) if reason else taken

    @staticmethod
    def _taken(kind: Kind, value: Any, path: str, found: Found) -> Any:
        taken = kind.take(value, path, found)
        if isinstance(taken, Misfit):
            found[path] = _message(value, kind.expected, taken)
        return taken

    def schema(self, shared: dict[str, Any]) -> dict[str, Any]:
        """Enter the JSON schema among the shared ones; return where it stands."""
        if self.name not in shared:
            shared[self.name] = self.content(shared)
        return {"$ref": f"#/$defs/{self.name}"}

    def content(self, shared: dict[str, Any]) -> dict[str, Any]:
        """Return the JSON schema itself."""
        told: dict[str, Any] = {"type": "object", "description": self.meaning, "properties": {}}
        for name, entry in self.entries.items():
            told["properties"][name] = entry.kind.schema(shared)
            if entry.meaning:
                told["properties"][name]["description"] = entry.meaning
            if entry.default is not None:
                told["properties"][name]["default"] = entry.default
        told["additionalProperties"] = self.others.schema(shared) if self.others else self.is_open
        return {**told, "required": list(self.entries)} if self.is_whole else told


class Section:
    """A table of the file.

    Its annotations are its keys, and so are those of the classes ``of`` which it is made, as far
    as they carry a ``Key``; these may be named, to be imported once they are needed. Beside them
    there may be tables of any name, ``entries``; keys that others check where it ``is_open``; and
    where it ``is_whole``, none may be left out.
    """

    _of: ClassVar[tuple[type | str, ...]] = ()
    _made: ClassVar[Mapping[str, Any]] = {}
    _others: ClassVar[Any] = None

    def __init_subclass__(
        cls, of: tuple[type | str, ...] = (), entries: Any = None, **made: bool
    ) -> None:
        cls._of, cls._others, cls._made = of, entries, made

    @staticmethod
    def rule(values: Mapping[str, Any]) -> str | None:
        """Return what was expected where keys do not go together, else None."""
        return None

    @classmethod
    @cache
    def as_kind(cls, key: Key) -> Table:
        """Return how a file's table is taken."""
        meaning = (cls.__doc__ or "").partition("\n")[0]
        others = None if cls._others is None else kind_of(cls._others)
        return Table(
            cls.__name__, meaning, cls._find, cls.rule, others, **cls._made, expected=key.expected
        )

    @classmethod
    def _find(cls) -> Mapping[str, Entry]:
        entries: dict[str, Entry] = {}
        for other in cls._of:
            found = entries_of(_class_at(other) if isinstance(other, str) else other)
            entries |= {key: entry for key, entry in found.items() if key not in entries}
        return entries | entries_of(cls, marked=False)


def _class_at(place: str) -> type:
    module, _, name = place.partition(":")
    return getattr(import_module(module), name)  # type: ignore[no-any-return]


def entries_of(cls: type, *, marked: bool = True) -> dict[str, Entry]:
    """Return the fields of a class as keys: those that carry a ``Key``, or all."""
    # What a key means stands in its annotation, or in the class's docstring.
    meanings, found = _meanings(cls), {}
    for name, hint in get_type_hints(cls, include_extras=True).items():
        marks = get_args(hint)[1:] if get_origin(hint) is Annotated else ()
        is_key = not name.startswith("_") and (not marked or any(_is_key(each) for each in marks))
        kind = kind_of(hint) if is_key else None
        if kind is not None:
            said = next((mark for mark in marks if isinstance(mark, str)), "")
            found[name] = Entry(kind, meanings.get(name, said))
    return found


def _is_key(mark: Any) -> bool:
    return isinstance(mark, Key)


def _meanings(cls: type) -> dict[str, str]:
    """Return the first paragraph of what a docstring says under Parameters, by name."""
    text = inspect.cleandoc(cls.__doc__ or "")
    found: dict[str, str] = {}
    name = ""
    for line in text.partition("Parameters\n----------\n")[2].splitlines():
        if not line.startswith(" "):
            name = line
        elif name:
            found[name] = f"{found.get(name, '')} {line.strip()}".strip()
    return found


def checked(values: Mapping[str, Any], table: Table, where: str, path: str = "") -> dict[str, Any]:
    """Return a table's values as they are used; refuse it with the first wrong key's name."""
    # ``where`` is what the message calls the file, ``path`` the table's own place there. The
    # message says how many others are wrong.
    found: Found = {}
    taken = table.take(values, path, found)
    if isinstance(taken, Misfit):
        found[path] = _message(values, table.expected, taken)
    if found:
        key, message = next(iter(found.items()))
        more = f" (and {len(found) - 1} more)" if len(found) > 1 else ""
        raise InvalidInputError(f"{where}, {f'{key}: ' if key else ''}{message}{more}")
    return dict(taken)


def _message(value: Any, expected: str, misfit: Misfit) -> str:
    """Return what a message says of a value."""
    # A section has no words of its own; a rule between its keys brings them as its reason.
    expected = expected or misfit.reason or "a table of keys"
    beyond = f", {misfit.limit}" if misfit.limit else ""
    is_said = misfit.limit.rpartition(" ")[2] in expected
    return f"{show_value(value)}; expected {expected}{'' if is_said else beyond}"


def _at(path: str, name: str) -> str:
    return f"{path}.{name}" if path else name
