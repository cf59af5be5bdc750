"""Reports of one sensor at one time."""

from dataclasses import dataclass, field

import numpy as np

from trackweave.arrays import FloatArray, IntArray, float_array, int_array, require_finite
from trackweave.errors import InvalidInputError

__all__ = ["Scan"]


@dataclass(frozen=True, slots=True, eq=False)
class Scan:
    """The reports of one sensor at one time; it may be empty.

    Parameters
    ----------
    time
        End of the scan [s].
    sensor
        Name of the sensor.
    measurement
        One row per report, shape (reports, dim): position [m]. Finite.
    sigma
        Standard deviation of each report along each axis [m], shape (reports, dim), positive;
        NaN where the sensor's own noise applies. Left out = NaN everywhere.
    report
        A number that identifies each report, shape (reports,); unique over a tracker's life.
        Left out = -1, and the tracker counts on from the last one.

    Raises
    ------
    InvalidInputError
        If a shape does not fit, or a time or position is not finite, or a sigma is not positive.
    """

    time: float
    sensor: str
    measurement: FloatArray
    sigma: FloatArray = field(default_factory=lambda: np.empty((0, 0)))
    report: IntArray = field(default_factory=lambda: np.empty(0, dtype=np.int64))

    def __post_init__(self) -> None:
        set_field = object.__setattr__
        measurement = float_array(self.measurement, "measurement", (None, None))
        n_reports, dim = measurement.shape
        if not np.isfinite(self.time):
            raise InvalidInputError(f"time: {self.time}; expected a finite number of seconds")
        require_finite(measurement, "measurement")
        if np.size(self.sigma) == 0:
            sigma = np.full((n_reports, dim), np.nan)
        else:
            sigma = float_array(self.sigma, "sigma", (n_reports, dim))
            if np.any(sigma <= 0) or np.any(np.isinf(sigma)):
                raise InvalidInputError(
                    "sigma: expected positive numbers, or NaN for the sensor's"
                )
        if np.size(self.report) == 0:
            report = np.full(n_reports, -1, dtype=np.int64)
        else:
            report = int_array(self.report, "report", (n_reports,))
        set_field(self, "time", float(self.time))
        set_field(self, "measurement", measurement)
        set_field(self, "sigma", sigma)
        set_field(self, "report", report)

    def __len__(self) -> int:
        return int(self.measurement.shape[0])
