"""From a sensor's scan to its plots, whatever it measures."""

import math

import numpy as np

from trackweave.arrays import FloatArray, is_number, require_instance
from trackweave.association.sensor_plots import SensorPlots
from trackweave.association.window_rule import coverage_of
from trackweave.domain.foreign_kind import ours
from trackweave.domain.scans import Scan
from trackweave.errors import InvalidInputError
from trackweave.fields import checked_dimension, checked_number
from trackweave.models.coverage import Coverage, FieldOfView
from trackweave.models.extent import extent
from trackweave.models.measurements import to_position, with_rounding
from trackweave.models.sensors import Sensor

__all__ = ["plots_of"]

NARROWEST = 1e-6
"""A sector through which nothing is seen [degrees]."""


def plots_of(  # noqa: PLR0913 all but the first three by name, and seldom needed
    scan: Scan,
    sensor: Sensor,
    dim: int,
    *,
    time: float | None = None,
    speed: float = 0.0,
    start: float | None = None,
    volume: float | None = None,
    ignored_width: float | None = None,
) -> SensorPlots:
    """Return a sensor's plots: positions wherever a report tells one, or else bearings.

    Range and azimuth become positions with the errors that they have there: the density of false
    alarms and the field of view, which are in units of what is measured, are brought to m² (m³)
    at each plot's place. Nearer to the sensor than the range is uncertain, and higher above the
    horizon than the elevation is sure to be from the zenith, they are taken to be that far off.

    Parameters
    ----------
    scan
        The scan.
    sensor
        Its sensor.
    dim
        Number of dimensions of the plots' space, 2 or 3; bearings have two.
    time
        The common time [s]; None for the scan's.
    speed
        How fast objects may be, one standard deviation along each axis [m/s]: what a plot of
        another time than ``time`` says is less sure by it. At least 0.
    start
        When the beam of a turning sensor began with this scan [s]; None for a whole turn ago.
    volume
        What the field of view holds, in units of what is measured in ``dim`` dimensions, range
        rates left out; above 0. None for what the sensor's own field of view holds in the plane.
    ignored_width
        How wide the false alarms of the sensor are spread in what plots leave out: range rates
        [m/s], in two dimensions elevations [rad], or both multiplied. Needed where it reports
        such, as its ``clutter_density`` is per unit of these too.

    Returns
    -------
    The plots in the order of the reports. Their ``volume`` is None where the field of view has
    no bound, or is of three dimensions, and ``volume`` is not given.

    Raises
    ------
    InvalidInputError
        If the reports do not fit the sensor, or do not tell what plots of so many dimensions
        need, or a value is out of range.

    Examples
    --------
    >>> import trackweave as tw
    >>> radar = tw.Sensor(
    ...     "radar", sigma=(30.0, 0.01), measurement=tw.MeasurementKind.RANGE_AZIMUTH  # m, rad
    ... )
    >>> scan = tw.Scan(time=0.0, sensor="radar", measurement=[[1000.0, 0.0]])  # due north
    >>> plots = tw.plots_of(scan, radar, 2)
    >>> plots.value.round(1), plots.sigma.round(1)  # m
    (array([[   0. , 1000.1]]), array([[10., 30.]]))
    """
    dim = checked_dimension(dim)
    _check(scan, sensor, dim)
    time, start = _number_or_none(time, "time"), _number_or_none(start, "start")
    volume = _number_or_none(volume, "volume")
    speed = checked_number(speed, "speed", "a number ≥ 0")
    if speed < 0.0:
        raise InvalidInputError(f"speed: {speed}; expected a number ≥ 0")
    kind, count = ours(sensor.measurement, sensor.name), len(scan)
    moves = scan.platform is not None and scan.platform.size > 0
    platform = np.asarray(scan.platform) if moves else sensor.platform
    view = coverage_of(sensor, scan, start)
    if volume is None and dim == 2:
        volume = extent(view, kind) or None
    density = sensor.clutter_density * _width_ignored(sensor, dim, ignored_width)
    drift: FloatArray | float = 0.0
    if scan.moments is not None or time is not None:
        moments = np.full(count, scan.time) if scan.moments is None else scan.moments
        drift = speed * np.abs((scan.time if time is None else time) - moments)
    if kind.is_bearing_only:
        return SensorPlots(
            value=scan.measurement.reshape(count),
            sigma=_sigmas(scan, sensor, dim).reshape(count),
            volume=volume,
            detection_probability=sensor.detection_probability,
            place=np.ascontiguousarray(platform[..., :2]),
            clutter_density=density,
            drift=drift,
            coverage=_field_of_view(view),
        )
    platforms = np.broadcast_to(platform, (count, 6))
    value, covariance, unit = _positions(scan, sensor, platforms, dim)
    return SensorPlots(
        value=value,
        volume=None if volume is None else volume * unit,
        detection_probability=sensor.detection_probability,
        covariance=covariance,
        clutter_density=density / unit,
        drift=drift,
        coverage=_field_of_view(view),
    )


def _check(scan: Scan, sensor: Sensor, dim: int) -> None:
    """Refuse what makes no plots."""
    require_instance(scan, Scan, "scan")
    require_instance(sensor, Sensor, "sensor")
    kind = sensor.measurement
    if not kind.gives_position(dim) and (not kind.is_bearing_only or dim == 3):
        raise InvalidInputError(
            f"sensor {sensor.name}: {kind.word} in {dim} dimensions; expected positions, or in "
            "two dimensions bearings"
        )
    size, found = kind.n_components(dim), scan.measurement.shape[1]
    if len(scan) and found != size:
        raise InvalidInputError(
            f"sensor {sensor.name}: reports of {found} numbers; expected {size} for {kind.word}"
        )


def _number_or_none(value: float | None, name: str) -> float | None:
    return None if value is None else checked_number(value, name)


def _sigmas(scan: Scan, sensor: Sensor, dim: int) -> FloatArray:
    """Return the standard deviation of each number of the reports."""
    if not len(scan):
        return np.empty((0, sensor.sigmas(dim).size))
    return sensor.noise(scan.sigma, scan.measurement, dim)


def _field_of_view(coverage: Coverage) -> FieldOfView | None:
    """Return a field of view from its form for kernels."""
    if coverage.everywhere:
        return None
    low, high, start, width = coverage.bounds
    first = math.degrees(start) % 360.0
    # A sector of no width would be taken for a whole turn.
    last = first + max(math.degrees(width), NARROWEST)
    corners = [(float(x), float(y)) for x, y in coverage.polygon]
    return FieldOfView(
        position=(float(coverage.position[0]), float(coverage.position[1])),
        min_range=float(low),
        max_range=float(high),
        azimuth_deg=(first, last),
        polygon=corners or None,
    )


def _width_ignored(sensor: Sensor, dim: int, given: float | None) -> float:
    """Return how wide the false alarms are spread in what plots leave out; 1 for nothing."""
    kind = sensor.measurement
    if not kind.has_rate and not (kind.has_elevation and dim == 2):
        return 1.0
    if given is None or not (is_number(given) and given > 0):
        raise InvalidInputError(
            f"ignored_width: {given!r:.80}; expected a number > 0, because plots leave out a part "
            f"of the {kind.word} of sensor {sensor.name}, per unit of which its clutter_density is"
        )
    return float(given)


def _positions(
    scan: Scan, sensor: Sensor, platforms: FloatArray, dim: int
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return positions, their covariances, and the volume in space of a unit of measurement."""
    kind, count = ours(sensor.measurement, sensor.name), len(scan)
    sigma = _sigmas(scan, sensor, dim)
    measurement = scan.measurement.reshape(count, sigma.shape[1])
    value, _ = to_position(kind, measurement, sigma, platforms, dim)
    covariance = scan.covariance
    if covariance is None or not count:
        covariance = sigma[:, :, None] ** 2 * np.eye(sigma.shape[1])
    covariance = covariance[:, :dim, :dim]
    if not kind.has_range:
        return value, covariance, np.ones(count)
    step = _steps(measurement, sigma, dim)
    return (
        value,
        with_rounding(step @ covariance @ step.swapaxes(1, 2)),
        np.abs(np.linalg.det(step)),
    )


def _steps(measurement: FloatArray, sigma: FloatArray, dim: int) -> FloatArray:
    """Return how positions move with range, azimuth and elevation; never not at all."""
    distance = np.maximum(measurement[:, 0], sigma[:, 0])
    azimuth, elevation = measurement[:, 1], np.zeros(distance.shape[0])
    if dim == 3:
        highest = np.maximum(math.pi / 2.0 - sigma[:, 2], 0.0)
        elevation = np.clip(measurement[:, 2], -highest, highest)
    east, north = np.sin(azimuth), np.cos(azimuth)
    level, up = np.cos(elevation), np.sin(elevation)
    along = np.stack([level * east, level * north, up], axis=1)
    across = np.stack([level * north, -level * east, np.zeros_like(up)], axis=1)
    over = np.stack([-up * east, -up * north, level], axis=1)
    steps = np.stack([along, distance[:, None] * across, distance[:, None] * over], axis=2)
    return np.ascontiguousarray(steps[:, :dim, :dim])
