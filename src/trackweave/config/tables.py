"""The tables of a file: which keys they have and what each takes, all of it read off classes."""

import inspect
import math
import types
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from importlib import import_module
from typing import (
    Annotated,
    Any,
    ClassVar,
    Literal,
    NamedTuple,
    Protocol,
    Union,
    get_args,
    get_origin,
    get_type_hints,
)

from trackweave.config.python_values import python_values
from trackweave.errors import InvalidInputError
from trackweave.keys import Key, show_value, suggest

__all__ = [
    "Entry",
    "Found",
    "Kind",
    "Misfit",
    "Section",
    "Table",
    "checked",
    "entries_of",
    "kind_of",
    "meanings_of",
]

Found = dict[str, str]
"""What is wrong, by dotted key: the value and what was expected, as a message says it."""


@dataclass(frozen=True, slots=True)
class Misfit:
    """A value that does not fit."""

    limit: str = ""  # That it lies beyond, if that is all
    reason: str = ""  # What was expected, where nothing else says it


class Kind(Protocol):
    """One way to take values."""

    @property
    def expected(self) -> str:
        """What a message says was expected; empty where others have to say it."""

    def take(self, value: Any, path: str, found: Found) -> Any:
        """Return the value as it is used, or a misfit; what is wrong further inside is entered."""

    def schema(self, shared: dict[str, Any]) -> dict[str, Any]:
        """Return the JSON schema; tables enter theirs among the shared ones."""


@dataclass(frozen=True, slots=True)
class _Number:
    """A finite number within its limits, whole or not."""

    key: Key
    whole: bool

    @property
    def expected(self) -> str:
        return self.key.expected or ("a whole number" if self.whole else "a number")

    def take(self, value: Any, path: str, found: Found) -> Any:
        kinds = int if self.whole else int | float
        if isinstance(value, bool) or not isinstance(value, kinds) or not _is_finite(value):
            return Misfit()
        least, most = self.key.least, self.key.most
        if not least <= value <= most:
            words, limit = ("at least", least) if value < least else ("at most", most)
            return Misfit(f"{words} {_shown(limit)}")
        return value if self.whole else float(value)

    def schema(self, shared: dict[str, Any]) -> dict[str, Any]:
        told: dict[str, Any] = {"type": "integer" if self.whole else "number"}
        for word, limit in (("minimum", self.key.least), ("maximum", self.key.most)):
            if math.isfinite(limit):
                told[word] = limit
        return told


@dataclass(frozen=True, slots=True)
class _Plain:
    """Truth values, or texts of which some may be the only ones."""

    key: Key
    of: type

    @property
    def expected(self) -> str:
        if self.key.expected or not self.key.words:
            return self.key.expected or {bool: "true or false", str: "text"}.get(self.of, "")
        *others, last = [f'"{word}"' for word in self.key.words]
        if len(others) > 2:
            return f"one of {', '.join([*others, last])}"
        return f"{', '.join(others)} or {last}" if others else last

    def take(self, value: Any, path: str, found: Found) -> Any:
        fits = isinstance(value, self.of) and value in (self.key.words or (value,))
        return value if fits and _holds(self.key, value) else Misfit()

    def schema(self, shared: dict[str, Any]) -> dict[str, Any]:
        words = {"enum": list(self.key.words)} if self.key.words else {}
        return {"type": _WORDS[self.of], **words}


@dataclass(frozen=True, slots=True)
class _Several:
    """A list of values of one kind."""

    key: Key
    item: Kind

    @property
    def expected(self) -> str:
        return self.key.expected or f"a list, each {self.item.expected}"

    def take(self, value: Any, path: str, found: Found) -> Any:
        if not isinstance(value, list):
            return Misfit()
        taken = [self.item.take(item, path, found) for item in value]
        wrong = [item for item in taken if isinstance(item, Misfit)]
        if wrong:
            return wrong[0]
        fits = self.key.size[0] <= len(taken) <= self.key.size[1] and _holds(self.key, taken)
        return taken if fits else Misfit()

    def schema(self, shared: dict[str, Any]) -> dict[str, Any]:
        least, most = self.key.size
        told: dict[str, Any] = {"type": "array", "items": self.item.schema(shared)}
        if least:
            told["minItems"] = least
        if math.isfinite(most):
            told["maxItems"] = most
        return told


@dataclass(frozen=True, slots=True)
class _Either:
    """A value of one of several kinds."""

    key: Key
    kinds: tuple[Kind, ...]

    @property
    def expected(self) -> str:
        return self.key.expected or " or ".join(kind.expected for kind in self.kinds)

    def take(self, value: Any, path: str, found: Found) -> Any:
        taken = [kind.take(value, path, found) for kind in self.kinds]
        return next((each for each in taken if not isinstance(each, Misfit)), taken[0])

    def schema(self, shared: dict[str, Any]) -> dict[str, Any]:
        return {"anyOf": [kind.schema(shared) for kind in self.kinds]}


_WORDS = {bool: "boolean", str: "string", dict: "object"}


def kind_of(hint: Any, key: Key | None = None) -> Kind | None:
    """Return how values of an annotated type are taken; None where a file cannot say them."""
    key = key or Key()
    origin, inner = get_origin(hint), get_args(hint)
    if origin is Annotated:
        keys = [mark for mark in inner[1:] if isinstance(mark, Key)]
        return kind_of(inner[0], keys[-1] if keys else key)
    if origin in (Union, types.UnionType):
        return _either([kind_of(each, key) for each in inner if each is not types.NoneType], key)
    if origin is Literal:
        return _Plain(Key(key.expected, words=inner), str)
    if origin in (tuple, Sequence, list):
        item = kind_of(inner[0])
        return None if item is None else _Several(key, item)
    if origin is None and hint in (int, float):
        return _Number(key, whole=hint is int)
    if hasattr(hint, "as_kind"):
        return hint.as_kind(key)  # type: ignore[no-any-return]  # a table says itself
    return _Plain(key, origin or hint) if (origin or hint) in _WORDS else None


def _either(kinds: list[Kind | None], key: Key) -> Kind | None:
    known = [kind for kind in kinds if kind is not None]
    if len(known) < len(kinds):
        return None
    return known[0] if len(known) == 1 else _Either(key, tuple(known))


def _holds(key: Key, value: Any) -> bool:
    return key.holds is None or key.holds(value)


def _is_finite(value: float) -> bool:
    return isinstance(value, int) or math.isfinite(value)


def _shown(limit: float) -> str:
    return f"{limit:g}" if float(f"{limit:g}") == limit else repr(limit)


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
    needed: tuple[str, ...] = ()  # The keys that may not be left out
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
                found[_at(path, name)] = f"unknown key; {self._hint(name)}"
        if len(found) > before:
            return taken
        if not known.keys() >= set(self.needed):
            return Misfit(reason=f"at least {', '.join(self.needed)}")
        reason = self.rule(taken)
        return Misfit(reason=reason) if reason else taken

    def _hint(self, name: str) -> str:
        """Return what to write for an unknown key: where a table below has it, or a word."""
        below: list[tuple[str, Kind | None]] = [(k, e.kind) for k, e in self.entries.items()]
        below += [(f"{key}.NAME", kind.others) for key, kind in below if isinstance(kind, Table)]
        found = [f"{k}.{name}" for k, t in below if isinstance(t, Table) and name in t.entries]
        if found:
            return f"did you mean {' or '.join(found)}?"
        return suggest(name, sorted(self.entries))

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
        return {**told, "required": list(self.needed)} if self.needed else told


class Section:
    """A table of the file.

    Its annotations are its keys, and so are those of the classes ``of`` which it is made, as far
    as they carry a ``Key``; these may be named, to be imported once they are needed. Beside them
    there may be tables of any name, ``entries``, keys that others check where it ``is_open``, and
    those ``needed`` may not be left out.
    """

    _of: ClassVar[tuple[type | str, ...]] = ()
    _made: ClassVar[Mapping[str, Any]] = {}
    _others: ClassVar[Any] = None

    def __init_subclass__(
        cls, of: tuple[type | str, ...] = (), entries: Any = None, **made: Any
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
    meanings, found = meanings_of(cls), {}
    for name, hint in get_type_hints(cls, include_extras=True).items():
        marks = get_args(hint)[1:] if get_origin(hint) is Annotated else ()
        is_key = not name.startswith("_") and (
            not marked or any(isinstance(each, Key) for each in marks)
        )
        kind = kind_of(hint) if is_key else None
        if kind is not None:
            said = next((mark for mark in marks if isinstance(mark, str)), "")
            found[name] = Entry(kind, meanings.get(name, said))
    return found


def meanings_of(cls: type) -> dict[str, str]:
    """Return the first paragraph of what a docstring says under Parameters, by name."""
    text = inspect.cleandoc(cls.__doc__ or "")
    found: dict[str, str] = {}
    names: list[str] = []
    for line in text.partition("Parameters\n----------\n")[2].splitlines():
        if not line.startswith(" "):
            names = line.split(", ") if line else []
        for name in names if line.startswith(" ") else ():
            found[name] = f"{found.get(name, '')} {line.strip()}".strip()
    return found


def checked(values: Mapping[str, Any], table: Table, where: str, path: str = "") -> dict[str, Any]:
    """Return a table's values as they are used; refuse it with the first wrong key's name."""
    # ``where`` is what the message calls the file, ``path`` the table's own place there. The
    # message says how many others are wrong.
    found: Found = {}
    values = python_values(values)
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
