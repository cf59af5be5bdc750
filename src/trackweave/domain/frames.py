"""Planes on which positions of the Earth are laid."""

from dataclasses import dataclass

import numpy as np

from trackweave.arrays import FloatArray

__all__ = ["LocalFrame"]


@dataclass(frozen=True, slots=True)
class LocalFrame:
    """The plane that touches the WGS-84 ellipsoid at an origin: x east, y north, z up.

    Parameters
    ----------
    latitude_deg
        Latitude of the origin [degrees], -90 to 90.
    longitude_deg
        Longitude of the origin [degrees], -180 to 360.
    """

    latitude_deg: float
    longitude_deg: float

    def to_plane(
        self, latitude_deg: FloatArray, longitude_deg: FloatArray, altitude_m: FloatArray
    ) -> FloatArray:
        """Return positions in the frame [m], shape (points, 3)."""
        import pymap3d

        east, north, up = pymap3d.geodetic2enu(
            latitude_deg, longitude_deg, altitude_m, self.latitude_deg, self.longitude_deg, 0.0
        )
        return np.stack([east, north, up], axis=-1)

    def to_geodetic(self, position: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return latitude [degrees], longitude [degrees] and altitude [m] of positions.

        Two-dimensional positions are taken to lie on the ellipsoid.
        """
        import pymap3d

        up = position[:, 2] if position.shape[1] == 3 else self._up_of_surface(position)
        return pymap3d.enu2geodetic(
            position[:, 0], position[:, 1], up, self.latitude_deg, self.longitude_deg, 0.0
        )

    def _up_of_surface(self, position: FloatArray) -> FloatArray:
        """Return how far the ellipsoid lies below the plane, by two fixed-point steps."""
        import pymap3d

        up = np.zeros(position.shape[0])
        for _ in range(3):
            altitude = pymap3d.enu2geodetic(
                position[:, 0], position[:, 1], up, self.latitude_deg, self.longitude_deg, 0.0
            )[2]
            up = up - altitude
        return up
