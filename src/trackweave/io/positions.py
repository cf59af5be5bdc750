"""Which columns of a table are positions, and what they say."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.domain.frames import LocalFrame, Projection
from trackweave.errors import DataFormatError, InvalidInputError
from trackweave.fields import checked_number
from trackweave.io.checks import Range, RowChecks
from trackweave.io.columns import BoolArray, read_numbers

__all__ = [
    "DISTANCE",
    "LATITUDE",
    "LONGITUDE",
    "NO_LATITUDE",
    "NO_LONGITUDE",
    "TRACK_COVARIANCE",
    "TRACK_PLACE",
    "TRACK_SPEED",
    "Positions",
    "choose_frame",
    "frame_about",
    "has_height",
    "has_positions",
    "not_available",
    "read_positions",
    "require_origin",
]

# Nothing on or near the Earth is farther; squares of it are still exact to a metre.
DISTANCE = Range(-1e9, 1e9)
# What tracks say: one that coasts may be far outside what is reported, and hardly know where.
TRACK_PLACE, TRACK_SPEED = Range(-1e15, 1e15), Range(-1e12, 1e12)
TRACK_COVARIANCE = Range(-1e36, 1e36)
LATITUDE = Range(-90.0, 90.0)
LONGITUDE = Range(-180.0, 360.0)
# What AIS sends for a position that the ship does not know.
NO_LATITUDE, NO_LONGITUDE = 91.0, 181.0
# Receivers without a fix send 0, 0, in the sea off Ghana: a smaller share than this, where the
# others' median lies so far off [degrees].
NO_FIX, FROM_ZERO_DEG = 0.9, 1.0
# Farther from its origin a tangent plane shortens distances by more than 13 %.
_FARTHEST_DEG = 30.0
_WORLD_WIDE = 0.2
"""A recording of which a greater share lies farther off is none of one region."""
_EXPECTED = "x,y[,z] or lat,lon[,alt_m]"


class Positions(NamedTuple):
    """Positions on a plane."""

    values: FloatArray  # Positions [m], shape (rows, dim), dim 2 or 3; meaningless in bad rows
    columns: tuple[str, ...]  # Names of the columns that they came from
    # The plane on which latitudes and longitudes were laid, None for plane coordinates.
    frame: LocalFrame | None


def has_positions(names: set[str]) -> bool:
    """Tell whether a table with columns of these names has positions."""
    return {"x", "y"} <= names or {"lat", "lon"} <= names


def not_available(checks: RowChecks, frame: LocalFrame | None) -> BoolArray:
    """Tell in which rows latitude or longitude is the code for "not available"."""
    if not _are_geodetic(set(checks.names), frame):
        return np.zeros(len(checks), dtype=np.bool_)
    latitude, longitude = (read_numbers(checks.column(name)).values for name in ("lat", "lon"))
    unknown: BoolArray = (latitude == NO_LATITUDE) & ~np.isnan(longitude)
    beyond = (longitude > 180.0) & (longitude <= LONGITUDE.high) & ~unknown
    # Where other longitudes are beyond 180 degrees too, 181 is one of them.
    if np.all(longitude[beyond] == NO_LONGITUDE):
        unknown |= beyond & (np.abs(latitude) <= LATITUDE.high)
    return unknown | _without_fix(latitude, longitude)


def _without_fix(latitude: FloatArray, longitude: FloatArray) -> BoolArray:
    """Tell which positions are 0, 0 though all else is elsewhere."""
    is_zero: BoolArray = (latitude == 0.0) & (longitude == 0.0)
    place = np.stack([latitude, longitude])[:, ~is_zero & np.isfinite(latitude + longitude)]
    is_usual = is_zero.sum() >= NO_FIX * (is_zero.sum() + place.shape[1])
    if not is_zero.any() or is_usual:
        return np.zeros_like(is_zero)
    return is_zero & bool(np.abs(np.median(place, axis=1)).max() > FROM_ZERO_DEG)


def read_positions(
    checks: RowChecks,
    frame: LocalFrame | None = None,
    among: BoolArray | None = None,
    within: Range = DISTANCE,
) -> Positions:
    """Return positions of all rows, NaN in those that are none; refuse a table without any."""
    # Of ``x,y`` beside ``lat,lon`` the latter count where a plane for them is given; else that is
    # chosen about their median. The third dimension is there when ``z`` has any filled cell (then
    # all must be filled), or when ``alt_m`` is filled in every good row. ``among`` are the rows
    # that are positions, None for all; ``within`` is what coordinates on the plane may be.
    names = set(checks.names)
    if _are_geodetic(names, frame):
        return _geodetic(checks, frame, among)
    if {"x", "y"} <= names:
        columns = ("x", "y", "z") if has_height(checks) else ("x", "y")
        values = [checks.numbers(name, within, among=among) for name in columns]
        return Positions(np.stack(values, axis=-1), columns, None)
    # Half of a pair: name the half that is missing.
    for first, second in (("x", "y"), ("y", "x"), ("lat", "lon"), ("lon", "lat")):
        if first in names:
            checks.require(second, f"position columns {_EXPECTED}")
    hint = "; --from 'csv?x=NAME&y=NAME' tells what columns are called in a file"
    on_earth = [
        next((n for n in checks.names if n.strip().lower().startswith(begin)), None)
        for begin in ("lat", "lon")
    ]
    if all(on_earth):
        hint = "; --from 'csv?lat={}&lon={}' tells what they are called here".format(*on_earth)
    elif {"left", "top"} <= names:
        hint = "; of boxes, give their middle as x, y"
    elif any(word in name.lower() for name in names for word in ("range", "azimuth", "bearing")):
        hint = "; of what a radar tells, --from 'csv?range_m=NAME&azimuth_deg=NAME' does"
    raise DataFormatError(
        f"{checks.name}, columns x and y: missing; expected position columns {_EXPECTED}{hint} "
        f"({checks.listed_columns})"
    )


def _are_geodetic(names: set[str], frame: LocalFrame | None) -> bool:
    """Tell whether positions are latitudes and longitudes, not coordinates on a plane."""
    return {"lat", "lon"} <= names and not ({"x", "y"} <= names and frame is None)


def has_height(checks: RowChecks) -> bool:
    """Tell whether heights say anything: those of images are 0 throughout."""
    return checks.filled("z") and bool((read_numbers(checks.column("z")).values != 0).any())


def frame_about(checks: RowChecks, projection: Projection) -> LocalFrame | None:
    """Return a plane about latitudes and longitudes, whatever their faults; None for none."""
    for first, second in (("lat", "lon"), ("sensor_lat", "sensor_lon")):
        if checks.filled(first) and checks.filled(second):
            latitude = read_numbers(checks.column(first)).values
            longitude = read_numbers(checks.column(second)).values
            good = (np.abs(latitude) <= LATITUDE.high) & (np.abs(longitude) <= LONGITUDE.high)
            return replace(choose_frame(latitude[good], longitude[good]), projection=projection)
    return None


def require_origin(origin: tuple[float, float], projection: Projection = "tangent") -> LocalFrame:
    """Return the plane with an origin: latitude -90 to 90, longitude -180 to 360 [degrees]."""
    try:
        latitude, longitude = (checked_number(number, "frame_origin") for number in origin)
    except (TypeError, ValueError) as err:
        raise InvalidInputError(
            f"frame_origin: {origin!r}; expected a latitude and a longitude [degrees]"
        ) from err
    for value, within in ((latitude, LATITUDE), (longitude, LONGITUDE)):
        if not within.low <= value <= within.high:
            raise InvalidInputError(f"frame_origin: {origin!r}; expected {within.limits} degrees")
    return LocalFrame(latitude, longitude, projection)


def _geodetic(checks: RowChecks, frame: LocalFrame | None, among: BoolArray | None) -> Positions:
    latitude = checks.numbers("lat", LATITUDE, among=among)
    longitude = checks.numbers("lon", LONGITUDE, among=among)
    # Bad rows must not upset the projection.
    good = checks.good if among is None else checks.good & among
    altitude = checks.optional_numbers("alt_m", DISTANCE, among)
    good = good & checks.good
    solid = checks.filled("alt_m") and not np.isnan(altitude[good]).any()
    if frame is None:
        frame = choose_frame(latitude[good], longitude[good])
    middle = (frame.latitude_deg, frame.longitude_deg)
    latitude, longitude = (
        np.where(good, angle, start)
        for angle, start in zip((latitude, longitude), middle, strict=True)
    )
    if not checks.anywhere:
        _refuse_far(checks, frame, latitude, longitude)
    values = frame.to_plane(latitude, longitude, np.nan_to_num(altitude))
    columns = ("lat", "lon", "alt_m") if solid else ("lat", "lon")
    return Positions(np.ascontiguousarray(values[:, : len(columns)]), columns, frame)


def choose_frame(latitude: FloatArray, longitude: FloatArray) -> LocalFrame:
    """Return a plane about the median [degrees], to 1e-4 (11 m): short to write down."""
    if latitude.size == 0:
        return LocalFrame(0.0, 0.0)
    # The median of longitudes is taken about their mean direction, for the sake of Fiji.
    angle = np.deg2rad(longitude)
    middle = np.rad2deg(np.arctan2(np.sin(angle).mean(), np.cos(angle).mean()))
    from_middle = (longitude - middle + 180.0) % 360.0 - 180.0
    east = (middle + np.median(from_middle) + 180.0) % 360.0 - 180.0
    return LocalFrame(round(float(np.median(latitude)), 4), round(float(east), 4))


def _densest(latitude: FloatArray, longitude: FloatArray) -> list[float]:
    """Return the middle of the reports in the fullest square of 10 degrees [degrees]."""
    squares = np.stack([latitude // 10.0, longitude // 10.0], axis=-1)
    _, which, count = np.unique(squares, axis=0, return_inverse=True, return_counts=True)
    mine = which.ravel() == np.argmax(count)
    return [round(float(np.median(angle[mine])), 1) for angle in (latitude, longitude)]


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
        f"({frame.latitude_deg:g}, {frame.longitude_deg:g}), for a plane holds no more of the "
        "Earth"
    )
    if far.mean() > _WORLD_WIDE:
        dense = _densest(latitude, longitude)
        where += (
            f". {int(far.sum()):,} of {far.size:,} rows lie farther off: a world-wide recording "
            "is tracked part by part, each with its own configuration of [frame] origin = "
            f"[latitude, longitude], such as {dense} where most reports of any such part are, and "
            "with bad rows skipped, which are those elsewhere"
        )
    checks.refuse("lon", far & by_longitude, where)
    checks.refuse("lat", far, where)
