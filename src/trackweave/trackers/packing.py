"""Values as bytes and back: numbers, texts, containers, arrays, generators and our own classes.

Nothing in the bytes is run. A class is named, and has to be one of a given few or of the packages
in ``PACKAGES``; an object is made of its attributes alone. What is one object stays one. The same
value gives the same bytes: sets are sorted, and ``at_rest()`` of a class that has it tells the
attributes without what is only room.
"""

import struct
from collections import deque
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import fields, is_dataclass
from enum import Enum
from typing import Any, NamedTuple

import numpy as np

from trackweave.errors import InvalidInputError

__all__ = ["ARRAYS", "COUNT", "FLOAT", "GENERATORS", "PACKAGES", "PLAIN", "Shape", "packed"]

PACKAGES = ("association", "domain", "estimation", "models", "solvers", "trackers")
"""Classes of these of our packages are known by name."""
GENERATORS = ("MT19937", "PCG64", "PCG64DXSM", "Philox", "SFC64")
"""Sources of random bits."""
ARRAYS = "biufcUSMm"
"""Kinds of arrays whose entries are bytes."""
PLAIN = (type(None), bool, int, float, str, bytes)
COUNT, FLOAT = struct.Struct("<Q"), struct.Struct("<d")
_HELD = "numbers, texts, containers, arrays, generators and objects of trackweave's classes"


class Shape(NamedTuple):
    """A class, and the names of an object's attributes."""

    kind: type
    names: tuple[str, ...]


def packed(value: Any, classes: Sequence[type] = ()) -> bytes:
    """Return a value as bytes.

    Parameters
    ----------
    value
        The value.
    classes
        Classes of others whose objects it may hold; they are known by their names.

    Returns
    -------
    The bytes; the same value gives the same.

    Raises
    ------
    InvalidInputError
        If it holds something else; the message says where.
    """
    packer = _Packer(classes)
    packer.put(value)
    return b"".join(packer.parts)


class _Packer:
    """Collects the parts of a value's bytes."""

    def __init__(self, classes: Sequence[type]) -> None:
        self.parts: list[bytes] = []
        self._classes = {kind: kind.__name__ for kind in classes}
        self._numbers: dict[int, int] = {}
        self._held: list[Any] = []
        """What has a number: as long as an object is held nobody else has its id."""
        self._shapes: dict[Shape, int] = {}
        self._path: list[str] = []

    def put(self, value: Any, under: str = "") -> None:
        """Append a value; ``under`` is what it is of the one that holds it."""
        self._path.append(under)
        kind = type(value)
        if kind in PLAIN:
            self.parts.append(_plain(value))
        elif isinstance(value, Enum):
            self.parts += (b"e", _text(self._name(kind)), _text(value.name))
        elif isinstance(value, np.generic):
            self._put_array(b"g", np.asarray(value))
        elif id(value) in self._numbers:
            self.parts += (b"r", COUNT.pack(self._numbers[id(value)]))
        else:
            self._numbers[id(value)] = len(self._held)
            self._held.append(value)
            self._put_object(value, kind)
        self._path.pop()

    def _put_object(self, value: Any, kind: type) -> None:
        if kind in {list, tuple}:
            self._put_all(b"l" if kind is list else b"t", value)
        elif kind is deque:
            self._put_all(b"q" + _plain(value.maxlen), value)
        elif kind is dict:
            self._put_items(value)
        elif kind in {set, frozenset}:
            self._put_set(value)
        elif kind is np.ndarray and value.dtype.kind in ARRAYS:
            self._put_array(b"a", value)
        elif kind is np.ndarray and value.dtype == object:
            self._put_parts(b"o", value.shape, value.ravel().tolist())
        elif kind is np.random.Generator:
            self._put_generator(value.bit_generator)
        else:
            self._put_instance(value, kind)

    def _put_parts(self, tag: bytes, *values: Any) -> None:
        self.parts.append(tag)
        for value in values:
            self.put(value)

    def _put_all(self, tag: bytes, values: Iterable[Any]) -> None:
        members = list(values)
        self.parts += (tag, COUNT.pack(len(members)))
        for place, member in enumerate(members):
            self.put(member, f"[{place}]")

    def _put_items(self, value: Mapping[Any, Any]) -> None:
        self.parts += (b"d", COUNT.pack(len(value)))
        for key, held in value.items():
            self.put(key)
            self.put(held, f"[{key!r:.40}]")

    def _put_set(self, value: Any) -> None:
        if not all(type(member) in PLAIN for member in value):
            raise self._refusal("a set of more than numbers and texts")
        self.parts += (b"s" if type(value) is set else b"z", COUNT.pack(len(value)))
        self.parts += sorted(map(_plain, value))

    def _put_array(self, tag: bytes, array: np.ndarray[Any, Any]) -> None:
        # Kernels differ by layout and by what may be written, and sums by order.
        is_turned = array.flags.f_contiguous and not array.flags.c_contiguous
        order, use = "F" if is_turned else "C", "w" if array.flags.writeable else "r"
        shape = b"".join(map(COUNT.pack, array.shape))
        content = array.tobytes("F" if is_turned else "C")
        self.parts += (tag, _text(array.dtype.str + order + use), bytes([array.ndim]), shape)
        self.parts.append(content)

    def _put_generator(self, bits: Any) -> None:
        name, seeds = type(bits).__name__, bits.seed_seq
        if name not in GENERATORS or type(seeds) is not np.random.SeedSequence:
            raise self._refusal(f"a generator by {name}")
        own = (seeds.entropy, seeds.spawn_key, seeds.pool_size, seeds.n_children_spawned)
        self._put_parts(b"R", name, bits.state, *own)

    def _put_instance(self, value: Any, kind: type) -> None:
        name, state = self._name(kind), _state(value)
        if state is None:
            raise self._refusal(f"a {name}")
        shape = Shape(kind, tuple(state))
        number = self._shapes.get(shape)
        self.parts += (b"i", COUNT.pack(len(self._shapes) if number is None else number))
        if number is None:
            self._shapes[shape] = len(self._shapes)
            self.parts += (_text(name), COUNT.pack(len(state)), *map(_text, state))
        for attribute, held in state.items():
            self.put(held, f".{attribute}")

    def _name(self, kind: type) -> str:
        """Return under which name a class is found again."""
        if kind in self._classes:
            return self._classes[kind]
        top, _, module = kind.__module__.partition(".")
        if top == "trackweave" and module.split(".")[0] in PACKAGES:
            return f"{module}:{kind.__qualname__}"
        raise self._refusal(f"a {kind.__module__}.{kind.__qualname__}")

    def _refusal(self, found: str) -> InvalidInputError:
        place = "".join(self._path).lstrip(".") or "value"
        return InvalidInputError(f"{place}: {found}; a checkpoint holds {_HELD}")


def _state(value: Any) -> dict[str, Any] | None:
    """Return an object's attributes, None where it has others than by name."""
    if isinstance(value, tuple):
        names: tuple[str, ...] | None = getattr(value, "_fields", None)
        return None if names is None else dict(zip(names, value, strict=True))
    if isinstance(value, type):
        return None
    if hasattr(value, "at_rest"):
        rest: dict[str, Any] = value.at_rest()
        return rest
    if is_dataclass(value) and not hasattr(value, "__dict__"):
        return {field.name: getattr(value, field.name) for field in fields(value)}
    state = value.__getstate__()
    if isinstance(state, dict):
        return state
    return {} if state is None and hasattr(value, "__dict__") else None


def _text(text: str) -> bytes:
    content = text.encode("utf-8", "surrogatepass")
    return COUNT.pack(len(content)) + content


def _plain(value: Any) -> bytes:
    """Return a number, a text, bytes, a truth or None."""
    if value is None:
        return b"N"
    if isinstance(value, bool):
        return b"T" if value else b"U"
    if isinstance(value, int):
        length = value.bit_length() // 8 + 1
        return b"n" + COUNT.pack(length) + value.to_bytes(length, "little", signed=True)
    if isinstance(value, float):
        return b"f" + FLOAT.pack(value)
    return b"x" + _text(value) if isinstance(value, str) else b"b" + COUNT.pack(len(value)) + value
