"""Whole trackers on a sky of three radars, and how far their estimates lie off the courses."""

import time as clock
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackweave.arrays import FloatArray
from trackweave.domain.tracks import CONFIRMED, TrackTable
from trackweave.metrics import evaluate
from trackweave.metrics.assignments import assignment_quality
from trackweave.run.tracking import track
from trackweave.studies.wiranto_scenes import (
    PERIOD,
    SEEN,
    SIDE,
    SIGMA,
    STRAIGHT,
    TURN_BEGINS,
    TURN_ENDS,
    TURNING,
    RadarSky,
)

__all__ = [
    "CUTOFF",
    "IMM",
    "LEGS",
    "MULTISCAN",
    "PAIRED",
    "PRESET",
    "TRACKERS",
    "Offsets",
    "Tracked",
    "leg_of",
    "offsets_from",
    "offsets_of_plots",
    "run_tracker",
]

CUTOFF = 5.0 * SIGMA
WARM_UP_S = 10.0
"""Time in which velocities become known."""
DETECTED_S = 10.0
"""Time after which a turn ought to be recognised."""
MAX_SPEED = 250.0
MANOEUVRING, QUIET = 30.0, 1.0
"""Process noise [m²/s³]: half the turn's acceleration² · period; little, beside a model of it."""
LEGS = ("straight courses", "turn", "turn's first 10 s", "turn after 10 s")
PRESET, PAIRED, FUSED, MULTISCAN, IMM = (
    "wiranto-2018", "wiranto-2018, one-to-one", "evidence, nearest neighbour", "default",
    "default, imm",
)  # fmt: skip
# What each tracker's file says of it, the preset's being silent; its usual process noise.
TRACKERS: dict[str, tuple[dict[str, Any], float]] = {
    PRESET: ({}, MANOEUVRING),
    PAIRED: ({"tracker": {"pairing": "one-to-one"}}, MANOEUVRING),
    FUSED: ({"plots": {"fuse": True}, "tracker": {"kind": "nearest-neighbour"}}, MANOEUVRING),
    MULTISCAN: ({}, MANOEUVRING),
    IMM: ({"motion": {"model": "imm"}}, QUIET),
}


@dataclass(frozen=True, slots=True, eq=False)
class Offsets:
    """How far estimates or measurements of one aircraft lie off its course.

    Parameters
    ----------
    time
        When [s].
    ahead, right
        Along the course and to its right [m].
    """

    time: FloatArray
    ahead: FloatArray
    right: FloatArray

    def within(self, chosen: NDArray[np.bool_]) -> "Offsets":
        """Return some of them."""
        return Offsets(self.time[chosen], self.ahead[chosen], self.right[chosen])

    @property
    def distance(self) -> FloatArray:
        """How far off they are [m]."""
        found: FloatArray = np.hypot(self.ahead, self.right)
        return found

    @property
    def rmse(self) -> float:
        """Root of the mean squared distance from the course's point [m]."""
        return float(np.sqrt(np.mean(self.distance**2)))

    @property
    def scatter(self) -> float:
        """The same about the mean offset [m]: how precise they are, displaced or not."""
        return float(np.sqrt(np.var(self.ahead) + np.var(self.right)))


@dataclass(frozen=True, slots=True, eq=False)
class Tracked:
    """What a tracker made of a sky.

    Parameters
    ----------
    tracks
        What was known after each instant.
    measures
        Measures by their names.
    offsets
        Of each aircraft's nearest confirmed track, as it was known then.
    smoothed
        The same after the fact.
    """

    tracks: TrackTable
    measures: dict[str, float]
    offsets: dict[str, Offsets]
    smoothed: dict[str, Offsets]


def run_tracker(
    sky: RadarSky, name: str, rng: np.random.Generator, process_noise: float | None = None
) -> Tracked:
    """Return what a tracker makes of a sky whose radars it knows.

    Parameters
    ----------
    sky
        The sky.
    name
        A name of ``TRACKERS``.
    rng
        Source of randomness.
    process_noise
        Power spectral density [m²/s³]; None for the tracker's usual one.

    Returns
    -------
    Tracks and measures.
    """
    said, usual = TRACKERS[name]
    noise = usual if process_noise is None else process_noise
    motion = {"process_noise": noise, "max_speed": MAX_SPEED, **said.get("motion", {})}
    begun = clock.process_time()
    values = track(
        sky.reports,
        {**_known(sky), **said, "motion": motion},
        preset=PRESET if name in {PRESET, PAIRED} else None,
        rng=rng,
    ).values
    cpu = clock.process_time() - begun
    tracks, assigned = values.tracks, np.full(sky.target.size, -1, dtype=np.int64)
    for row, own in values.assignment.items():
        assigned[row] = own
    figures = evaluate(sky.truth, tracks, cutoff=CUTOFF)
    quality = assignment_quality(sky.target, assigned)
    measures = {
        "GOSPA [m]": float(figures.gospa or 0.0),
        "RMSE [m]": float(figures.rmse or np.nan),
        "switches": float(figures.switches),
        "false tracks per scan": float(figures.false_per_time or 0.0),
        "missed per scan": float(figures.missed_per_time or 0.0),
        "classified rightly [%]": 100.0 * float(np.mean((assigned >= 0) == (sky.target >= 0))),
        "on the right track [%]": 100.0 * float(quality.right_share or 0.0),
        "CPU [ms/scan]": 1000.0 * cpu / len(sky.instants),
    }
    return Tracked(tracks, measures, _nearest(sky, tracks), _nearest(sky, values.history))


def _nearest(sky: RadarSky, tracks: TrackTable) -> dict[str, Offsets]:
    believed = tracks.status >= CONFIRMED
    return {
        name: offsets_from(sky, name, tracks.time[believed], tracks.mean[believed, :2])
        for name in (*STRAIGHT, TURNING)
    }


def _known(sky: RadarSky) -> dict[str, Any]:
    """Return what a configuration says of the sky, so that nothing has to be estimated."""
    view = [[0.0, 0.0], [SIDE, 0.0], [SIDE, SIDE], [0.0, SIDE]]
    radar = {
        "sigma": SIGMA, "detection_probability": SEEN, "scan_period": PERIOD,
        "clutter_per_scan": sky.shape.false_alarms, "field_of_view": {"polygon": view},
    }  # fmt: skip
    present = sky.shape.n_objects / SIDE**2
    lifecycle = {
        "initial_target_density": present,
        # One more in a hundred scans.
        "new_target_density": 0.01 / SIDE**2,
    }
    return {"sensors": {"default": radar}, "lifecycle": lifecycle}


def offsets_from(sky: RadarSky, name: str, time: FloatArray, place: FloatArray) -> Offsets:
    """Return how far the nearest of some places at each time lies off an aircraft's course.

    Parameters
    ----------
    sky
        The sky.
    name
        The aircraft.
    time, place
        When [s] and where [m] there is an estimate or a measurement.

    Returns
    -------
    One for each of the truth's times at which a place is within the cutoff.
    """
    times, where, velocity = sky.course(name)
    moment, apart = [], [np.empty((0, 2))]
    for number, now in enumerate(times):
        here = place[np.abs(time - now) < 0.1 * PERIOD] - where[number]
        nearest = here[np.argsort(np.sum(here**2, axis=1))[:1]]
        if nearest.size and np.hypot(*nearest[0]) <= CUTOFF:
            moment.append(number)
            apart.append(nearest)
    chosen = np.array(moment, dtype=np.int64)
    return _offsets(times[chosen], np.concatenate(apart), velocity[chosen])


def offsets_of_plots(sky: RadarSky, name: str) -> Offsets:
    """Return how far all plots of an aircraft lie off its course.

    Parameters
    ----------
    sky
        The sky.
    name
        The aircraft.

    Returns
    -------
    One for each plot.
    """
    own = np.asarray(sky.reports.carried["target"]) == name
    times, where, velocity = sky.course(name)
    moment = np.searchsorted(times, sky.reports.time[own] - 0.1 * PERIOD)
    apart = sky.reports.measurement[own] - where[moment]
    return _offsets(times[moment], apart, velocity[moment])


def _offsets(time: FloatArray, apart: FloatArray, velocity: FloatArray) -> Offsets:
    along = velocity / np.linalg.norm(velocity, axis=1, keepdims=True)
    aside = np.column_stack([along[:, 1], -along[:, 0]])
    return Offsets(time, np.sum(apart * along, axis=1), np.sum(apart * aside, axis=1))


def leg_of(offsets: dict[str, Offsets], leg: str) -> Offsets:
    """Return the offsets of one of the ``LEGS``.

    Parameters
    ----------
    offsets
        Those of each aircraft.
    leg
        Its name. The turn is to the left: what lies outside of it is on the right.

    Returns
    -------
    The offsets.
    """
    if leg == LEGS[0]:
        parts = [offsets[name].within(offsets[name].time >= WARM_UP_S) for name in STRAIGHT]
        return Offsets(*(
            np.concatenate([getattr(part, axis) for part in parts])
            for axis in ("time", "ahead", "right")
        ))  # fmt: skip
    own = offsets[TURNING]
    begin = TURN_BEGINS + (DETECTED_S if leg == LEGS[3] else 0.0)
    end = TURN_BEGINS + DETECTED_S if leg == LEGS[2] else TURN_ENDS
    return own.within((own.time > begin) & (own.time <= end))
