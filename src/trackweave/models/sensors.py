"""What a sensor reports, how often, how well and how falsely."""

from dataclasses import dataclass, fields
from typing import Annotated, TypeAlias

import numpy as np

from trackweave.arrays import FloatArray, name_text
from trackweave.domain.foreign_kind import ForeignKind, kind_of
from trackweave.domain.measurements import MeasurementKind
from trackweave.errors import InvalidInputError
from trackweave.fields import checked_dimension, plain, settle
from trackweave.keys import COORDINATE, DENSITY, NOISE, PROBABILITY, SECONDS, Key
from trackweave.models.biases import Biases
from trackweave.models.coverage import FieldOfView, hiding
from trackweave.models.local_noise import local_noise
from trackweave.models.measurements import NO_PLATFORM
from trackweave.models.rotation import Rotation
from trackweave.models.strength import StrengthModel

__all__ = ["BIASES", "DOUBTED", "Sensor"]

BIASES = tuple(each.name for each in fields(Biases))
"""Keys of what is wrong with all reports of a sensor alike."""
DOUBTED = (
    "sigma", "detection_probability", "clutter_density", "clutter_per_scan", "field_of_view",
    "scan_period", "rotation", "position", "place", *BIASES,
)  # fmt: skip
"""Keys of a sensor that give way to what reports show where these contradict them clearly."""
HEIGHT_NOISE = 20.0
"""Standard deviation of heights of which nothing is known [m]: many come in steps of 100 feet."""
TRUST = "true, false, or a list of keys: " + ", ".join(f'"{key}"' for key in DOUBTED)
Echo: TypeAlias = Annotated[
    tuple[Annotated[float, COORDINATE], ...],
    Key("four numbers in brackets, such as [9e3, 4e3, 150.0, 0.3]", size=(4, 4)),
]
"""A place that gives false alarms: x, y, their spread [m], their number a scan."""
NoiseAt: TypeAlias = Annotated[
    tuple[Annotated[float, COORDINATE], ...],
    Key("x, y and a noise along each axis, such as [40.0, 5.0, 0.3, 0.5]", size=(4, 5)),
]
"""The noise at a place: x, y, and standard deviations along x, y[, z] [m]."""
EXTENT = Key("a number from 0 to 1e9 in metres", 0, 1e9)
CHANCE = PROBABILITY.said("a number between 0 and 1, both excluded")


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
    sigma_at
        For positions whose noise is not the same everywhere: for some places x, y and the standard
        deviation along each axis there [m], instead of ``sigma``. In between it is interpolated.
    detection_probability
        Chance that a scan reports an object that it covers.
    clutter_density
        False alarms per unit of what is measured (m², m³, m·rad, rad …) and scan.
    scan_period
        Time from scan to scan, or of a turn [s].

        None where there is no such time.
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
        Chance that a report's identity is another than its object's was.
    hidden_share
        Share of their time for which objects are where this sensor beside others cannot see them:
        below its horizon, in a blind sector, above its cone; 0 for never.
    mean_silence
        How long they are there on average [s].
    echoes
        Places that give false alarms again and again: for each x, y, how far these spread [m] and
        how many there are a scan; in three dimensions a scan and radian of elevation (of positions
        a metre of height).
    clutter_persistence
        Chance that a false alarm comes again at its place in the next scan, as the sea's do; 0
        where each is for itself. What stands then takes longer to become a confirmed track.
    tail_share
        Share of its reports whose noise is wider; 0 for noise without heavy tails.
    tail_scale
        How many times as wide the noise of those is.
    tail_persistence
        How much it is the same objects whose reports are wild: by how much likelier a report's
        noise is wide if that of the object's last report was. 0 where each is for itself.
    sigma_height
        Standard deviation of the heights that its reports tell beside their places [m].
    height_offset
        By how much these are above those of other sensors [m].
    extent
        How far each of several reports that one object gives in a scan is from the next at most
        [m]; 0 where an object gives one. In ``track`` and the service their middle stands for all;
        a tracker that is given scans one by one takes them as they come.
    scans
        Whether it looks, so that what it does not report was missed; false for one that hears
        objects report themselves, each at its own pace, as AIS does.

        None for what a scan shows: that of a sensor with a ``scan_period``, and one of several
        reports, tells what was missed; a lone report does not. An empty scan always does.
    trust
        Whether what is told is kept where reports contradict it: of all keys, or of those named.

        Only "sigma", "detection_probability", clutter, "field_of_view", "scan_period", "rotation",
        "position" (or "place") and biases ever give way, in ``track``. A tracker that is given
        scans one by one always keeps what it was told.

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
    detection_probability: Annotated[float, CHANCE] = 0.9
    clutter_density: Annotated[
        float,
        DENSITY.said("a number > 0 per unit of what is measured (m², m³, m·rad, rad) and scan"),
    ] = 1e-6
    scan_period: Annotated[float | None, SECONDS] = None
    field_of_view: FieldOfView | None = None
    measurement: MeasurementKind | ForeignKind = MeasurementKind.POSITION
    position: tuple[float, ...] | None = None
    rotation: Rotation | None = None
    strength: StrengthModel | None = None
    identity_error: Annotated[float, CHANCE] = 0.001
    hidden_share: Annotated[float, Key("a number from 0 to 0.9", 0, 0.9)] = 0.0
    mean_silence: Annotated[float, SECONDS] = 60.0
    echoes: Annotated[tuple[Echo, ...], Key()] = ()
    clutter_persistence: Annotated[float, Key("a number from 0 to 0.9", 0, 0.9)] = 0.0
    sigma_at: Annotated[tuple[NoiseAt, ...], Key()] = ()
    tail_share: Annotated[float, Key("a number from 0 to 0.5", 0, 0.5)] = 0.0
    tail_scale: Annotated[float, Key("a number from 1 to 1000", 1, 1000)] = 10.0
    tail_persistence: Annotated[float, Key("a number from 0 to 0.999", 0, 0.999)] = 0.0
    sigma_height: Annotated[float, NOISE] = HEIGHT_NOISE
    height_offset: Annotated[float, COORDINATE] = 0.0
    extent: Annotated[float, EXTENT] = 0.0
    scans: Annotated[bool | None, Key()] = None
    trust: Annotated[bool | tuple[Annotated[str, Key(words=DOUBTED)], ...], Key(TRUST)] = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "name", name_text(plain(self.name), "name"))
        object.__setattr__(self, "measurement", kind_of(self.measurement))
        settle(self)
        sigmas = np.atleast_1d(np.asarray(self.sigma, dtype=float))
        if sigmas.size == 0 or not np.all(sigmas > 0):
            raise InvalidInputError(f"sigma: {self.sigma}; expected numbers > 0")
        if self.sigma_at:
            self._check_places()
        told = (self.scan_period, self.rotation)
        if self.scans is False and told != (None, None):
            raise InvalidInputError(
                "scans: False; expected True for a sensor with a scan_period or a rotation"
            )
        if self.extent and (self.scans is False or not self._tells_places()):
            raise InvalidInputError(
                f"extent: {self.extent:g}; expected 0 for a sensor that does not look, or whose "
                "reports are no positions or ranges with directions"
            )
        if self.measurement is MeasurementKind.RANGE_RATE:
            raise InvalidInputError("measurement: range-rate; expected what tells a direction")
        if self.position is not None and len(self.position) not in {2, 3}:
            raise InvalidInputError(f"position: {self.position}; expected two or three numbers")

    def _tells_places(self) -> bool:
        kind = self.measurement
        return isinstance(kind, MeasurementKind) and (kind.is_position or kind.has_range)

    def _check_places(self) -> None:
        sizes = {len(each) for each in self.sigma_at}
        if len(sizes) > 1 or min(min(each[2:]) for each in self.sigma_at) <= 0:
            raise InvalidInputError(
                f"sigma_at: {[*map(list, self.sigma_at)]}; expected x, y and as many numbers > 0 "
                "for each place"
            )
        if isinstance(self.measurement, ForeignKind) or not self.measurement.is_position:
            raise InvalidInputError(
                f"sigma_at: of a sensor of {self.measurement.word}; expected one of positions"
            )

    @property
    def platform(self) -> FloatArray:
        """Where it stands and that it does not move: x, y, z [m] and their rates [m/s]."""
        platform = np.array(NO_PLATFORM)
        if self.position is not None:
            platform[: len(self.position)] = self.position
        return platform

    def hiding(self) -> tuple[float, float]:
        """Return how probably it loses an object from scan to scan, and finds one it lost.

        Returns
        -------
        Both probabilities; 0 where it has no scan period.
        """
        return hiding(self.hidden_share, self.mean_silence, self.scan_period or 0.0)

    def false_alarms(self, place: FloatArray, volume: FloatArray) -> FloatArray:
        """Return how many times as dense false alarms are at some places as on average.

        Parameters
        ----------
        place
            x and y [m], shape (places, 2).
        volume
            How many m² a unit of what is measured stands for there, shape (places,).

        Returns
        -------
        At least 1 each; more near ``echoes``.
        """
        density = np.ones(place.shape[0])
        for east, north, spread, count in self.echoes:
            square = np.sum((place - (east, north)) ** 2, axis=1) / (2.0 * spread**2)
            own = count * np.exp(-np.minimum(square, 700.0)) / (2.0 * np.pi * spread**2)
            density += own * volume / self.clutter_density
        return density

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

    def noise(self, told: FloatArray, measurement: FloatArray, dim: int) -> FloatArray:
        """Return the standard deviation of each number of some reports [m, rad, m/s].

        Parameters
        ----------
        told
            What each report says of it, shape (reports, numbers); NaN where it says nothing.
        measurement
            What they hold, of the same shape.
        dim
            Number of dimensions of the tracking space.

        Returns
        -------
        A report's own, else that of its place or sensor; of the same shape.

        Raises
        ------
        InvalidInputError
            If the sensor was given another number of them.
        """
        usual: FloatArray = self.sigmas(dim)[: told.shape[1]]
        if self.sigma_at and told.shape[0]:
            usual = local_noise(self.sigma_at, measurement)[:, : told.shape[1]]
            if usual.shape[1] < told.shape[1]:
                raise InvalidInputError(
                    f"sensor {self.name}: sigma_at for {usual.shape[1]} axes; expected "
                    f"{told.shape[1]}"
                )
        return np.where(np.isnan(told), usual, told)
