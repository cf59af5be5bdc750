"""Keys that are swept: lists and ranges of values, and the points that they make together."""

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np

from trackweave.errors import InvalidInputError
from trackweave.keys import show_value

__all__ = ["Point", "Sweep", "merged", "nested", "sweeps_of"]

MOST_VALUES = 100_000
"""A range has so many values at most."""
_RANGE = frozenset({"from", "to", "step", "count", "scale"})
_EXPECTED = (
    "expected a list of values, or a range such as {from = 1, to = 9, step = 2} or "
    '{from = 1e-6, to = 1e-3, count = 4, scale = "logarithmic"}'
)

Path = tuple[str, ...]
Point = Mapping[Path, Any]
"""One value for each swept key."""


@dataclass(frozen=True, slots=True)
class Sweep:
    """The swept keys of one scenario or configuration, each with its values."""

    keys: Mapping[Path, tuple[Any, ...]]

    def __len__(self) -> int:
        return math.prod(len(values) for values in self.keys.values())

    def values(self) -> Iterator[Point]:
        """Yield each value once, beside the first of all other keys."""
        first = {key: values[0] for key, values in self.keys.items()}
        for key, values in self.keys.items():
            yield from ({**first, key: value} for value in values)

    def points(self) -> Iterator[Point]:
        """Yield each combination of values, the last key's the fastest."""
        for values in product(*self.keys.values()):
            yield dict(zip(self.keys, values, strict=True))


def sweeps_of(table: Mapping[str, Any], fixed: Mapping[str, Any], where: str) -> Sweep:
    """Return what a table ``sweep`` says.

    Parameters
    ----------
    table
        Nested as the keys are, with a list or a range for each.
    fixed
        Keys that have one value, nested alike: none of them may be swept too.
    where
        What messages call the table.

    Returns
    -------
    The values of each key.

    Raises
    ------
    InvalidInputError
        If a sweep is none, names a value twice, or contradicts what is fixed.
    """
    keys: dict[Path, tuple[Any, ...]] = {}
    for path, given in _leaves(table):
        name = f"{where}.{'.'.join(path)}"
        keys[path] = _values(given, name)
        at: Any = fixed
        for part in path:
            at = at.get(part) if isinstance(at, Mapping) else None
        if at is not None:
            raise InvalidInputError(
                f"{name}: swept and also set to {show_value(at)}; expected one of the two"
            )
    return Sweep(keys)


def nested(point: Point) -> dict[str, Any]:
    """Return a point's values, nested as in a file."""
    found: dict[str, Any] = {}
    for path, value in point.items():
        table = found
        for part in path[:-1]:
            table = table.setdefault(part, {})
        table[path[-1]] = value
    return found


def merged(below: Mapping[str, Any], above: Mapping[str, Any]) -> dict[str, Any]:
    """Return nested tables with another's values laid over them."""
    found = dict(below)
    for key, value in above.items():
        under = found.get(key)
        both = isinstance(value, Mapping) and isinstance(under, Mapping)
        found[key] = merged(under, value) if both else value  # type: ignore[arg-type]
    return found


def _leaves(table: Mapping[str, Any], path: Path = ()) -> Iterator[tuple[Path, Any]]:
    for key, value in table.items():
        if isinstance(value, Mapping) and not (value.keys() <= _RANGE and "from" in value):
            yield from _leaves(value, (*path, key))
        else:
            yield (*path, key), value


def _values(given: Any, name: str) -> tuple[Any, ...]:
    if isinstance(given, Mapping):
        return _range(given, name)
    if isinstance(given, str) or not isinstance(given, Sequence) or not given:
        raise InvalidInputError(f"{name}: {show_value(given)}; {_EXPECTED}")
    twice = [one for number, one in enumerate(given) if _told(one) in map(_told, given[:number])]
    if twice:
        raise InvalidInputError(
            f"{name}: {show_value(twice[0])} comes twice; expected each value once"
        )
    return tuple(given)


def _told(value: Any) -> str:
    return json.dumps(value, sort_keys=True, default=str)


def _range(given: Mapping[str, Any], name: str) -> tuple[int | float, ...]:
    said = show_value(given)
    ends = [given.get("from"), given.get("to")]
    step, count, scale = given.get("step"), given.get("count"), given.get("scale", "linear")
    numbers = [each for each in (*ends, step) if each is not None]
    is_bad = None in ends or (step is None) == (count is None)
    is_bad |= any(isinstance(n, bool) or not isinstance(n, int | float) for n in numbers)
    is_bad |= scale not in {"linear", "logarithmic"} or (scale != "linear" and step is not None)
    is_bad |= count is not None and not (type(count) is int and 2 <= count <= MOST_VALUES)
    if is_bad:
        raise InvalidInputError(f"{name}: {said}; {_EXPECTED}")
    low, high = float(given["from"]), float(given["to"])
    if not (math.isfinite(low) and math.isfinite(high) and low < high):
        raise InvalidInputError(f"{name}: {said}; expected from below to")
    if scale == "logarithmic":
        if low <= 0:
            raise InvalidInputError(
                f"{name}: {said}; expected from above 0 on a logarithmic scale"
            )
        return tuple(float(each) for each in np.geomspace(low, high, int(count or 0)))
    if step is None:
        even = np.linspace(low, high, int(count or 0))
        # Whole numbers stay so, for keys that are.
        is_whole = all(type(end) is int for end in ends) and bool(np.all(even == np.rint(even)))
        return tuple(even.astype(np.int64).tolist() if is_whole else even.tolist())
    if not 0 < step <= high - low or (high - low) / step >= MOST_VALUES:
        raise InvalidInputError(
            f"{name}: {said}; expected a step above 0, from one to {MOST_VALUES:,} times"
        )
    steps = [
        given["from"] + number * step for number in range(int((high - low) / step + 1e-9) + 1)
    ]
    return tuple(steps)
