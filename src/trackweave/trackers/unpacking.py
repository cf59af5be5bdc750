"""What `packing` has made of a value, read; whatever the bytes are, nothing in them is run."""

import math
import struct
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import fields, is_dataclass
from enum import Enum
from importlib import import_module
from typing import Any

import numpy as np

from trackweave.errors import DataFormatError
from trackweave.trackers.packing import ARRAYS, COUNT, FLOAT, GENERATORS, PACKAGES, PLAIN, Shape

__all__ = ["unpacked"]

_UNFINISHED = object()
_BROKEN = (
    ArithmeticError, AttributeError, ImportError, LookupError, MemoryError, RecursionError,
    TypeError, ValueError, struct.error,
)  # fmt: skip
"""What bytes that are no value make of themselves."""


def unpacked(content: bytes, classes: Sequence[type] = ()) -> Any:
    """Return the value that bytes are of.

    Parameters
    ----------
    content
        The bytes.
    classes
        As they were packed with.

    Returns
    -------
    The value.

    Raises
    ------
    DataFormatError
        If they are of none; the message says from which byte on.
    """
    reader = _Unpacker(content, classes)
    try:
        value = reader.take()
    except DataFormatError:
        raise
    except _BROKEN as err:
        raise DataFormatError(f"byte {reader.place}: no value ({err!s:.80})") from err
    if reader.place != len(content):
        raise DataFormatError(f"byte {reader.place}: something behind the value")
    return value


class _Unpacker:
    """Reads a value, part by part."""

    def __init__(self, content: bytes, classes: Sequence[type]) -> None:
        self._content, self.place = content, 0
        self._classes = {kind.__name__: kind for kind in classes}
        self._objects: list[Any] = []
        self._shapes: list[Shape] = []
        self._readers: dict[bytes, Callable[[], Any]] = {
            b"N": lambda: None, b"T": lambda: True, b"U": lambda: False,
            b"n": lambda: int.from_bytes(self._bytes(self._count()), "little", signed=True),
            b"f": lambda: FLOAT.unpack(self._bytes(8))[0],
            b"x": self._text, b"b": lambda: self._bytes(self._count()),
            b"e": self._member, b"g": lambda: self._array()[()], b"r": self._reference,
            b"l": self._list, b"t": lambda: self._late(self._members, tuple),
            b"q": self._deque, b"d": self._dict,
            b"s": lambda: self._late(self._plain_members, set),
            b"z": lambda: self._late(self._plain_members, frozenset),
            b"a": lambda: self._late(self._array), b"o": lambda: self._late(self._object_array),
            b"R": lambda: self._late(self._generator), b"i": self._instance,
        }  # fmt: skip

    def take(self) -> Any:
        """Read a value."""
        return self._readers[self._bytes(1)]()

    def _bytes(self, count: int) -> bytes:
        begin, self.place = self.place, self.place + count
        if self.place > len(self._content):
            raise DataFormatError(f"byte {begin}: {count} bytes expected, and the end came")
        return self._content[begin : self.place]

    def _count(self) -> int:
        return int(COUNT.unpack(self._bytes(COUNT.size))[0])

    def _many(self) -> range:
        """Read how many values follow; each has a byte at least."""
        count = self._count()
        if count > len(self._content) - self.place:
            raise DataFormatError(f"byte {self.place}: {count} values expected, and fewer bytes")
        return range(count)

    def _text(self) -> str:
        return self._bytes(self._count()).decode("utf-8", "surrogatepass")

    def _members(self) -> list[Any]:
        return [self.take() for _ in self._many()]

    def _plain_members(self) -> list[Any]:
        members = self._members()
        if not all(type(member) in PLAIN for member in members):
            raise DataFormatError(f"byte {self.place}: a set of more than numbers and texts")
        return members

    def _late(self, read: Callable[[], Any], make: Callable[[Any], Any] | None = None) -> Any:
        """Read what there is only once its parts are; it has a number before they have theirs."""
        number = len(self._objects)
        self._objects.append(_UNFINISHED)
        parts = read()
        self._objects[number] = parts if make is None else make(parts)
        return self._objects[number]

    def _early(self, made: Any) -> Any:
        self._objects.append(made)
        return made

    def _reference(self) -> Any:
        found = self._objects[self._count()]
        if found is _UNFINISHED:
            raise DataFormatError(f"byte {self.place}: a value within itself")
        return found

    def _list(self) -> list[Any]:
        made: list[Any] = self._early([])
        made += self._members()
        return made

    def _deque(self) -> deque[Any]:
        made: deque[Any] = self._early(deque(maxlen=self.take()))
        made += self._members()
        return made

    def _dict(self) -> dict[Any, Any]:
        made: dict[Any, Any] = self._early({})
        for _ in self._many():
            key = self.take()
            made[key] = self.take()
        return made

    def _array(self) -> Any:
        facts, n_axes = self._text(), self._bytes(1)[0]
        shape = tuple(self._count() for _ in range(n_axes))
        kind = np.dtype(facts[:-2])
        if kind.kind not in ARRAYS or facts[-2:] not in {"Cw", "Cr", "Fw", "Fr"}:
            raise DataFormatError(f"byte {self.place}: an array of {facts!r:.40}")
        order: Any = facts[-2]
        content = self._bytes(math.prod(shape) * kind.itemsize)
        found = np.empty(shape, kind, order)
        if content:
            # Into memory of its own, where numbers lie as kernels expect them.
            found[...] = np.frombuffer(content, kind).reshape(shape, order=order)
        found = found.astype(kind.newbyteorder("="), copy=False)
        found.flags.writeable = facts[-1] == "w"
        return found

    def _object_array(self) -> Any:
        shape, members = self.take(), self.take()
        made = np.empty(len(members), dtype=object)
        made[:] = members
        return made.reshape(shape)

    def _generator(self) -> np.random.Generator:
        name, state, entropy, key, size, spawned = (self.take() for _ in range(6))
        if name not in GENERATORS:
            raise DataFormatError(f"byte {self.place}: a generator by {name!r:.40}")
        seeds = np.random.SeedSequence(
            entropy, spawn_key=key, pool_size=size, n_children_spawned=spawned
        )
        bits = getattr(np.random, name)(seeds)
        bits.state = state
        return np.random.Generator(bits)

    def _member(self) -> Enum:
        kind, name = self._kind(self._text()), self._text()
        if not issubclass(kind, Enum):
            raise DataFormatError(f"byte {self.place}: a member of {kind.__name__}")
        return kind[name]

    def _instance(self) -> Any:
        number = self._count()
        if number == len(self._shapes):
            kind = self._kind(self._text())
            names = tuple(self._text() for _ in self._many())
            self._require_fields(kind, names)
            self._shapes.append(Shape(kind, names))
        shape = self._shapes[number]
        if issubclass(shape.kind, tuple):
            return self._late(
                lambda: [self.take() for _ in shape.names],
                lambda values: tuple.__new__(shape.kind, values),
            )
        made = self._early(object.__new__(shape.kind))
        own = getattr(made, "__dict__", None)
        for name in shape.names:
            if own is None:
                object.__setattr__(made, name, self.take())
            else:
                own[name] = self.take()
        return made

    def _require_fields(self, kind: type, names: tuple[str, ...]) -> None:
        """Refuse an object of a class that has other fields now."""
        expected: tuple[str, ...] | None = getattr(kind, "_fields", None)
        if is_dataclass(kind):
            expected = tuple(field.name for field in fields(kind))
        if expected is not None and set(names) != set(expected):
            raise DataFormatError(
                f"{kind.__name__} of {', '.join(names)}; expected {', '.join(expected)}: "
                "another version has written it"
            )

    def _kind(self, name: str) -> type:
        """Return the class of a name."""
        if name in self._classes:
            return self._classes[name]
        module, _, inner = name.partition(":")
        if module.split(".")[0] not in PACKAGES:
            raise DataFormatError(f"an object of class {name!r:.80}, which is none of ours")
        found: Any = import_module(f"trackweave.{module}")
        for part in inner.split("."):
            found = getattr(found, part)
        if not isinstance(found, type) or found.__module__ != f"trackweave.{module}":
            raise DataFormatError(f"an object of class {name!r:.80}, which is none of ours")
        return found
