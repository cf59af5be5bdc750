"""From a file or a mapping to a checked configuration."""

import os
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from trackweave.config.plugins import NO_PLUGINS, Plugins, taken_apart
from trackweave.config.search import check_search
from trackweave.config.sections import KINDS, ConfigurationSection
from trackweave.config.sources import ANY_SENSOR, value_at
from trackweave.config.tables import checked
from trackweave.domain.facts import Place
from trackweave.errors import InvalidInputError
from trackweave.keys import Key
from trackweave.models.motion import MODELS
from trackweave.toml_file import read_toml

__all__ = ["Configuration", "load_configuration", "without_deadline"]


@dataclass(frozen=True, slots=True)
class Configuration:
    """What a file says, every value checked; keys left out are filled later."""

    values: Mapping[str, Any] = field(default_factory=dict)  # As given, nested as in the file
    name: str = "configuration"  # What messages call the file
    plugins: Plugins = NO_PLUGINS  # What it names from outside the package, whose keys are apart
    learned: frozenset[str] = frozenset()  # Dotted keys that an earlier recording told

    def said(self, *path: str) -> Any:
        """Return what is said of a key; None for nothing."""
        return value_at(self.values, path)

    def table(self, *path: str) -> dict[str, Any]:
        """Return the keys of a table that are given."""
        return dict(self.said(*path) or {})

    def changed(self, **tables: Mapping[str, Any]) -> "Configuration":
        """Return the same with other tables, which are not checked again."""
        return replace(self, values={**self.values, **tables})

    def places(self) -> dict[str, Place]:
        """Return where sensors are told to stand on the Earth, by the names of their tables."""
        told = {name: own.get("place") for name, own in self.table("sensors").items()}
        return {name: Place(*place) for name, place in told.items() if place is not None}

    def sensor(self, name: str) -> dict[str, Any]:
        """Return a sensor's own keys over those for every sensor."""
        own = self.table("sensors", name)
        usual = self.table("sensors", ANY_SENSOR)
        # Of the two ways to tell the clutter, the sensor's own wins. So do its own scans, or its
        # own word that there are none.
        if "clutter_density" in own or "clutter_per_scan" in own:
            less = {"clutter_density", "clutter_per_scan"}
        else:
            less = set()
        if "position" in own or "place" in own:
            less |= {"position", "place"}
        if own.get("scans") is False:
            less |= {"scan_period", "rotation"}
        elif "scan_period" in own or "rotation" in own:
            less.add("scans")
        return {key: value for key, value in usual.items() if key not in less} | own


def without_deadline(search: Mapping[str, Any]) -> dict[str, Any]:
    """Return the keys of ``[search]`` that are the solver's."""
    return {key: value for key, value in search.items() if key != "deadline_ms"}


def load_configuration(
    source: str | Path | Mapping[str, Any] | Configuration | None,
) -> Configuration:
    """Return the configuration that a file or a mapping holds, every value checked."""
    # A message names file, key, value and what was expected.
    if isinstance(source, Configuration):
        return source
    if source is None:
        return Configuration()
    if isinstance(source, Mapping):
        name, values = "configuration", dict(source)
    elif not isinstance(source, str | os.PathLike):
        raise InvalidInputError(
            f"config: {source!r:.80}; expected the path of a TOML file, or a mapping of its keys"
        )
    else:
        name, values = str(source), read_toml(Path(source), "a configuration")
    rest, plugins = _apart(values, name)
    rest = checked(rest, ConfigurationSection.as_kind(Key()), name)
    check_search(without_deadline(rest.get("search", {})), name)
    check_search(rest.get("fusion", {}).get("search", {}), name, "fusion.search")
    return Configuration(rest, name, replace(plugins, file=name))


def _apart(values: Any, name: str) -> tuple[Any, Plugins]:
    """Return a file's keys without those of plug-ins, and these."""
    try:
        return taken_apart(values, {"motion": (*MODELS, "imm"), "measurement": KINDS})
    except InvalidInputError as err:
        raise InvalidInputError(f"{name}, {err}") from err
