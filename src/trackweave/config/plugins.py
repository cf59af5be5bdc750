"""Models and solvers from outside the package, named in tracker.toml by entry point."""

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib.metadata import entry_points
from typing import Any

from trackweave.config.sources import ANY_SENSOR, Sources
from trackweave.config.tables import Table, checked, entries_of
from trackweave.domain.foreign_kind import ForeignKind
from trackweave.errors import InvalidInputError
from trackweave.keys import suggest
from trackweave.models.foreign_motion import ForeignMotion
from trackweave.plugin_faults import told_as_theirs

__all__ = ["NO_PLUGINS", "Plugin", "Plugins", "plugin_class", "taken_apart"]

# Keys of [motion] that are not the model's own.
BESIDE = ("filter",)
# Of a table of the file, where classes for it come from.
GROUPS = {"motion": "motions", "sensors": "measurements"}


@dataclass(frozen=True, slots=True)
class Plugin:
    """A class from outside, and the keys that a file gives it."""

    key: str  # Under which key of the file it is named, such as "motion.model"
    word: str
    kind: type
    options: Mapping[str, Any]

    def made(self, file: str) -> Any:
        """Return an object of the class; a message names file, key and what was expected."""
        table = self.key.rsplit(".", 1)[0]
        keys = Table(self.word, "", lambda: entries_of(self.kind, marked=False))
        values = checked(self.options, keys, file, table)
        needed = [each.name for each in _fields(self.kind) if _is_needed(each)]
        missing = ", ".join(f"{table}.{name}" for name in needed if name not in values)
        if missing:
            raise InvalidInputError(
                f"{file}, {missing}: left out; expected a value, as {self.word} has no usual one"
            )
        try:
            return self.kind(**values)
        except InvalidInputError as err:
            raise InvalidInputError(f"{file}, {table}.{err}") from err
        except Exception:
            group = GROUPS[table.partition(".")[0]]
            with told_as_theirs(self.kind, group, "__init__", self.word):
                raise

    def values(self, made: Any) -> dict[str, Any]:
        """Return all keys of an object of the class, as a file has them."""
        return {each.name: getattr(made, each.name) for each in _fields(self.kind)}


@dataclass(frozen=True, slots=True)
class Plugins:
    """What a configuration names from outside: how objects move, and what sensors measure."""

    file: str = "configuration"
    motion: Plugin | None = None
    sensors: Mapping[str, Plugin] = field(default_factory=dict)
    ours: tuple[str, ...] = ()
    """Sensors of which the file says that they measure what ours do, whatever others do."""

    def kinds(self) -> dict[str, ForeignKind | None]:
        """Return kinds of measurement by the names of their sensors; None for one of ours."""
        return {name: self.kind_of(name) for name in (*self.sensors, *self.ours)}

    def kind_of(self, name: str) -> ForeignKind | None:
        """Return what a sensor measures, None where a kind of ours is told or nothing."""
        plugin = self.sensors.get(name) or self.sensors.get(ANY_SENSOR)
        if name in self.ours:
            return None
        return None if plugin is None else ForeignKind(plugin.made(self.file), plugin.word)

    def moving(self, sources: Sources) -> ForeignMotion | None:
        """Return how objects move, and enter each value; None where a model of ours says so."""
        if self.motion is None:
            return None
        made = self.motion.made(self.file)
        sources.choose(("motion", "model"))
        for name, value in self.motion.values(made).items():
            sources.choose(("motion", name), default=value)
        return ForeignMotion(made)

    def enter(self, name: str, kind: ForeignKind, sources: Sources) -> None:
        """Enter each value of a sensor's kind of measurement."""
        plugin = self.sensors.get(name) or self.sensors.get(ANY_SENSOR)
        if plugin is not None:
            for key, value in plugin.values(kind.model).items():
                sources.choose(("sensors", name, key), default=value)

    def take_out(self, name: str, table: dict[str, Any]) -> None:
        """Take the keys of a sensor's kind of measurement out of its table."""
        for key in self.sensors[name].options if name in self.sensors else ():
            table.pop(key, None)

    def put_back(self, values: Mapping[str, Any]) -> Mapping[str, Any]:
        """Return a configuration's keys with those that were taken out of them."""
        if self.motion is not None:
            own = {"model": self.motion.word, **self.motion.options}
            values = {**values, "motion": {**own, **values.get("motion", {})}}
        if self.sensors:
            tables = dict(values.get("sensors", {}))
            for name, plugin in self.sensors.items():
                own = {"measurement": plugin.word, **plugin.options}
                tables[name] = {**own, **tables.get(name, {})}
            values = {**values, "sensors": tables}
        return values


NO_PLUGINS = Plugins()


def taken_apart(values: Any, ours: Mapping[str, tuple[str, ...]]) -> tuple[Any, Plugins]:
    """Return a configuration's keys without those of plug-ins, and these."""
    # ``ours`` are the words of ours for "motion" and "measurement". What is no table of tables is
    # left for others to refuse.
    if not isinstance(values, Mapping):
        return values, NO_PLUGINS
    rest = dict(values)
    motion = _named(rest.get("motion"), "motion.model", ours["motion"])
    if motion is not None:
        beside = {k: v for k, v in rest["motion"].items() if k in BESIDE}
        _refuse_unknown(rest["motion"], motion, BESIDE)
        rest["motion"] = beside
    sensors, tables, known = {}, rest.get("sensors"), list[str]()
    for name, table in tables.items() if isinstance(tables, Mapping) else ():
        plugin = _named(table, f"sensors.{name}.measurement", ours["measurement"])
        if plugin is None and isinstance(table, Mapping) and table.get("measurement") is not None:
            known.append(name)
        if plugin is not None:
            sensors[name] = plugin
            own = {"measurement", *plugin.options}
            rest["sensors"] = {
                **rest["sensors"], name: {k: v for k, v in table.items() if k not in own}
            }  # fmt: skip
    return rest, Plugins(motion=motion, sensors=sensors, ours=tuple(known))


def _named(table: Any, key: str, ours: tuple[str, ...]) -> Plugin | None:
    """Return the plug-in that a table names, None where it names one of ours or nothing."""
    group, name = key.split(".")[0], key.rsplit(".", 1)[1]
    word = table.get(name) if isinstance(table, Mapping) else None
    if not isinstance(word, str) or word in ours:
        return None
    kind = plugin_class(GROUPS[group], word, key)
    if kind is None:
        return None
    names = {each.name for each in _fields(kind)}
    return Plugin(key, word, kind, {k: v for k, v in table.items() if k in names})


def _refuse_unknown(table: Mapping[str, Any], plugin: Plugin, beside: tuple[str, ...]) -> None:
    known = sorted({each.name for each in _fields(plugin.kind)} | set(beside) | {"model"})
    for key in table:
        if key not in known:
            raise InvalidInputError(f"motion.{key}: unknown key; {suggest(key, known)}")


def plugin_class(group: str, word: str, key: str) -> type | None:
    """Return the class that an entry point of a group ``trackweave.…`` names; None for none."""
    for found in entry_points(group=f"trackweave.{group}", name=word):
        try:
            kind = found.load()
        except Exception as err:
            raise InvalidInputError(
                f'{key}: "{word}" is {found.value}, which cannot be loaded ({err}); expected a '
                "dataclass"
            ) from err
        if not isinstance(kind, type) or not dataclasses.is_dataclass(kind):
            raise InvalidInputError(
                f'{key}: "{word}" is {found.value}; expected a dataclass, whose fields are keys'
            )
        return kind
    return None


def _fields(kind: type) -> list[dataclasses.Field[Any]]:
    return [each for each in dataclasses.fields(kind) if each.init]


def _is_needed(each: dataclasses.Field[Any]) -> bool:
    missing = dataclasses.MISSING
    return each.default is missing and each.default_factory is missing
