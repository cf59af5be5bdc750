"""The configuration's JSON Schema, for editors that check and complete."""

from typing import Any

from trackweave.config.search import METHODS, options_model
from trackweave.config.sections import Configuration

__all__ = ["json_schema"]


def json_schema() -> dict[str, Any]:
    """Return the JSON Schema of ``tracker.toml``, the options of all solvers included."""
    schema = Configuration.model_json_schema()
    for name in ("SearchSection", "SolverSection"):
        _add_options(schema["$defs"][name])
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        **schema,
        "title": "tracker.toml",
    }


def _add_options(search: dict[str, Any]) -> None:
    """Add the options of all solvers to a table that names one."""
    search["additionalProperties"] = False
    search["properties"]["method"] = {
        "description": search["properties"]["method"]["description"],
        "enum": list(METHODS),
    }
    for method in METHODS:
        options = options_model(method).model_json_schema().get("properties", {})
        for name, option in options.items():
            entry = search["properties"].setdefault(name, {"anyOf": [], "description": ""})
            known = entry["description"]
            entry["description"] = f"{known}, {method}" if known else f"Option of: {method}"
            if option not in entry["anyOf"]:
                entry["anyOf"].append(option)
