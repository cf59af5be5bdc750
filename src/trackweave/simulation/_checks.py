"""Checks of a scenario's values, worded alike: key, value, what was expected."""

import math
from collections.abc import Sequence

from trackweave.errors import InvalidInputError

__all__ = ["flag", "number", "text", "vector", "whole"]

LONGEST_NAME = 256
"""Bytes of a name, as files of reports may have."""


def number(
    value: object, key: str, *, above: float = -math.inf, low: float = -math.inf,
    high: float = math.inf,
) -> float:  # fmt: skip
    """Return a finite number with ``above < value`` and ``low <= value <= high``."""
    parts = []
    if above > -math.inf:
        parts.append(f"above {above:g}")
    if low > -math.inf:
        parts.append(f"of at least {low:g}")
    if high < math.inf:
        parts.append(f"of at most {high:g}")
    if _is_number(value):
        found = _as_float(value)
        if math.isfinite(found) and found > above and low <= found <= high:
            return found
    wanted = f"a number {' and '.join(parts)}" if parts else "a finite number"
    raise InvalidInputError(f"{key}: {value!r:.80}; expected {wanted}")


def whole(value: object, key: str, low: int, high: int | None = None) -> int:
    """Return a whole number that is at least ``low`` and at most ``high``."""
    is_whole = isinstance(value, int) or hasattr(value, "__index__")
    if is_whole and not isinstance(value, bool) and int(value) >= low:  # type: ignore[call-overload]
        if high is not None and int(value) > high:  # type: ignore[call-overload]
            raise InvalidInputError(f"{key}: {value!r:.80}; expected at most {high}")
        return int(value)  # type: ignore[call-overload,no-any-return]
    raise InvalidInputError(f"{key}: {value!r:.80}; expected a whole number of at least {low}")


def vector(value: object, key: str, dim: int | None = None) -> tuple[float, ...]:
    """Return so many finite numbers, two or three where none is said."""
    wanted = "two or three" if dim is None else {1: "one", 2: "two", 3: "three"}[dim]
    lengths = (2, 3) if dim is None else (dim,)
    items = _items(value)
    if items is not None and len(items) in lengths and all(_is_number(item) for item in items):
        numbers = tuple(_as_float(item) for item in items)
        if all(math.isfinite(item) for item in numbers):
            return numbers
    raise InvalidInputError(f"{key}: {value!r:.80}; expected {wanted} finite numbers")


def text(value: object, key: str) -> str:
    """Return a text that is not empty."""
    if isinstance(value, str) and value.strip() == value != "" and value.isprintable():
        if len(value.encode()) <= LONGEST_NAME:
            return value
        raise InvalidInputError(f"{key}: {value!r:.80}; expected at most {LONGEST_NAME} bytes")
    raise InvalidInputError(
        f"{key}: {value!r:.80}; expected a text that is not empty, without blanks around it or "
        "line breaks in it"
    )


def flag(value: object, key: str) -> bool:
    """Return true or false."""
    if isinstance(value, bool):
        return value
    raise InvalidInputError(f"{key}: {value!r:.80}; expected true or false")


def _is_number(value: object) -> bool:
    # NumPy's scalars are numbers too; true and false are not.
    return hasattr(value, "__float__") and not isinstance(value, bool | str)


def _as_float(value: object) -> float:
    try:
        return float(value)  # type: ignore[arg-type]  # a number, as _is_number says
    except (OverflowError, TypeError, ValueError):
        return math.nan


def _items(value: object) -> list[object] | None:
    if isinstance(value, Sequence) and not isinstance(value, str | bytes):
        return list(value)
    if hasattr(value, "tolist"):
        listed = value.tolist()
        return listed if isinstance(listed, list) else None
    return None
