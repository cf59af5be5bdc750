"""Which tracker, and whether it gets plots that were fused first."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

from trackweave.config.fields import default_of
from trackweave.config.ledger import Ledger, value_at
from trackweave.models.sensors import Sensor
from trackweave.trackers.lifecycle import Lifecycle

if TYPE_CHECKING:
    from trackweave.association.plots_rule import PlotCost, PlotsRule

__all__ = ["PlotSettings", "TrackerSettings", "plots_of_ledger", "tracker_of_ledger"]

# Scans so near to each other, as a share of the shortest scan period, are of one instant.
USUAL_SHARE = 0.1
# Times in seconds since 1970 are no finer than this [s].
CLOCK_NOISE = 1e-6


@dataclass(frozen=True, slots=True)
class TrackerSettings:
    """Which tracker gives reports to tracks."""

    kind: Literal["multi-hypothesis", "nearest-neighbour"] = "multi-hypothesis"
    pairing: Literal["nearest", "one-to-one"] = "one-to-one"


@dataclass(frozen=True, slots=True)
class PlotSettings:
    """How the plots of an instant are fused."""

    within: float  # How far apart the scans of one instant may be [s]
    cost: "PlotCost"
    gate: float  # Greatest squared distance of a plot from the tuple that it joins
    object_density: float  # Objects expected per m² (m³)
    max_tuples: int  # Greatest number of tuples
    keep_lone: bool = False  # Whether positions where only one sensor looks become reports

    def rule(self) -> "PlotsRule":
        """Return the rule of the plots: by evidence lone ones may stand, by eq. 1 never."""
        from trackweave.association.plots_rule import PlotsRule

        return PlotsRule(
            object_density=self.object_density,
            cost=self.cost,
            gate=self.gate,
            negative_only=self.cost == "evidence",
            lone_plots=True,
            max_tuples=self.max_tuples,
            overflow="thin",
        )


def tracker_of_ledger(ledger: Ledger) -> tuple[TrackerSettings, list[str]]:
    """Return which tracker is asked for, and sentences on keys that another would use."""
    # It is entered only where file or preset say something, so that runs that ask for nothing stay
    # what they are.
    usual = TrackerSettings()
    if not _is_given(ledger, "tracker"):
        return usual, _unused(ledger)
    kind = ledger.choose(("tracker", "kind"), default=usual.kind)
    notes = _unused(ledger)
    if kind == "nearest-neighbour":
        pairing = ledger.choose(("tracker", "pairing"), default=usual.pairing)
        if ledger.file.get("window"):
            notes.append("window: the nearest-neighbour tracker has none")
    else:
        pairing = usual.pairing
        if value_at(ledger.file, ("tracker", "pairing")) is not None:
            notes.append("tracker.pairing: only the nearest-neighbour tracker pairs")
    return TrackerSettings(kind, pairing), notes


def plots_of_ledger(
    ledger: Ledger, sensors: Sequence[Sensor], lifecycle: Lifecycle
) -> PlotSettings | None:
    """Return how plots are to be fused, None where they are not."""
    if not _is_given(ledger, "plots"):
        return None
    from trackweave.association.plots_rule import PlotsRule

    is_fused = ledger.choose(("plots", "fuse"), default=False)
    periods = [sensor.scan_period for sensor in sensors if sensor.scan_period is not None]
    shortest = min(periods, default=0.0)
    within = ledger.choose(("plots", "within"), default=max(CLOCK_NOISE, USUAL_SHARE * shortest))
    density = lifecycle.initial_target_density or lifecycle.new_target_density

    def choose(key: str, default: Any) -> Any:
        return ledger.choose(("plots", key), default=default)

    settings = PlotSettings(
        within=max(CLOCK_NOISE, shortest) if within == "period" else within,
        cost=choose("cost", default_of(PlotsRule, "cost")),
        gate=choose("gate", default_of(PlotsRule, "gate")),
        object_density=choose("object_density", density),
        max_tuples=choose("max_tuples", default_of(PlotsRule, "max_tuples")),
        keep_lone=choose("keep_lone", False),
    )
    return settings if is_fused else None


def _unused(ledger: Ledger) -> list[str]:
    """Return a sentence on keys of plots that nobody asks to be fused."""
    said = [key for key in ledger.file.get("plots", {}) if key != "fuse"]
    fused = value_at(ledger.file, ("plots", "fuse")), value_at(ledger.preset, ("plots", "fuse"))
    if not said or fused[0] or (fused[0] is None and fused[1]):
        return []
    return [f"plots: without fuse = true nothing follows from {', '.join(said)}"]


def _is_given(ledger: Ledger, table: str) -> bool:
    """Tell whether the file or the preset says anything in a table."""
    return bool(ledger.file.get(table) or ledger.preset.get(table))
