"""What a receiver goes on saying of an aircraft that it no longer hears.

State vectors that are asked for at regular times, as of ADS-B receivers, tell the last position of
each aircraft for minutes after the last message. To the last digit the same place, of what was too
fast to stop there, is no news: it would end the track and begin one of something at rest.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple, Self

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.domain.reports import ReportTable
from trackweave.models.sensors import Sensor

__all__ = ["HeldLook", "HeldPlaces", "held_in"]

# It went straight on for the two looks before, but for such a part of its way. Who brakes no
# harder than so [m/s²] shows it there, if it stops at the place where it is said again; nor is
# hardly anything so fast as to be the way from one aircraft to another [m/s].
STRAIGHT, BRAKES, FASTEST = 0.35, 4.0, 400.0
# Two places on a way are no more looks apart than so: at one between an aircraft may be missed.
LOOKS_APART = 2


class HeldLook(NamedTuple):
    """What a sensor said at one time."""

    time: float
    place: FloatArray  # [m], shape (reports, 2)
    row: dict[bytes, int]  # Where each is among them, by its bits


@dataclass(slots=True)
class HeldPlaces:
    """What a sensor said last, look by look, and which of it it goes on saying."""

    looks: list[HeldLook] = field(default_factory=list)
    """The last of them."""
    held: dict[bytes, int] = field(default_factory=dict)
    """Places that are said again of what has moved on, and how many looks ago that was."""

    @classmethod
    def of(cls, sensor: Sensor, *, is_on_earth: bool) -> "Self | None":
        """Return what a sensor that has said nothing says; None where nothing can be held."""
        # On a plane that no latitudes tell, places may be pixels, and speeds anything.
        scans = sensor.scans is not False and sensor.rotation is None
        is_position = sensor.measurement.is_position
        return cls() if is_on_earth and scans and is_position else None

    def take(self, time: float, place: FloatArray) -> list[bool]:
        """Tell which reports of the next look say again where something was that has moved on."""
        # ``place`` are they on the plane [m], shape (reports, 2).
        keys = [at.tobytes() for at in place]
        again = [key in self.held or self._is_held(key) for key in keys]
        self.held = {key: ago + 1 for key, ago in self.held.items() if ago < LOOKS_APART}
        self.held |= {key: 0 for key, is_again in zip(keys, again, strict=True) if is_again}
        look = HeldLook(time, place, {key: row for row, key in enumerate(keys)})
        self.looks = [*self.looks[1 - 3 * LOOKS_APART :], look]
        return again

    def _is_held(self, key: bytes) -> bool:
        """Tell whether a place was new at one of the last looks, of what was under way."""
        for ago in range(1, min(LOOKS_APART, len(self.looks)) + 1):
            if key in self.looks[-ago].row:
                first, earlier = self.looks[-ago], self.looks[:-ago][::-1]
                if any(key in look.row for look in earlier):
                    return False
                place = first.place[first.row[key]]
                return any(
                    _went_on((first.time, place), second, third)
                    for number, second in enumerate(earlier[:LOOKS_APART])
                    for third in earlier[number + 1 : number + 1 + LOOKS_APART]
                )
        return False


def _went_on(at: tuple[float, FloatArray], second: HeldLook, third: HeldLook) -> bool:
    """Tell whether something went straight and fast to a place, by two looks before."""
    way, wait = at[1] - second.place, at[0] - second.time
    length = np.linalg.norm(way, axis=1)
    for step in way[(length > 2.0 * STRAIGHT * BRAKES * wait**2) & (length < FASTEST * wait)]:
        before = at[1] - step * (1.0 + (second.time - third.time) / wait)
        off = np.linalg.norm(third.place - before, axis=1)
        if off.size and off.min() < STRAIGHT * np.linalg.norm(step):
            return True
    return False


def held_in(reports: ReportTable, sensors: Mapping[str, Sensor], first: IntArray) -> IntArray:
    """Return the row of the report of which each is a copy, held places included.

    Parameters
    ----------
    reports
        All of a run, by time.
    sensors
        As configured, by name.
    first
        The same without held places: each one's own where it is no copy, shape (reports,).

    Returns
    -------
    Shape (reports,).
    """
    first = first.copy()
    for index, name in enumerate(reports.sensors):
        known = HeldPlaces.of(sensors[name], is_on_earth=reports.frame is not None)
        rows = np.flatnonzero((reports.sensor == index) & (first == np.arange(first.size)))
        if known is None or rows.size == 0:
            continue
        heads: dict[bytes, int] = {}
        for look in np.split(rows, np.flatnonzero(np.diff(reports.look[rows])) + 1):
            place = reports.measurement[look][:, :2]
            again = known.take(float(reports.time[look].max()), place)
            for row, at, is_again in zip(look.tolist(), place, again, strict=True):
                if is_again:
                    first[row] = heads[at.tobytes()]
                else:
                    heads[at.tobytes()] = row
    return first[first]
