"""Which tracker, and whether it gets plots that were fused first."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal

from trackweave.config.sections import PlotsSection, TrackerSection
from trackweave.config.sources import Sources, value_at
from trackweave.models.sensors import Sensor
from trackweave.trackers.lifecycle import Lifecycle

if TYPE_CHECKING:
    from trackweave.association.plots_rule import PlotsRule

__all__ = ["PlotSettings", "TrackerSettings", "plots_of_sources", "tracker_of_sources"]

# Scans so near to each other, as a share of the shortest scan period, are of one instant.
USUAL_SHARE = 0.1
# Times in seconds since 1970 are no finer than this [s].
CLOCK_NOISE = 1e-6


@dataclass(frozen=True, slots=True)
class TrackerSettings:
    """Which tracker gives reports to tracks."""

    kind: Literal["multi-hypothesis", "nearest-neighbour"] = TrackerSection.kind
    pairing: Literal["nearest", "one-to-one"] = TrackerSection.pairing


@dataclass(frozen=True, slots=True)
class PlotSettings:
    """How the plots of an instant are fused."""

    within: float  # How far apart the scans of one instant may be [s]
    rule: "PlotsRule"  # By evidence lone plots may stand, by eq. 1 never
    keep_lone: bool  # Whether positions where only one sensor looks become reports


def tracker_of_sources(sources: Sources) -> tuple[TrackerSettings, list[str]]:
    """Return which tracker is asked for, and sentences on keys that another would use."""
    # It is entered only where file or preset say something, so that runs that ask for nothing stay
    # what they are.
    usual = TrackerSettings()
    if not _is_given(sources, "tracker"):
        return usual, _unused(sources)
    kind = sources.choose(("tracker", "kind"), default=usual.kind)
    notes = _unused(sources)
    if kind == "nearest-neighbour":
        pairing = sources.choose(("tracker", "pairing"), default=usual.pairing)
        if sources.file.get("window"):
            notes.append("window: the nearest-neighbour tracker has none")
    else:
        pairing = usual.pairing
        if value_at(sources.file, ("tracker", "pairing")) is not None:
            notes.append("tracker.pairing: only the nearest-neighbour tracker pairs")
    return TrackerSettings(kind, pairing), notes


def plots_of_sources(
    sources: Sources, sensors: Sequence[Sensor], lifecycle: Lifecycle
) -> PlotSettings | None:
    """Return how plots are to be fused, None where they are not."""
    if not _is_given(sources, "plots"):
        return None
    from trackweave.association.plots_rule import PlotsRule

    is_fused = sources.choose(("plots", "fuse"), default=PlotsSection.fuse)
    periods = [sensor.scan_period for sensor in sensors if sensor.scan_period is not None]
    shortest = min(periods, default=0.0)
    within = sources.choose(("plots", "within"), default=max(CLOCK_NOISE, USUAL_SHARE * shortest))
    density = lifecycle.initial_target_density or lifecycle.new_target_density
    rule = sources.filled("plots", PlotsRule(density, lone_plots=True, overflow="thin"))
    keep_lone = sources.choose(("plots", "keep_lone"), default=PlotsSection.keep_lone)
    if not is_fused:
        return None
    within = max(CLOCK_NOISE, shortest) if within == "period" else within
    return PlotSettings(within, replace(rule, negative_only=rule.cost == "evidence"), keep_lone)


def _unused(sources: Sources) -> list[str]:
    """Return a sentence on keys of plots that nobody asks to be fused."""
    said = [key for key in sources.file.get("plots", {}) if key != "fuse"]
    fused = value_at(sources.file, ("plots", "fuse")), value_at(sources.preset, ("plots", "fuse"))
    if not said or fused[0] or (fused[0] is None and fused[1]):
        return []
    return [f"plots: without fuse = true nothing follows from {', '.join(said)}"]


def _is_given(sources: Sources, table: str) -> bool:
    """Tell whether the file or the preset says anything in a table."""
    return bool(sources.file.get(table) or sources.preset.get(table))
