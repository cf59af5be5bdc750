"""Ranges and angles of a table of reports."""

from dataclasses import dataclass, field

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.domain.measurements import MeasurementKind
from trackweave.domain.reports import ANGLE_NOISE_DEG, NOISE_M
from trackweave.io.checks import Range, RowChecks
from trackweave.io.columns import BoolArray

__all__ = ["AZIMUTH", "Polar", "angles", "choose_components", "read_polar"]

AZIMUTH = Range(-180.0, 360.0)
_RANGE = Range(0.0, 1e9)
_ELEVATION = Range(-90.0, 90.0)
_RATE = Range(-3e8, 3e8)
_SIGMA = Range(*NOISE_M, expected="a positive number", positive=True)
_SIGMA_ANGLE = Range(*ANGLE_NOISE_DEG, expected="a positive number", positive=True)
_COLUMNS = ("range_m", "azimuth_deg", "elevation_deg", "range_rate_mps")
# Flatter than this [rad] a distance on the ground cannot be told from the zenith.
_STEEPEST = np.radians(89.9)


@dataclass
class Polar:
    """Ranges and angles as they came; row by row, NaN where there are none.

    Parameters
    ----------
    rows
        Which rows have a range.
    values
        Range [m], azimuth and elevation [rad], range rate [m/s], shape (rows, 4).
    sigma
        Their standard deviations, of the same shape.
    columns
        Names of the columns that were read.
    has_elevation, has_rate
        Which sensors have one in all of their rows; True for sensors without a range.
    partial
        Which sensors have an elevation, or a range rate, in some rows only.
    """

    rows: BoolArray
    values: FloatArray
    sigma: FloatArray
    columns: tuple[str, ...]
    has_elevation: BoolArray = field(default_factory=lambda: np.zeros(0, dtype=np.bool_))
    has_rate: BoolArray = field(default_factory=lambda: np.zeros(0, dtype=np.bool_))
    partial: tuple[BoolArray, ...] = ()

    def complete(self, good: BoolArray, sensor: IntArray) -> None:
        """Find out which sensors tell an elevation and a range rate in all of their good rows.

        Parameters
        ----------
        good
            Rows without a fault.
        sensor
            Number of each row's sensor.
        """
        rows = self.rows & good
        count = np.bincount(sensor[rows], minlength=int(sensor.max()) + 1)
        filled = [
            np.bincount(sensor[rows & ~np.isnan(self.values[:, place])], minlength=count.size)
            for place in (2, 3)
        ]
        self.has_elevation, self.has_rate = (full == count for full in filled)
        self.partial = tuple((full > 0) & (full < count) for full in filled)


def read_polar(checks: RowChecks, rows: BoolArray, heading: FloatArray) -> Polar:
    """Return the ranges and angles of some rows.

    Parameters
    ----------
    checks
        The table; bad cells are complained of there.
    rows
        The rows that have a range.
    heading
        What each row's azimuth counts from [rad].

    Returns
    -------
    Numbers and noise, azimuths clockwise from north from 0 to 2π.
    """
    values, sigma = np.full((2, len(checks), 4), np.nan)
    limits = (_RANGE, AZIMUTH, _ELEVATION, _RATE)
    for place, (name, within) in enumerate(zip(_COLUMNS, limits, strict=True)):
        if name not in checks.names:
            continue
        values[:, place] = checks.numbers(name, within, optional=place > 1, among=rows)
        if place in {1, 2}:
            sigma[:, place] = angles(checks, f"sigma_{name}", rows)
        elif f"sigma_{name}" in checks.names:
            sigma[:, place] = checks.numbers(f"sigma_{name}", _SIGMA, optional=True, among=rows)
    values[:, 1] = (np.radians(values[:, 1]) + heading) % (2 * np.pi)
    values[:, 2] = np.radians(values[:, 2])
    return Polar(rows, values, sigma, (*_COLUMNS, *(f"sigma_{name}" for name in _COLUMNS)))


def angles(checks: RowChecks, name: str, among: BoolArray) -> FloatArray:
    """Return the standard deviations of angles, such as ``sigma_azimuth_deg`` [rad].

    Parameters
    ----------
    checks
        The table; bad cells are complained of there.
    name
        The column's name; there need be none.
    among
        The rows to look at.

    Returns
    -------
    One number per row, NaN where there is none.
    """
    if name not in checks.names:
        return np.full(len(checks), np.nan)
    return np.radians(checks.numbers(name, _SIGMA_ANGLE, optional=True, among=among))


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
        solid = bool(polar.has_elevation[number])
        rate = bool(polar.has_rate[number])
        if solid and space == 2:
            _lay_flat(polar, rows)
            solid = False
            notes.append(
                f"sensor {names[number]}: its ranges become distances on the ground by their "
                "elevations, because not every sensor tells heights"
            )
        places = [0, 1, *([2] if solid else []), *([3] if rate else [])]
        values[rows, : len(places)] = polar.values[np.ix_(rows, places)]
        sigma[rows, : len(places)] = polar.sigma[np.ix_(rows, places)]
        kind[rows] = _KINDS[solid, rate]
        for column, partial in zip(_COLUMNS[2:], polar.partial, strict=True):
            if partial[number]:
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
