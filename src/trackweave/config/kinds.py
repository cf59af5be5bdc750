"""What a key takes, read off its annotation: how it is checked, and how a schema shows it."""

import math
import types
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Any, Literal, Protocol, Union, get_args, get_origin

from trackweave.keys import Key

__all__ = ["Found", "Kind", "Misfit", "kind_of"]

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
