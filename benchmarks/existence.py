"""Whether it is still there: four objects meet, and one of them ends where all are close.

Four objects of nearly constant velocity (0.01 m²/s³) come together in the middle of a square of
300 m, within a metre of one another at half of 81 s, and one of them ends there. A sensor reports
positions each second, σ = 1 m, P_D = 0.9, with ten false alarms a scan; the tracker is told all of
it, and that one object in a hundred ends each second. GOSPA with a cutoff of 10 m, its order 2.
"""

import argparse
import math
import time
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import polars as pl
from scipy.optimize import linear_sum_assignment
from text_tables import command, heading, table

from trackweave import track

Array = np.ndarray[Any, Any]
SIDE, SIGMA, DETECTED, FALSE_ALARMS, NOISE = 300.0, 1.0, 0.9, 10, 0.01
SCANS, OBJECTS, SURVIVAL = 81, 4, 0.99
DEATH = SCANS // 2  # The first scan that the first object does not live to see
CUTOFF = 10.0
STEP = np.kron(np.array([[1.0, 1.0], [0.0, 1.0]]), np.eye(2))  # x, y, vx, vy, over a second
SPREAD = NOISE * np.kron(np.array([[1 / 3, 1 / 2], [1 / 2, 1.0]]), np.eye(2))


class Scene(NamedTuple):
    """True positions, shape (scans, objects, 2), and the reports; ``origin`` is -1 for nobody.

    The first object's go on after its end.
    """

    place: Array
    reports: pl.DataFrame
    origin: Array

    def living(self, scan: int) -> Array:
        """Return the positions of the objects that there are at a scan."""
        return self.place[scan, int(scan >= DEATH) :]


def scene_of(seed: int) -> Scene:
    """Return the scene of a seed: tracks drawn from the meeting on, forwards and backwards."""
    rng = np.random.default_rng(seed)
    state = np.empty((SCANS, OBJECTS, 4))
    middle = np.array([SIDE / 2, SIDE / 2, 0.0, 0.0])
    state[DEATH] = rng.multivariate_normal(middle, 0.1 * np.eye(4), OBJECTS)
    for scan in range(DEATH + 1, SCANS):
        wander = rng.multivariate_normal(np.zeros(4), SPREAD, OBJECTS)
        state[scan] = state[scan - 1] @ STEP.T + wander
    for scan in range(DEATH - 1, -1, -1):
        wander = rng.multivariate_normal(np.zeros(4), SPREAD, OBJECTS)
        state[scan] = (state[scan + 1] - wander) @ np.linalg.inv(STEP).T
    rows: list[tuple[float, float, float, int]] = []
    for scan in range(SCANS):
        for number in range(int(scan >= DEATH), OBJECTS):
            x, y = state[scan, number, :2] + rng.normal(0.0, SIGMA, 2)
            if rng.random() < DETECTED:
                rows.append((float(scan), x, y, number))
        alarms = rng.uniform(0.0, SIDE, (rng.poisson(FALSE_ALARMS), 2))
        rows += [(float(scan), x, y, -1) for x, y in alarms.tolist()]
    columns = np.array(rows)
    reports = pl.DataFrame(columns[:, :3], schema=["time", "x", "y"], orient="row")
    return Scene(state[:, :, :2], reports, columns[:, 3].astype(int))


def told(**lifecycle: Any) -> dict[str, Any]:
    """Return the configuration that tells all of the scene, and more of the lifecycle."""
    corners = [[0.0, 0.0], [SIDE, 0.0], [SIDE, SIDE], [0.0, SIDE]]
    return {
        "motion": {"process_noise": NOISE, "max_speed": 3.0},
        "sensors": {
            "default": {
                "sigma": SIGMA, "detection_probability": DETECTED, "scan_period": 1.0,
                "clutter_density": FALSE_ALARMS / SIDE**2, "field_of_view": {"polygon": corners},
            },
        },
        "lifecycle": {
            "survival": SURVIVAL,
            "initial_target_density": OBJECTS / SIDE**2,
            "new_target_density": 0.005 / SIDE**2,
            **lifecycle,
        },
    }  # fmt: skip


class Judged(NamedTuple):
    """Squared parts of GOSPA [m²] of each scan, and of the false rows how many are of what."""

    localisation: Array
    missed: Array
    false: Array
    ended: int
    doubled: int
    nobody: int


def judged(scene: Scene, rows: Sequence[Array]) -> Judged:
    """Compare the positions shown at each scan with the truth."""
    parts = np.zeros((SCANS, 3))
    ended = doubled = nobody = 0
    for scan, shown in enumerate(rows):
        living = scene.living(scan)
        apart = np.linalg.norm(living[:, None] - shown[None], axis=2)
        target, column = linear_sum_assignment(np.minimum(apart, CUTOFF) ** 2)
        near = apart[target, column] < CUTOFF
        parts[scan, 0] = np.sum(apart[target, column][near] ** 2)
        parts[scan, 1:] = CUTOFF**2 / 2 * (np.array(apart.shape) - near.sum())
        for row in np.setdiff1d(np.arange(len(shown)), column[near]):
            gone = np.linalg.norm(scene.place[scan, 0] - shown[row]) < CUTOFF
            if scan >= DEATH and gone:
                ended += 1
            elif len(living) and apart[:, row].min() < CUTOFF:
                doubled += 1
            else:
                nobody += 1
    return Judged(parts[:, 0], parts[:, 1], parts[:, 2], ended, doubled, nobody)


def shown_by(tracks: pl.DataFrame, *, tentative: bool) -> list[Array]:
    """Return what rows show at each scan, with tentative ones or without."""
    rows = tracks if tentative else tracks.filter(pl.col("status") != "tentative")
    return [
        rows.filter(pl.col("time") == float(scan)).select("x", "y").to_numpy()
        for scan in range(SCANS)
    ]


def shown_by_origin(scene: Scene) -> list[Array]:
    """Return what could be shown where somebody told of whom each report is.

    A Kalman filter for each object, from its first report on, shown while it more probably lives
    than not.
    """
    shown: list[list[Array]] = [[] for _ in range(SCANS)]
    look, noise = np.eye(2, 4), SIGMA**2 * np.eye(2)
    when = scene.reports["time"].to_numpy()
    seen = scene.reports.select("x", "y").to_numpy()
    for number in range(OBJECTS):
        mean, spread, lives = np.zeros(4), np.zeros((4, 4)), 0.0
        for scan in range(SCANS):
            lives *= SURVIVAL
            mean, spread = STEP @ mean, STEP @ spread @ STEP.T + SPREAD
            own = seen[(when == scan) & (scene.origin == number)]
            if not len(own):
                lives *= (1.0 - DETECTED) / (1.0 - DETECTED * lives)
            elif lives == 0.0:
                mean, spread = np.array([*own[0], 0.0, 0.0]), np.eye(4)
                lives = 1.0
            else:
                gain = spread @ look.T @ np.linalg.inv(look @ spread @ look.T + noise)
                mean, lives = mean + gain @ (own[0] - look @ mean), 1.0
                spread = spread - gain @ look @ spread
            if lives >= 0.5:
                shown[scan].append(mean[:2])
    return [np.array(places).reshape(-1, 2) for places in shown]


def row_by_number(scenes: Sequence[Scene]) -> list[Any]:
    """Return the row of who is told which reports are of objects, but not of which.

    From the first scan to the last he knows how probably there are how many, beginning with all,
    and shows the mean, rounded: what is left where objects cannot be told apart.
    """
    numbers = range(OBJECTS + 1)
    lives = np.array([[_binomial(n, of, SURVIVAL) for of in numbers] for n in numbers])
    extra, lacking = [], []
    for scene in scenes:
        chance = np.eye(OBJECTS + 1)[OBJECTS]
        when = scene.reports["time"].to_numpy()[scene.origin >= 0]
        for scan in range(SCANS):
            seen = int(np.count_nonzero(when == scan))
            chance = (lives @ chance) * [_binomial(seen, of, DETECTED) for of in numbers]
            chance /= chance.sum()
            off = math.floor(chance @ np.arange(OBJECTS + 1) + 0.5) - len(scene.living(scan))
            extra.append(max(0, off))
            lacking.append(max(0, -off))
    missed, false = (float(CUTOFF * np.sqrt(np.mean(each) / 2)) for each in (lacking, extra))
    ended = sum(extra) / len(scenes)
    return ["told which reports are of objects", None, None, missed, false, ended, None, None]


def _binomial(count: int, of: int, probability: float) -> float:
    return math.comb(of, count) * probability**count * (1 - probability) ** max(0, of - count)


def row_of(name: str, runs: Sequence[Judged], cpu: float | None) -> list[Any]:
    """Return a row: RMS over scans and runs of each part, and false rows of a run by cause."""
    parts = np.array([run[:3] for run in runs])
    by_part = np.sqrt(parts.mean(axis=(0, 2)))
    ended, *others = np.mean([run[3:] for run in runs], axis=0).tolist()
    whole = float(np.sqrt(parts.sum(axis=1).mean()))
    return [name, whole, *by_part.tolist(), ended, sum(others), cpu]


HEAD = [
    "", "GOSPA m", "localisation", "missed", "false", "false rows a run near the one that ended",
    "others", "CPU s",
]  # fmt: skip
WAYS: Mapping[str, Mapping[str, Any]] = {
    "told all": {},
    "`certain_probability = 0.95`": {"certain_probability": 0.95},
    "`survival = 0.9`": {"survival": 0.9},
}


def rows_for(seeds: Sequence[int]) -> list[list[Any]]:
    """Return the table's rows."""
    scenes = [scene_of(seed) for seed in seeds]
    best = [judged(scene, shown_by_origin(scene)) for scene in scenes]
    rows = [row_of("told of whom each report is", best, None), row_by_number(scenes)]
    for name, keys in WAYS.items():
        begin = time.process_time()
        found = [
            track(scene.reports, told(**keys), rng=seed).tracks
            for seed, scene in zip(seeds, scenes, strict=True)
        ]
        cpu = (time.process_time() - begin) / len(seeds)
        shown = {name: False} if keys else {name: False, f"{name}, tentative rows too": True}
        for words, tentative in shown.items():
            runs = [
                judged(scene, shown_by(tracks, tentative=tentative))
                for scene, tracks in zip(scenes, found, strict=True)
            ]
            rows.append(row_of(words, runs, cpu))
    return rows


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--first", type=int, default=1001, help="first seed")
    parser.add_argument("--seeds", type=int, default=60)
    arguments = parser.parse_args()
    track(scene_of(0).reports, told())  # compiles
    rows = rows_for(range(arguments.first, arguments.first + arguments.seeds))
    print(heading(command("existence.py")), end="\n\n")
    print(table(HEAD, rows))


if __name__ == "__main__":
    main()
