"""From the keys of ``[sensors.NAME]`` to a sensor."""

import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, fields, replace
from itertools import pairwise
from typing import Any

import numpy as np

from trackweave.config.load import Configuration
from trackweave.config.sources import Sources
from trackweave.domain.foreign_kind import ForeignKind
from trackweave.domain.measurements import MeasurementKind
from trackweave.errors import InvalidInputError
from trackweave.estimation.estimates import SensorEstimate
from trackweave.keys import show_value
from trackweave.models.coverage import FieldOfView
from trackweave.models.rotation import Rotation
from trackweave.models.sensors import BIASES, Sensor
from trackweave.models.strength import StrengthModel

__all__ = [
    "UNKNOWN_SENSOR",
    "ObservedSensor",
    "is_period",
    "require_places",
    "sense_of",
    "sensor_of",
    "told_rotation",
    "view_keys",
]


@dataclass(frozen=True, slots=True)
class ObservedSensor:
    """What one sensor's reports show without any estimating."""

    measurement: MeasurementKind | ForeignKind = MeasurementKind.POSITION  # What they hold
    dim: int = 2
    says_where: bool = False  # Whether each report tells where the sensor was
    # Whether it has to be known where the sensor is, because it does not report positions and is
    # not the only one.
    needs_place: bool = False
    plane: str = ""  # What is known of the plane on which it would be, for whoever has to say
    extent: float = 1.0  # The size of the space that its measurements fill, in their own units
    usual_range: float = 1000.0  # Median distance of its reports [m]
    reports_per_scan: float = 1.0  # Their mean number
    scan_period: float | None = None  # Time from scan to scan [s], None where it does not scan
    rotation: Rotation | None = None  # How its beam turns, as far as reports tell
    is_turn_sure: bool = True  # Whether they show so
    field_of_view: FieldOfView | None = None  # As far as its silence tells; None for everywhere


UNKNOWN_SENSOR = ObservedSensor()


USUAL: dict[str, Any] = {field.name: field.default for field in fields(Sensor)}
# Keys that are taken as they are, in the order of a complete configuration; those of them that
# are not estimated where nothing is.
PLAIN = (
    "identity_error", "hidden_share", "mean_silence", "echoes", "clutter_persistence",
    "sigma_at", "tail_share", "tail_scale", "tail_persistence", "sigma_height", "height_offset",
    "extent", "trust",
)  # fmt: skip
NONE_AT_ZERO = {
    "hidden_share", "echoes", "clutter_persistence", "sigma_at", "tail_share", "tail_persistence",
    "height_offset", "extent",
}  # fmt: skip
# What is taken where neither the file nor the reports tell.
USUAL_CLUTTER_SHARE = 0.1
USUAL_SIGMA = {
    "azimuth_deg": 0.5,
    "elevation_deg": 0.5,
    "range_rate_mps": 1.0,
    "bearing_deg": 1.0,
}
USUAL_RANGE_SHARE = 0.01
# A period that is told is one found in the reports if it differs by less than this share.
PERIOD_AGREES = 0.002
FULL_TURN = (0.0, 360.0)
# In a message.
MOST_NAMED, MOST_SHOWN = 20, 3
FINEST_ANGLE_DEG, COARSEST_ANGLE_DEG = 1e-3, 20.0


def require_places(said: Callable[[str], Any], observed: Mapping[str, ObservedSensor]) -> None:
    """Refuse sensors of which nobody says where they stand, all at once."""
    # ``said`` returns what is told of a sensor's position, None for nothing.
    missing = {
        name: " and ".join(seen.measurement.columns(seen.dim)[:2])
        for name, seen in observed.items()
        if seen.needs_place and not seen.says_where and said(name) is None
    }
    if not missing:
        return
    # In TOML every name may be quoted.
    tables = ", ".join(
        f"[sensors.{json.dumps(name, ensure_ascii=False)}]" for name in [*missing][:MOST_SHOWN]
    )
    tables += ", …" if len(missing) > MOST_SHOWN else ""
    keys = ", ".join(f"sensors.{name}.position" for name in [*missing][:MOST_NAMED])
    more = f" and {len(missing) - MOST_NAMED} more" if len(missing) > MOST_NAMED else ""
    where, whose = ("the sensor stands", "its") if len(missing) == 1 else ("each stands", "their")
    columns = " or ".join(dict.fromkeys(missing.values()))
    raise InvalidInputError(
        f"{keys}{more}: left out; expected where {where}, [x, y] in metres, because {whose} "
        f"{columns} count from there: under {tables} a line such as position = [0.0, 0.0], or "
        "place = [latitude, longitude] in degrees (or columns sensor_x,sensor_y, or "
        "sensor_lat,sensor_lon in degrees, of a table, which `trackweave convert` makes of any "
        "format)" + next((f". {seen.plane}" for seen in observed.values() if seen.plane), "")
    )


def sensor_of(
    sources: Sources,
    configuration: Configuration,
    found: SensorEstimate | None,
    name: str,
    seen: ObservedSensor,
) -> Sensor:
    """Return a sensor, and enter each value; refuse what does not fit its reports."""
    section = configuration.sensor(name)

    def choose(key: str, estimated: Any = None, default: Any = None) -> Any:
        return sources.choose(("sensors", name, key), estimated, default)

    kind = seen.measurement
    said = choose("measurement", default=kind.word)
    if said != kind.word:
        raise InvalidInputError(
            f'sensors.{name}.measurement: "{said}"; expected "{kind.word}", as its reports hold'
        )
    if found is not None and sources.said(("sensors", name, "sigma")) is not None:
        # What is told holds everywhere.
        found = replace(found, sigma_at=())
    sigma = _sigma(choose("sigma", *_likely_sigma(found, seen)), name, seen)
    if isinstance(kind, ForeignKind):
        configuration.plugins.enter(name, kind, sources)
    detection = choose("detection_probability", *_likely(found, "detection_probability"))
    for key in BIASES:
        # They are taken out of reports before anything else.
        if sources.said(("sensors", name, key)) is not None:
            choose(key)
    position = choose("position")
    view = choose("field_of_view", view_keys(seen.field_of_view))
    clutter = _clutter(sources, section, (name, found, seen))
    rotation, period = _rotation(sources, (name, found, seen))
    likely_scans = True if period is not None or rotation is not None else found and found.scans
    scans = choose("scans", likely_scans)
    likely = None if found is None or found.strength is None else asdict(found.strength)
    strength = choose("strength", likely)
    return Sensor(
        name=name,
        sigma=sigma,
        detection_probability=detection,
        clutter_density=clutter,
        scan_period=period,
        field_of_view=None if view is None else _field_of_view(view, position),
        measurement=kind,
        position=None if position is None else tuple(position),
        rotation=rotation,
        strength=None if strength is None else StrengthModel(**strength),
        scans=scans,
        **{key: choose(key, *_likely(found, key)) for key in PLAIN},
    )


def _likely(found: SensorEstimate | None, key: str) -> tuple[Any, Any]:
    """Return the value of a key as estimated, None for none, and as usual."""
    value, usual = getattr(found, key, None), USUAL[key]
    if key in {"echoes", "sigma_at"}:
        # As files hold them, which a complete configuration is read from again.
        value, usual = [*map(list, value or ())], []
    return None if key in NONE_AT_ZERO and not value else value, usual


def view_keys(view: FieldOfView | None) -> dict[str, Any] | None:
    """Return the keys of a file that bound a field of view, None for none."""
    if view is None:
        return None
    keys: dict[str, Any] = {}
    if math.isfinite(view.max_range):
        keys["max_range_m"] = view.max_range
    if view.azimuth_deg != (0.0, 360.0):
        keys["azimuth_deg"] = list(view.azimuth_deg)
    if view.polygon is not None:
        keys["polygon"] = [list(corner) for corner in view.polygon]
    return keys


def _likely_sigma(found: SensorEstimate | None, seen: ObservedSensor) -> tuple[Any, Any]:
    """Return the noise as estimated and as usual, in the units of a file; None for none."""
    kind = seen.measurement
    sigma = None if found is None else found.sigma
    if kind.is_position:
        if found is not None and found.axes is not None:
            return dict(zip(kind.columns(3), found.axes, strict=False)), None
        return sigma, None
    if isinstance(kind, ForeignKind):
        return None, USUAL["sigma"]
    columns = kind.columns(seen.dim)
    usual = {**USUAL_SIGMA, "range_m": USUAL_RANGE_SHARE * seen.usual_range}
    default = {column: usual[column] for column in columns}
    if sigma is None or not (kind.has_range or isinstance(sigma, Sequence)):
        return None, default
    if isinstance(sigma, Sequence):
        turned = [
            math.degrees(number) if column.endswith("_deg") else number
            for column, number in zip(columns, sigma, strict=True)
        ]
        return dict(zip(columns, turned, strict=True)), default
    # Estimated in metres on the plane: along the range, and across it at the usual range.
    across = float(
        np.clip(math.degrees(sigma / seen.usual_range), FINEST_ANGLE_DEG, COARSEST_ANGLE_DEG)
    )
    angles = {column: across for column in columns if column.endswith("_deg")}
    return {**default, "range_m": float(sigma), **angles}, default


def _sigma(value: Any, name: str, seen: ObservedSensor) -> float | tuple[float, ...]:
    """Return the noise by component [m, rad, m/s]."""
    kind = seen.measurement
    is_single = kind.is_position or isinstance(kind, ForeignKind)
    if is_single and not isinstance(value, Mapping):
        return float(value)
    columns = kind.columns(3 if kind.is_position else seen.dim)
    # One number is of the one column that a bearing has, in its unit.
    only = {columns[0]: value} if len(columns) == 1 else {}
    given = value if isinstance(value, Mapping) else only
    numbers = {key: number for key, number in given.items() if number is not None}
    least = columns[:2] if kind.is_position else columns
    if not set(least) <= set(numbers) <= set(columns):
        expected = ", ".join(f"{column} = …" for column in least)
        raise InvalidInputError(
            f"sensors.{name}.sigma: {show_value(value)}; expected {{{expected}}}, because its "
            f"reports hold {kind.word}"
        )
    return tuple(
        math.radians(numbers[column]) if column.endswith("_deg") else float(numbers[column])
        for column in columns
        if column in numbers
    )


def _clutter(
    sources: Sources,
    section: Mapping[str, Any],
    sensor: tuple[str, SensorEstimate | None, ObservedSensor],
) -> float:
    """Return the false alarms per unit of what is measured, and scan."""
    name, found, seen = sensor
    path = ("sensors", name, "clutter_density")
    is_position = seen.measurement.is_position
    if "clutter_per_scan" in section:
        sources.choose(("sensors", name, "clutter_per_scan"))
        volume = _volume_of(section.get("field_of_view"), seen)
        if volume is None:
            volume = found.covered if found and is_position else None
        if volume is None and not is_position:
            volume = seen.extent
        if volume is None:
            raise InvalidInputError(
                f"sensors.{name}.clutter_per_scan: needs an area; expected a field_of_view too, "
                "or clutter_density"
            )
        return float(sources.enter(path, section["clutter_per_scan"] / volume, "file"))
    if is_position:
        return float(sources.choose(path, found and found.clutter_density))
    density = None
    tells = seen.measurement.has_range or seen.measurement.is_bearing_only
    if found is not None and (tells or isinstance(found.sigma, Sequence)):
        in_own_units = isinstance(found.sigma, Sequence)
        scale = 1.0 if in_own_units else found.covered / seen.extent
        density = found.clutter_density * scale
    usual = USUAL_CLUTTER_SHARE * seen.reports_per_scan / seen.extent
    return float(sources.choose(path, density, usual))


def _rotation(
    sources: Sources, sensor: tuple[str, SensorEstimate | None, ObservedSensor]
) -> tuple[Rotation | None, float | None]:
    """Return how the beam turns, and the scan period [s]."""
    name, found, seen = sensor
    turning = seen.rotation
    likely = found.scan_period if found else seen.scan_period
    if sources.said(("sensors", name, "scans")) is False:
        turning = likely = None
    period = sources.choose(
        ("sensors", name, "scan_period"), turning.period if turning else likely
    )
    seen_word = None if turning is None else sense_of(turning)
    word = sources.choose(("sensors", name, "rotation"), seen_word, "none")
    if sources.said(("sensors", name, "phase_deg")) is not None:
        sources.choose(("sensors", name, "phase_deg"))
    if word == "none":
        return None, period
    if seen_word is not None and word != seen_word:
        sources.enter(("sensors", name, "rotation"), seen_word, "estimated")
    if turning is not None and period and not is_period(period, turning):
        # The reports' own times and directions measure it better than any data sheet.
        period = sources.enter(("sensors", name, "scan_period"), turning.period, "estimated")
    if turning is None:
        raise InvalidInputError(
            f'sensors.{name}.rotation: "{word}"; expected a scan_period with it, because its '
            "reports show no turn, or none of it"
        )
    return turning, period


def told_rotation(section: Mapping[str, Any]) -> Rotation | None:
    """Return how a beam turns where a sensor's keys leave nothing of it open."""
    if "phase_deg" not in section:
        return None
    direction = 1 if section["rotation"] == "clockwise" else -1
    return Rotation(section["scan_period"], math.radians(section["phase_deg"]), direction)


def sense_of(turning: Rotation) -> str:
    """Return the word for the sense in which a beam turns."""
    return "clockwise" if turning.direction > 0 else "counter-clockwise"


def is_period(told: float, turning: Rotation) -> bool:
    """Tell whether a scan period [s] is that of the turn that reports show, as data sheets go."""
    return abs(turning.period / told - 1.0) <= PERIOD_AGREES


def _field_of_view(keys: Mapping[str, Any], position: Sequence[float] | None) -> FieldOfView:
    east, north = (position or (0.0, 0.0))[:2]
    return FieldOfView(
        position=(east, north),
        min_range=keys.get("min_range_m", 0.0),
        max_range=keys.get("max_range_m", math.inf),
        azimuth_deg=keys.get("azimuth_deg", FULL_TURN),
        polygon=keys.get("polygon"),
    )


def _volume_of(view: Mapping[str, Any] | None, seen: ObservedSensor) -> float | None:
    """Return how much of what is measured a simple field of view holds, None for others."""
    if seen.measurement.is_position:
        return _area_of(view or {})
    if view is None or "polygon" in view:
        return None
    width = math.radians(_width_of(view))
    if seen.measurement.is_bearing_only:
        return width
    if "max_range_m" not in view or len(seen.measurement.columns(seen.dim)) > 2:
        return None
    return float((view["max_range_m"] - view.get("min_range_m", 0.0)) * width)


def _width_of(view: Mapping[str, Any]) -> float:
    start, end = view.get("azimuth_deg", FULL_TURN)
    return 360.0 if end - start >= 360 else (end - start) % 360 or 360.0


def _area_of(view: Mapping[str, Any]) -> float | None:
    """Return the area of a field of view that has a simple one [m²]."""
    if ("polygon" in view) == ("max_range_m" in view):
        return None
    if "polygon" in view:
        corners = [*view["polygon"], view["polygon"][0]]
        twice = sum(a[0] * b[1] - b[0] * a[1] for a, b in pairwise(corners))
        return abs(twice) / 2 or None
    ring = view["max_range_m"] ** 2 - view.get("min_range_m", 0.0) ** 2
    return float(math.pi * ring * _width_of(view) / 360.0)
