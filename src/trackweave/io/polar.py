"""Ranges and angles of a table of reports."""

from typing import NamedTuple

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.domain.measurements import MeasurementKind
from trackweave.domain.reports import ANGLE_NOISE_DEG, NOISE_M
from trackweave.io.checks import Range, RowChecks
from trackweave.io.columns import BoolArray

__all__ = ["AZIMUTH", "POLAR_COLUMNS", "Polar", "choose_components", "read_polar", "read_sigma"]

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

    rows: BoolArray
    """Which rows have a range."""
    values: FloatArray
    """Range [m], azimuth and elevation [rad], range rate [m/s], shape (rows, 4)."""
    sigma: FloatArray
    """Their standard deviations, of the same shape."""
    complete: BoolArray
    """Which sensors tell elevations, and range rates, in all of their rows, shape (2, sensors)."""
    partial: BoolArray
    """Which sensors do so in some of their rows only, of the same shape."""


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
    """Write the numbers of each sensor's kind, side by side.

    Parameters
    ----------
    polar
        Ranges and angles.
    sensors
        Names of the sensors, and the number of each row's.
    space
        Number of dimensions of the tracking space. In two an elevation makes the range a distance
        on the ground.
    into
        Where to write numbers, noise and kinds.

    Returns
    -------
    A sentence for each sensor of which something is not used.
    """
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
