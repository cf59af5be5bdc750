"""The record of a run as JSON."""

import json
import math
from collections.abc import Mapping
from enum import Enum
from pathlib import PurePath
from typing import Any

import numpy as np

__all__ = ["encode_json"]


def encode_json(document: Mapping[str, Any]) -> bytes:
    """Return a document as JSON text: the same document always the same bytes.

    Keys keep their order. Numbers that are not finite become null; NumPy's numbers and arrays,
    enumerations and paths become numbers, lists and text. A list of objects, such as that of the
    scans, takes one line per object.

    Parameters
    ----------
    document
        The document.

    Returns
    -------
    UTF-8 text that ends in a line break.
    """
    lines = [f"  {_dump(str(key))}: {_value(item)}" for key, item in document.items()]
    # Lone surrogates, which file names may have, survive only as escapes.
    return ("{\n" + ",\n".join(lines) + "\n}\n").encode("utf-8", "backslashreplace")


def _value(item: Any) -> str:
    # Object by object: a long run lists tens of thousands of scans.
    if isinstance(item, list) and item and all(isinstance(entry, Mapping) for entry in item):
        return "[\n    " + ",\n    ".join(_dump(_plain(entry)) for entry in item) + "\n  ]"
    plain = _plain(item)
    if isinstance(plain, dict) and plain:
        entries = [f"    {_dump(key)}: {_dump(entry)}" for key, entry in plain.items()]
        return "{\n" + ",\n".join(entries) + "\n  }"
    return _dump(plain)


_AS_IT_IS = frozenset({bool, int, str})
_dump = json.JSONEncoder(ensure_ascii=False, allow_nan=False).encode


def _plain(item: Any) -> Any:
    """Return the same value made of what JSON knows."""
    # What nearly everything is comes first: a long run lists a million numbers.
    if item is None or type(item) in _AS_IT_IS:
        return item
    if isinstance(item, Enum):
        return _plain(item.value)
    if isinstance(item, np.ndarray | np.generic):
        return _plain(item.tolist())
    if isinstance(item, float):
        return item if math.isfinite(item) else None
    if isinstance(item, (dict, Mapping)):
        return {str(_plain(key)): _plain(value) for key, value in item.items()}
    if isinstance(item, list | tuple):
        return [_plain(entry) for entry in item]
    if isinstance(item, set | frozenset):
        return sorted(_plain(entry) for entry in item)
    if isinstance(item, int | str):
        return item
    if isinstance(item, PurePath):
        return str(item)
    raise TypeError(f"{type(item).__name__}: expected something that JSON knows")
