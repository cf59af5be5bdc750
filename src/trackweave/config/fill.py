"""From what was given, estimated and usual to the values that a run uses."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Literal

from trackweave.association.growth_limits import GrowthLimits
from trackweave.config.load import Configuration, without_deadline
from trackweave.config.moving import motion_of
from trackweave.config.plots import (
    PlotSettings,
    TrackerSettings,
    plots_of_sources,
    tracker_of_sources,
)
from trackweave.config.presets import preset_notes, preset_values
from trackweave.config.search import DEFAULT_METHOD, make_solver
from trackweave.config.sections import (
    LifecycleSection,
    LiveSection,
    MotionSection,
    OutputSection,
)
from trackweave.config.sensing import UNKNOWN_SENSOR, ObservedSensor, require_places, sensor_of
from trackweave.config.sources import ANY_SENSOR, Sources, value_at
from trackweave.estimation.estimates import Estimates
from trackweave.keys import suggest
from trackweave.models.foreign_motion import AnyMotion
from trackweave.models.sensors import Sensor
from trackweave.trackers.lifecycle import Lifecycle
from trackweave.trackers.window import Window

__all__ = [
    "ANY_SENSOR", "UNUSED", "Settings", "fill", "known_sigma", "left_out", "needs_estimates",
]  # fmt: skip

ESTIMATED = (
    ("motion", "process_noise"), ("motion", "max_speed"), ("lifecycle", "new_target_density"),
)  # fmt: skip
# Of more sensors than this no list helps.
MOST_NAMED = 20
UNUSED = "[sensors."
"""How a note begins on a table that is not used; such notes come first."""
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
    max_ahead: float = (
        LiveSection.max_ahead
    )  # How far a scan's time may jump ahead of all others [s]
    # For how long reports of sensors that do not look are gathered before they are searched [s];
    # None for each time by itself.
    together: float | None = None
    divide: bool = LifecycleSection.divide  # Whether tracks may end in two
    join: bool = LifecycleSection.join  # Whether ends and later beginnings may be one object
    merge: float | None = None  # Nearer than this two tracks may share a report [m]
    # Told keys, by which tracks are far likelier than by what reports seem to say of them.
    confirmed: tuple[str, ...] = ()


def needs_estimates(configuration: Configuration, names: Sequence[str]) -> bool:
    """Tell whether a configuration leaves out, for any sensor, what can be estimated."""
    return bool(left_out(configuration, names))


def left_out(configuration: Configuration, names: Sequence[str]) -> list[str]:
    """Return the keys that a configuration leaves out and that can be estimated.

    Parameters
    ----------
    configuration
        What was told.
    names
        Its sensors.

    Returns
    -------
    Dotted keys.
    """
    given = configuration.plugins.put_back(configuration.values)
    missing = [".".join(path) for path in ESTIMATED if value_at(given, path) is None]
    for name in names:
        own = configuration.sensor(name)
        needed = [key for key in ESTIMATED_OF_SENSOR if key not in own]
        if own.get("scans") is False:
            needed = [key for key in needed if key != "scan_period"]
        if "clutter_per_scan" in own and "field_of_view" in own:
            needed = [key for key in needed if key != "clutter_density"]
        missing += [f"sensors.{name}.{key}" for key in needed]
    return missing


def known_sigma(configuration: Configuration, names: Sequence[str]) -> dict[str, float]:
    """Return the noise of positions that the configuration gives, by sensor [m]."""
    # Sensors without are left out; it is the largest where axes differ.
    given = {name: configuration.sensor(name).get("sigma") for name in names}
    return {
        name: max(sigma.values()) if isinstance(sigma, Mapping) else sigma
        for name, sigma in given.items()
        if sigma is not None and (not isinstance(sigma, Mapping) or "x" in sigma)
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
    sources = Sources(configuration.plugins.put_back(configuration.values), preset_values(preset))
    seed = configuration.said("seed")
    sources.enter(("seed",), seed, "default" if seed is None else "file")
    seen = observed or {}
    # Files begin with how objects move, which takes the sensors' periods to fill.
    sources.values["motion"] = {}
    require_places(
        lambda name: sources.said(("sensors", name, "position")),
        {name: seen[name] for name in names if name in seen},
    )
    sensors = tuple(
        sensor_of(
            sources,
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
    motion = configuration.plugins.moving(sources) or motion_of(
        sources, told, min(periods, default=1.0), ways
    )
    unscented = sources.choose(("motion", "filter"), default=MotionSection.filter) == "unscented"
    window = sources.filled("window", Window(), estimates)
    lifecycle = _lifecycle(sources, estimates)
    divide = sources.choose(("lifecycle", "divide"), default=LifecycleSection.divide)
    join = sources.choose(("lifecycle", "join"), default=LifecycleSection.join)
    merge = sources.choose(("lifecycle", "merge"), None)
    sources.choose(("lifecycle", "at_rest"), default=LifecycleSection.at_rest)
    search, deadline = _search(sources, configuration)
    max_ahead = sources.choose(("live", "max_ahead"), default=LiveSection.max_ahead)
    usual = estimates and (estimates.period or _beside_lone(sensors))
    period = sources.choose(("output", "period"), usual)
    tracker, doubts = tracker_of_sources(sources)
    plots = plots_of_sources(sources, sensors, lifecycle)
    unused = [name for name in configuration.table("sensors") if name not in (*names, ANY_SENSOR)]
    notes = [_unused(name, names[:MOST_NAMED]) for name in unused]
    notes += [*(estimates.notes if estimates else ()), *_doubts(sources, estimates)]
    notes += (
        doubts + _overruled(sources, preset) + preset_notes(preset) + _sooner(lifecycle, sources)
    )
    if divide and join and sources.sources.get("lifecycle.join") != "default":
        but = "" if merge is None else " but through merges"
        notes.append(f"lifecycle.join: where tracks may divide, no later track is joined{but}")
    if getattr(search, "settle", True) is False:
        # The document of the preset hillis-1997 knows no false alarms.
        notes.append("search.settle is off: each lone report counts as a track of one report")
    return Settings(
        motion, sensors, window, lifecycle, search, _growth(sources, sensors),
        sources.choose(("output", "estimate"), default=OutputSection.estimate),
        None if deadline is None else deadline / 1000.0,
        period, sources.values, sources.sources, tuple(notes), unscented, tracker, plots,
        max_ahead, estimates.together if estimates else None, divide, join, merge,
        estimates.confirmed if estimates else (),
    )  # fmt: skip


def _unused(name: str, names: Sequence[str]) -> str:
    """Return a sentence on a sensor's table that no report is of."""
    hint = suggest(name, names)
    hint = hint if hint.startswith("did") else f"the reports are of {', '.join(names)}"
    return f"{UNUSED}{name}]: not used, for no report is of a sensor {name}; {hint}"


def _doubts(sources: Sources, estimates: Estimates | None) -> list[str]:
    """Return a sentence on each sensor whose estimates are used although they are doubtful."""
    notes = []
    for name, doubt in (estimates.doubts if estimates else {}).items():
        keys = [f"sensors.{name}.sigma", f"sensors.{name}.detection_probability"]
        keys += ["motion.process_noise", "motion.max_speed"]
        used = [key for key in keys if sources.sources.get(key) == "estimated"]
        if used:
            notes.append(f"sensor {name}: {doubt}; better give {', '.join(used)}")
    return notes


def _sooner(lifecycle: Lifecycle, sources: Sources) -> list[str]:
    """Return a sentence where tracks are confirmed before they have the hits that are told."""
    certain, came = lifecycle.certain_probability, sources.sources
    is_told = (came.get("lifecycle.confirm"), came.get("lifecycle.certain_probability"))
    if is_told != ("file", "default") or lifecycle.confirm_hits <= Lifecycle().confirm_hits:
        return []
    return [
        f"lifecycle.confirm: a track whose object is certain by {certain:g} is confirmed "
        f"before it has {lifecycle.confirm_hits} hits; give certain_probability = 1 for hits alone"
    ]


def _overruled(sources: Sources, preset: str | None) -> list[str]:
    """Return a sentence where the file says otherwise than the preset."""
    others = [
        ".".join(path)
        for path, value in _leaves(sources.preset)
        if value_at(sources.file, path) not in (None, value)
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


def _beside_lone(sensors: Sequence[Sensor]) -> float | None:
    """Return the time between rows beside sensors that hear objects report themselves, if any."""
    # Each such report is a moment at which all tracks could be shown.
    looking = [each.scan_period for each in sensors if each.scan_period is not None]
    is_lone = any(each.scans is False for each in sensors)
    return min(looking) if is_lone and looking else None


def _lifecycle(sources: Sources, estimates: Estimates | None) -> Lifecycle:
    usual = Lifecycle()
    rate = f"{usual.confirm_hits}/{usual.confirm_opportunities}"
    hits, _, opportunities = sources.choose(("lifecycle", "confirm"), default=rate).partition("/")
    usual = replace(usual, confirm_hits=int(hits), confirm_opportunities=int(opportunities))
    return sources.filled("lifecycle", usual, estimates)


def _growth(sources: Sources, sensors: Sequence[Sensor]) -> GrowthLimits:
    usual = GrowthLimits()
    if all(sensor.measurement.is_bearing_only for sensor in sensors):
        usual = GrowthLimits.of_bearings()
    elif all(sensor.scans is False for sensor in sensors):
        usual = GrowthLimits.of_lone_reports()
    return sources.filled("growth", usual)


def _search(sources: Sources, configuration: Configuration) -> tuple[Any, float | None]:
    """Return the solver and the deadline [ms]."""
    given = without_deadline(configuration.table("search"))
    preset = dict(sources.preset.get("search", {}))
    if given.get("method") not in {None, preset.get("method")}:
        # The preset's options are its own method's.
        preset = {}
    solver = make_solver({**preset, **given}, configuration.name)
    sources.choose(("search", "method"), default=DEFAULT_METHOD)
    for option in {**preset, **given}:
        if option != "method":
            sources.choose(("search", option))
    return solver, sources.choose(("search", "deadline_ms"))
