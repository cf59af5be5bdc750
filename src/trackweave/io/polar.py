"""Ranges and angles of a table of reports, and where the sensors were that took them."""

from typing import NamedTuple

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.domain.frames import LocalFrame
from trackweave.domain.measurements import MeasurementKind
from trackweave.domain.reports import ANGLE_NOISE_DEG, NOISE_M
from trackweave.errors import DataFormatError
from trackweave.io.checks import Range, RowChecks
from trackweave.io.columns import BoolArray
from trackweave.io.positions import DISTANCE, LATITUDE, LONGITUDE, choose_frame

__all__ = [
    "AZIMUTH",
    "POLAR_COLUMNS",
    "Polar",
    "choose_components",
    "read_heading",
    "read_platforms",
    "read_polar",
    "read_sigma",
]

_SPEED = Range(-1e9, 1e9)
_HEADING = Range(-360.0, 360.0)


def read_platforms(
    checks: RowChecks, frame: LocalFrame | None, *, on_plane: bool = False
) -> tuple[FloatArray | None, LocalFrame | None]:
    """Return where each row's sensor was and how it moved, and the plane of that."""
    # Columns ``sensor_x,sensor_y[,sensor_z]`` [m] or ``sensor_lat,sensor_lon[,sensor_alt_m]``
    # [degrees, m], and ``sensor_vx,sensor_vy[,sensor_vz]`` [m/s]; what is left out of height and
    # speed is 0. Of shape (rows, 6), NaN where a row does not say; None where no row does. Where
    # reports are ``on_plane`` no plane may be chosen.
    geodetic = checks.filled("sensor_lat") or checks.filled("sensor_lon")
    if geodetic and frame is None and on_plane:
        raise DataFormatError(
            f"{checks.name}, column sensor_lat: beside x and y; expected sensor_x,sensor_y, "
            "or reports in lat,lon"
        )
    first, second, up = (
        ("sensor_lat", "sensor_lon", "sensor_alt_m")
        if geodetic
        else ("sensor_x", "sensor_y", "sensor_z")
    )
    if not (checks.filled(first) or checks.filled(second)):
        return None, frame
    for name, other in ((first, second), (second, first)):
        checks.require(name, f"where the sensor was, beside {other}")
    said = checks.filled_cells(first) | checks.filled_cells(second)
    within = (LATITUDE, LONGITUDE) if geodetic else (DISTANCE, DISTANCE)
    values = np.full((len(checks), 6), np.nan)
    for axis, name in enumerate((first, second)):
        values[:, axis] = checks.numbers(name, within[axis], among=said)
    for axis, name in ((2, up), (3, "sensor_vx"), (4, "sensor_vy"), (5, "sensor_vz")):
        limits = DISTANCE if axis == 2 else _SPEED
        values[said, axis] = np.nan_to_num(checks.optional_numbers(name, limits)[said])
    if geodetic:
        rows = said & checks.good
        frame = frame or choose_frame(values[rows, 0], values[rows, 1])
        values[rows, :3] = frame.to_plane(*values[rows, :3].T)
    return values, frame


def read_heading(checks: RowChecks) -> FloatArray:
    """Return what each row's azimuth or bearing counts from [rad], 0 for north."""
    return np.radians(np.nan_to_num(checks.optional_numbers("sensor_heading_deg", _HEADING)))


AZIMUTH = Range(-180.0, 360.0)
_LIMITS = {
    "range_m": Range(0.0, 1e9),
    "azimuth_deg": AZIMUTH,
    "elevation_deg": Range(-90.0, 90.0),
    "range_rate_mps": Range(-3e8, 3e8),
}
POLAR_COLUMNS = (*_LIMITS, *(f"sigma_{name}" for name in _LIMITS))
_SIGMA = Range(*NOISE_M, expected="a positive number", positive=True)
_SIGMA_ANGLE = Range(*ANGLE_NOISE_DEG, expected="a positive number", positive=True)
# Flatter than this [rad] a distance on the ground cannot be told from the zenith.
_STEEPEST = np.radians(89.9)


class Polar(NamedTuple):
    """Ranges and angles row by row, NaN where there are none."""

    rows: BoolArray  # Which rows have a range
    values: FloatArray  # Range [m], azimuth and elevation [rad], range rate [m/s], shape (rows, 4)
    sigma: FloatArray  # Their standard deviations, of the same shape
    # Which sensors tell elevations, and range rates, in all of their rows, shape (2, sensors).
    complete: BoolArray
    partial: BoolArray  # Which sensors do so in some of their rows only, of the same shape


def read_polar(checks: RowChecks, rows: BoolArray, heading: FloatArray, sensor: IntArray) -> Polar:
    """Return ranges and angles of some rows, azimuths from 0 to 2π by each row's heading [rad]."""
    values, sigma = np.full((2, len(checks), 4), np.nan)
    for place, (name, within) in enumerate(_LIMITS.items()):
        if name in checks.names:
            values[:, place] = checks.numbers(name, within, optional=place > 1, among=rows)
            sigma[:, place] = read_sigma(checks, f"sigma_{name}", rows)
    values[:, 1] = (np.radians(values[:, 1]) + heading) % (2 * np.pi)
    values[:, 2] = np.radians(values[:, 2])
    good, n_sensors = rows & checks.good, int(sensor.max()) + 1
    count = np.bincount(sensor[good], minlength=n_sensors)
    filled = np.stack(
        [
            np.bincount(sensor[good & ~np.isnan(values[:, place])], minlength=n_sensors)
            for place in (2, 3)
        ]
    )
    return Polar(rows, values, sigma, filled == count, (filled > 0) & (filled < count))


def read_sigma(checks: RowChecks, name: str, among: BoolArray | None) -> FloatArray:
    """Return standard deviations [m, m/s or rad], NaN where a row, or the table, has none."""
    if name.endswith("_deg"):
        return np.radians(checks.optional_numbers(name, _SIGMA_ANGLE, among))
    return checks.optional_numbers(name, _SIGMA, among)


def choose_components(
    polar: Polar,
    sensors: tuple[np.ndarray, IntArray],
    space: int,
    into: tuple[FloatArray, FloatArray, IntArray],
) -> list[str]:
    """Write numbers, noise and kinds of each sensor; return a sentence on what is not used."""
    # ``sensors`` are their names and the number of each row's; ``space`` is the number of
    # dimensions of the tracking space: in two an elevation makes the range a distance on the
    # ground.
    names, sensor = sensors
    values, sigma, kind = into
    notes = []
    for number in np.unique(sensor[polar.rows]):
        rows = polar.rows & (sensor == number)
        solid, rate = polar.complete[:, number].tolist()
        if solid and space == 2:
            _lay_flat(polar, rows)
            solid = False
            notes.append(
                f"sensor {names[number]}: its ranges become distances on the ground by their "
                "elevations, because not every sensor tells heights"
            )
        places = [0, 1, *[2] * solid, *[3] * rate]
        values[rows, : len(places)] = polar.values[np.ix_(rows, places)]
        sigma[rows, : len(places)] = polar.sigma[np.ix_(rows, places)]
        kind[rows] = _KINDS[solid, rate]
        for column, partial in zip(list(_LIMITS)[2:], polar.partial[:, number], strict=True):
            if partial:
                notes.append(
                    f"sensor {names[number]}: {column} is not used, because some of its rows "
                    "have none"
                )
    return notes


_KINDS = {
    (False, False): MeasurementKind.RANGE_AZIMUTH,
    (False, True): MeasurementKind.RANGE_AZIMUTH_RATE,
    (True, False): MeasurementKind.RANGE_AZIMUTH_ELEVATION,
    (True, True): MeasurementKind.RANGE_AZIMUTH_ELEVATION_RATE,
}


def _lay_flat(polar: Polar, rows: BoolArray) -> None:
    """Turn ranges and their rates into those on the ground, as of level motion."""
    level = np.cos(np.clip(polar.values[rows, 2], -_STEEPEST, _STEEPEST))
    polar.values[rows, 0] *= level
    polar.values[rows, 3] /= level
