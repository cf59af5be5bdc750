"""Which of several values of a key counts, and where it came from."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, TypeVar

from trackweave.config.tables import entries_of

__all__ = ["ANY_SENSOR", "Sources", "value_at"]

# The table whose keys apply to every sensor that has none of its own.
ANY_SENSOR = "default"

Filled = TypeVar("Filled")


@dataclass
class Sources:
    """Chooses values in order of precedence and writes down where each came from."""

    file: Mapping[str, Any]  # What the file says, nested as there
    preset: Mapping[str, Any]
    # Every key with the value chosen, nested as in a file.
    values: dict[str, Any] = field(default_factory=dict)
    # Where each came from: "file", "preset", "estimated" or "default", by dotted key.
    sources: dict[str, str] = field(default_factory=dict)

    def choose(self, path: Sequence[str], estimated: Any = None, default: Any = None) -> Any:
        """Enter and return a key's value: what the file says, else preset, reports or default."""
        for source, given in (("file", self.file), ("preset", self.preset)):
            for name in self._names(path):
                value = value_at(given, name)
                if value is not None:
                    return self.enter(path, value, source)
        if estimated is not None:
            return self.enter(path, estimated, "estimated")
        return self.enter(path, default, "default")

    def filled(self, table: str, usual: Filled, estimates: Any = None) -> Filled:
        """Enter all keys of a table that a class has; return one with their values."""
        # What a key leaves out is estimated by the name that it has, or as ``usual`` has it.
        values = {
            key: self.choose((table, key), getattr(estimates, key, None), getattr(usual, key))
            for key in entries_of(type(usual))
        }
        return replace(usual, **values)  # type: ignore[type-var]  # a dataclass

    def said(self, path: Sequence[str]) -> Any:
        """Return what the file says of a key, or else the preset; None for nothing."""
        for given in (self.file, self.preset):
            for name in self._names(path):
                value = value_at(given, name)
                if value is not None:
                    return value
        return None

    def _names(self, path: Sequence[str]) -> list[Sequence[str]]:
        """Return where a key may stand: a sensor's in its own table, or in that for all."""
        if path[0] != "sensors":
            return [path]
        own, key = value_at(self.file, path[:2]) or {}, path[2]
        turns = own.get("rotation") not in (None, "none")
        # Scans of its own, or its own word that there are none, leave no room for the others'.
        if key in ("scan_period", "rotation") and own.get("scans") is False:
            return [path]
        if key == "scans" and (own.get("scan_period") is not None or turns):
            return [path]
        return [path, ("sensors", ANY_SENSOR, *path[2:])]

    def enter(self, path: Sequence[str], value: Any, source: str) -> Any:
        """Enter a value that has been chosen already; return it."""
        table = self.values
        for key in path[:-1]:
            table = table.setdefault(key, {})
        table[path[-1]] = value
        self.sources[".".join(path)] = source
        return value


def value_at(values: Mapping[str, Any], path: Sequence[str]) -> Any:
    """Return what stands at a place of nested tables, None where there is nothing."""
    found: Any = values
    for key in path:
        if not isinstance(found, Mapping) or key not in found:
            return None
        found = found[key]
    return found
