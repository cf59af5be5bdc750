"""The oblique stereographic projection of the ellipsoid.

After J. P. Snyder, *Map projections: a working manual*, USGS professional paper 1395, 1987,
pages 160-163.
"""

import numpy as np

from trackweave.arrays import FloatArray

__all__ = ["from_stereographic", "to_stereographic"]

# WGS-84.
_SEMI_MAJOR_M = 6_378_137.0
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
