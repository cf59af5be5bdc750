"""Where objects may be that no track follows."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.association._nodes import ScanInput
from trackweave.models._kernels import thin_covered
from trackweave.models.coverage import Coverage

__all__ = ["Undetected"]


@dataclass(frozen=True, slots=True, eq=False)
class _Lost:
    """An object whose track ended: somewhere around its last place; known since a time."""

    position: FloatArray
    radius: float
    time: float
    since: float


@dataclass(frozen=True, slots=True, eq=False)
class _Look:
    """A scan: what was new before it, what share of it all it left, and where it looked."""

    new: float
    left: float
    coverage: Coverage


class Undetected:
    """The expected density of objects that exist and are not tracked.

    A first part is fed by new objects everywhere and thinned by every scan where it looked,
    because what is detected begins a track. Around the last place of a track that ended, the
    chance that its object was only lost is spread evenly over the ball that it can have reached
    since: so a lost object is taken up again sooner than an unknown one.
    """

    LOST_CHANCE = 0.5
    """How probable it is that an ended track's object lives on unseen."""
    LOST_PERIODS = 12
    """For how many scan periods it is looked for."""
    MAX_LOOKS = 64
    """How many scans are told apart by where they looked; what is older counts as everywhere, as
    much as its sector is of a turn."""

    def __init__(
        self,
        initial: float,
        new: float,
        max_speed: float,
        period: float,
        *,
        by_bearings: bool = True,
    ) -> None:
        self._uniform = initial
        self._new = new
        self._max_speed = max_speed
        self._period = period
        # Beside sensors that tell places a bearing begins no track: what it sees stays undetected.
        self._by_bearings = by_bearings
        self._came = 0.0
        self._looks: list[_Look] = []
        self._lost: list[_Lost] = []

    def __getstate__(self) -> dict[str, Any]:
        # A shallow copy is independent: what the lists hold never changes.
        return {**self.__dict__, "_looks": self._looks.copy(), "_lost": self._lost.copy()}

    def look(self, scan: ScanInput, interval: float) -> FloatArray:
        """Return the log density at a scan's reports; take out what the scan detects."""
        # The density is per m² or m³. ``interval`` is in seconds since the scan before, 0 for one
        # of the same instant.
        if interval > 0:
            self.wait(scan.time, interval)
        density = self.log_density(scan.position, scan.time)
        self._take_out(scan, interval)
        return density

    def pass_over(self, scan: ScanInput, interval: float) -> None:
        """Do the same where nobody asks for the density."""
        if interval > 0:
            self.wait(scan.time, interval)
        self._take_out(scan, interval)

    def _take_out(self, scan: ScanInput, interval: float) -> None:
        if not scan.is_located and not self._by_bearings:
            return
        detected = scan.detection_probability
        if not scan.is_silence_telling:
            # Lone reports come to a look at everything over a period, not each by itself.
            detected = 1.0 - (1.0 - detected) ** min(interval / self._period, 1.0)
        self.scanned(detected, scan.coverage)

    def log_density(self, position: FloatArray, time: float) -> FloatArray:
        """Return the log density at each position, shape (positions,) [m⁻² or m⁻³]."""
        count, dim = position.shape
        if not count:
            return np.empty(0)
        density = np.full(count, self._uniform)
        for look in self._looks:
            density += look.new
            thin_covered(density, position, look.coverage, look.left)
        density += self._came
        for lost in self._lost:
            if lost.since >= time:
                continue
            radius = lost.radius + self._max_speed * max(0.0, time - lost.time)
            volume = math.pi * radius**2 if dim == 2 else 4.0 / 3.0 * math.pi * radius**3
            near = np.sum((position - lost.position) ** 2, axis=1) <= radius**2
            density[near] += self.LOST_CHANCE / volume
        logarithm: FloatArray = np.log(np.maximum(density, 1e-300))
        return logarithm

    def scanned(self, detection_probability: float, coverage: Coverage) -> None:
        """Take out what a scan has detected."""
        self._looks.append(_Look(self._came, 1.0 - detection_probability, coverage))
        self._came = 0.0
        # As long as all scans look everywhere, one number says it all.
        while self._looks and (
            self._looks[0].coverage.everywhere or len(self._looks) > self.MAX_LOOKS
        ):
            oldest = self._looks.pop(0)
            looked = 1.0 if oldest.coverage.everywhere else _turned_share(oldest.coverage)
            self._uniform = (self._uniform + oldest.new) * (1.0 - looked * (1.0 - oldest.left))

    def wait(self, time: float, interval: float) -> None:
        """Let new objects come in an interval [s] that ends at a time; forget the long lost."""
        self._came += self._new * min(interval / self._period, 1e3)
        horizon = self.LOST_PERIODS * self._period
        self._lost = [lost for lost in self._lost if time - lost.time <= horizon]

    def lose(self, position: FloatArray, radius: float, time: float, since: float) -> None:
        """Begin to look for an object last seen at a place and time, within a radius [m]."""
        # Scans up to ``since`` [s] are not affected.
        self._lost.append(_Lost(position.copy(), radius, time, since))


def _turned_share(coverage: Coverage) -> float:
    """Return how much of a turn a coverage is."""
    return float(min(1.0, coverage.bounds[3] / (2.0 * math.pi)))
