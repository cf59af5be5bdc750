"""Values and unknown words, as messages show them."""

import difflib
import json
from collections.abc import Mapping, Sequence
from typing import Any

__all__ = ["show_value", "suggest"]


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
