"""A configuration as a commented file that reads back as the same values."""

import json
import math
import re
from collections.abc import Iterable, Mapping, Sequence
from textwrap import wrap
from typing import Any

from pydantic import BaseModel

from trackweave.config.fill import ANY_SENSOR, Settings
from trackweave.config.search import DEFAULT_METHOD, options_model
from trackweave.config.sections import Configuration, SensorSection

__all__ = ["WIDTH", "commented_toml"]

WIDTH = 110
"""Longest line of a comment."""
VALUE_WIDTH = 40
BARE = re.compile(r"[A-Za-z0-9_-]+")
# Filled from others that say more.
INSTEAD = {"clutter_density": "clutter_per_scan"}
NO_TABLE: Mapping[str, str] = {}
Places = dict[tuple[str, ...], tuple[str, ...]]


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
    fields = Configuration.model_fields
    for name, value in settings.values.items():
        if not isinstance(value, Mapping):
            text = fields[name].description or ""
            lines += ["", *_entry((name,), value, text, _origin((name,), settings, remarks))]
    for name, value in settings.values.items():
        if name == "sensors":
            lines += _sensors(value, settings, remarks, doubts)
        elif isinstance(value, Mapping):
            lines += _table((name,), value, _model(fields[name].annotation), settings, remarks)
    return "\n".join(lines).lstrip("\n") + "\n"


def _sensors(
    sensors: Mapping[str, Mapping[str, Any]],
    settings: Settings,
    remarks: Mapping[str, str],
    doubts: Mapping[str, str],
) -> list[str]:
    """Return the sensors' tables: what all agree on once, and each one's own."""
    lines = []
    shared: dict[str, Any] = {}
    if len(sensors) > 1 and ANY_SENSOR not in sensors:
        shared = _shared(sensors, settings)
        if any(value is not None for value in shared.values()):
            like: Places = {("sensors", ANY_SENSOR, key): _first(sensors, key) for key in shared}
            lines += _table(
                ("sensors", ANY_SENSOR), shared, SensorSection, settings, remarks, like=like
            )
    for name, values in sensors.items():
        own = {key: value for key, value in values.items() if key not in shared}
        if not own and name not in doubts:
            continue
        above = [f"In doubt: {doubts[name]}."] if name in doubts else []
        lines += _table(("sensors", name), own, SensorSection, settings, remarks, above=above)
    return lines


def _shared(sensors: Mapping[str, Mapping[str, Any]], settings: Settings) -> dict[str, Any]:
    """Return the keys on whose value all sensors agree, and on where it came from."""
    first, *others = sensors
    shared = {}
    for key, value in sensors[first].items():
        origin = settings.sources.get(f"sensors.{first}.{key}")
        if all(
            sensors[name].get(key) == value
            and key in sensors[name]
            and settings.sources.get(f"sensors.{name}.{key}") == origin
            for name in others
        ):
            shared[key] = value
    return shared


def _first(sensors: Mapping[str, Any], key: str) -> tuple[str, ...]:
    return ("sensors", next(iter(sensors)), key)


def _table(  # noqa: PLR0913 what a table is made of
    path: tuple[str, ...],
    values: Mapping[str, Any],
    model: type[BaseModel] | None,
    settings: Settings,
    remarks: Mapping[str, str],
    *,
    above: Iterable[str] = (),
    like: Places | None = None,
) -> list[str]:
    """Return a table's lines: its heading, then its keys, then the tables inside."""
    lines = ["", *(line for sentence in above for line in _comment(sentence))]
    lines.append("[" + ".".join(map(_key, path)) + "]")
    inside = []
    known = _described(path, model)
    for key, value in values.items():
        if key in INSTEAD and values.get(INSTEAD[key]) is not None:
            continue
        place = (*path, key)
        origin = _origin((like or {}).get(place, place), settings, remarks)
        if isinstance(value, Mapping) and place != ("sensors", path[-1], "sigma"):
            if _given(value):
                # Chosen as a whole, so that it is said once where it came from.
                said = [origin] if origin.startswith("estimated") else []
                inner = _inner(model, key)
                inside += _table(place, value, inner, settings, remarks, above=said)
            continue
        lines += _entry(place, value, known.get(key, ""), origin)
    return lines + inside


def _given(values: Mapping[str, Any]) -> bool:
    return any(value is not None for value in values.values())


def _described(path: tuple[str, ...], model: type[BaseModel] | None) -> dict[str, str]:
    """Return what each key of a table means, as far as the section says."""
    fields = dict(model.model_fields) if model is not None else {}
    if path == ("search",):
        fields = {**options_model(DEFAULT_METHOD).model_fields, **fields}
    return {name: field.description or "" for name, field in fields.items()}


def _inner(model: type[BaseModel] | None, key: str) -> type[BaseModel] | None:
    field = model.model_fields.get(key) if model is not None else None
    return None if field is None else _model(field.annotation)


def _model(annotation: Any) -> type[BaseModel] | None:
    """Return the section among what a key may be, None where there is none."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    inner = getattr(annotation, "__args__", ())
    return next((found for part in inner if (found := _model(part)) is not None), None)


def _origin(place: tuple[str, ...], settings: Settings, remarks: Mapping[str, str]) -> str:
    """Return where a value came from, and what is to be said of it."""
    key = ".".join(place)
    source = settings.sources.get(key, "")
    remark = remarks.get(key, "")
    return ": ".join(part for part in (source, remark) if part)


def _entry(place: tuple[str, ...], value: Any, meaning: str, origin: str) -> list[str]:
    """Return a key's lines; a key without a value is shown as a comment."""
    said = _comment(meaning.replace("``", "`")) if meaning else []
    if value is None:
        return [*said, f"# {_key(place[-1])} = …  # left out"]
    text = f"{_key(place[-1])} = {_value(value)}"
    return [*said, f"{text:<{VALUE_WIDTH}}  # {origin}" if origin else text]


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
