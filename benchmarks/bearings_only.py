"""Angles of four passive sensors to tracks, beside a filter that is told whose each bearing is.

Twenty objects (or as many as asked for) move through a square of 10 km; four sensors on a circle
around it report bearings each second. The filter that is told the truth is the same extended
Kalman filter, begun where the first bearings of its object cross. Both are judged at the same
seconds, from the tenth on; an object is tracked while a track that is not tentative lies within
300 m of it, and a track without an object is false.
"""

import argparse
from collections.abc import Sequence
from typing import Any

import numpy as np
from simulated import judged, tracked
from simulated_scenes import Scene, bearings
from text_tables import command, heading, table

Array = np.ndarray[Any, np.dtype[Any]]
FIRST, SECONDS, CUTOFF = 10.0, 60.0, 300.0
CASES = {
    "5 objects, 2 mrad": (5, 2e-3),
    "10 objects, 2 mrad": (10, 2e-3),
    "20 objects, 2 mrad": (20, 2e-3),
    "20 objects, 3.5 mrad": (20, 3.5e-3),
}
HEAD = [
    "", "seeds", "tracked", "RMSE m", "told the truth m", "ratio", "within 15 %",
    "false at a time", "false tracks", "switches", "CPU ms/s",
]  # fmt: skip


def wrapped(angle: Array | float) -> Any:
    """Return angles between -π and π."""
    return (np.asarray(angle) + np.pi) % (2 * np.pi) - np.pi


def begun(place: Array, bearing: Array, sigma: float) -> tuple[Array, Array]:
    """Return where bearings cross, by least squares, and the covariance."""
    point = np.full(2, 5e3)
    for _ in range(50):
        apart = point - place
        slope = np.stack([apart[:, 1], -apart[:, 0]], axis=1) / np.sum(apart**2, axis=1)[:, None]
        off = wrapped(bearing - np.arctan2(apart[:, 0], apart[:, 1]))
        point = point + np.linalg.lstsq(slope, off, rcond=None)[0]
    return point, np.linalg.inv(slope.T @ slope) * sigma**2


def told(scene: Scene, target: int) -> dict[float, Array]:
    """Return where the filter that is told an object's bearings has it at each second."""
    rows = np.flatnonzero(scene.origin == target)
    time = scene.reports["time"].to_numpy()[rows]
    bearing = np.radians(scene.reports["bearing_deg"].to_numpy())[rows]
    place = scene.reports.select("sensor_x", "sensor_y").to_numpy()[rows]
    sigma = np.radians(scene.config["sensors"]["default"]["sigma"]["bearing_deg"])
    noise, speed = (scene.config["motion"][key] for key in ("process_noise", "max_speed"))
    known: dict[float, Array] = {}
    mean, spread, last = np.empty(0), np.empty(0), 0.0
    for now in np.unique(time):
        here = time == now
        if not mean.size:
            if here.sum() < 2:
                continue
            point, own = begun(place[here], bearing[here], sigma)
            mean, spread = np.concatenate([point, np.zeros(2)]), np.zeros((4, 4))
            spread[:2, :2], spread[2:, 2:] = own, np.eye(2) * speed**2 / 4
        else:
            step, eye = now - last, np.eye(2)
            ahead = np.kron([[1.0, step], [0.0, 1.0]], eye)
            drift = np.kron([[step**3 / 3, step**2 / 2], [step**2 / 2, step]], eye)
            mean, spread = ahead @ mean, ahead @ spread @ ahead.T + noise * drift
            for at, angle in zip(place[here], bearing[here], strict=True):
                apart = mean[:2] - at
                slope = np.array([apart[1], -apart[0], 0.0, 0.0]) / (apart @ apart)
                gain = spread @ slope / (slope @ spread @ slope + sigma**2)
                mean = mean + gain * wrapped(angle - np.arctan2(apart[0], apart[1]))
                spread = spread - np.outer(gain, slope @ spread)
        last = float(now)
        known[last] = mean[:2].copy()
    return known


def told_rmse(scene: Scene) -> float:
    """Return the root mean square error of the filter that is told the truth [m]."""
    squares = [
        float(np.sum((point - scene.at(second)[target]) ** 2))
        for target in range(len(scene.start))
        for second, point in told(scene, target).items()
        if second >= FIRST
    ]
    return float(np.sqrt(np.mean(squares)))


def row(name: str, case: tuple[int, float], seeds: Sequence[int]) -> list[Any]:
    """Return the figures of a case, means over seeds."""
    found, exact = [], []
    for place, seed in enumerate([seeds[0], *seeds]):
        scene = bearings(seed, targets=case[0], sigma=case[1])
        result, cpu = tracked(scene, seed)
        if place:  # the first run compiles
            found.append(judged(scene, result, cpu, (FIRST, SECONDS), CUTOFF))
            exact.append(told_rmse(scene))
    tracked_, false, switches, rmse, names, cpu = np.mean(np.array(found), axis=0).tolist()
    ratios = [one.rmse / other for one, other in zip(found, exact, strict=True)]
    near = f"{sum(ratio <= 1.15 for ratio in ratios)} of {len(ratios)}"
    return [
        name, len(seeds), f"{100 * tracked_:.1f} %", rmse, float(np.mean(exact)),
        float(np.median(ratios)), near, false, names - case[0], switches,
        cpu / SECONDS * 1e3,
    ]  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeats", type=int, default=8, help="scenes, by seed")
    parser.add_argument("--cases", nargs="+", choices=CASES, default=list(CASES))
    arguments = parser.parse_args()
    seeds = range(1, arguments.repeats + 1)
    print(heading(command("bearings_only.py")), end="\n\n")
    rows = [row(name, CASES[name], seeds) for name in arguments.cases]
    print(table(HEAD, rows))


if __name__ == "__main__":
    main()
