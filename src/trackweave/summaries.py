"""What a result says of itself in a line or a few: never its whole content."""

from collections.abc import Collection, Sized
from dataclasses import fields
from typing import Any

import numpy as np

__all__ = ["counted", "summary"]

MOST_CHARACTERS, MOST_MEMBERS = 80, 4


def summary(value: Any) -> str:
    """Return a dataclass in one line; stands in a class as its ``__repr__``."""
    # Of whatever holds more than a few values the size alone.
    parts = [f"{field.name}={_brief(getattr(value, field.name))}" for field in fields(value)]
    return f"{type(value).__name__}({', '.join(parts)})"


def counted(count: int, thing: str) -> str:
    """Return a count in words, such as 1 report, or 1,200 reports."""
    return f"{count:,} {thing}{'' if count == 1 else 's'}"


def _brief(value: Any) -> str:
    """Return a value as part of a line."""
    if isinstance(value, np.ndarray):
        if value.ndim == 1 and 0 < value.size <= MOST_MEMBERS:
            return str(value.tolist())
        return f"array of {'×'.join(map(str, value.shape)) or 'one value'}"
    if hasattr(type(value), "__dataclass_fields__") and isinstance(value, Sized):
        return f"{type(value).__name__} of {counted(len(value), 'row')}"
    if isinstance(value, Collection) and not isinstance(value, str) and len(value) > MOST_MEMBERS:
        return f"{type(value).__name__} of {len(value):,}"
    text = repr(value)
    return text if len(text) <= MOST_CHARACTERS else f"{text[: MOST_CHARACTERS - 1]}…"
