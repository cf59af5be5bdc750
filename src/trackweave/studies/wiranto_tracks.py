"""Whole trackers on a sky of three radars, and how far their estimates lie off the courses."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackweave.arrays import FloatArray
from trackweave.domain.tracks import CONFIRMED, TrackTable
from trackweave.metrics import evaluate
from trackweave.metrics.assignments import assignment_quality
from trackweave.run.tracking import track
from trackweave.studies import Tick, draws
from trackweave.studies.wiranto_plots import DOCUMENT, METHODS, Sorted, posed, sort_plots
from trackweave.studies.wiranto_scenes import (
    PERIOD,
    SEEN,
    SIDE,
    SIGMA,
    STRAIGHT,
    TURN,
    TURNING,
    RadarSky,
    SkyShape,
    draw_sky,
)  # fmt: skip
from trackweave.studies.writing import Table, frame

__all__ = [
    "IMM", "LEGS", "MULTISCAN", "NOISES", "PAIRED", "PLOTS", "PRESET", "SELECTED", "SMOOTHED",
    "USABLE", "Offsets", "Tracked", "by_noise", "figures", "leg_of", "offsets_from",
    "offsets_of_plots",
    "run_tracker", "tracking",
]  # fmt: skip

CUTOFF = 5.0 * SIGMA
SETTLED_S = 10.0
"""Time in which velocities become known [s]."""
MANOEUVRING, QUIET = 30.0, 1.0
"""Process noise [m²/s³]: half the turn's acceleration² · period; little, beside a model of it."""
NOISES = (1.0, 3.0, 10.0, 30.0, 100.0)
LEGS = ("straight courses", "turn")
PRESET, PAIRED, USABLE = "wiranto-2018", "wiranto-2018, one-to-one", "wiranto"
MULTISCAN, IMM = "default", "default, imm"
PLOTS, SELECTED, SMOOTHED = "plots", "selected, fused", "default, imm, history"
# What each tracker's file says of it, its preset, and its usual process noise.
TRACKERS: dict[str, tuple[dict[str, Any], str | None, float]] = {
    PRESET: ({}, PRESET, MANOEUVRING),
    PAIRED: ({"tracker": {"pairing": "one-to-one"}}, PRESET, MANOEUVRING),
    USABLE: ({}, USABLE, MANOEUVRING),
    MULTISCAN: ({}, None, MANOEUVRING),
    IMM: ({"motion": {"model": "imm"}}, None, QUIET),
}
OFF = ("RMSE [m]", "scatter [m]", "to the right [m]", "ahead [m]")


@dataclass(frozen=True, slots=True, eq=False)
class Offsets:
    """How far places lie off an aircraft's course at times [s]: along it, to its right [m]."""

    time: FloatArray
    ahead: FloatArray
    right: FloatArray

    def within(self, chosen: NDArray[np.bool_]) -> "Offsets":
        """Return some of them."""
        return Offsets(self.time[chosen], self.ahead[chosen], self.right[chosen])

    def row(self) -> tuple[float, ...]:
        """Return what ``OFF`` names: scatter is about the mean offset, displaced or not."""
        scatter = np.sqrt(np.var(self.ahead) + np.var(self.right))
        right, ahead = float(self.right.mean()), float(self.ahead.mean())
        return float(np.sqrt(np.mean(self.ahead**2 + self.right**2))), float(scatter), right, ahead


@dataclass(frozen=True, slots=True, eq=False)
class Tracked:
    """What a tracker made of a sky: as known then and smoothed after the fact, and measures."""

    tracks: TrackTable
    history: TrackTable
    measures: dict[str, float]


def run_tracker(
    sky: RadarSky, name: str, rng: np.random.Generator, process_noise: float | None = None
) -> Tracked:
    """Return what a tracker makes of a sky whose radars it knows."""
    said, preset, usual = TRACKERS[name]
    noise = usual if process_noise is None else process_noise
    motion = {"process_noise": noise, "max_speed": 250.0, **said.get("motion", {})}
    radar = {
        "sigma": SIGMA, "detection_probability": SEEN, "scan_period": PERIOD,
        "clutter_per_scan": sky.shape.false_alarms,
        "field_of_view": {"polygon": [[0.0, 0.0], [SIDE, 0.0], [SIDE, SIDE], [0.0, SIDE]]},
    }  # fmt: skip
    lifecycle = {
        "initial_target_density": sky.shape.n_objects / SIDE**2,
        # One more in a hundred scans.
        "new_target_density": 0.01 / SIDE**2,
    }
    given = {"sensors": {"default": radar}, "lifecycle": lifecycle, **said, "motion": motion}
    values = track(sky.reports, given, preset=preset, rng=rng).values
    assigned = np.full(sky.target.size, -1, dtype=np.int64)
    for row, own in values.assignment.items():
        assigned[row] = own
    figures = evaluate(sky.truth, values.tracks, cutoff=CUTOFF)
    quality = assignment_quality(sky.target, assigned)
    return Tracked(values.tracks, values.history, {
        "GOSPA [m]": float(figures.gospa or 0.0),
        "RMSE [m]": float(figures.rmse or np.nan),
        "switches": float(figures.switches or 0),
        "false tracks per scan": float(figures.false_per_time or 0.0),
        "missed per scan": float(figures.missed_per_time or 0.0),
        "classified rightly [%]": 100.0 * float(np.mean((assigned >= 0) == (sky.target >= 0))),
        "on the right track [%]": 100.0 * float(quality.right_share or 0.0),
    })  # fmt: skip


def tracking(rng: np.random.Generator, n_skies: int, tick: Tick) -> dict[str, Table]:
    """Return how well whole trackers follow, and how far off the courses they are."""
    rows: list[tuple[object, ...]] = []
    legs: list[tuple[object, ...]] = []
    head: tuple[str, ...] = ()
    for number, own in draws(rng, n_skies, tick):
        sky = draw_sky(SkyShape(), own)
        selected = _selected(sky, own)
        off = {
            PLOTS: {name: offsets_of_plots(sky, name) for name in (*STRAIGHT, TURNING)},
            SELECTED: _all_offsets(sky, selected.time, selected.place),
        }
        for tracker in TRACKERS:
            found = run_tracker(sky, tracker, own)
            off[tracker] = _all_offsets(sky, *_confirmed(found.tracks))
            if tracker == IMM:
                off[SMOOTHED] = _all_offsets(sky, *_confirmed(found.history))
            head = ("tracker", "draw", *found.measures)
            rows.append((tracker, number, *found.measures.values()))
        for what, offsets in off.items():
            legs += [(what, leg, number, *leg_of(offsets, leg).row()) for leg in LEGS]
    courses = frame(("what", "leg", "draw", *OFF), tuple(legs))
    return {"tracking": frame(head, rows), "courses": courses}


def by_noise(
    rng: np.random.Generator, noises: Sequence[float], n_skies: int, tick: Tick
) -> dict[str, Table]:
    """Return how far off the courses two trackers are, by the process noise that they assume."""
    rows: list[tuple[object, ...]] = []
    for number, own in draws(rng, n_skies, tick):
        sky = draw_sky(SkyShape(), own)
        for tracker in (PRESET, IMM):
            for noise in noises:
                found = run_tracker(sky, tracker, own, noise)
                off = _all_offsets(sky, *_confirmed(found.tracks))
                rows += [(tracker, noise, leg, number, *leg_of(off, leg).row()) for leg in LEGS]
    return {"noise": frame(("tracker", "noise [m²/s³]", "leg", "draw", *OFF), tuple(rows))}


def figures(rng: np.random.Generator, tick: Tick) -> dict[str, Table]:
    """Return what the document's figures plot, of one sky: each a table of points."""
    sky = draw_sky(SkyShape(), rng)
    selected = _selected(sky, rng)
    document, imm = (run_tracker(sky, name, rng) for name in (PRESET, IMM))
    names = [sky.reports.sensors[number] for number in sky.reports.sensor]
    plots = zip(
        sky.reports.time.tolist(), names, *sky.reports.measurement.T.tolist(),
        [str(name) or None for name in sky.reports.carried["target"]],
        [int(group) if group >= 0 else None for group in selected.group], strict=True,
    )  # fmt: skip
    lines = [
        ("truth", name, *row)
        for name in (*STRAIGHT, TURNING)
        for row in zip(sky.course(name)[0].tolist(), *sky.course(name)[1].T.tolist(), strict=True)
    ]
    tracks = document.tracks
    lines += [
        (
            "estimate",
            str(tracks.track[row]),
            float(tracks.time[row]),
            *tracks.mean[row, :2].tolist(),
        )
        for row in np.lexsort((tracks.time, tracks.track)).tolist()
        if tracks.status[row] >= CONFIRMED
    ]
    lines += [
        (SELECTED, None, when, *where.tolist())
        for when, where in zip(selected.time.tolist(), selected.place, strict=True)
    ]
    places = {
        SELECTED: _all_offsets(sky, selected.time, selected.place),
        "estimate": _all_offsets(sky, *_confirmed(document.tracks)),
        IMM: _all_offsets(sky, *_confirmed(imm.tracks)),
        PLOTS: {name: offsets_of_plots(sky, name) for name in (*STRAIGHT, TURNING)},
    }
    tick(1, 1)
    return {
        "figure3": frame(("time", "sensor", "x", "y", "target", "group"), tuple(plots)),
        "figure4": frame(("what", "name", "time", "x", "y"), tuple(lines)),
        "figure5": _off_course(places, STRAIGHT[0]),
        "figure6": _off_course(places, TURNING),
    }


def _off_course(places: Mapping[str, Mapping[str, Offsets]], name: str) -> Table:
    rows = [
        (what, *row)
        for what, by_name in places.items()
        for row in zip(by_name[name].time.tolist(), by_name[name].ahead.tolist(),
                       by_name[name].right.tolist(), strict=True)
    ]  # fmt: skip
    return frame(("what", "time", "ahead [m]", "to the right [m]"), tuple(rows))


def _selected(sky: RadarSky, rng: np.random.Generator) -> Sorted:
    """Return a sky's plots as the document's Ant System sorts them."""
    instants, solver = posed(sky, "equation-1"), METHODS[DOCUMENT][1]
    return sort_plots(sky, instants, [solver(problem, rng=rng) for problem in instants.problems])


def _confirmed(tracks: TrackTable) -> tuple[FloatArray, FloatArray]:
    """Return when and where confirmed tracks are."""
    believed = tracks.status >= CONFIRMED
    return tracks.time[believed], tracks.mean[believed, :2]


def _all_offsets(sky: RadarSky, time: FloatArray, place: FloatArray) -> dict[str, Offsets]:
    return {name: offsets_from(sky, name, time, place) for name in (*STRAIGHT, TURNING)}


def offsets_from(sky: RadarSky, name: str, time: FloatArray, place: FloatArray) -> Offsets:
    """Return how far the nearest place at each time lies off a course, if within the cutoff."""
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
    """Return how far each plot of an aircraft lies off its course."""
    own = np.asarray(sky.reports.carried["target"]) == name
    times, where, velocity = sky.course(name)
    moment = np.searchsorted(times, sky.reports.time[own] - 0.1 * PERIOD)
    apart = sky.reports.measurement[own] - where[moment]
    return _offsets(times[moment], apart, velocity[moment])


def _offsets(time: FloatArray, apart: FloatArray, velocity: FloatArray) -> Offsets:
    along = velocity / np.linalg.norm(velocity, axis=1, keepdims=True)
    aside = np.column_stack([along[:, 1], -along[:, 0]])
    return Offsets(time, np.sum(apart * along, axis=1), np.sum(apart * aside, axis=1))


def leg_of(offsets: Mapping[str, Offsets], leg: str) -> Offsets:
    """Return the offsets on one of the ``LEGS``; outside of the turn, to the left, is right."""
    if leg == LEGS[0]:
        parts = [offsets[name].within(offsets[name].time >= SETTLED_S) for name in STRAIGHT]
        return Offsets(*(
            np.concatenate([getattr(part, axis) for part in parts])
            for axis in ("time", "ahead", "right")
        ))  # fmt: skip
    own = offsets[TURNING]
    return own.within((own.time > TURN[0]) & (own.time <= TURN[1]))
