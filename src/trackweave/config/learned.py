"""What an earlier recording told of sensors and objects; it counts where nothing else is said."""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

from trackweave.config.fill import ANY_SENSOR
from trackweave.config.load import Configuration

__all__ = ["LEARNED", "learned_keys", "learned_sources", "with_learned"]

LEARNED = "learned"
"""Where a value comes from that was learned of an earlier recording."""
TABLES = ("motion", "lifecycle")
# How many objects there are when a recording begins is of that recording.
PASSING = {"initial_target_density"}
FROM_REPORTS = ("estimated", LEARNED)
# Of the two ways to tell the clutter, what is told wins.
INSTEAD = {"clutter_density": "clutter_per_scan"}


def learned_keys(values: Mapping[str, Any], sources: Mapping[str, str]) -> dict[str, Any]:
    """Return the keys of a complete configuration that reports told, nested as in a file."""
    found = {name: _from_reports(values.get(name, {}), name, sources) for name in TABLES}
    sensors = {
        name: _from_reports(table, f"sensors.{name}", sources)
        for name, table in values.get("sensors", {}).items()
    }
    found["sensors"] = {name: table for name, table in sensors.items() if table}
    return {name: table for name, table in found.items() if table}


def _from_reports(
    table: Mapping[str, Any], path: str, sources: Mapping[str, str]
) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for key, value in table.items():
        source = sources.get(f"{path}.{key}")
        if source is None and isinstance(value, Mapping):
            inside = _from_reports(value, f"{path}.{key}", sources)
            found |= {key: inside} if inside else {}
        elif source in FROM_REPORTS and value is not None and key not in PASSING:
            found[key] = value
    return found


def with_learned(told: Configuration, learned: Configuration) -> Configuration:
    """Return a configuration with what ``init --learn`` wrote where it is silent."""
    # Whatever it says itself counts. It knows what of it was learned.
    tables: dict[str, Mapping[str, Any]] = {}
    for name in TABLES:
        tables[name] = _beneath(told.table(name), learned.table(name), {})
    sensors, usual = told.table("sensors"), told.table("sensors", ANY_SENSOR)
    for name, known in learned.table("sensors").items():
        above = {} if name == ANY_SENSOR else usual
        sensors[name] = _beneath(sensors.get(name, {}), known, above)
    tables["sensors"] = sensors
    frame = told.table("frame") or learned.table("frame")
    tables |= {"frame": frame} if frame else {}
    tables = {name: table for name, table in tables.items() if table}
    entered = frozenset(_paths(tables)) - frozenset(_paths(told.values))
    return replace(told.changed(**tables), learned=entered)


def _beneath(
    told: Mapping[str, Any], known: Mapping[str, Any], above: Mapping[str, Any]
) -> dict[str, Any]:
    said = {**above, **told}
    free = {
        key: value
        for key, value in known.items()
        if key not in said and INSTEAD.get(key) not in said
    }
    # Ways to move, and their noises, belong to the model that they were learned with.
    if "model" in said:
        free = {key: value for key, value in free.items() if key != "imm"}
    return {**free, **told}


def _paths(table: Mapping[str, Any], path: str = "") -> Iterator[str]:
    for key, value in table.items():
        yield path + key
        if isinstance(value, Mapping):
            yield from _paths(value, f"{path}{key}.")


def learned_sources(sources: Mapping[str, str], configuration: Configuration) -> dict[str, str]:
    """Return where each value came from, those that were learned before told from a file's."""
    return {
        key: LEARNED if source == "file" and key in configuration.learned else source
        for key, source in sources.items()
    }
