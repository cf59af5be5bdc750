"""The configuration's JSON Schema, for editors that check and complete."""

from typing import Any

from trackweave.config.search import options_of
from trackweave.config.sections import ConfigurationSection
from trackweave.config.tables import Section
from trackweave.keys import Key
from trackweave.solvers import METHODS

__all__ = ["json_schema", "tables"]


def json_schema() -> dict[str, Any]:
    """Return the JSON Schema of ``tracker.toml``, the options of all solvers included."""
    content, shared = tables()
    for name in ("SearchSection", "SolverSection"):
        _add_options(shared[name])
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "tracker.toml",
        **content,
        "$defs": shared,
    }


def tables(
    section: type[Section] = ConfigurationSection,
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return the schema of a file itself and those of its tables, without solvers' options."""
    shared: dict[str, Any] = {}
    return section.as_kind(Key()).content(shared), shared


def _add_options(search: dict[str, Any]) -> None:
    """Add the options of all solvers to a table that names one."""
    search["additionalProperties"] = False
    search["properties"]["method"]["enum"] = list(METHODS)
    for method in METHODS:
        for name, option in options_of(method).content({})["properties"].items():
            entry = search["properties"].setdefault(name, {"anyOf": [], "description": ""})
            known = entry["description"]
            entry["description"] = f"{known}, {method}" if known else f"Option of: {method}"
            if option not in entry["anyOf"]:
                entry["anyOf"].append(option)
