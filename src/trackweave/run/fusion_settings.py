"""What a fusion runs with: what was asked for, then the preset, then the defaults."""

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from importlib import import_module
from typing import Any

from trackweave.config.messages import suggest
from trackweave.config.presets import FUSION_PRESETS, PRESETS
from trackweave.config.search import make_solver
from trackweave.config.sections import SearchSection
from trackweave.errors import InvalidInputError
from trackweave.fusion.associator import TrackAssociator
from trackweave.fusion.bias import BiasModel
from trackweave.fusion.combine import Combination
from trackweave.fusion.statistic import Statistic

__all__ = ["FusionSettings", "settle_fusion"]

DEFAULTS: dict[str, Any] = {
    # Trackers that follow one object share its turns: their errors are not independent.
    "method": "fast-covariance-intersection",
    "process_noise": None,
    "confirm": None,
    "complete": False,
    "hysteresis": 0.1,
    "patience": 3.0,
    "register": False,
    "bias": list(BiasModel().estimate),
    "statistic": {
        field.name: field.default
        for field in dataclasses.fields(Statistic)
        if field.default is not dataclasses.MISSING
    }
    # What filters keep errs alike from time to time: without this, young tracks of one object are
    # rejected more often than asked for.
    | {"correlation": "effective"},
    "search": {"method": "auto"},
}
OPEN = frozenset({"search"})
"""Tables with keys beyond those of the defaults, checked elsewhere."""


@dataclass(frozen=True, slots=True)
class FusionSettings:
    """Everything that a fusion needs.

    Parameters
    ----------
    values
        Every key with its value, nested.
    sources
        Where each came from, by dotted key: given, preset, estimated or default.
    """

    values: dict[str, Any]
    sources: dict[str, str]

    def associator(self, names: list[str]) -> TrackAssociator:
        """Return what decides which tracks are of one object.

        Parameters
        ----------
        names
            Names of the sensors, in the order of the chain.

        Returns
        -------
        It, unused.
        """
        values = self.values
        return TrackAssociator(
            sensors=names,
            statistic=Statistic(**values["statistic"]),
            process_noise=values["process_noise"],
            confirm=values["confirm"],
            search=make_solver(SearchSection(**values["search"]), "fusion"),
            hysteresis=values["hysteresis"],
            patience=values["patience"],
            complete=values["complete"],
        )


def settle_fusion(
    given: Mapping[str, Any], *, preset: str | None, process_noise: float | None
) -> FusionSettings:
    """Return everything that a fusion needs.

    Parameters
    ----------
    given
        What was asked for, nested as ``DEFAULTS``; None is as good as left out.
    preset
        Name of a preset, applied where ``given`` is silent; None for none.
    process_noise
        What the tracks' covariances tell of it [m²/s³]; None for nothing.

    Returns
    -------
    The settings.

    Raises
    ------
    InvalidInputError
        If a key or a preset is unknown, or a value cannot be used.
    """
    layers = [("given", given), ("preset", _preset(preset))]
    values: dict[str, Any] = {}
    sources: dict[str, str] = {}
    for key, value in DEFAULTS.items():
        if not isinstance(value, dict):
            values[key], sources[key] = _first(layers, (key,), value)
            continue
        keys = list(value)
        if key in OPEN:
            keys += [more for _, layer in layers for more in (layer.get(key) or {})]
        values[key] = {}
        for inner in dict.fromkeys(keys):
            found, source = _first(layers, (key, inner), value.get(inner))
            values[key][inner], sources[f"{key}.{inner}"] = found, source
    # Options of one method are none of another's.
    if sources["search.method"] == "given":
        own = {"method", *(given.get("search") or {})}
        values["search"] = {k: v for k, v in values["search"].items() if k in own}
        sources = {k: v for k, v in sources.items() if not k.startswith("search.") or k[7:] in own}
    _require_known(given)
    if values["process_noise"] is None:
        values["process_noise"] = 1.0 if process_noise is None else process_noise
        sources["process_noise"] = "default" if process_noise is None else "estimated"
    settings = FusionSettings(values, sources)
    _require_usable(settings)
    return settings


def _preset(name: str | None) -> Mapping[str, Any]:
    if name is None:
        return {}
    if name not in FUSION_PRESETS:
        if name in PRESETS:
            raise InvalidInputError(
                f'preset: "{name}" is one for tracking; expected {", ".join(FUSION_PRESETS)}'
            )
        raise InvalidInputError(
            f'preset: "{name}" is not known; {suggest(name, list(FUSION_PRESETS))}'
        )
    values: Mapping[str, Any] = import_module(FUSION_PRESETS[name]).CONFIGURATION
    return values


def _first(
    layers: list[tuple[str, Mapping[str, Any]]], path: tuple[str, ...], default: Any
) -> tuple[Any, str]:
    """Return the first value that a layer gives, and which layer that is."""
    for name, layer in layers:
        value: Any = layer
        for key in path:
            value = value.get(key) if isinstance(value, Mapping) else None
        if value is not None:
            return value, name
    return default, "default"


def _require_known(given: Mapping[str, Any]) -> None:
    """Refuse keys that there are not."""
    for key, value in given.items():
        if key not in DEFAULTS:
            raise InvalidInputError(f"config, {key}: unknown key; {suggest(key, list(DEFAULTS))}")
        table = DEFAULTS[key]
        if not isinstance(table, dict) or value is None:
            continue
        if not isinstance(value, Mapping):
            raise InvalidInputError(f"config, {key}: {value!r:.80}; expected a table of keys")
        for inner in value if key not in OPEN else ():
            if inner not in table:
                raise InvalidInputError(
                    f"config, {key}.{inner}: unknown key; {suggest(inner, list(table))}"
                )


def _require_usable(settings: FusionSettings) -> None:
    """Refuse values of a wrong kind; each part refuses its own."""
    for key in ("complete", "register"):
        if not isinstance(settings.values[key], bool):
            raise InvalidInputError(
                f"config, {key}: {settings.values[key]!r:.80}; expected true or false"
            )
    Combination(settings.values["method"])
    BiasModel(tuple(settings.values["bias"]))
    settings.associator([])
