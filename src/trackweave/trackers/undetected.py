"""Where objects may be that no track follows."""

import math
from dataclasses import dataclass

import numpy as np

from trackweave.arrays import FloatArray

__all__ = ["Undetected"]


@dataclass(frozen=True, slots=True, eq=False)
class _Lost:
    """An object whose track ended: somewhere around its last place."""

    position: FloatArray
    radius: float
    time: float


class Undetected:
    """The expected density of objects that exist and are not tracked.

    A uniform part is fed by new objects and thinned by every scan, because what is detected
    begins a track. Around the last place of a track that ended, the chance that its object was
    only lost is spread evenly over the ball that it can have reached since: so a lost object is
    taken up again sooner than an unknown one.
    """

    LOST_CHANCE = 0.5
    """How probable it is that an ended track's object lives on unseen."""
    LOST_PERIODS = 12
    """For how many scan periods it is looked for."""

    def __init__(self, initial: float, new: float, max_speed: float, period: float) -> None:
        self._uniform = initial
        self._new = new
        self._max_speed = max_speed
        self._period = period
        self._lost: list[_Lost] = []

    def log_density(self, position: FloatArray, time: float) -> FloatArray:
        """Return the log density at each position, shape (positions,) [m⁻² or m⁻³]."""
        dim = position.shape[1]
        density = np.full(position.shape[0], self._uniform)
        for lost in self._lost:
            radius = lost.radius + self._max_speed * max(0.0, time - lost.time)
            volume = math.pi * radius**2 if dim == 2 else 4.0 / 3.0 * math.pi * radius**3
            near = np.sum((position - lost.position) ** 2, axis=1) <= radius**2
            density[near] += self.LOST_CHANCE / volume
        logarithm: FloatArray = np.log(np.maximum(density, 1e-300))
        return logarithm

    def scanned(self, detection_probability: float) -> None:
        """Take out what a scan has detected."""
        self._uniform *= 1.0 - detection_probability

    def wait(self, time: float, interval: float) -> None:
        """Let new objects come during an interval [s] up to a time; forget the long lost."""
        self._uniform += self._new * min(interval / self._period, 1e3)
        horizon = self.LOST_PERIODS * self._period
        self._lost = [lost for lost in self._lost if time - lost.time <= horizon]

    def lose(self, position: FloatArray, radius: float, time: float) -> None:
        """Begin to look for an object last seen at a place and time, within a radius [m]."""
        self._lost.append(_Lost(position.copy(), radius, time))
