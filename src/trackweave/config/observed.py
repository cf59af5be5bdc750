"""What a configuration has to fit: the sensors of a table of reports."""

from dataclasses import dataclass

from trackweave.domain.foreign_kind import ForeignKind
from trackweave.domain.measurements import MeasurementKind
from trackweave.models.coverage import FieldOfView
from trackweave.models.rotation import Rotation

__all__ = ["UNKNOWN_SENSOR", "ObservedSensor"]


@dataclass(frozen=True, slots=True)
class ObservedSensor:
    """What one sensor's reports show without any estimating."""

    measurement: MeasurementKind | ForeignKind = MeasurementKind.POSITION  # What they hold
    dim: int = 2
    says_where: bool = False  # Whether each report tells where the sensor was
    # Whether it has to be known where the sensor is, because it does not report positions and is
    # not the only one.
    needs_place: bool = False
    extent: float = 1.0  # The size of the space that its measurements fill, in their own units
    usual_range: float = 1000.0  # Median distance of its reports [m]
    reports_per_scan: float = 1.0  # Their mean number
    scan_period: float | None = None  # Time from scan to scan [s], None where it does not scan
    rotation: Rotation | None = None  # How its beam turns, as far as reports tell
    is_turn_sure: bool = True  # Whether they show so
    field_of_view: FieldOfView | None = None  # As far as its silence tells; None for everywhere


UNKNOWN_SENSOR = ObservedSensor()
