"""What several sensors saw of the same sky, and how it depends on their biases.

A sensor's biases are six numbers. What it tells lies too far *east* and *north* [m], as its
positions are shifted or it does not stand where it is said to; its clock is ahead by a *clock
offset* [s]. Of one that measures ranges these are too long by a *range bias* [m] and by a share,
the *range scale*; its azimuths are too great by an *azimuth bias* [rad].
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from trackweave.arrays import FloatArray, IntArray
from trackweave.estimation.neighbours import expected_of
from trackweave.estimation.tracklets import FEWEST_REPORTS

__all__ = [
    "AZIMUTH",
    "CLOCK",
    "EAST",
    "NORTH",
    "N_BIASES",
    "RANGE",
    "SCALE",
    "USUAL_BIASES",
    "Sightings",
    "tracks_apart",
]

RANGE, SCALE, AZIMUTH, EAST, NORTH, CLOCK = range(6)
N_BIASES = 6
USUAL_BIASES = (200.0, 2e-3, float(np.radians(0.5)), 1000.0, 1000.0, 1.0)
"""Their standard deviations beforehand: a range [m], a share, an azimuth [rad], two shifts [m], a
clock [s]."""
# The standard deviation of a normal distribution, of its median distance from the middle.
OF_MEDIAN = 1.4826
# Of fewer tracks no noise can be told.
FEWEST_TRACKS = 3


@dataclass(frozen=True, eq=False)
class Sightings:
    """Reports in tracks of one sensor each, one row each, on the plane."""

    time: FloatArray  # [s]
    sensor: IntArray
    track: IntArray  # Numbered from 0 over all sensors
    centre: FloatArray  # Where the sensor is [m], shape (reports, 2); of positions, the position
    distance: FloatArray  # On the ground [m]; 1 for positions
    slant: FloatArray  # As measured [m]; 0 for positions
    azimuth: FloatArray  # [rad, clockwise from north]; 0 for positions
    # How much farther off on the ground an object is that is a metre farther off; 1 for positions.
    steepness: FloatArray
    height: FloatArray  # [m]; NaN where not told
    is_polar: NDArray[np.bool_]  # Of each sensor
    period: FloatArray  # Of each sensor, from scan to scan [s]

    @property
    def n_sensors(self) -> int:
        """Number of sensors."""
        return int(self.is_polar.size)

    @cached_property
    def track_sensor(self) -> IntArray:
        """The sensor of each track."""
        sensor = np.zeros(int(self.track.max(initial=-1)) + 1, dtype=np.int64)
        sensor[self.track] = self.sensor
        return sensor

    @cached_property
    def rows(self) -> list[IntArray]:
        """Rows of each track, by time."""
        order = np.lexsort((self.time, self.track))
        return np.split(order, np.flatnonzero(np.diff(self.track[order])) + 1)

    def corrected(self, bias: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return times [s] and places [m] without biases, shape (sensors, 6)."""
        own = bias[self.sensor]
        too_long = own[:, RANGE] + own[:, SCALE] * self.slant
        outward, _ = self._directions(own[:, AZIMUTH])
        length = np.where(
            self.is_polar[self.sensor], self.distance - self.steepness * too_long, 0.0
        )
        centre = self.centre - own[:, [EAST, NORTH]]
        return self.time - own[:, CLOCK], centre + length[:, None] * outward

    def without(self, bias: FloatArray) -> "Sightings":
        """Return what sensors would have seen without biases, shape (sensors, 6)."""
        own, polar = bias[self.sensor], self.is_polar[self.sensor]
        slant = np.where(polar, (self.slant - own[:, RANGE]) / (1.0 + own[:, SCALE]), self.slant)
        longer = np.where(self.slant > 0.0, slant / np.maximum(self.slant, 1e-9), 1.0)
        return replace(
            self,
            time=self.time - own[:, CLOCK],
            centre=self.centre - own[:, [EAST, NORTH]],
            slant=slant,
            distance=self.distance * longer,
            azimuth=self.azimuth - np.where(polar, own[:, AZIMUTH], 0.0),
        )

    def slopes(self, bias: FloatArray) -> FloatArray:
        """Return how far a unit of each bias but the clock's moves places [m], (reports, 2, 5)."""
        outward, side = self._directions(bias[self.sensor, AZIMUTH])
        polar = self.is_polar[self.sensor]
        longer = np.where(polar, self.steepness, 0.0)[:, None] * outward
        slope = np.zeros((self.time.size, 2, CLOCK))
        slope[:, :, RANGE], slope[:, :, SCALE] = longer, self.slant[:, None] * longer
        slope[:, :, AZIMUTH] = np.where(polar, self.distance, 0.0)[:, None] * side
        slope[:, 0, EAST] = slope[:, 1, NORTH] = 1.0
        return slope

    def axes(self, bias: FloatArray) -> FloatArray:
        """Return the directions along and across each report's line of sight, (reports, 2, 2)."""
        return np.stack(self._directions(bias[self.sensor, AZIMUTH]), axis=1)

    def _directions(self, turn: FloatArray) -> tuple[FloatArray, FloatArray]:
        azimuth = self.azimuth - np.where(self.is_polar[self.sensor], turn, 0.0)
        sine, cosine = np.sin(azimuth), np.cos(azimuth)
        return np.stack([sine, cosine], axis=1), np.stack([cosine, -sine], axis=1)

    @cached_property
    def track_sigma(self) -> FloatArray:
        """Noise of each track along [m] and across [rad; m for positions], shape (tracks, 2)."""
        # Each report beside the curve through two before and two after, which biases hardly move;
        # a track is as noisy as its sensor's usual one at least, and more where its own is.
        none = np.zeros((self.n_sensors, N_BIASES))
        (time, place), axes = self.corrected(none), self.axes(none)
        sigma = np.full((len(self.rows), 2), np.nan)
        for number, rows in enumerate(self.rows):
            if rows.size < FEWEST_REPORTS or np.diff(time[rows]).min() <= 0.0:
                continue
            curve, known = expected_of(time[rows], place[rows])[-1]
            inner = rows[2:-2]
            off = np.einsum("rki,ri->rk", axes[inner], place[inner] - curve)
            off /= np.sqrt(1.0 + known)[:, None]
            off[:, 1] /= self.distance[inner]
            sigma[number] = OF_MEDIAN * np.median(np.abs(off), axis=0)
        for sensor in range(self.n_sensors):
            own = self.track_sensor == sensor
            if np.isfinite(sigma[own, 0]).any():
                usual = np.maximum(np.nanmedian(sigma[own], axis=0), 1e-9)
                sigma[own] = np.fmax(sigma[own], usual)
        return sigma

    def part(self, rows: NDArray[np.bool_]) -> "Sightings":
        """Return some of the reports, their tracks numbered anew."""
        number = np.unique(self.track[rows], return_inverse=True)[1].reshape(-1)
        return Sightings(
            self.time[rows], self.sensor[rows], number, self.centre[rows], self.distance[rows],
            self.slant[rows], self.azimuth[rows], self.steepness[rows], self.height[rows],
            self.is_polar, self.period,
        )  # fmt: skip


def tracks_apart(numbers: list[IntArray]) -> IntArray:
    """Return tracks numbered over all sensors, of tracks numbered from 0 in each, -1 for none."""
    offset, found = 0, []
    for number in numbers:
        found.append(np.where(number >= 0, number + offset, -1))
        offset += int(number.max(initial=-1)) + 1
    return np.concatenate([np.empty(0, dtype=np.int64), *found])
