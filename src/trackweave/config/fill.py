"""From what was given, estimated and usual to the values that a run uses."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields
from typing import Any, Literal

from trackweave.association.growth_limits import GrowthLimits
from trackweave.config.ledger import ANY_SENSOR, Ledger, value_at
from trackweave.config.moving import motion_of
from trackweave.config.observed import UNKNOWN_SENSOR, ObservedSensor
from trackweave.config.plots import (
    PlotSettings,
    TrackerSettings,
    plots_of_ledger,
    tracker_of_ledger,
)
from trackweave.config.presets import preset_notes, preset_values
from trackweave.config.search import DEFAULT_METHOD, make_solver
from trackweave.config.sections import Configuration
from trackweave.config.sensing import section_of, sensor_of
from trackweave.domain.measurements import MeasurementKind
from trackweave.estimation import Estimates
from trackweave.models.foreign_motion import AnyMotion
from trackweave.models.sensors import Sensor
from trackweave.trackers.clock_guard import MAX_AHEAD
from trackweave.trackers.lifecycle import Lifecycle
from trackweave.trackers.window import Window

__all__ = ["ANY_SENSOR", "Settings", "fill", "known_sigma", "needs_estimates"]

ESTIMATED_OF_SENSOR = ("sigma", "detection_probability", "clutter_density", "scan_period")


@dataclass(frozen=True, slots=True)
class Settings:
    """A configuration without gaps, as the tracker takes it."""

    motion: AnyMotion
    sensors: tuple[Sensor, ...]
    window: Window  # Scans that are open to change
    lifecycle: Lifecycle  # When tracks begin, are believed and end
    search: Any  # None for the tracker's own
    growth: GrowthLimits
    estimate: Literal["average", "best"]  # What is told of a track
    deadline: float | None  # Wall clock per scan [s]; None for no limit
    period: float | None  # Least time between rows of a track [s]; None for every scan
    values: Mapping[str, Any]  # Every key with the value used, nested as in the file
    # Where each came from: "file", "preset", "estimated" or "default", by dotted key.
    sources: Mapping[str, str]
    notes: tuple[str, ...] = ()  # Sentences on what a user should know of them
    # Whether what is not linear is taken by sigma points instead of slopes.
    unscented: bool = False
    tracker: TrackerSettings = field(default_factory=TrackerSettings)
    # How the plots of an instant are fused before; None where they are not.
    plots: PlotSettings | None = None
    max_ahead: float = MAX_AHEAD  # How far a scan's time may jump ahead of all others [s]
    # For how long reports of sensors that do not look are gathered before they are searched [s];
    # None for each time by itself.
    together: float | None = None


def needs_estimates(configuration: Configuration, names: Sequence[str]) -> bool:
    """Tell whether a configuration leaves out, for any sensor, what can be estimated."""
    given = configuration.as_file()
    paths = [("motion", "process_noise"), ("motion", "max_speed")]
    paths.append(("lifecycle", "new_target_density"))
    if any(value_at(given, path) is None for path in paths):
        return True
    for name in names:
        own = section_of(configuration, name)
        needed = {key for key in ESTIMATED_OF_SENSOR if getattr(own, key) is None}
        if own.scans is False:
            needed.discard("scan_period")
        if own.clutter_per_scan is not None and own.field_of_view is not None:
            needed.discard("clutter_density")
        if needed:
            return True
    return False


def known_sigma(configuration: Configuration, names: Sequence[str]) -> dict[str, float]:
    """Return the noise of positions that the configuration gives, by sensor [m]."""
    # Sensors without are left out; it is the largest where axes differ.
    given = {name: section_of(configuration, name).sigma for name in names}
    return {
        name: sigma
        if isinstance(sigma, float | int)
        else max(sigma.x or 0.0, sigma.y or 0.0, sigma.z or 0.0)
        for name, sigma in given.items()
        if isinstance(sigma, float | int) or (sigma is not None and sigma.x is not None)
    }


def fill(
    configuration: Configuration,
    estimates: Estimates | None,
    names: Sequence[str],
    *,
    preset: str | None = None,
    observed: Mapping[str, ObservedSensor] | None = None,
) -> Settings:
    """Return a configuration without gaps."""
    # What the file says comes first, for a sensor its own table before ``sensors.default``; then
    # what the preset says; then what was estimated; then the usual. A sensor of which nothing was
    # observed reports positions.
    ledger = Ledger(configuration.as_file(), preset_values(preset))
    ledger.enter(
        ("seed",), configuration.seed, "default" if configuration.seed is None else "file"
    )
    seen = observed or {}
    # Files begin with how objects move, which takes the sensors' periods to fill.
    ledger.values["motion"] = {}
    sensors = tuple(
        sensor_of(
            ledger,
            configuration,
            estimates.sensors.get(name) if estimates else None,
            name,
            seen.get(name, UNKNOWN_SENSOR),
        )
        for name in names
    )
    periods = [sensor.scan_period for sensor in sensors if sensor.scan_period is not None]
    told = (estimates.process_noise, estimates.max_speed) if estimates else (None, None)
    ways = estimates.ways if estimates else None
    motion = configuration.plugins.moving(ledger) or motion_of(
        ledger, told, min(periods, default=1.0), ways
    )
    unscented = ledger.choose(("motion", "filter"), default="extended") == "unscented"
    window = Window(
        depth=ledger.choose(("window", "depth"), estimates and estimates.depth, Window().depth),
        max_scans=ledger.choose(
            ("window", "max_scans"), estimates and estimates.max_scans, Window().max_scans
        ),
    )
    lifecycle = _lifecycle(ledger, estimates)
    search, deadline = _search(ledger, configuration)
    max_ahead = ledger.choose(("live", "max_ahead"), default=MAX_AHEAD)
    period = ledger.choose(("output", "period"), estimates and estimates.period)
    tracker, doubts = tracker_of_ledger(ledger)
    plots = plots_of_ledger(ledger, sensors, lifecycle)
    unused = [name for name in configuration.sensors if name not in (*names, ANY_SENSOR)]
    notes = [f"sensors.{name}: no report is from this sensor" for name in unused]
    notes += [*(estimates.notes if estimates else ()), *_doubts(ledger, estimates)]
    notes += doubts + _overruled(ledger, preset) + preset_notes(preset)
    if getattr(search, "settle", True) is False:
        # The document of the preset hillis-1997 knows no false alarms.
        notes.append("search.settle is off: each lone report counts as a track of one report")
    return Settings(
        motion, sensors, window, lifecycle, search, _growth(ledger, sensors),
        ledger.choose(("output", "estimate"), default="average"),
        None if deadline is None else deadline / 1000.0,
        period, ledger.values, ledger.sources, tuple(notes), unscented, tracker, plots,
        max_ahead, estimates.together if estimates else None,
    )  # fmt: skip


def _doubts(ledger: Ledger, estimates: Estimates | None) -> list[str]:
    """Return a sentence on each sensor whose estimates are used although they are doubtful."""
    notes = []
    for name, doubt in (estimates.doubts if estimates else {}).items():
        keys = [f"sensors.{name}.sigma", f"sensors.{name}.detection_probability"]
        keys += ["motion.process_noise", "motion.max_speed"]
        used = [key for key in keys if ledger.sources.get(key) == "estimated"]
        if used:
            notes.append(f"sensor {name}: {doubt}; better give {', '.join(used)}")
    return notes


def _overruled(ledger: Ledger, preset: str | None) -> list[str]:
    """Return a sentence where the file says otherwise than the preset."""
    others = [
        ".".join(path)
        for path, value in _leaves(ledger.preset)
        if value_at(ledger.file, path) not in (None, value)
    ]
    if not others:
        return []
    return [f"preset {preset}: the configuration says otherwise of {', '.join(others)}"]


def _leaves(values: Mapping[str, Any]) -> Iterator[tuple[tuple[str, ...], Any]]:
    """Yield each key of nested tables with its value."""
    for key, value in values.items():
        if isinstance(value, Mapping):
            yield from (((key, *path), leaf) for path, leaf in _leaves(value))
        else:
            yield (key,), value


def _lifecycle(ledger: Ledger, estimates: Estimates | None) -> Lifecycle:
    usual = Lifecycle()
    confirm = ledger.choose(
        ("lifecycle", "confirm"), default=f"{usual.confirm_hits}/{usual.confirm_opportunities}"
    )
    hits, opportunities = confirm.split("/")
    return Lifecycle(
        confirm_hits=int(hits),
        confirm_opportunities=int(opportunities),
        delete_after_misses=ledger.choose(
            ("lifecycle", "delete_after_misses"),
            estimates and estimates.delete_after_misses,
            usual.delete_after_misses,
        ),
        hidden_share=ledger.choose(
            ("lifecycle", "hidden_share"),
            estimates and estimates.hidden_share,
            usual.hidden_share,
        ),
        mean_silence=ledger.choose(
            ("lifecycle", "mean_silence"),
            estimates and estimates.mean_silence,
            usual.mean_silence,
        ),
        rejoin=ledger.choose(("lifecycle", "rejoin")),
        new_target_density=ledger.choose(
            ("lifecycle", "new_target_density"),
            estimates and estimates.new_target_density,
            usual.new_target_density,
        ),
        initial_target_density=ledger.choose(
            ("lifecycle", "initial_target_density"),
            estimates and estimates.initial_target_density,
        ),
        confirm_probability=ledger.choose(
            ("lifecycle", "confirm_probability"), default=usual.confirm_probability
        ),
        certain_probability=ledger.choose(
            ("lifecycle", "certain_probability"), default=usual.certain_probability
        ),
        survival=ledger.choose(("lifecycle", "survival"), default=usual.survival),
    )


def _growth(ledger: Ledger, sensors: Sequence[Sensor]) -> GrowthLimits:
    usual = GrowthLimits()
    if all(sensor.measurement is MeasurementKind.BEARING for sensor in sensors):
        usual = GrowthLimits.of_bearings()
    elif all(sensor.scans is False for sensor in sensors):
        usual = GrowthLimits.of_lone_reports()
    names = [field.name for field in fields(GrowthLimits)]
    return GrowthLimits(
        **{name: ledger.choose(("growth", name), default=getattr(usual, name)) for name in names}
    )


def _search(ledger: Ledger, configuration: Configuration) -> tuple[Any, float | None]:
    """Return the solver and the deadline [ms]."""
    section = configuration.search
    preset = dict(ledger.preset.get("search", {}))
    if section.method not in {None, preset.get("method")}:
        # The preset's options are its own method's.
        preset = {}
    chosen = section.model_copy(update={**preset, **section.model_dump(exclude_unset=True)})
    solver = make_solver(chosen, configuration.name)
    ledger.choose(("search", "method"), default=DEFAULT_METHOD)
    for option in {**preset, **(section.model_extra or {})}:
        if option != "method":
            ledger.choose(("search", option))
    return solver, ledger.choose(("search", "deadline_ms"))
