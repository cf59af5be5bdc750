"""From what was given, estimated and usual to the values that a run uses."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from itertools import pairwise
from typing import Any, Literal

from trackweave.association.tree import GrowthLimits
from trackweave.config.presets import preset_values
from trackweave.config.search import DEFAULT_METHOD, make_solver
from trackweave.config.sections import Configuration, FieldOfViewSection, SensorSection
from trackweave.errors import InvalidInputError
from trackweave.estimation import Estimates
from trackweave.models.coverage import FieldOfView
from trackweave.models.motion import ConstantVelocity
from trackweave.models.sensors import Sensor
from trackweave.trackers.lifecycle import Lifecycle
from trackweave.trackers.window import Window

__all__ = ["ANY_SENSOR", "Settings", "fill", "known_sigma", "needs_estimates"]

# The table whose keys apply to every sensor that has none of its own.
ANY_SENSOR = "default"
ESTIMATED_OF_SENSOR = ("sigma", "detection_probability", "clutter_density", "scan_period")


@dataclass(frozen=True, slots=True)
class Settings:
    """A configuration without gaps, as the tracker takes it.

    Parameters
    ----------
    motion
        How objects move.
    sensors
        The sensors of the reports.
    window
        Scans that are open to change.
    lifecycle
        When tracks begin, are believed and end.
    search
        The solver; None for the tracker's own.
    growth
        What bounds the number of sequences.
    estimate
        What is told of a track.
    deadline
        Wall clock per scan [s]; None for no limit.
    period
        Least time between rows of a track [s]; None for every scan.
    values
        Every key with the value used, nested as in the file.
    sources
        Where each value came from: "file", "preset", "estimated" or "default", by dotted key.
    notes
        Sentences on what a user should know of them.
    """

    motion: ConstantVelocity
    sensors: tuple[Sensor, ...]
    window: Window
    lifecycle: Lifecycle
    search: Any
    growth: GrowthLimits
    estimate: Literal["average", "best"]
    deadline: float | None
    period: float | None
    values: Mapping[str, Any]
    sources: Mapping[str, str]
    notes: tuple[str, ...] = ()


@dataclass
class _Ledger:
    """Chooses values in order of precedence and writes down where each came from."""

    file: Mapping[str, Any]
    preset: Mapping[str, Any]
    values: dict[str, Any] = field(default_factory=dict)
    sources: dict[str, str] = field(default_factory=dict)

    def choose(self, path: Sequence[str], estimated: Any = None, default: Any = None) -> Any:
        """Return the value of a key and enter it."""
        for source, given in (("file", self.file), ("preset", self.preset)):
            for name in _names(path):
                value = _at(given, name)
                if value is not None:
                    return self.enter(path, value, source)
        if estimated is not None:
            return self.enter(path, estimated, "estimated")
        return self.enter(path, default, "default")

    def enter(self, path: Sequence[str], value: Any, source: str) -> Any:
        """Enter a value that has been chosen already; return it."""
        table = self.values
        for key in path[:-1]:
            table = table.setdefault(key, {})
        table[path[-1]] = value
        self.sources[".".join(path)] = source
        return value


def needs_estimates(configuration: Configuration, names: Sequence[str]) -> bool:
    """Tell whether a configuration leaves out anything that can be estimated.

    Parameters
    ----------
    configuration
        As read.
    names
        Names of the sensors.

    Returns
    -------
    False where every such key is given for every sensor.
    """
    given = configuration.as_file()
    paths = [("motion", "process_noise"), ("motion", "max_speed")]
    paths.append(("lifecycle", "new_target_density"))
    if any(_at(given, path) is None for path in paths):
        return True
    for name in names:
        own = _sensor_section(configuration, name)
        needed = {key for key in ESTIMATED_OF_SENSOR if getattr(own, key) is None}
        if own.clutter_per_scan is not None and own.field_of_view is not None:
            needed.discard("clutter_density")
        if needed:
            return True
    return False


def known_sigma(configuration: Configuration, names: Sequence[str]) -> dict[str, float]:
    """Return the noise that the configuration gives, by sensor [m].

    Parameters
    ----------
    configuration
        As read.
    names
        Names of the sensors.

    Returns
    -------
    One number per sensor that has one; the largest where axes differ.
    """
    given = {name: _sensor_section(configuration, name).sigma for name in names}
    return {
        name: sigma if isinstance(sigma, float | int) else max(sigma.x, sigma.y, sigma.z or 0.0)
        for name, sigma in given.items()
        if sigma is not None
    }


def fill(
    configuration: Configuration,
    estimates: Estimates | None,
    names: Sequence[str],
    *,
    preset: str | None = None,
) -> Settings:
    """Return a configuration without gaps.

    What the file says comes first, for a sensor its own table before ``sensors.default``; then
    what the preset says; then what was estimated; then the usual.

    Parameters
    ----------
    configuration
        As read.
    estimates
        What the reports tell; None where the configuration leaves nothing to estimate.
    names
        Names of the sensors of the reports.
    preset
        Name of a preset, None for none.

    Returns
    -------
    Everything that a tracker needs, and where each value came from.

    Raises
    ------
    InvalidInputError
        If the preset is unknown, or values given apart do not fit together.
    """
    ledger = _Ledger(configuration.as_file(), preset_values(preset))
    ledger.enter(
        ("seed",), configuration.seed, "default" if configuration.seed is None else "file"
    )
    ledger.choose(("motion", "model"), default="constant-velocity")
    motion = ConstantVelocity(
        process_noise=ledger.choose(
            ("motion", "process_noise"), estimates and estimates.process_noise
        ),
        max_speed=ledger.choose(("motion", "max_speed"), estimates and estimates.max_speed),
    )
    sensors = tuple(_sensor(ledger, configuration, estimates, name) for name in names)
    window = Window(
        depth=ledger.choose(("window", "depth"), default=Window().depth),
        max_scans=ledger.choose(("window", "max_scans"), default=Window().max_scans),
    )
    lifecycle = _lifecycle(ledger, estimates)
    search, deadline = _search(ledger, configuration)
    period = ledger.choose(("output", "period"))
    unused = [name for name in configuration.sensors if name not in (*names, ANY_SENSOR)]
    notes = [f"sensors.{name}: no report is from this sensor" for name in unused]
    notes += _doubts(ledger, estimates)
    if getattr(search, "settle", True) is False:
        # The document of the preset hillis-1997 knows no false alarms.
        notes.append("search.settle is off: each lone report counts as a track of one report")
    return Settings(
        motion, sensors, window, lifecycle, search, _growth(ledger),
        ledger.choose(("output", "estimate"), default="average"),
        None if deadline is None else deadline / 1000.0,
        period, ledger.values, ledger.sources, tuple(notes),
    )  # fmt: skip


def _doubts(ledger: _Ledger, estimates: Estimates | None) -> list[str]:
    """Return a sentence on each sensor whose estimates are used although they are doubtful."""
    notes = []
    for name, doubt in (estimates.doubts if estimates else {}).items():
        keys = [f"sensors.{name}.sigma", f"sensors.{name}.detection_probability"]
        keys += ["motion.process_noise", "motion.max_speed"]
        used = [key for key in keys if ledger.sources.get(key) == "estimated"]
        if used:
            notes.append(f"sensor {name}: {doubt}; better give {', '.join(used)}")
    return notes


def _sensor(
    ledger: _Ledger, configuration: Configuration, estimates: Estimates | None, name: str
) -> Sensor:
    section = _sensor_section(configuration, name)
    found = estimates.sensors.get(name) if estimates else None

    def choose(key: str, estimated: Any = None, default: Any = None) -> Any:
        return ledger.choose(("sensors", name, key), estimated, default)

    choose("measurement", default="position")
    sigma = choose("sigma", found and found.sigma)
    if isinstance(sigma, Mapping):
        sigma = tuple(sigma[axis] for axis in ("x", "y", "z") if sigma.get(axis) is not None)
    detection = choose("detection_probability", found and found.detection_probability)
    position = choose("position")
    view = choose("field_of_view")
    if section.clutter_per_scan is not None:
        choose("clutter_per_scan")
        area = _area_of(section.field_of_view) or (found.covered if found else None)
        if area is None:
            raise InvalidInputError(
                f"sensors.{name}.clutter_per_scan: needs an area; expected a field_of_view too, "
                "or clutter_density"
            )
        clutter = ledger.enter(
            ("sensors", name, "clutter_density"), section.clutter_per_scan / area, "file"
        )
    else:
        clutter = choose("clutter_density", found and found.clutter_density)
    return Sensor(
        name=name,
        sigma=sigma,
        detection_probability=detection,
        clutter_density=clutter,
        scan_period=choose("scan_period", found and found.scan_period),
        field_of_view=None if view is None else _field_of_view(section, position),
    )


def _lifecycle(ledger: _Ledger, estimates: Estimates | None) -> Lifecycle:
    usual = Lifecycle()
    confirm = ledger.choose(
        ("lifecycle", "confirm"), default=f"{usual.confirm_hits}/{usual.confirm_opportunities}"
    )
    hits, opportunities = confirm.split("/")
    return Lifecycle(
        confirm_hits=int(hits),
        confirm_opportunities=int(opportunities),
        delete_after_misses=ledger.choose(
            ("lifecycle", "delete_after_misses"), default=usual.delete_after_misses
        ),
        new_target_density=ledger.choose(
            ("lifecycle", "new_target_density"), estimates and estimates.new_target_density
        ),
        initial_target_density=ledger.choose(
            ("lifecycle", "initial_target_density"), estimates and estimates.initial_target_density
        ),
        confirm_probability=ledger.choose(
            ("lifecycle", "confirm_probability"), default=usual.confirm_probability
        ),
        certain_probability=ledger.choose(
            ("lifecycle", "certain_probability"), default=usual.certain_probability
        ),
        survival=ledger.choose(("lifecycle", "survival"), default=usual.survival),
    )


def _growth(ledger: _Ledger) -> GrowthLimits:
    usual = GrowthLimits()
    names = [field.name for field in fields(GrowthLimits)]
    return GrowthLimits(
        **{name: ledger.choose(("growth", name), default=getattr(usual, name)) for name in names}
    )


def _search(ledger: _Ledger, configuration: Configuration) -> tuple[Any, float | None]:
    """Return the solver and the deadline [ms]."""
    section = configuration.search
    preset = dict(ledger.preset.get("search", {}))
    if section.method not in {None, preset.get("method")}:
        # The preset's options are its own method's.
        preset = {}
    chosen = section.model_copy(update={**preset, **section.model_dump(exclude_unset=True)})
    solver = make_solver(chosen)
    ledger.choose(("search", "method"), default=DEFAULT_METHOD)
    for option in {**preset, **(section.model_extra or {})}:
        if option != "method":
            ledger.choose(("search", option))
    return solver, ledger.choose(("search", "deadline_ms"))


def _sensor_section(configuration: Configuration, name: str) -> SensorSection:
    """Return a sensor's own keys over those for every sensor."""
    usual = configuration.sensors.get(ANY_SENSOR, SensorSection())
    own = configuration.sensors.get(name, SensorSection())
    update = {key: getattr(own, key) for key in own.model_fields_set}
    # Of the two ways to tell the clutter, the sensor's own wins.
    if update.get("clutter_density") is not None:
        update["clutter_per_scan"] = None
    elif update.get("clutter_per_scan") is not None:
        update["clutter_density"] = None
    return usual.model_copy(update=update)


def _field_of_view(section: SensorSection, position: Sequence[float] | None) -> FieldOfView:
    view = section.field_of_view or FieldOfViewSection()
    east, north = (position or (0.0, 0.0))[:2]
    turn = view.azimuth_deg or (0.0, 360.0)
    return FieldOfView(
        position=(east, north),
        min_range=view.min_range_m or 0.0,
        max_range=float("inf") if view.max_range_m is None else view.max_range_m,
        azimuth_deg=(turn[0], turn[1]),
        polygon=None if view.polygon is None else [(x, y) for x, y in view.polygon],
    )


def _area_of(view: FieldOfViewSection | None) -> float | None:
    """Return the area of a field of view that has a simple one [m²]."""
    if view is None or (view.polygon is not None and view.max_range_m is not None):
        return None
    if view.polygon is not None:
        corners = [*view.polygon, view.polygon[0]]
        twice = sum(a[0] * b[1] - b[0] * a[1] for a, b in pairwise(corners))
        return abs(twice) / 2 or None
    if view.max_range_m is None:
        return None
    start, end = view.azimuth_deg or (0.0, 360.0)
    width = 360.0 if end - start >= 360 else (end - start) % 360 or 360.0
    ring = view.max_range_m**2 - (view.min_range_m or 0.0) ** 2
    return float(math.pi * ring * width / 360.0)


def _names(path: Sequence[str]) -> list[Sequence[str]]:
    """Return where a key may stand: for a sensor, in its own table or in that for every one."""
    if path[0] == "sensors":
        return [path, ("sensors", ANY_SENSOR, *path[2:])]
    return [path]


def _at(values: Mapping[str, Any], path: Sequence[str]) -> Any:
    found: Any = values
    for key in path:
        if not isinstance(found, Mapping) or key not in found:
            return None
        found = found[key]
    return found
