"""What a sensor reports, how often, how well and how falsely."""

from dataclasses import dataclass

import numpy as np

from trackweave.arrays import FloatArray, name_text
from trackweave.domain.foreign_kind import ForeignKind, kind_of
from trackweave.domain.measurements import MeasurementKind
from trackweave.errors import InvalidInputError
from trackweave.fields import checked_dimension, plain, settle
from trackweave.models.coverage import FieldOfView
from trackweave.models.measurements import NO_PLATFORM
from trackweave.models.rotation import Rotation
from trackweave.models.strength import StrengthModel

__all__ = ["DOUBTED", "Sensor"]

DOUBTED = ("sigma",)
"""Keys of a sensor that give way to what reports show where these contradict them clearly."""


@dataclass(frozen=True, slots=True)
class Sensor:
    """A sensor: what it measures, how well, how often, and how falsely.

    Parameters
    ----------
    name
        As in the reports.
    sigma
        Standard deviation of each number of a report [m, rad, m/s]: one for all, or one each.
        Applies where a report carries none. Must be positive.
    detection_probability
        Chance to report an object that it covers, in (0, 1).
    clutter_density
        False alarms per unit of what is measured (m², m³, m·rad, rad …) and scan. Must be
        positive.
    scan_period
        Seconds from scan to scan; None where there is no such time. Must be positive.
    field_of_view
        What it covers, about ``position`` or where its scans say that it is; None for
        everywhere.
    measurement
        What its reports hold; one of ours, or a kind of your own, see `Measurement`.
    position
        Where it stands, x, y[, z] [m]; None for the origin. Scans of a moving sensor say it.
    rotation
        How its beam turns; None where a scan is taken at one time.
    strength
        What the strength of its reports says; None for nothing.
    identity_error
        Chance that a report's identity is another than its object's was, in (0, 1).
    scans
        Whether it scans: what a scan of it covers and does not report was missed. False for one
        that hears objects report themselves, as AIS does: its reports say nothing of other
        objects, however many share a time. None for what a scan shows: that of a sensor with a
        ``scan_period``, and one of several reports, tells what was missed; a lone report does
        not. An empty scan always does.
    trust
        Whether ``track`` keeps what is told of it even where its reports contradict that: True
        for all, or the names of fields, of which only "sigma" ever gives way. A tracker that is
        given scans one by one always keeps what it was told.

    Raises
    ------
    InvalidInputError
        If a value is out of range.

    Examples
    --------
    >>> import trackweave as tw
    >>> radar = tw.Sensor(
    ...     "radar",
    ...     sigma=(50.0, 0.003),  # m, rad
    ...     measurement=tw.MeasurementKind.RANGE_AZIMUTH,
    ...     detection_probability=0.9,
    ...     clutter_density=1e-5,  # per m·rad and scan
    ...     scan_period=4.0,  # s
    ...     field_of_view=tw.FieldOfView(max_range=20_000.0),  # m
    ... )
    >>> radar.sigmas(2)
    array([5.e+01, 3.e-03])
    """

    name: str
    sigma: float | tuple[float, ...] = 1.0
    detection_probability: float = 0.9
    clutter_density: float = 1e-6
    scan_period: float | None = None
    field_of_view: FieldOfView | None = None
    measurement: MeasurementKind | ForeignKind = MeasurementKind.POSITION
    position: tuple[float, ...] | None = None
    rotation: Rotation | None = None
    strength: StrengthModel | None = None
    identity_error: float = 0.01
    scans: bool | None = None
    trust: bool | tuple[str, ...] = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "name", name_text(plain(self.name), "name"))
        object.__setattr__(self, "measurement", kind_of(self.measurement))
        settle(self)
        sigmas = np.atleast_1d(np.asarray(self.sigma, dtype=float))
        if sigmas.size == 0 or not np.all(sigmas > 0):
            raise InvalidInputError(f"sigma: {self.sigma}; expected numbers > 0")
        for name in ("detection_probability", "identity_error"):
            if not 0 < getattr(self, name) < 1:
                raise InvalidInputError(f"{name}: {getattr(self, name)}; expected between 0 and 1")
        for name in ("clutter_density", "scan_period"):
            value = getattr(self, name)
            if value is not None and not value > 0:
                raise InvalidInputError(f"{name}: {value}; expected a finite number > 0")
        told = (self.scan_period, self.rotation)
        if self.scans is False and told != (None, None):
            raise InvalidInputError(
                "scans: False; expected True for a sensor with a scan_period or a rotation"
            )
        if self.measurement is MeasurementKind.RANGE_RATE:
            raise InvalidInputError("measurement: range-rate; expected what tells a direction")
        if not isinstance(self.trust, bool) and not set(self.trust) <= set(DOUBTED):
            known = ", ".join(f'"{key}"' for key in DOUBTED)
            raise InvalidInputError(
                f"trust: {self.trust!r:.80}; expected True, False or some of {known}"
            )
        if self.position is not None and len(self.position) not in {2, 3}:
            raise InvalidInputError(f"position: {self.position}; expected two or three numbers")

    @property
    def platform(self) -> FloatArray:
        """Where it stands and that it does not move: x, y, z [m] and their rates [m/s]."""
        platform = np.array(NO_PLATFORM)
        if self.position is not None:
            platform[: len(self.position)] = self.position
        return platform

    def trusts(self, key: str) -> bool:
        """Tell whether a key is kept as told, whatever reports show.

        Parameters
        ----------
        key
            Its name, such as "sigma".

        Returns
        -------
        As ``trust`` says.
        """
        return self.trust if isinstance(self.trust, bool) else key in self.trust

    def tells_silence(self, n_reports: int) -> bool:
        """Tell whether a scan says anything of objects that it does not report.

        Parameters
        ----------
        n_reports
            How many reports it holds.

        Returns
        -------
        As ``scans`` says, or the scan itself shows.
        """
        if n_reports == 0:
            return True
        if self.scans is None:
            return self.scan_period is not None or n_reports > 1
        return self.scans

    def sigmas(self, dim: int) -> FloatArray:
        """Return the standard deviation of each number of a report [m, rad, m/s].

        Parameters
        ----------
        dim
            Number of dimensions of the tracking space.

        Returns
        -------
        One number per component.

        Raises
        ------
        InvalidInputError
            If the sensor was given another number of them.
        """
        size = self.measurement.n_components(checked_dimension(dim))
        if isinstance(self.sigma, float):
            return np.full(size, self.sigma)
        sigmas = np.atleast_1d(np.asarray(self.sigma, dtype=float))
        if sigmas.size not in (1, size):
            raise InvalidInputError(
                f"sensor {self.name}: sigma for {sigmas.size} axes; expected 1 or {size}"
            )
        return np.ascontiguousarray(np.broadcast_to(sigmas, (size,)))
