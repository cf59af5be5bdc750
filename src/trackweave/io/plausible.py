"""Numbers that look like another unit, or another column, are asked back, never converted."""

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.errors import DataFormatError
from trackweave.io.checks import RowChecks
from trackweave.io.columns import cell_text, read_numbers

__all__ = ["ask_back", "questions"]

# Beyond these no time in seconds lies, and moments of our day in finer units do.
_FINER = ((1e17, "nanoseconds"), (1e14, "microseconds"), (1e11, "milliseconds"))
_LATITUDE, _RIGHT_ANGLE = 90.0, np.pi / 2
FEWEST_ROWS = 20
"""So many numbers that are all small are no chance."""
FEWEST_ANGLES, LEAST_SPAN = 60, 1.0
"""So many directions that lie within a full turn in radians, and are that far apart."""


def ask_back(checks: RowChecks) -> None:
    """Refuse a table in which a whole column cannot be what its name says, and say what it seems.

    Raises
    ------
    DataFormatError
        If times seem to be milliseconds or finer, or latitudes and longitudes to be swapped.
    """
    time = _filled(checks, "time")
    if time.size:
        least = float(np.min(np.abs(time)))
        unit = next((unit for beyond, unit in _FINER if least > beyond), None)
        if unit is not None:
            _refuse(checks, "time", f"seconds; these look like {unit} from 1970")
    latitude, longitude = _filled(checks, "lat"), _filled(checks, "lon")
    if latitude.size and longitude.size:
        beyond = np.abs(latitude) > _LATITUDE
        # 91 is AIS's code for "not available".
        if np.mean(beyond & (latitude != 91.0)) > 0.5 and np.all(np.abs(longitude) <= _LATITUDE):
            _refuse(checks, "lat", "latitudes from -90 to 90; lat and lon look swapped")


def questions(checks: RowChecks) -> list[str]:
    """Return a question for each column whose numbers may be another unit, but need not."""
    asked = []
    latitude, longitude = _filled(checks, "lat"), _filled(checks, "lon")
    if (
        min(latitude.size, longitude.size) >= FEWEST_ROWS
        and np.all(np.abs(latitude) <= _RIGHT_ANGLE)
        and np.all(np.abs(longitude) <= 2 * _RIGHT_ANGLE)
    ):
        asked.append(
            "lat, lon: all within 1.571 and 3.142; are they radians? They are taken for degrees"
        )
    if {"range_m", "height_m"} <= set(checks.names):
        far, high = (read_numbers(checks.column(name)).values for name in ("range_m", "height_m"))
        both = np.isfinite(far) & np.isfinite(high)
        if both.sum() >= FEWEST_ROWS and np.mean(far[both] < high[both]) > 0.5:
            asked.append(
                "range_m: shorter than height_m in most rows; are they kilometres? They are taken "
                "for metres"
            )
    return [*asked, *_of_directions(checks), *_of_ranges(checks)]


def _of_directions(checks: RowChecks) -> list[str]:
    """Return a question for each column of directions that begins and ends as radians do."""
    asked = []
    for name in ("azimuth_deg", "bearing_deg"):
        angle = _filled(checks, name)
        if angle.size < FEWEST_ANGLES or np.max(np.abs(angle)) > 2 * np.pi:
            continue
        # A beam so narrow that is pointed due north is rarer than a column in radians.
        if np.ptp(angle) > LEAST_SPAN:
            asked.append(
                f"{checks.own_name(name)}: all from {angle.min():.4g} to {angle.max():.4g}; are "
                "they radians? They are taken for degrees"
            )
    return asked


def _of_ranges(checks: RowChecks) -> list[str]:
    """Return a question where ranges are too short beside what else is told of them."""
    for other, words in (
        ("sigma_range_m", "shorter than their own sigma_range_m"),
        ("range_rate_mps", "so short that range_rate_mps crosses them within a second"),
    ):
        if not {"range_m", other} <= set(checks.names):
            continue
        far, beside = (read_numbers(checks.column(name)).values for name in ("range_m", other))
        both = np.isfinite(far) & np.isfinite(beside)
        if both.sum() >= FEWEST_ROWS and np.mean(far[both] < np.abs(beside[both])) > 0.5:
            return [
                f"range_m: {words} in most rows; are they kilometres? They are taken for metres"
            ]
    return []


def _filled(checks: RowChecks, name: str) -> FloatArray:
    """Return the numbers of a column, none where there is no such column."""
    if name not in checks.names:
        return np.empty(0)
    numbers = read_numbers(checks.column(name))
    return numbers.values[np.isfinite(numbers.values)]


def _refuse(checks: RowChecks, name: str, expected: str) -> None:
    column = checks.column(name)
    found = cell_text(column, int(np.flatnonzero(~column.is_null().to_numpy())[0]))
    place = f"{checks.name}, column {checks.own_name(name)}"
    raise DataFormatError(f"{place}: {found}; expected {expected}")
