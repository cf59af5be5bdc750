"""Reports of one sensor at one time."""

from copy import copy
from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from trackweave.arrays import (
    FloatArray,
    IntArray,
    covariance_array,
    float_array,
    int_array,
    n_axes,
    name_text,
    require_finite,
)
from trackweave.errors import InvalidInputError
from trackweave.fields import checked_flag, checked_number, plain
from trackweave.summaries import summary

__all__ = ["Scan"]

HIGHEST_M = 1e8


@dataclass(frozen=True, slots=True, eq=False)
class Scan:
    """The reports of one sensor at one time; it may be empty.

    Parameters
    ----------
    time
        End of the scan [s], for a turning sensor of the turn or of the sector handed over.
    sensor
        Name of the sensor, a text or a whole number; kept as text, so that 0 is "0".
    measurement
        One row per report, shape (reports, components): what the sensor measures, angles in
        radians. Finite. An empty list is an empty scan of no components, shape (0, 0), which fits
        every tracker.
    sigma
        Standard deviation of each number, of the same shape, positive; NaN where the sensor's own
        noise applies. Left out = NaN everywhere.
    report
        A number that identifies each report, shape (reports,); unique over a tracker's life.
        Left out = -1, and the tracker counts on from the last one.
    moments
        Each report's own time [s], shape (reports,), none after ``time``; None for ``time``.
    platform
        Where the sensor is and how it moves: x, y, z [m] and their rates [m/s], shape (6,), or
        one row per report, shape (reports, 6); None for where the sensor stands.
    identity
        A number for whom each report says it is of, shape (reports,), -1 for nobody; None where
        no report says.
    strength
        How strong each report is, shape (reports,), NaN where it does not tell; None for none.
    height
        How high what each report tells of is, where its measurement does not say [m], shape
        (reports,), NaN where it does not tell; None for none. Evidence of whose it is.
    covariance
        Covariance of each report's numbers in place of ``sigma``, shape (reports, components,
        components), symmetric and positive definite: for reports whose errors are correlated,
        as those fused of several plots are. None for errors that are independent.
    context
        Further numbers of each report, shape (reports, numbers), as a kind of measurement from
        outside the package asks for; None for none.
    tells_silence
        Whether it says anything of objects that it does not report; None for what its sensor's
        ``scans`` and the number of reports say. A part of a scan says what all of it did.

    Raises
    ------
    InvalidInputError
        If a shape does not fit, a time or measurement is not finite, a sigma is not positive, a
        covariance is not positive definite, a height is beyond 1e8 m, a moment lies after the
        scan's end, or the sensor's name is neither text nor a whole number.

    Examples
    --------
    >>> import trackweave as tw
    >>> scan = tw.Scan(time=10.0, sensor="radar", measurement=[[120.0, 40.0], [7.0, 3.0]])
    >>> len(scan), scan.time  # reports; s
    (2, 10.0)
    """

    time: float
    sensor: str
    measurement: FloatArray
    sigma: FloatArray = field(default_factory=lambda: np.empty((0, 0)))
    report: IntArray = field(default_factory=lambda: np.empty(0, dtype=np.int64))
    moments: FloatArray | None = None
    platform: FloatArray | None = None
    identity: IntArray | None = None
    strength: FloatArray | None = None
    height: FloatArray | None = None
    covariance: FloatArray | None = None
    context: FloatArray | None = None
    tells_silence: bool | None = None

    __repr__ = summary

    def __post_init__(self) -> None:
        set_field = object.__setattr__
        set_field(self, "time", checked_number(self.time, "time", "a finite number [s]"))
        if _is_empty(self.measurement) and np.ndim(self.measurement) == 1:
            # An empty list does not say how long its rows would be.
            measurement = np.empty((0, 0))
        else:
            measurement = float_array(self.measurement, "measurement", (None, None))
        n_reports, dim = measurement.shape
        require_finite(measurement, "measurement")
        if _is_empty(self.sigma):
            sigma = np.full((n_reports, dim), np.nan)
        else:
            sigma = float_array(self.sigma, "sigma", (n_reports, dim))
            if np.any(sigma <= 0) or np.any(np.isinf(sigma)):
                raise InvalidInputError(
                    "sigma: expected positive numbers, or NaN for the sensor's"
                )
        if _is_empty(self.report):
            report = np.full(n_reports, -1, dtype=np.int64)
        else:
            report = int_array(self.report, "report", (n_reports,))
        self._check_extras(n_reports)
        if self.covariance is not None:
            sigma = self._check_covariance(self.covariance, (n_reports, dim, dim))
        set_field(self, "sensor", name_text(plain(self.sensor), "sensor"))
        set_field(self, "measurement", measurement)
        set_field(self, "sigma", sigma)
        set_field(self, "report", report)

    def __len__(self) -> int:
        return int(self.measurement.shape[0])

    def part(self, rows: IntArray | NDArray[np.bool_] | list[int], **instead: Any) -> "Scan":
        """Return the scan with some of its reports.

        Parameters
        ----------
        rows
            Their places, or whether each counts.
        instead
            Fields that are otherwise, of the types that a scan holds; nothing is checked again.

        Returns
        -------
        A scan of the same sensor and time.

        Examples
        --------
        >>> import trackweave as tw
        >>> scan = tw.Scan(time=10.0, sensor="radar", measurement=[[120.0, 40.0], [7.0, 3.0]])
        >>> scan.part([1]).measurement.tolist()
        [[7.0, 3.0]]
        """
        part = copy(self)
        own = {
            name: value[rows] for name in _PER_REPORT if (value := getattr(self, name)) is not None
        }
        if self.platform is not None and self.platform.ndim == 2:
            own["platform"] = self.platform[rows]
        for name, value in {**own, **instead}.items():
            object.__setattr__(part, name, value)
        return part

    def _check_extras(self, n_reports: int) -> None:
        """Check and cast what a scan need not have."""
        set_field = object.__setattr__
        if self.moments is not None:
            moments = float_array(self.moments, "moments", (n_reports,))
            require_finite(moments, "moments")
            if np.any(moments > self.time):
                raise InvalidInputError(
                    f"moments: {moments.max():.15g} s; expected none after the scan's end at "
                    f"{self.time:.15g} s"
                )
            set_field(self, "moments", moments)
        if self.platform is not None:
            shape = (6,) if n_axes(self.platform, "platform") == 1 else (n_reports, 6)
            platform = float_array(self.platform, "platform", shape)
            require_finite(platform, "platform")
            set_field(self, "platform", platform)
        if self.identity is not None:
            set_field(self, "identity", int_array(self.identity, "identity", (n_reports,)))
        if self.strength is not None:
            set_field(self, "strength", float_array(self.strength, "strength", (n_reports,)))
        if self.height is not None:
            height = float_array(self.height, "height", (n_reports,))
            if np.any(np.abs(height) > HIGHEST_M):
                raise InvalidInputError(
                    f"height: {np.nanmax(np.abs(height)):.6g} m; expected -{HIGHEST_M:g} to "
                    f"{HIGHEST_M:g}, or NaN where a report does not tell"
                )
            set_field(self, "height", height)
        if self.tells_silence is not None:
            set_field(self, "tells_silence", checked_flag(self.tells_silence, "tells_silence"))
        if self.context is not None:
            set_field(self, "context", float_array(self.context, "context", (n_reports, None)))

    def _check_covariance(self, given: ArrayLike, shape: tuple[int, ...]) -> FloatArray:
        """Check and cast the covariances; return the standard deviations on their diagonals."""
        covariance = covariance_array(given, "covariance", shape)
        object.__setattr__(self, "covariance", covariance)
        scale: FloatArray = np.sqrt(np.einsum("kii->ki", covariance))
        return scale


_OF_ALL = {"time", "sensor", "platform", "tells_silence"}
_PER_REPORT = tuple(each.name for each in fields(Scan) if each.name not in _OF_ALL)


def _is_empty(values: ArrayLike) -> bool:
    """Tell whether values are none; rows of different lengths are some."""
    try:
        return np.size(values) == 0
    except ValueError:
        return False
