"""Aircraft that turn at 3 g: models of motion compared, in clutter and with misses.

Eight aircraft at 250 m/s fly straight for a while, turn at 3 g to one side or the other by 60° to
180°, and fly on, over a square of 40 km; a radar reports positions with σ = 50 m each 2 s, sees
nine of ten, and adds 30 false alarms to each scan.
"""

import argparse
import time
from typing import Any, NamedTuple

import numpy as np
import polars as pl
from text_tables import command, heading, table

from trackweave import TrackTable, TruthTable, evaluate, track

Array = np.ndarray[Any, Any]
SPEED, PULL, SIGMA, PERIOD, SCANS = 250.0, 3 * 9.81, 50.0, 2.0, 60
AIRCRAFT, FALSE_ALARMS, HALF = 8, 30, 20_000.0
CUTOFF = 250.0
SPEEDS = {"max_speed": 350.0}
TURN = {"process_noise": 4.0, "max_turn_rate": 0.2, "turn_noise": 1e-4}
MOTIONS: dict[str, dict[str, Any]] = {
    "constant velocity, 1 m²/s³": {"process_noise": 1.0},
    "constant velocity, 30 m²/s³": {"process_noise": 30.0},
    "constant velocity, 300 m²/s³": {"process_noise": 300.0},
    "constant velocity, estimated": {},
    "constant acceleration": {
        "model": "constant-acceleration", "process_noise": 30.0, "max_acceleration": 40.0,
    },
    "coordinated turn": {"model": "coordinated-turn", **TURN, "turn_noise": 5e-4},
    "IMM: velocity, turn": {
        "model": "imm",
        "imm": {
            "models": ["constant-velocity", "coordinated-turn"], "sojourn_time": [40.0, 12.0],
            "constant-velocity": {"process_noise": 1.0}, "coordinated-turn": TURN,
        },
    },
    "IMM: velocity, acceleration": {
        "model": "imm",
        "imm": {
            "models": ["constant-velocity", "constant-acceleration"],
            "sojourn_time": [40.0, 12.0],
            "constant-velocity": {"process_noise": 1.0},
            "constant-acceleration": {"process_noise": 60.0, "max_acceleration": 40.0},
        },
    },
    "IMM: quiet and rough velocity": {
        "model": "imm",
        "imm": {
            "models": ["quiet", "rough"], "sojourn_time": [40.0, 12.0],
            "quiet": {"model": "constant-velocity", "process_noise": 1.0},
            "rough": {"model": "constant-velocity", "process_noise": 600.0},
        },
    },
}  # fmt: skip


class Scene(NamedTuple):
    """True positions, shape (scans, aircraft, 2), whether each turns, and the reports."""

    time: Array
    place: Array
    turning: Array
    reports: pl.DataFrame


def scene_of(seed: int) -> Scene:
    rng = np.random.default_rng(seed)
    time_ = PERIOD * np.arange(SCANS)
    fine = 20
    step = PERIOD / fine
    place = np.empty((SCANS, AIRCRAFT, 2))
    turning = np.zeros((SCANS, AIRCRAFT), dtype=bool)
    for aircraft in range(AIRCRAFT):
        course = rng.uniform(0, 2 * np.pi)
        middle = rng.uniform(-HALF / 3, HALF / 3, 2)
        begins = rng.uniform(30.0, 70.0)
        lasts = rng.uniform(np.pi / 3, np.pi) * SPEED / PULL
        rate = rng.choice([-1.0, 1.0]) * PULL / SPEED
        here = middle - begins * SPEED * np.array([np.sin(course), np.cos(course)])
        for scan in range(SCANS):
            place[scan, aircraft] = here
            for part in range(fine):
                now = time_[scan] + part * step
                turns = begins <= now < begins + lasts
                turning[scan, aircraft] |= turns
                course += rate * step * turns
                here = here + step * SPEED * np.array([np.sin(course), np.cos(course)])
    seen = rng.random(place.shape[:2]) < 0.9
    rows = []
    for scan in range(SCANS):
        noisy = place[scan, seen[scan]] + rng.normal(0, SIGMA, (seen[scan].sum(), 2))
        false = rng.uniform(-HALF, HALF, (rng.poisson(FALSE_ALARMS), 2))
        rows += [(time_[scan], x, y) for x, y in np.concatenate([noisy, false])]
    reports = pl.DataFrame(rows, schema=["time", "x", "y"], orient="row")
    return Scene(time_, place, turning, reports)


def measured(scene: Scene, motion: dict[str, Any], seed: int) -> dict[str, Any]:
    """Return the measures of a run: errors of tracks as they were known, and smoothed."""
    config = {
        "motion": {**motion, **SPEEDS},
        "sensors": {
            "default": {
                "sigma": SIGMA, "detection_probability": 0.9, "scan_period": PERIOD,
                "clutter_density": FALSE_ALARMS / (2 * HALF) ** 2,
            }
        },
    }  # fmt: skip
    cpu = time.process_time()
    result = track(scene.reports, config, rng=np.random.default_rng(seed))
    cpu = time.process_time() - cpu
    values = result.values
    truth = TruthTable(
        time=np.repeat(scene.time, AIRCRAFT),
        target=np.tile([str(k) for k in range(AIRCRAFT)], SCANS).astype(object),
        position=scene.place.reshape(-1, 2),
    )
    judged = evaluate(truth, values.tracks, cutoff=CUTOFF)
    straight, turning, lost = errors(scene, values.tracks)
    late_straight, late_turning, _ = errors(scene, values.history)
    return {
        "straight": straight, "turning": turning, "lost": lost,
        "late_straight": late_straight, "late_turning": late_turning,
        "gospa": float(judged.gospa), "switches": float(judged.switches),
        "cpu": cpu / SCANS * 1e3,
    }  # fmt: skip


def errors(scene: Scene, tracks: TrackTable) -> tuple[Array, Array, float]:
    """Return the nearest believed track's errors, straight and turning, and the share without."""
    straight, turning, lost = [], [], 0
    believed = tracks.status >= 1
    for scan, now in enumerate(scene.time):
        rows = believed & (np.abs(tracks.time - now) < 1e-6)
        if scan < 6:
            continue
        for aircraft in range(AIRCRAFT):
            apart = tracks.mean[rows, :2] - scene.place[scan, aircraft]
            nearest = np.min(np.linalg.norm(apart, axis=1), initial=np.inf)
            if nearest > CUTOFF:
                lost += 1
            else:
                (turning if scene.turning[scan, aircraft] else straight).append(nearest)
    return np.array(straight), np.array(turning), lost / ((SCANS - 6) * AIRCRAFT)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeats", type=int, default=5, help="scenes, by seed")
    arguments = parser.parse_args()
    scenes = [scene_of(seed) for seed in range(1, arguments.repeats + 1)]
    rows = []
    for name, motion in MOTIONS.items():
        measured(scenes[0], motion, 0)  # compiles
        runs = [measured(scene, motion, seed) for seed, scene in enumerate(scenes)]
        together = {
            key: np.sqrt(np.mean(np.concatenate([run[key] for run in runs]) ** 2))
            for key in ("straight", "turning", "late_straight", "late_turning")
        }
        mean = {key: np.mean([run[key] for run in runs]) for key in runs[0] if key not in together}
        rows.append(
            [name, together["straight"], together["turning"], together["late_straight"],
             together["late_turning"], f"{mean['lost']:.1%}".replace("%", " %"), mean["switches"],
             mean["gospa"], mean["cpu"]]
        )  # fmt: skip
    print(heading(command("manoeuvres.py")), end="\n\n")
    print(
        table(
            ["motion", "RMSE straight m", "turning", "history, straight", "turning", "lost",
             "switches", "GOSPA", "CPU ms/scan"],
            rows,
        )
    )  # fmt: skip


if __name__ == "__main__":
    main()
