"""Trackers of every kind in the middle of their work, and the shapes that a checkpoint gives them.

As a program it writes the shapes anew, for whoever has changed what a tracker holds:
``PYTHONPATH=tests python -m oracles.checkpoints``.
"""

import hashlib
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import trackweave as tw
from oracles.boxes import box
from oracles.plugins import Place, Straight
from oracles.scenes import MOTION, scan, scene, sensor
from trackweave.domain.tracks import CONFIRMED
from trackweave.trackers.checkpoint import LAYOUT, pack
from trackweave.trackers.packing import _Packer

SHAPES = Path(__file__).with_name("checkpoint_shapes.txt")
CLASSES = (Place, Straight)
NAMES = ("a", "b")
TURN = tw.Rotation(period=4.0, phase=0.3, direction=1)
RADARS = {"a": (-3000.0, 0.0), "b": (500.0, 4000.0)}


class Case(NamedTuple):
    """A tracker before its first step, and its steps."""

    tracker: Any
    steps: list[Any]


def advance(tracker: Any, step: Any) -> str:
    """Let a tracker take a step and return a digest of all that it says."""
    if isinstance(tracker, tw.BoxTracker):
        frame = tracker.update(**step)
        said = (frame.number, frame.time, frame.identifiers, frame.tracks)
        return hashlib.sha256(repr(said).encode()).hexdigest()
    hypothesis = tracker.step(step, rng=7)
    return hashlib.sha256(pack(hypothesis, CLASSES)).hexdigest()


def of_scans(steps: list[Any], *sensors: tw.Sensor, **options: Any) -> Case:
    given = {"motion": MOTION, "sensors": sensors or (sensor(),), "window": 3}
    return Case(tw.MultiHypothesisTracker(**(given | options)), steps)


def two_halves() -> Case:
    """Two sensors that see different places; scans that come late, and one in two parts."""
    views = [tw.FieldOfView(azimuth_deg=span) for span in ((0.0, 45.0), (45.0, 90.0))]
    both = [sensor(name, field_of_view=view) for name, view in zip(NAMES, views, strict=True)]
    scans = scene(5, objects=5, times=range(9), names=NAMES)
    scans[7], scans[8] = scans[8], scans[7]
    whole = scans.pop(13)
    parts = [
        scan(whole.time, whole.measurement[part], whole.sensor, whole.report[part])
        for part in (slice(0, 2), slice(2, None))
    ]
    return of_scans([*scans[:13], *parts, *scans[13:]], *both)


def turning() -> Case:
    """Turning radars of range and azimuth, one of which moves and turns otherwise than told."""
    rng = np.random.default_rng(5)
    place, speed = rng.uniform(-2000, 2000, (5, 2)), rng.normal(0, 12, (5, 2))
    told = [TURN, tw.Rotation(period=3.9, phase=0.3, direction=1)]
    radars = [
        tw.Sensor(
            name, sigma=(15.0, 0.004), measurement=tw.MeasurementKind.RANGE_AZIMUTH,
            clutter_density=1e-5, scan_period=4.0, rotation=turn, position=RADARS[name],
            field_of_view=tw.FieldOfView(position=RADARS[name], max_range=7000.0),
        )
        for name, turn in zip(NAMES, told, strict=True)
    ]  # fmt: skip
    steps = []
    for time in np.arange(0.0, 40.0, 4.0).tolist():
        place = place + 4.0 * speed
        for name, stands in RADARS.items():
            at = np.array(stands) + (time * 8.0 if name == "b" else 0.0)
            seen = place[rng.random(len(place)) < 0.95] - at
            azimuth = np.arctan2(*seen.T) % (2 * np.pi)
            turned = (azimuth - TURN.phase) % (2 * np.pi) / (2 * np.pi)
            moments = TURN.when(np.ceil(TURN.turned(time)) + turned)
            measured = np.stack([np.hypot(*seen.T), azimuth], axis=1)
            platform = np.r_[at, np.zeros(4)] if name == "b" else None
            end = float(moments.max() + 0.01)
            steps.append(tw.Scan(end, name, measured, moments=moments, platform=platform))
    return of_scans(steps, *radars)


def bearings() -> Case:
    rng = np.random.default_rng(3)
    place, speed = rng.uniform(1e3, 9e3, (4, 2)), rng.uniform(-20.0, 20.0, (4, 2))
    eyes = {f"eye {n}": at for n, at in enumerate(((5e3, 14e3), (14e3, 5e3), (5e3, -4e3)))}
    sensors = [
        tw.Sensor(
            name, measurement=tw.MeasurementKind.BEARING, sigma=0.002, scan_period=1.0,
            clutter_density=1.0, position=at,
        )
        for name, at in eyes.items()
    ]  # fmt: skip
    steps = []
    for time in range(6):
        for name, at in eyes.items():
            apart = place + time * speed - at
            bearing = np.arctan2(*apart.T) + rng.normal(0.0, 0.002, 4)
            steps.append(tw.Scan(float(time), name, bearing[:, None] % (2 * np.pi)))
    return of_scans(steps, *sensors, motion=tw.ConstantVelocity(0.1, max_speed=40.0))


def known_and_jumping() -> Case:
    """Tracks known beforehand; identities and strengths; stamps that cannot be right."""
    table = tw.TrackTable(
        np.zeros(2), np.array([7, 9]), np.full(2, CONFIRMED), np.full((2, 4), 300.0),
        np.tile(np.eye(4) * 900.0, (2, 1, 1)), np.zeros(2), np.ones(2, dtype=np.int64),
        np.zeros(2),
    )  # fmt: skip
    loud = tw.StrengthModel(
        target_mean=12.0, target_sigma=2.0, clutter_mean=3.0, clutter_sigma=2.0
    )
    steps = []
    for each in scene(4, times=range(14)):
        strength = 3.0 + each.report % 10
        identity = np.where(each.report % 3, -1, each.report % 5)
        stray = 86400.0 if 5 <= each.time < 7 else 0.0
        steps.append(replace(each, time=each.time + stray, strength=strength, identity=identity))
    return of_scans(steps, sensor(strength=loud), priors=table, estimate="best")


def fused() -> Case:
    rule = tw.PlotsRule(object_density=1e-6, negative_only=True, lone_plots=True)
    fuser = tw.PlotFuser([sensor(name) for name in NAMES], rule, motion=MOTION)
    inside = tw.MultiHypothesisTracker(motion=MOTION, sensors=fuser.fused_sensors(1.0), window=3)
    scans = scene(5, objects=4, times=range(8), names=NAMES)
    steps = [scans[k : k + 2] for k in range(0, len(scans), 2)]
    return Case(tw.FusedPlotsTracker(fuser, inside), steps)


def boxes() -> Case:
    rng = np.random.default_rng(2)
    steps = []
    for k in range(12):
        places = [box(2.0 * k), box(200.0 - 3.0 * k, 9.0), box(40.0, 80.0)][: 2 + k % 2]
        shift = rng.normal(0, 0.3, (len(places), 4))
        kinds, data = ["car", "van", "car"][: len(places)], [(k, n) for n in range(len(places))]
        camera = [[1.0, 0.0, 0.1 * k], [0.0, 1.0, 0.0]]
        frame = {"boxes": np.array(places) + shift, "scores": rng.uniform(0.5, 1, len(places))}
        steps.append({**frame, "classes": kinds, "data": data, "camera": camera})
    return Case(tw.BoxTracker(window=3, delay=1), steps)


def imm() -> tw.Imm:
    return tw.Imm([MOTION, tw.CoordinatedTurn(0.1, 1e-3, 30.0, 0.5)], (60.0, 20.0))


CASES: dict[str, Callable[[], Case]] = {
    "exact": lambda: of_scans(scene(1), search=tw.Exact()),
    "genetic": lambda: of_scans(scene(2), search=tw.Genetic(), motion=tw.RandomWalk(1.0, 30.0)),
    "islands": lambda: of_scans(scene(3, times=range(6)), search=tw.Islands()),
    "two halves": two_halves,
    "turning": turning,
    "bearings": bearings,
    "known and jumping": known_and_jumping,
    "modes": lambda: of_scans(scene(6), motion=imm(), unscented=True),
    "space": lambda: of_scans(
        scene(7, dim=3), motion=tw.ConstantAcceleration(0.1, 30.0, 5.0), dim=3
    ),
    "models of others": lambda: of_scans(
        scene(8), sensor(measurement=Place()), motion=Straight(0.05, 30.0)
    ),
    "nearest": lambda: Case(
        tw.NearestNeighbourTracker(motion=MOTION, sensors=[sensor(name) for name in NAMES]),
        scene(9, names=NAMES),
    ),
    "fused": fused,
    "boxes": boxes,
}


def shapes() -> dict[str, set[tuple[str, ...]]]:
    """Return under which classes and names a checkpoint holds what."""
    found: dict[str, set[tuple[str, ...]]] = {}
    for make in CASES.values():
        case = make()
        for step in case.steps:
            advance(case.tracker, step)
            packer = _Packer(CLASSES)
            packer.put(case.tracker)
            for shape in packer._shapes:
                if shape.kind not in CLASSES:
                    name = f"{shape.kind.__module__}.{shape.kind.__qualname__}"
                    found.setdefault(name, set()).add(tuple(sorted(shape.names)))
    return found


def told(found: dict[str, set[tuple[str, ...]]]) -> str:
    lines = [f"{name}: {' '.join(names)}" for name in found for names in found[name]]
    return "\n".join([f"layout {LAYOUT}", *sorted(lines)]) + "\n"


if __name__ == "__main__":
    SHAPES.write_text(told(shapes()))
    sys.stdout.write(f"{SHAPES}\n")
