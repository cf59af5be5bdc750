"""What a field takes as a key of a file: its range, and the words that a message says of it.

A field whose annotation carries a ``Key`` is a key of the file: ``Annotated[float, SECONDS]``.
Checking, the JSON schema and the comments of written files follow from that, from the field's type
and from what the class's docstring says under Parameters.
"""

import difflib
import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Any, TypeAlias

__all__ = [
    "ABOVE_ZERO",
    "ANGLE_NOISE",
    "AT_LEAST_ZERO",
    "COORDINATE",
    "COUNT",
    "DENSITY",
    "NOISE",
    "POSITIVE",
    "PROBABILITY",
    "SECONDS",
    "SPEED",
    "Key",
    "Pair",
    "show_value",
    "suggest",
]


@dataclass(frozen=True, slots=True)
class Key:
    """What is expected of a value, beyond its type.

    Parameters
    ----------
    expected
        What a message says after "expected"; empty to go by the type.
    least, most
        Limits of a number, both included.
    size
        Least and greatest length of a list.
    words
        The only texts; empty for any.
    holds
        What else must be true of a value of the right type.
    is_open
        Whether ``most`` is for files alone, against slips, and programs may go beyond.
    """

    expected: str = ""
    least: float = -math.inf
    most: float = math.inf
    size: tuple[int, float] = (0, math.inf)
    words: tuple[str, ...] = ()
    holds: Callable[[Any], bool] | None = None
    is_open: bool = False

    def said(self, expected: str) -> "Key":
        """Return the same in other words."""
        return replace(self, expected=expected)


ABOVE_ZERO = Key("a number above 0", math.ulp(0.0))
AT_LEAST_ZERO = Key("a number of at least 0", 0)
# The ranges of tracker.toml end where nothing real goes on, far from where squares and products of
# 16 digits do.
POSITIVE = Key("a number > 0", 1e-9, 1e9)
"""What is counted or compared: false alarms of a scan, distances in units of noise, nats."""
NOISE = Key("a number > 0 in metres", 1e-9, 1e9)
ANGLE_NOISE = Key("a number > 0 of degrees, at most 180", 1e-9, 180.0)
DENSITY = Key("a number > 0", 1e-30, 1e30)
"""From one in a cube of ten million kilometres to one in that of an atom."""
SECONDS = Key("a number > 0 in seconds", 1e-6, 1e9)
"""From the last digit of times since 1970, a microsecond, to three decades."""
SPEED = Key("a number > 0 in m/s", 1e-12, 3e8)
"""From a thirtieth of a millimetre a year to light."""
PROBABILITY = Key("a number between 0 and 1", 1e-12, 1 - 1e-12)
"""Beyond are certainties, which no number of reports could amend."""
COUNT = Key("a whole number from 1 to 1000", 1, 1000)
COORDINATE = Key("a number", -1e9, 1e9)
Pair: TypeAlias = Annotated[
    tuple[Annotated[float, COORDINATE], ...],
    Key("two finite numbers in brackets, such as [0.0, 0.0]", size=(2, 2)),
]
"""A place on the plane [m]."""


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
