"""The tables of ``tracker.toml`` on sensors."""

from typing import Annotated, Literal

from pydantic import Field, model_validator

from trackweave.config.fields import (
    AngleNoise,
    Coordinate,
    Density,
    Expected,
    Noise,
    Pair,
    Positive,
    Probability,
    Seconds,
    Section,
    one_of,
)
from trackweave.domain.measurements import MeasurementKind
from trackweave.models.sensors import DOUBTED

__all__ = ["FieldOfViewSection", "SensorSection", "SigmaTable", "StrengthSection"]

KINDS = tuple(kind.word for kind in MeasurementKind if kind is not MeasurementKind.RANGE_RATE)
Measurement = Annotated[
    str,
    one_of(KINDS),
    Field(json_schema_extra={"enum": list(KINDS)}),
    Expected("one of " + ", ".join(f'"{kind}"' for kind in KINDS) + ", or the name of a plug-in"),
]
Trust = Annotated[
    bool | list[Annotated[str, one_of(DOUBTED), Field(json_schema_extra={"enum": list(DOUBTED)})]],
    Expected("true, false, or a list of keys: " + ", ".join(f'"{key}"' for key in DOUBTED)),
]
Strength = Annotated[float, Field(ge=-1e12, le=1e12), Expected("a number")]

_TABLES = (
    {"x", "y"},
    {"x", "y", "z"},
    {"range_m", "azimuth_deg"},
    {"range_m", "azimuth_deg", "range_rate_mps"},
    {"range_m", "azimuth_deg", "elevation_deg"},
    {"range_m", "azimuth_deg", "elevation_deg", "range_rate_mps"},
    {"bearing_deg"},
)


class SigmaTable(Section):
    """Standard deviation by column."""

    x: Noise | None = None
    """East [m]."""

    y: Noise | None = None
    """North [m]."""

    z: Noise | None = None
    """Up [m]; needed for positions in three dimensions."""

    range_m: Noise | None = None
    """Range [m]."""

    azimuth_deg: AngleNoise | None = None
    """Azimuth [degrees]."""

    elevation_deg: AngleNoise | None = None
    """Elevation [degrees]."""

    range_rate_mps: Annotated[Noise, Expected("a number > 0 in m/s")] | None = None
    """Range rate [m/s]."""

    bearing_deg: AngleNoise | None = None
    """Bearing [degrees]."""

    @model_validator(mode="after")
    def _of_one_kind(self) -> "SigmaTable":
        if self.model_fields_set not in _TABLES:
            raise ValueError("one for each column of a measurement")
        return self


class FieldOfViewSection(Section):
    """Where a sensor sees: a ring sector around its position, a polygon, or what both share."""

    min_range_m: (
        Annotated[float, Field(ge=0, le=1e9), Expected("a number ≥ 0 in metres")] | None
    ) = None
    """Nearest range [m]."""

    max_range_m: (
        Annotated[float, Field(ge=1e-6, le=1e9), Expected("a number > 0 in metres")] | None
    ) = None
    """Farthest range [m]."""

    azimuth_deg: (
        Annotated[
            list[Annotated[float, Field(ge=-360, le=720)]],
            Field(min_length=2, max_length=2),
            Expected("two numbers from -360 to 720, such as [0, 360]"),
        ]
        | None
    ) = None
    """Where the sector starts and ends [degrees clockwise from north]."""

    polygon: (
        Annotated[
            list[Pair],
            Field(min_length=3),
            Expected("at least three corners, such as [[0, 0], [9, 0], [0, 9]]"),
        ]
        | None
    ) = None
    """Corners of a polygon [m], in order."""

    @model_validator(mode="after")
    def _ranges_in_order(self) -> "FieldOfViewSection":
        if self.max_range_m is not None and (self.min_range_m or 0.0) >= self.max_range_m:
            raise ValueError("min_range_m below max_range_m")
        return self


class StrengthSection(Section):
    """What the strength of a report tells of its origin: both kinds are about normal."""

    target_mean: Strength
    """Mean strength of reports of objects, in the unit of the column (best in decibels)."""

    target_sigma: Positive
    """Its standard deviation."""

    clutter_mean: Strength
    """Mean strength of false alarms."""

    clutter_sigma: Positive
    """Its standard deviation."""


class SensorSection(Section):
    """What a sensor measures, how well and how often."""

    measurement: Measurement | None = None
    """What its reports hold; read off the columns where left out."""

    sigma: (
        Annotated[
            Noise | SigmaTable,
            Expected(
                "a number > 0 in metres, or one for each column: {x = 10.0, y = 12.0}, "
                "{range_m = 70.0, azimuth_deg = 0.08} or {bearing_deg = 1.0}"
            ),
        ]
        | None
    ) = None
    """Standard deviation of a report: of a position along each axis [m], or by column; a report's
    own columns come first."""

    detection_probability: (
        Annotated[Probability, Expected("a number between 0 and 1, both excluded")] | None
    ) = None
    """Chance that a scan reports an object that it covers."""

    clutter_density: (
        Annotated[
            Density,
            Expected("a number > 0 per unit of what is measured (m², m³, m·rad, rad) and scan"),
        ]
        | None
    ) = None
    """False alarms per unit of what is measured (m², m³, m·rad, rad …) and scan."""

    clutter_per_scan: (
        Annotated[Positive, Expected("a number > 0 of false alarms per scan")] | None
    ) = None
    """False alarms per scan, uniform over what is covered; instead of ``clutter_density``."""

    scan_period: Seconds | None = None
    """Time from scan to scan, or of a turn [s]."""

    scans: Annotated[bool, Expected("true or false")] | None = None
    """Whether it looks, so that what it does not report was missed; false for one that hears
    objects report themselves, each at its own pace, as AIS does."""

    rotation: (
        Annotated[
            Literal["clockwise", "counter-clockwise", "none"],
            Expected('"clockwise", "counter-clockwise" or "none"'),
        ]
        | None
    ) = None
    """How its beam turns, seen from above, where reports carry their own times; or that it does
    not, so that each time is a scan."""

    position: (
        Annotated[
            list[Coordinate],
            Field(min_length=2, max_length=3),
            Expected("two or three numbers in metres, such as [0.0, 0.0]"),
        ]
        | None
    ) = None
    """Where the sensor stands, x, y[, z] [m]."""

    field_of_view: FieldOfViewSection | None = None
    """Where it sees; left out = as its silence tells beside other sensors, else everywhere."""

    strength: StrengthSection | None = None
    """What the strength of its reports tells; left out = nothing."""

    identity_error: (
        Annotated[Probability, Expected("a number between 0 and 1, both excluded")] | None
    ) = None
    """Chance that a report's identity is another than its object's was."""

    trust: Trust | None = None
    """Whether what is told is kept where reports contradict it: of all keys, or of those named."""

    @model_validator(mode="after")
    def _fits_together(self) -> "SensorSection":
        if self.clutter_density is not None and self.clutter_per_scan is not None:
            raise ValueError("clutter_density or clutter_per_scan, not both")
        if self.scans is False and not (
            self.scan_period is None and self.rotation in (None, "none")
        ):
            raise ValueError("scans = true with a scan_period or a rotation")
        return self
