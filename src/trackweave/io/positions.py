"""Which columns of a table are positions, and what they say."""

from dataclasses import dataclass

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.domain.frames import LocalFrame
from trackweave.errors import DataFormatError, InvalidInputError
from trackweave.io.checks import Range, RowChecks

__all__ = ["DISTANCE", "Positions", "read_positions", "require_origin"]

# Nothing on or near the Earth is farther; squares of it are still exact to a metre.
DISTANCE = Range(-1e9, 1e9)
_LATITUDE = Range(-90.0, 90.0)
_LONGITUDE = Range(-180.0, 360.0)
# Farther from its origin a tangent plane shortens distances by more than 13 %.
_FARTHEST_DEG = 30.0
_LATER = ("range_m", "azimuth_deg", "elevation_deg", "range_rate_mps", "bearing_deg")
_EXPECTED = "x,y[,z] or lat,lon[,alt_m]"


@dataclass(frozen=True, slots=True)
class Positions:
    """Positions on a plane.

    Parameters
    ----------
    values
        Positions [m], shape (rows, dim), dim 2 or 3; meaningless in bad rows.
    columns
        Names of the columns that they came from.
    frame
        The plane on which latitudes and longitudes were laid, None for plane coordinates.
    """

    values: FloatArray
    columns: tuple[str, ...]
    frame: LocalFrame | None


def read_positions(checks: RowChecks, frame: LocalFrame | None = None) -> Positions:
    """Return the positions of a table.

    Where it has both ``x,y`` and ``lat,lon``, ``lat,lon`` are taken when a plane for them is given
    and ``x,y`` otherwise.

    The third dimension is there when ``z`` has any filled cell (then all must be filled), or
    when ``alt_m`` is filled in every good row.

    Parameters
    ----------
    checks
        The table; bad cells are complained of there.
    frame
        The plane for latitudes and longitudes; None to choose one about their median.

    Returns
    -------
    Positions of all rows.

    Raises
    ------
    DataFormatError
        If the table has no such columns.
    """
    names = set(checks.names)
    geodetic = {"lat", "lon"} <= names
    if {"x", "y"} <= names and not (geodetic and frame):
        columns = ("x", "y", "z") if checks.filled("z") else ("x", "y")
        values = np.stack([checks.numbers(name, DISTANCE) for name in columns], axis=-1)
        return Positions(values, columns, None)
    if geodetic:
        return _geodetic(checks, frame)
    later = [name for name in _LATER if name in names]
    if later:
        raise DataFormatError(
            f"{checks.name}, column {later[0]}: not supported yet as a measurement; "
            f"expected position columns {_EXPECTED}"
        )
    # Half of a pair: name the half that is missing.
    for first, second in (("x", "y"), ("y", "x"), ("lat", "lon"), ("lon", "lat")):
        if first in names:
            checks.require(second, f"position columns {_EXPECTED}")
    raise DataFormatError(
        f"{checks.name}, columns x and y: missing; expected position columns {_EXPECTED} "
        f"({checks.listed_columns})"
    )


def require_origin(origin: tuple[float, float]) -> LocalFrame:
    """Return the plane with an origin.

    Parameters
    ----------
    origin
        Latitude, -90 to 90, and longitude, -180 to 360 [degrees].

    Returns
    -------
    The plane that touches the ellipsoid there.

    Raises
    ------
    InvalidInputError
        If these are not two numbers within their ranges.
    """
    try:
        latitude, longitude = (float(number) for number in origin)
    except (TypeError, ValueError) as err:
        raise InvalidInputError(
            f"frame_origin: {origin!r}; expected a latitude and a longitude [degrees]"
        ) from err
    for value, within in ((latitude, _LATITUDE), (longitude, _LONGITUDE)):
        if not within.low <= value <= within.high:
            raise InvalidInputError(f"frame_origin: {origin!r}; expected {within.limits} degrees")
    return LocalFrame(latitude, longitude)


def _geodetic(checks: RowChecks, frame: LocalFrame | None) -> Positions:
    latitude = checks.numbers("lat", _LATITUDE)
    longitude = checks.numbers("lon", _LONGITUDE)
    altitude = np.zeros(len(checks))
    if checks.filled("alt_m"):
        altitude = checks.numbers("alt_m", DISTANCE, optional=True)
        solid = not np.isnan(altitude[checks.good]).any()
    else:
        solid = False
    # Bad rows must not upset the projection.
    good = checks.good
    latitude, longitude = np.where(good, latitude, 0.0), np.where(good, longitude, 0.0)
    if frame is None:
        frame = _choose_frame(latitude[good], longitude[good])
    _refuse_far(checks, frame, latitude, longitude)
    values = frame.to_plane(latitude, longitude, np.nan_to_num(altitude))
    columns = ("lat", "lon", "alt_m") if solid else ("lat", "lon")
    return Positions(np.ascontiguousarray(values[:, : len(columns)]), columns, frame)


def _choose_frame(latitude: FloatArray, longitude: FloatArray) -> LocalFrame:
    """Return a frame about the median position, to 1e-4 degrees (11 m): short to write down."""
    if latitude.size == 0:
        return LocalFrame(0.0, 0.0)
    # The median of longitudes is taken about their mean direction, for the sake of Fiji.
    angle = np.deg2rad(longitude)
    middle = np.rad2deg(np.arctan2(np.sin(angle).mean(), np.cos(angle).mean()))
    from_middle = (longitude - middle + 180.0) % 360.0 - 180.0
    east = (middle + np.median(from_middle) + 180.0) % 360.0 - 180.0
    return LocalFrame(round(float(np.median(latitude)), 4), round(float(east), 4))


def _refuse_far(
    checks: RowChecks, frame: LocalFrame, latitude: FloatArray, longitude: FloatArray
) -> None:
    lat, lon = np.deg2rad(latitude), np.deg2rad(longitude)
    lat_0, lon_0 = np.deg2rad(frame.latitude_deg), np.deg2rad(frame.longitude_deg)
    cosine = np.sin(lat) * np.sin(lat_0) + np.cos(lat) * np.cos(lat_0) * np.cos(lon - lon_0)
    # Of the two columns the message names the one that lies farther off.
    far = cosine < np.cos(np.deg2rad(_FARTHEST_DEG))
    across = np.abs((longitude - frame.longitude_deg + 180.0) % 360.0 - 180.0)
    by_longitude = across > np.abs(latitude - frame.latitude_deg)
    where = (
        f"a position within {_FARTHEST_DEG:g} degrees (3,300 km) of the plane's origin "
        f"({frame.latitude_deg:g}, {frame.longitude_deg:g})"
    )
    checks.refuse("lon", far & by_longitude, where)
    checks.refuse("lat", far, where)
