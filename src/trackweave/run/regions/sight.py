"""Which scans say something of a region: those that look there, or that the window counts.

Most scans of a large network look elsewhere: a radar is out of reach, or its beam points away.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trackweave.arrays import FloatArray
from trackweave.association.window_rule import coverage_of
from trackweave.domain.scans import Scan
from trackweave.models.sensors import Sensor
from trackweave.run.regions.cutting import Region
from trackweave.trackers._arguments import reference_of, slowest_of
from trackweave.trackers.scan_preparation import begin_of_sweep

__all__ = ["Looks"]

ASIDE = 0.1
"""So far beside its sector a beam may look, as a tracker follows how it turns [rad]."""
FARTHEST = 1e9
"""How far a sensor sees of whose reach nothing is known [m]."""


@dataclass(frozen=True, slots=True, eq=False)
class Looks:
    """Where each scan of a run looked; a row each."""

    place: FloatArray  # Of the sensor, x, y [m]
    reach: FloatArray  # [m]
    first: FloatArray  # The clockwise first edge of what it swept, clockwise from north [rad]
    width: FloatArray  # [rad]
    is_needed: NDArray[np.bool_]  # Whether it counts wherever it looked

    @classmethod
    def of(cls, scans: Sequence[Scan], sensors: Sequence[Sensor]) -> "Looks":
        """Return where scans looked, which are in order of time."""
        named = {each.name: each for each in sensors}
        slowest = slowest_of(sensors)
        reference, _ = reference_of(slowest)
        rows, needed = [], np.zeros(len(scans), dtype=np.bool_)
        # From the first on, new objects are counted.
        needed[:1] = True
        ends: dict[str, float] = {}
        for number, scan in enumerate(scans):
            rows.append(_bounds(scan, named[scan.sensor], ends))
            # Of the window's own clock every scan counts; without one, of each sensor.
            needed[number] |= reference in (None, scan.sensor)
        told = np.array(rows, dtype=np.float64).reshape(-1, 5)
        return cls(told[:, :2], told[:, 2], told[:, 3], told[:, 4], needed)

    def into(self, region: Region) -> NDArray[np.bool_]:
        """Tell of each scan whether it looked into a region, or counts in any case."""
        low = np.clip(region.low, self.place - FARTHEST, self.place + FARTHEST) - self.place
        high = np.clip(region.high, self.place - FARTHEST, self.place + FARTHEST) - self.place
        nearest = np.clip(0.0, low, high)
        away = np.hypot(nearest[:, 0], nearest[:, 1])
        # What does not hold the sensor lies within a quarter turn of its nearest point.
        ahead = np.arctan2(nearest[:, 0], nearest[:, 1])
        sides = [
            (np.arctan2(x, y) - ahead + np.pi) % (2 * np.pi) - np.pi
            for x in (low[:, 0], high[:, 0])
            for y in (low[:, 1], high[:, 1])
        ]
        begin, spread = ahead + np.min(sides, axis=0), np.ptp(sides, axis=0)
        behind = (begin - self.first + ASIDE) % (2 * np.pi) <= self.width + 2 * ASIDE
        before = (self.first - ASIDE - begin) % (2 * np.pi) <= spread
        sees: NDArray[np.bool_] = (away <= self.reach) & ((away == 0.0) | behind | before)
        return sees | self.is_needed


def _bounds(scan: Scan, sensor: Sensor, ends: dict[str, float]) -> tuple[float, ...]:
    """Return a scan's row, where earlier ones of its sensor have ended."""
    start = begin_of_sweep(scan, sensor.rotation, ends.get(scan.sensor, -np.inf))
    ends[scan.sensor] = scan.time
    seen = coverage_of(sensor, scan, start)
    if seen.everywhere:
        return (0.0, 0.0, np.inf, 0.0, 2 * np.pi)
    _, reach, first, width = seen.bounds.tolist()
    return (*seen.position.tolist(), reach, first, width)
