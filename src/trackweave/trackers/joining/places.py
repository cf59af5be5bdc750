"""Where and at which speed things happen: densities that samples tell, each without its own."""

from typing import NamedTuple

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.trackers.joining.segments import Paths

__all__ = ["Places", "Room"]

NARROW, ALIKE = 0.05, 0.4
"""What is nearer than this share of the room's width, or alike in the logarithm of the speed, is
one place."""
MOST = 1000
"""So many samples tell a density."""


class Places(NamedTuple):
    """Where and how fast: shapes (n, dim) [m] and (n,), of the logarithm of the speed."""

    position: FloatArray
    speed: FloatArray

    @classmethod
    def of(cls, paths: Paths, row: IntArray, *, onwards: bool) -> "Places":
        """Return those of some states."""
        return cls(paths.states.mean[row, : paths.dim], paths.speed(row, onwards=onwards)[0])


class Room:
    """Where objects were at all, and how dense they were there."""

    def __init__(self, paths: Paths) -> None:
        position = paths.states.mean[:, : paths.dim]
        low, high = np.quantile(position, (0.005, 0.995), axis=0)
        size = np.maximum(high - low, 1e-3 * float(np.max(high - low)) + 1e-9)
        self.volume = float(np.prod(size))
        self._width = NARROW * self.volume ** (1.0 / paths.dim)
        some = np.unique(np.linspace(0, len(position) - 1, MOST).astype(int))
        self._seen = Places.of(paths, some, onwards=False)

    def even(self, places: Places) -> FloatArray:
        """Return the density of objects that are anywhere alike, by speed."""
        off = (places.speed[:, np.newaxis] - self._seen.speed) / ALIKE
        return np.asarray((np.mean(_bell(off), axis=1) / ALIKE + 1e-3) / self.volume)

    def presence(self, places: Places) -> FloatArray:
        """Return the density of objects that are seen, half of it even over the room."""
        share = np.full(self._seen.speed.size, 1.0 / self._seen.speed.size)
        return np.asarray(0.5 * self.even(places) + 0.5 * self.near(self._seen, places) @ share)

    def near(self, samples: Places, places: Places) -> FloatArray:
        """Return the density that each sample gives each place, shape (places, samples)."""
        # None gives any to its own place, where samples and places are the same.
        density = np.ones((places.speed.size, samples.speed.size))
        for axis in range(samples.position.shape[1]):
            off = places.position[:, axis, np.newaxis] - samples.position[:, axis]
            density *= _bell(off / self._width) / self._width
        density *= _bell((places.speed[:, np.newaxis] - samples.speed) / ALIKE) / ALIKE
        if samples is places:
            np.fill_diagonal(density, 0.0)
        return density


def _bell(off: FloatArray) -> FloatArray:
    return np.asarray(np.exp(-0.5 * off**2) / np.sqrt(2.0 * np.pi))
