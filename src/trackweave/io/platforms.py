"""Where sensors were, how they moved, and how they were turned, row by row."""

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.domain.frames import LocalFrame
from trackweave.errors import DataFormatError
from trackweave.io.checks import Range, RowChecks
from trackweave.io.positions import DISTANCE, LATITUDE, LONGITUDE, choose_frame

__all__ = ["read_heading", "read_platforms"]

_SPEED = Range(-1e9, 1e9)
_HEADING = Range(-360.0, 360.0)


def read_platforms(
    checks: RowChecks, frame: LocalFrame | None, *, on_plane: bool = False
) -> tuple[FloatArray | None, LocalFrame | None]:
    """Return where each row's sensor was and how it moved, and the plane of that.

    Columns ``sensor_x,sensor_y[,sensor_z]`` [m] or ``sensor_lat,sensor_lon[,sensor_alt_m]``
    [degrees, m], and ``sensor_vx,sensor_vy[,sensor_vz]`` [m/s]; what is left out of height and
    speed is 0.

    Parameters
    ----------
    checks
        The table; bad cells are complained of there.
    frame
        The plane for latitudes and longitudes; None to choose one about their median.
    on_plane
        Whether the reports are plane coordinates, so that no plane may be chosen.

    Returns
    -------
    x, y, z [m] and their rates [m/s], shape (rows, 6), NaN where a row does not say, or None where
    no row does; and the plane that was chosen or given.

    Raises
    ------
    DataFormatError
        If half of a pair of columns is missing, or latitudes come without a plane.
    """
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
