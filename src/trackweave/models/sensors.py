"""What a sensor reports, how often, how well and how falsely."""

from dataclasses import dataclass

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.errors import InvalidInputError
from trackweave.models.coverage import FieldOfView

__all__ = ["Sensor"]


@dataclass(frozen=True, slots=True)
class Sensor:
    """A sensor that reports positions.

    Parameters
    ----------
    name
        As in the reports.
    sigma
        Standard deviation of a report along each axis [m]: one number, or one per axis. Applies
        where a report carries none. Must be positive.
    detection_probability
        Chance to report an object that it covers, in (0, 1).
    clutter_density
        False alarms per m² (m³) of covered space and scan. Must be positive.
    scan_period
        Seconds from scan to scan, None for a sensor that does not scan: a single report of it
        says nothing of other objects, and makes no track miss a chance. Must be positive.
    field_of_view
        What it covers; None for everywhere.

    Raises
    ------
    InvalidInputError
        If a value is out of range.
    """

    name: str
    sigma: float | tuple[float, ...] = 1.0
    detection_probability: float = 0.9
    clutter_density: float = 1e-6
    scan_period: float | None = None
    field_of_view: FieldOfView | None = None

    def __post_init__(self) -> None:
        sigmas = np.atleast_1d(np.asarray(self.sigma, dtype=float))
        if sigmas.size == 0 or not np.all(np.isfinite(sigmas) & (sigmas > 0)):
            raise InvalidInputError(f"sigma: {self.sigma}; expected numbers > 0 in metres")
        if not 0 < self.detection_probability < 1:
            raise InvalidInputError(
                f"detection_probability: {self.detection_probability}; expected between 0 and 1"
            )
        for name in ("clutter_density", "scan_period"):
            value = getattr(self, name)
            if value is not None and not (np.isfinite(value) and value > 0):
                raise InvalidInputError(f"{name}: {value}; expected a finite number > 0")

    def sigmas(self, dim: int) -> FloatArray:
        """Return the standard deviation along each axis [m].

        Parameters
        ----------
        dim
            Number of axes.

        Returns
        -------
        One number per axis.

        Raises
        ------
        InvalidInputError
            If the sensor was given another number of axes.
        """
        sigmas = np.atleast_1d(np.asarray(self.sigma, dtype=float))
        if sigmas.size not in (1, dim):
            raise InvalidInputError(
                f"sensor {self.name}: sigma for {sigmas.size} axes; expected 1 or {dim}"
            )
        return np.ascontiguousarray(np.broadcast_to(sigmas, (dim,)))
