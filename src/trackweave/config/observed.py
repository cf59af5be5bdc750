"""What a configuration has to fit: the sensors of a table of reports."""

from dataclasses import dataclass

from trackweave.domain.measurements import MeasurementKind
from trackweave.models.coverage import FieldOfView
from trackweave.models.rotation import Rotation

__all__ = ["UNKNOWN_SENSOR", "ObservedSensor"]


@dataclass(frozen=True, slots=True)
class ObservedSensor:
    """What one sensor's reports show without any estimating.

    Parameters
    ----------
    measurement
        What they hold.
    dim
        Number of dimensions of the tracking space.
    says_where
        Whether each report tells where the sensor was.
    needs_place
        Whether it has to be known where the sensor is, because it does not report positions and
        is not the only one.
    extent
        How far its measurements reach: the size of the space that they fill, in their own units.
    usual_range
        Median distance of its reports [m].
    reports_per_scan
        Their mean number.
    scan_period
        Time from scan to scan [s], None where it does not scan.
    rotation
        How its beam turns, as far as reports tell.
    is_turn_sure
        Whether they show so.
    field_of_view
        Where it sees, as far as its silence tells; None for everywhere.
    """

    measurement: MeasurementKind = MeasurementKind.POSITION
    dim: int = 2
    says_where: bool = False
    needs_place: bool = False
    extent: float = 1.0
    usual_range: float = 1000.0
    reports_per_scan: float = 1.0
    scan_period: float | None = None
    rotation: Rotation | None = None
    is_turn_sure: bool = True
    field_of_view: FieldOfView | None = None


UNKNOWN_SENSOR = ObservedSensor()
