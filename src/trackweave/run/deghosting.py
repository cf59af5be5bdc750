"""Ghosts of two sensors' bearings, told from objects once all bearings are there.

Where two sensors see two objects, their bearings cross at four places, and for a while two ghosts
move as objects do. A window decides too early; the whole of the bearings tells, as ghosts do not
fly straight for long. What each track has of each sensor is a leg; legs are assigned to each other
anew at the least cost of all flights, the association of tracks of several sensors of Huo et al.
2008 with a likelihood in place of a distance.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from trackweave.arrays import FloatArray, IntArray
from trackweave.config.fill import Settings
from trackweave.domain.reports import ReportTable
from trackweave.domain.tracks import TrackTable
from trackweave.estimation.bearing_flights import Bearings, Flight, flight_of
from trackweave.estimation.coverage import reach_of_bearings
from trackweave.models.motion import ConstantVelocity
from trackweave.run.polar_to_cartesian import platforms_of
from trackweave.run.record import Assigned
from trackweave.summaries import counted

__all__ = ["Deghosted", "deghosted", "unbroken"]

STRAIGHTEST = 0.001
PROCESS_NOISES = (STRAIGHTEST, 0.01, 0.1, 1.0, 10.0)
"""Where none was told, how much objects wander is found with the legs [m²/s³]."""
CLEAR, OF_BENDS = 3.0, 0.05
"""So many nats less are worth it to say that a track was a ghost, and so much of what a straight
flight costs more: where objects turn, some ghosts turn less."""
LEAST_LEG, MOST_MOMENTS, MOST_TRACKS = 4, 60, 30
"""A leg has so many bearings, those of so many moments are asked (threads of linear algebra take a
hundred times as long beside other load, and begin with larger matrices), and more tracks are not
taken apart."""
NEAR = 0.1  # How far off a flight a track sets out, as a share of its way
TOGETHER = 0.5  # Legs overlap for so much of the shorter
NEVER = 1e9  # Of legs of different times [nats]
ENDS, LONGEST_GAP, IN_LINE = 6, 0.5, 2.5
"""So many bearings tell whether a leg goes on, after so much of their time at most, and so far off
a line in squares of sigma each."""


class Deghosted(NamedTuple):
    """What the bearings of a whole recording say of which leg goes with which."""

    changed: tuple[int, ...]  # The tracks that have another leg now
    gain: float  # By how much that is likelier [nats]
    process_noise: float  # Under which it is likeliest [m²/s³]
    flown: Mapping[int, tuple[FloatArray, FloatArray]]
    """When and where each of them was: times [s] and x, y [m]."""

    def known(self, tracks: TrackTable) -> TrackTable:
        """Return tracks as if those that were ghosts had been known where they flew."""
        if not self.flown:
            return tracks
        mean, covariance = tracks.mean.copy(), tracks.covariance.copy()
        for name, (time, path) in self.flown.items():
            rows = np.flatnonzero(tracks.track == name)
            for axis in (0, 1):
                mean[rows, axis] = np.interp(tracks.time[rows], time, path[:, axis])
            near = max(NEAR * float(np.ptp(path, axis=0).max()), 1.0)
            covariance[rows, :2, :2] = near**2 * np.eye(2)
        return replace(tracks, mean=mean, covariance=covariance)

    def notes(self) -> list[str]:
        """Return a sentence, if anything changed."""
        if not self.changed:
            return []
        return [
            f"{counted(len(self.changed), 'track')} were ghosts of two sensors' bearings for a "
            "while and have in hindsight the bearings that make straight flights (run.json: "
            f"ghosts; {self.gain:.3g} nats likelier, process noise {self.process_noise:g} m²/s³); "
            "tracks keep what was known then, assignments and history are those of now"
        ]

    def as_record(self) -> dict[str, Any] | None:
        """Return what run.json says; None where nothing changed."""
        if not self.changed:
            return None
        return {
            "tracks": [*self.changed], "gain": self.gain, "process_noise": self.process_noise,
        }  # fmt: skip


NONE = Deghosted((), 0.0, 0.0, {})


def deghosted(
    reports: ReportTable, assigned: Assigned, settings: Settings
) -> tuple[Assigned, Deghosted]:
    """Return assignments in which no leg would better be another track's, and what changed."""
    motion, track = settings.motion, assigned.track
    numbers = np.unique(track[track >= 0])
    if not (
        settings.join
        and isinstance(motion, ConstantVelocity)
        and 1 < numbers.size <= MOST_TRACKS
        and len(reports.kinds) == 2
        and all(settings.sensors[k].measurement.is_bearing_only for k in (0, 1))
        and reports.dim == 2
    ):
        return assigned, NONE
    noises: tuple[float, ...] = PROCESS_NOISES
    if settings.sources.get("motion.process_noise") in {"file", "preset"}:
        noises = (STRAIGHTEST * motion.process_noise, motion.process_noise)
    bearings = _bearings(reports, settings)
    reach, sensor = reach_of_bearings(bearings.place), reports.sensor
    if reach <= 0.0:
        # From one place nothing crosses.
        return assigned, NONE
    # Most runs need no import of what assigns.
    from scipy.optimize import linear_sum_assignment

    is_asked = _asked(reports.time, sensor)
    flights = _Flights(bearings, sensor, is_asked, motion.max_speed, reach)
    whole = unbroken(bearings, sensor, track)
    as_is = min(float(np.trace(cost)) for cost in flights.costs(track, noises, only_own=True))
    costs = flights.costs(whole, noises)
    pairs = [linear_sum_assignment(cost) for cost in costs]
    totals = [float(cost[pair].sum()) for cost, pair in zip(costs, pairs, strict=True)]
    best = int(np.argmin(totals))
    gain = as_is - totals[best]
    if not gain > CLEAR + OF_BENDS * (totals[0] - totals[best]):
        return assigned, NONE
    now, is_second = whole.copy(), sensor == 1
    names = np.unique(whole[whole >= 0])
    for first, second in zip(*pairs[best], strict=True):
        now[is_second & (whole == names[second])] = names[first]
    is_other = now != track
    changed = np.unique(np.concatenate([now[is_other], track[is_other]]))
    found = Deghosted(
        tuple(changed.tolist()), gain, noises[best], flights.flown(now, changed, noises[best])
    )
    return Assigned(now, np.where(is_other, np.nan, assigned.probability)), found


def unbroken(bearings: Bearings, sensor: IntArray, track: IntArray) -> IntArray:
    """Return tracks of which no end is followed by one whose bearings go on, for both sensors.

    A ghost far beyond all objects is lost and found again many times.

    Parameters
    ----------
    bearings
        All of a recording, by time.
    sensor
        Which of the two made each, 0 or 1.
    track
        The track of each, -1 for none.

    Returns
    -------
    The same, under the number of the first of each.
    """
    whole = track.copy()
    numbers = np.unique(track[track >= 0])
    rows = {n: [np.flatnonzero((track == n) & (sensor == k)) for k in (0, 1)] for n in numbers}
    rows = {n: each for n, each in rows.items() if min(leg.size for leg in each) > 1}
    begins = {n: bearings.time[min(leg[0] for leg in each)] for n, each in rows.items()}
    free = sorted(rows, key=lambda n: begins[n])
    for n in list(free):
        end = bearings.time[max(leg[-1] for leg in rows[n])]
        for later in free:
            if begins[later] > end and all(
                _goes_on(bearings, one[-ENDS:], other[:ENDS])
                for one, other in zip(rows[n], rows[later], strict=True)
            ):
                whole[whole == later] = whole[rows[n][0][0]]
                free.remove(later)
                break
    return whole


def _goes_on(bearings: Bearings, one: IntArray, other: IntArray) -> bool:
    """Tell whether the last bearings of one leg and the first of another are in one line."""
    own = bearings.at(np.concatenate([one, other]))
    if own.time[one.size] - own.time[one.size - 1] > LONGEST_GAP * np.ptp(own.time):
        return False
    angle = np.unwrap(own.angle)
    line = np.polynomial.Polynomial.fit(own.time, angle, 1, w=1.0 / own.sigma)
    off = (angle - line(own.time)) / own.sigma
    return float(off @ off) < IN_LINE * off.size


def _bearings(reports: ReportTable, settings: Settings) -> Bearings:
    """Return all reports of a run as bearings."""
    places = {each.name: each.position for each in settings.sensors if each.position is not None}
    usual = np.array([settings.sensors[k].sigmas(2)[0] for k in (0, 1)])
    told = reports.sigma[:, 0]
    return Bearings(
        reports.time,
        platforms_of(reports, places)[:, :2],
        reports.measurement[:, 0],
        np.where(np.isnan(told), usual[reports.sensor], told),
    )


class _Flights(NamedTuple):
    """What tells how probable flights are."""

    bearings: Bearings
    sensor: IntArray
    is_asked: NDArray[np.bool_]  # The same bearings are, whatever tracks they are of
    max_speed: float
    reach: float

    def costs(
        self, track: IntArray, noises: Sequence[float], *, only_own: bool = False
    ) -> list[FloatArray]:
        """Return under each process noise what each leg costs with each of the other's [nats]."""
        numbers = np.unique(track[track >= 0])
        legs = [
            [np.flatnonzero(self.is_asked & (track == n) & (self.sensor == k)) for n in numbers]
            for k in (0, 1)
        ]
        costs = [np.full((numbers.size, numbers.size), NEVER) for _ in noises]
        for i, one in enumerate(legs[0]):
            for j, other in enumerate(legs[1]):
                if i != j and (only_own or not _are_together(self.bearings.time, one, other)):
                    continue
                rows = np.sort(np.concatenate([one, other]))
                # What no object can have made are false alarms, from anywhere.
                most = rows.size * math.log(2.0 * math.pi)
                for cost, noise in zip(costs, noises, strict=True):
                    cost[i, j] = min(self._of(rows, noise).cost, most) if rows.size else 0.0
        return costs

    def flown(
        self, track: IntArray, names: IntArray, noise: float
    ) -> dict[int, tuple[FloatArray, FloatArray]]:
        """Return when and where some tracks were."""
        flown = {}
        for name in np.intersect1d(names, track[self.is_asked]).tolist():
            rows = np.flatnonzero(self.is_asked & (track == name))
            flown[name] = self.bearings.time[rows], self._of(rows, noise).path
        return flown

    def _of(self, rows: IntArray, noise: float) -> Flight:
        return flight_of(self.bearings.at(rows), noise, self.max_speed, self.reach)


def _asked(time: FloatArray, sensor: IntArray) -> NDArray[np.bool_]:
    """Tell which bearings are asked: all of every so manieth moment of each sensor."""
    moments = [np.unique(time[sensor == k]) for k in (0, 1)]
    every = -(-max(each.size for each in moments) // MOST_MOMENTS)
    of = [np.isin(time, each[::every]) & (sensor == k) for k, each in enumerate(moments)]
    return np.asarray(of[0] | of[1])


def _are_together(time: FloatArray, one: IntArray, other: IntArray) -> bool:
    """Tell whether two legs are long enough and of the same time."""
    if min(one.size, other.size) < LEAST_LEG:
        return False
    begin, end = time[[one[0], other[0]]], time[[one[-1], other[-1]]]
    return bool(end.min() - begin.max() >= TOGETHER * (end - begin).min() > 0.0)
