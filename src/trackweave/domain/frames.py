"""Planes on which positions of the Earth are laid, tangent or stereographic.

The oblique stereographic projection of the ellipsoid is after J. P. Snyder, *Map projections: a
working manual*, USGS professional paper 1395, 1987, pages 160-163.
"""

from dataclasses import dataclass, replace
from typing import Literal, TypeAlias

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.keys import Key

__all__ = ["ORIGIN", "PLACE", "LocalFrame", "Projection", "from_stereographic", "to_stereographic"]

_DEGREES = "in degrees, from -90 to 90 and -180 to 360"
ORIGIN = Key(
    f"[latitude, longitude] {_DEGREES}",
    size=(2, 2),
    holds=lambda place: -90 <= place[0] <= 90 and -180 <= place[1] <= 360,
)
PLACE = replace(
    ORIGIN.said(
        f"[latitude, longitude] or [latitude, longitude, altitude] {_DEGREES}, and metres"
    ),
    size=(2, 3),
)

Projection: TypeAlias = Literal["tangent", "stereographic"]

# WGS-84.
_SEMI_MAJOR_M = 6_378_137.0
_SEMI_MINOR_M = 6_356_752.314245179


@dataclass(frozen=True, slots=True)
class LocalFrame:
    """A plane that touches the WGS-84 ellipsoid at an origin: x east, y north, z altitude.

    ``tangent`` sees the Earth along the plane's normal; ``stereographic`` is true to angles
    everywhere and stretches distances instead, by 0.15 % at 500 km from the origin and 0.6 % at
    1,000 km: the system plane of wide areas.

    The horizontal position is that of the point of the ellipsoid right below, so that it does not
    depend on altitude: two sensors that know an aircraft's altitude differently, or not at all,
    see it at one place. The third coordinate is the altitude itself, not the height over the
    plane, which would fall by 8 km within 320 km of level flight. The price is that horizontal
    distances are those at sea level, too short by 0.16 % per 10 km of altitude, and tangent ones
    are seen along the plane's normal: radially too short by 0.3 % at 500 km from the origin and
    1.2 % at 1,000 km.

    Parameters
    ----------
    latitude_deg
        Latitude of the origin [degrees], -90 to 90.
    longitude_deg
        Longitude of the origin [degrees], -180 to 360.
    projection
        How the Earth is laid on the plane.
    """

    latitude_deg: float
    longitude_deg: float
    projection: Projection = "tangent"

    def to_plane(
        self, latitude_deg: FloatArray, longitude_deg: FloatArray, altitude_m: FloatArray
    ) -> FloatArray:
        """Return positions in the frame [m], shape (points, 3)."""
        import pymap3d

        on_surface = np.zeros_like(np.asarray(latitude_deg, dtype=np.float64))
        if self.projection == "stereographic":
            origin = (self.latitude_deg, self.longitude_deg)
            east, north = to_stereographic(latitude_deg, longitude_deg, origin)
        else:
            east, north, _ = pymap3d.geodetic2enu(
                latitude_deg, longitude_deg, on_surface, self.latitude_deg, self.longitude_deg, 0.0
            )
        altitude = np.broadcast_to(altitude_m, on_surface.shape)
        return np.stack([east, north, altitude], axis=-1)

    def to_geodetic(self, position: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return latitude [degrees], longitude [degrees] and altitude [m] of positions [m]."""
        # Two-dimensional positions are taken to lie on the ellipsoid. A position beyond the
        # horizon (more than some 6,370 km from the origin) becomes the horizon's.
        import pymap3d

        if self.projection == "stereographic":
            origin = (self.latitude_deg, self.longitude_deg)
            latitude, longitude = from_stereographic(position[:, 0], position[:, 1], origin)
        else:
            latitude, longitude, _ = pymap3d.ecef2geodetic(*self._surface_points(position).T)
        has_altitude = position.shape[1] == 3
        altitude = position[:, 2].copy() if has_altitude else np.zeros(len(position))
        return np.asarray(latitude), np.asarray(longitude), altitude

    def _surface_points(self, position: FloatArray) -> FloatArray:
        """Return where the plane's normals through positions pierce the ellipsoid, Earth-fixed."""
        import pymap3d

        x, y = position[:, 0], position[:, 1]
        above, below = (
            np.stack(
                pymap3d.enu2ecef(
                    x, y, np.full(len(position), up), self.latitude_deg, self.longitude_deg, 0.0
                ),
                axis=-1,
            )
            for up in (1.0, 0.0)
        )
        normal = above - below
        # With the polar axis stretched to a sphere of radius a: |point + t normal| = a.
        to_sphere = np.array([1.0, 1.0, _SEMI_MAJOR_M / _SEMI_MINOR_M])
        point, direction = below * to_sphere, normal * to_sphere
        square = np.sum(direction**2, axis=1)
        half = np.sum(point * direction, axis=1)
        rest = np.sum(point**2, axis=1) - _SEMI_MAJOR_M**2
        root = np.sqrt(np.maximum(half**2 - square * rest, 0.0))
        # The root near the plane; this form of it does not cancel.
        denominator = half + root
        near = -rest / np.where(denominator == 0.0, 1.0, denominator)
        points: FloatArray = below + near[:, np.newaxis] * normal
        return points


# WGS-84.
_ECCENTRICITY = 0.081819190842621
# Nearer to a pole the formulas lose their meaning by a division of 0 by 0.
_POLE = np.radians(89.9999)
_ROUNDS = 6


def to_stereographic(
    latitude_deg: FloatArray, longitude_deg: FloatArray, origin: tuple[float, float]
) -> tuple[FloatArray, FloatArray]:
    """Return x and y [m] of latitudes and longitudes [degrees] about an origin [degrees]."""
    chi_0, scale = _origin(origin[0])
    chi = _conformal(np.radians(np.asarray(latitude_deg, dtype=np.float64)))
    turn = np.radians(np.asarray(longitude_deg, dtype=np.float64) - origin[1])
    # Equations 21-24 to 21-27.
    down = 1 + np.sin(chi_0) * np.sin(chi) + np.cos(chi_0) * np.cos(chi) * np.cos(turn)
    stretch = 2 * scale / np.maximum(down, 1e-9)
    east = stretch * np.cos(chi) * np.sin(turn)
    north = stretch * (np.cos(chi_0) * np.sin(chi) - np.sin(chi_0) * np.cos(chi) * np.cos(turn))
    return east, north


def from_stereographic(
    x: FloatArray, y: FloatArray, origin: tuple[float, float]
) -> tuple[FloatArray, FloatArray]:
    """Return latitudes and longitudes [degrees] of x and y [m] about an origin [degrees]."""
    chi_0, scale = _origin(origin[0])
    distance = np.hypot(x, y)
    # Equations 21-36 to 21-38.
    away = 2 * np.arctan2(distance, 2 * scale)
    north = y / np.where(distance > 0, distance, 1.0)
    chi = np.arcsin(
        np.clip(np.cos(away) * np.sin(chi_0) + np.sin(away) * np.cos(chi_0) * north, -1.0, 1.0)
    )
    turn = np.arctan2(
        x * np.sin(away),
        distance * np.cos(chi_0) * np.cos(away) - y * np.sin(chi_0) * np.sin(away),
    )
    longitude = (origin[1] + np.degrees(turn) + 180.0) % 360.0 - 180.0
    return np.degrees(_geodetic(chi)), longitude


def _origin(latitude_deg: float) -> tuple[float, float]:
    """Return the origin's conformal latitude [rad], and the radius of the sphere there [m]."""
    latitude = float(np.clip(np.radians(latitude_deg), -_POLE, _POLE))
    chi = float(_conformal(np.array(latitude)))
    radius = np.cos(latitude) / np.sqrt(1 - (_ECCENTRICITY * np.sin(latitude)) ** 2)
    return chi, float(_SEMI_MAJOR_M * radius / np.cos(chi))


def _conformal(latitude: FloatArray) -> FloatArray:
    """Return conformal latitudes, equation 3-1 [rad]."""
    sine = _ECCENTRICITY * np.sin(latitude)
    flat = ((1 - sine) / (1 + sine)) ** (_ECCENTRICITY / 2)
    return np.asarray(2 * np.arctan(np.tan(np.pi / 4 + latitude / 2) * flat) - np.pi / 2)


def _geodetic(chi: FloatArray) -> FloatArray:
    """Return latitudes of conformal ones, equation 3-4 in rounds [rad]."""
    latitude = chi
    for _ in range(_ROUNDS):
        sine = _ECCENTRICITY * np.sin(latitude)
        steep = ((1 + sine) / (1 - sine)) ** (_ECCENTRICITY / 2)
        latitude = 2 * np.arctan(np.tan(np.pi / 4 + chi / 2) * steep) - np.pi / 2
    return np.asarray(latitude)
