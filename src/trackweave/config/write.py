"""A configuration as a commented file that reads back as the same values."""

import json
import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from textwrap import wrap
from typing import Any

from trackweave.config.fill import ANY_SENSOR, Settings
from trackweave.config.sections import ConfigurationSection
from trackweave.keys import Key

__all__ = ["WIDTH", "commented_toml"]

WIDTH = 110
"""Longest line of a comment."""
VALUE_WIDTH = 40
BARE = re.compile(r"[A-Za-z0-9_-]+")
# Filled from others that say more.
INSTEAD = {"clutter_density": "clutter_per_scan"}
NO_TABLE: Mapping[str, str] = {}
Path = tuple[str, ...]


def commented_toml(
    settings: Settings,
    *,
    head: Sequence[str] = (),
    remarks: Mapping[str, str] = NO_TABLE,
    doubts: Mapping[str, str] = NO_TABLE,
) -> str:
    """Return every key with its value, what it means and where the value came from."""
    # Remarks, by dotted key, go after where a value came from, such as how sure it is; doubts, by
    # sensor, say why its estimates are doubtful. Read back, the text says the same.
    lines = [line for sentence in head for line in _comment(sentence)]
    pen = _Pen(settings.sources, remarks)
    for name, value in settings.values.items():
        if not isinstance(value, Mapping):
            lines += ["", *pen.entry((name,), value, pen.origin((name,)))]
    for name, value in settings.values.items():
        if name == "sensors":
            lines += _sensors(value, pen, doubts)
        elif isinstance(value, Mapping):
            lines += pen.table((name,), value)
    return "\n".join(lines).lstrip("\n") + "\n"


def _sensors(
    sensors: Mapping[str, Mapping[str, Any]], pen: "_Pen", doubts: Mapping[str, str]
) -> list[str]:
    """Return the sensors' tables: what all agree on once, and each one's own."""
    lines, first = [], ("sensors", next(iter(sensors), ""))
    shared: dict[str, Any] = {}
    if len(sensors) > 1 and ANY_SENSOR not in sensors:
        shared = _shared(sensors, pen.sources)
        if _given(shared):
            lines += pen.table(("sensors", ANY_SENSOR), shared, like=first)
    for name, values in sensors.items():
        own = {key: value for key, value in values.items() if key not in shared}
        if own or name in doubts:
            above = [f"In doubt: {doubts[name]}."] if name in doubts else []
            lines += pen.table(("sensors", name), own, above=above)
    return lines


def _shared(
    sensors: Mapping[str, Mapping[str, Any]], sources: Mapping[str, str]
) -> dict[str, Any]:
    """Return the keys on whose value all sensors agree, and on where it came from."""

    def told(name: str, key: str) -> tuple[Any, ...]:
        return key in sensors[name], sensors[name].get(key), sources.get(f"sensors.{name}.{key}")

    first, *others = sensors
    return {
        key: value
        for key, value in sensors[first].items()
        if all(told(name, key) == told(first, key) for name in others)
    }


@dataclass(frozen=True, slots=True)
class _Pen:
    """Writes tables, with where each value came from and what is to be said of it."""

    sources: Mapping[str, str]
    remarks: Mapping[str, str]

    def origin(self, place: Path) -> str:
        """Return where a value came from, and what is to be said of it."""
        parts = (table.get(".".join(place), "") for table in (self.sources, self.remarks))
        return ": ".join(filter(None, parts))

    def table(
        self, path: Path, values: Mapping[str, Any], *, above: Iterable[str] = (), like: Path = ()
    ) -> list[str]:
        """Return a table's lines: its heading, then its keys, then the tables inside."""
        # The values came from where those of the table ``like`` it did.
        lines = ["", *(line for sentence in above for line in _comment(sentence))]
        lines.append("[" + ".".join(map(_key, path)) + "]")
        inside = []
        for key, value in values.items():
            if key in INSTEAD and values.get(INSTEAD[key]) is not None:
                continue
            place, origin = (*path, key), self.origin((*(like or path), key))
            if not isinstance(value, Mapping) or (path[0], key) == ("sensors", "sigma"):
                lines += self.entry(place, value, origin)
            elif _given(value):
                # Chosen as a whole, so that it is said once where it came from.
                said = [origin] if origin.startswith("estimated") else []
                inside += self.table(place, value, above=said)
        return lines + inside

    @staticmethod
    def entry(place: Path, value: Any, origin: str) -> list[str]:
        """Return a key's lines; a key without a value is shown as a comment."""
        said = _comment(_meaning(place).replace("``", "`"))
        if value is None:
            return [*said, f"# {_key(place[-1])} = …  # left out"]
        text = f"{_key(place[-1])} = {_value(value)}"
        return [*said, f"{text:<{VALUE_WIDTH}}  # {origin}" if origin else text]


def _given(values: Mapping[str, Any]) -> bool:
    return any(value is not None for value in values.values())


def _meaning(place: Path) -> str:
    """Return what a key means; nothing for a solver's option."""
    table: Any = ConfigurationSection.as_kind(Key())
    for name in place[:-1]:
        entry = table.entries.get(name)
        table = entry.kind if entry else table.others
    entry = table.entries.get(place[-1])
    return entry.meaning if entry else ""


def _comment(sentence: str) -> list[str]:
    """Return a sentence as lines of a comment, whatever characters it holds."""
    clean = "".join(letter if letter.isprintable() else " " for letter in sentence)
    return [f"# {line}" for line in wrap(clean, WIDTH - 2)]


def _key(name: str) -> str:
    return name if BARE.fullmatch(name) else _text(name)


def _text(value: str) -> str:
    """Return a text in quotation marks; TOML's escapes are those of JSON, and one more."""
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")


def _value(value: Any) -> str:
    """Return a value as TOML; a number keeps every digit."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return _text(value)
    if isinstance(value, Mapping):
        given = {key: part for key, part in value.items() if part is not None}
        return "{" + ", ".join(f"{_key(k)} = {_value(v)}" for k, v in given.items()) + "}"
    if isinstance(value, Sequence):
        return "[" + ", ".join(map(_value, value)) + "]"
    if isinstance(value, float):
        # Numbers of NumPy call themselves by another name.
        return repr(float(value)) if math.isfinite(value) else str(float(value))
    return str(int(value))
