"""Presets by name: what each says where the configuration file is silent."""

from collections.abc import Mapping
from importlib import import_module
from typing import Any

from trackweave.errors import InvalidInputError
from trackweave.keys import suggest

__all__ = ["FUSION_PRESETS", "PRESETS", "preset_notes", "preset_values"]

# The module of each preset; its CONFIGURATION is nested as a configuration file is. One that keeps
# to its document's letter names in USABLE the preset that serves on reports of one's own.
PRESETS: dict[str, str] = {
    "hillis": "trackweave.presets.hillis",
    "hillis-1997": "trackweave.presets.hillis_1997",
    "wiranto": "trackweave.presets.wiranto",
    "wiranto-2018": "trackweave.presets.wiranto_2018",
}
# Those of fusion, whose CONFIGURATION is nested as what ``fuse`` takes.
FUSION_PRESETS: dict[str, str] = {
    "huo-2008": "trackweave.presets.huo_2008",
    "huo": "trackweave.presets.huo",
}


def preset_values(name: str | None, *, fusion: bool = False) -> Mapping[str, Any]:
    """Return what a preset says, nested as in a file; for fusion as in its table ``[fusion]``."""
    # A preset for tracking is none for fusing tracks, and the other way round.
    if name is None:
        return {}
    known, others, purpose = (PRESETS, FUSION_PRESETS, "fusing tracks")
    if fusion:
        known, others, purpose = (FUSION_PRESETS, PRESETS, "tracking")
    if not isinstance(name, str):
        raise InvalidInputError(f"preset: {name!r:.80}; expected {', '.join(known)}, or None")
    if name in others:
        raise InvalidInputError(
            f'preset: "{name}" is one for {purpose}; expected {", ".join(known)}'
        )
    if name not in known:
        raise InvalidInputError(f'preset: "{name}" is not known; {suggest(name, sorted(known))}')
    values: Mapping[str, Any] = import_module(known[name]).CONFIGURATION
    return values


def preset_notes(name: str | None) -> list[str]:
    """Return a sentence on which preset to take instead of one that keeps to its document."""
    module = {**PRESETS, **FUSION_PRESETS}.get(name or "")
    usable = getattr(import_module(module), "USABLE", None) if module else None
    if usable is None:
        return []
    return [f"preset {name} keeps to its document's letter; --preset {usable} is made for use"]
