"""What a fusion runs with: what was asked for, the file, the preset, then the defaults."""

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from trackweave.config.load import Configuration, load_configuration
from trackweave.config.presets import preset_values
from trackweave.config.search import DEFAULT_METHOD, check_search, make_solver
from trackweave.config.sections import FusionSection
from trackweave.config.tables import checked
from trackweave.fusion.associator import TrackAssociator
from trackweave.fusion.bias import BiasModel
from trackweave.fusion.statistic import Statistic
from trackweave.keys import Key

__all__ = ["FusionOrder", "FusionSettings", "order_of", "settle_fusion"]

_TABLE = FusionSection.as_kind(Key())
_USUAL = {field.name: field.default for field in dataclasses.fields(TrackAssociator)}
_OF_ASSOCIATOR = [
    key for key in _TABLE.entries if key in _USUAL and key not in ("statistic", "search")
]
DEFAULTS: dict[str, Any] = {
    "method": FusionSection.method,
    **{key: _USUAL[key] for key in _OF_ASSOCIATOR},
    "register": FusionSection.register,
    "bias": list(BiasModel().estimate),
    # What filters keep errs alike from time to time: with no correlation, young tracks of one
    # object are rejected more often than asked for.
    "statistic": dataclasses.asdict(Statistic(correlation="effective")),
    "search": {"method": DEFAULT_METHOD},
}

Layer = tuple[str, Mapping[str, Any]]


@dataclass(frozen=True, slots=True)
class FusionOrder:
    """What was asked for."""

    # Where each comes from, "given" or "file", and its keys, nested; what comes first counts.
    layers: tuple[Layer, ...]
    seed: int | None = None  # What the file says of it


@dataclass(frozen=True, slots=True)
class FusionSettings:
    """Everything that a fusion needs."""

    values: dict[str, Any]  # Every key with its value, nested
    # Where each came from, by dotted key: given, file, preset, estimated or default.
    sources: dict[str, str]

    def associator(self, names: list[str]) -> TrackAssociator:
        """Return what decides which tracks are of one object, for sensors in the chain's order."""
        values = self.values
        return TrackAssociator(
            sensors=names,
            statistic=Statistic(**values["statistic"]),
            search=make_solver(values["search"], "config", "fusion.search"),
            **{key: values[key] for key in _OF_ASSOCIATOR},
        )


def order_of(
    config: str | Path | Mapping[str, Any] | Configuration | None,
    options: Mapping[str, Any] | None = None,
) -> FusionOrder:
    """Return what was asked for, every value checked."""
    # The configuration may also be the table ``[fusion]`` alone. The options go before it, nested
    # like that table; None is as good as left out.
    layers: list[Layer] = []
    if options is not None:
        layers.append(("given", _checked(options)))
    if isinstance(config, Mapping) and "fusion" not in config:
        return FusionOrder((*layers, ("given", _checked(config))))
    if config is None:
        return FusionOrder(tuple(layers))
    whole = load_configuration(config)
    source = "given" if isinstance(config, Mapping) else "file"
    return FusionOrder((*layers, (source, whole.table("fusion"))), whole.said("seed"))


def _checked(table: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return the keys of a table ``[fusion]`` that are given."""
    given = checked(table, _TABLE, "config")
    check_search(given.get("search", {}), "config")
    return given


def settle_fusion(
    order: FusionOrder, *, preset: str | None, process_noise: float | None
) -> FusionSettings:
    """Return everything that a fusion needs; a preset applies where the order is silent."""
    # The process noise [m²/s³] is what the tracks' covariances tell of it; None for nothing.
    layers: list[Layer] = [
        *order.layers, ("preset", preset_values(preset, fusion=True)),
        ("estimated", {} if process_noise is None else {"process_noise": process_noise}),
        ("default", DEFAULTS),
    ]  # fmt: skip
    values: dict[str, Any] = {}
    sources: dict[str, str] = {}
    for key, usual in DEFAULTS.items():
        if not isinstance(usual, dict):
            values[key], sources[key] = _first(layers, key)
            continue
        tables = [(source, layer.get(key) or {}) for source, layer in layers]
        own = _of_one_method(tables) if key == "search" else tables
        values[key] = {}
        for inner in dict.fromkeys(name for _, table in reversed(own) for name in table):
            values[key][inner], sources[f"{key}.{inner}"] = _first(own, inner)
    settings = FusionSettings(values, sources)
    settings.associator([])
    return settings


def _first(layers: Sequence[Layer], key: str) -> tuple[Any, str]:
    """Return the first value that there is, and where it came from."""
    for source, layer in layers:
        if layer.get(key) is not None:
            return layer[key], source
    return None, "default"


def _of_one_method(tables: Sequence[Layer]) -> list[Layer]:
    """Return the tables of solvers' options that mean the method that counts."""
    method, _ = _first(tables, "method")
    # A table without a method speaks of the one that those after it name.
    return [
        (source, table)
        for place, (source, table) in enumerate(tables)
        if _first(tables[place:], "method")[0] == method
    ]
