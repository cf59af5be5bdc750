"""Our own tracker on a scene of the bench, through the public interface."""

import math
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl
from bench_data import Bench, Scene

from trackweave import TrackingResult, track

CONFIGURATION = Path(__file__).with_name("bench.toml")
KEYS = ("gospa", "switches", "missed_per_scan", "false_per_scan", "rmse")


def configuration_for(scene: Scene, path: Path, changes: Mapping[str, Any]) -> dict[str, Any]:
    """Return the file's content with the scene's clutter density and some tables' keys changed."""
    values = tomllib.loads(path.read_text(encoding="utf-8"))
    values["sensors"]["default"]["clutter_density"] = scene.meta["clutter_density"]
    for name, keys in changes.items():
        values.setdefault(name, {}).update(keys)
    return values


def tracked(
    scene: Scene, path: Path, *, priors: bool, changes: Mapping[str, Any] | None = None
) -> TrackingResult:
    """Track a scene; the truth behind its reports is hidden."""
    return track(
        reports_of(scene),
        configuration_for(scene, path, changes or {}),
        priors=priors_of(scene) if priors else None,
        rng=np.random.default_rng(scene.seed),
    )


def warm_up(bench: Bench, path: Path) -> None:
    """Compile everything that scenes may need: crowded ones leave gaps that the search closes."""
    for targets in (20, 100):
        tracked(bench.scene(targets, 1, 1), path, priors=True)


def measured(
    bench: Bench, scene: Scene, path: Path, *, priors: bool,
    changes: Mapping[str, Any] | None = None,
) -> dict[str, Any]:  # fmt: skip
    """Return the judge's measures of a run, and the CPU time of each instant [ms]."""
    result = tracked(scene, path, priors=priors, changes=changes)
    judged = bench.score(scene, rows_of(result))
    totals = result.run["totals"]
    return {
        **{key: float(judged[key]) for key in KEYS},
        "cpu": cpu_by_instant(result, scene.sensors),
        "proven": totals["proven_scans"] / totals["scans"],
        "among_kept": totals["scans_optimal_among_kept"] / totals["scans"],
        "worst_gap": totals["worst_gap"],
    }


def rows_of(result: TrackingResult) -> list[tuple[int, int, float, float]]:
    """Return the confirmed and coasting rows as the judge takes them: scan, track, x, y."""
    known = result.tracks.filter(pl.col("status") != "tentative")
    return [
        (round(time), int(name), x, y)
        for time, name, x, y in known.select("time", "track", "x", "y").iter_rows()
    ]


def reports_of(scene: Scene) -> pl.DataFrame:
    """Return a scene's reports without their origin."""
    names = ("time", "sensor", "x", "y")
    columns = {name: scene.detections[name] for name in names}
    return pl.DataFrame(columns).with_columns(pl.col("sensor").cast(pl.Int64))


def priors_of(scene: Scene) -> pl.DataFrame:
    """Return the noisy first states as a tracks table."""
    known, zero = scene.priors, np.zeros(len(scene.priors))
    columns = {"time": zero, "track": known["target"].astype(int) + 1}
    axes = ("x", "y", "vx", "vy")
    columns.update({axis: known[axis] for axis in axes})
    for place, first in enumerate(axes):
        for second in axes[place:]:
            columns[f"p_{first}_{second}"] = known[f"p_{first}"] if first == second else zero
    return pl.DataFrame(columns)


def cpu_by_instant(result: TrackingResult, n_sensors: int) -> np.ndarray[Any, np.dtype[Any]]:
    """Return the CPU time of each instant, over all its sensors [ms]."""
    times = np.array([scan["cpu_ms"] for scan in result.run["timing"]["scans"]])
    return times.reshape(-1, n_sensors).sum(axis=1)


def told(scene: Scene) -> list[tuple[int, int, float, float]]:
    """Return the rows of a Kalman filter that sets out from the priors and is told the truth."""
    noise, process = scene.meta["sigma"] ** 2, scene.meta["q"]
    step = np.array([[1.0, 1.0], [0.0, 1.0]])
    drift = process * np.array([[1 / 3, 1 / 2], [1 / 2, 1.0]])
    known, n_targets = scene.priors, len(scene.priors)
    # Axes do not mix, so each target has two filters of position and speed.
    mean = np.stack(
        [np.column_stack([known[a], known[f"v{a}"]]) for a in ("x", "y")], axis=1
    )  # targets × axes × (position, speed)
    spread = np.zeros((n_targets, 2, 2))
    spread[:, 0, 0], spread[:, 1, 1] = known["p_x"], known["p_vx"]
    rows = []
    for scan in range(scene.n_scans):
        if scan:
            mean = mean @ step.T
            spread = step @ spread @ step.T + drift
        now = scene.detections[scene.detections["scan"] == scan]
        for report in now[now["origin"] >= 0]:
            target = int(report["origin"])
            gain = spread[target][:, 0] / (spread[target][0, 0] + noise)
            for axis, name in enumerate(("x", "y")):
                mean[target, axis] += gain * (report[name] - mean[target, axis, 0])
            spread[target] -= np.outer(gain, spread[target][0])
        rows += [(scan, k, mean[k, 0, 0], mean[k, 1, 0]) for k in range(n_targets)]
    return rows


def mean_of(results: list[dict[str, Any]], key: str) -> float:
    """Return the mean of a measure over runs."""
    return math.fsum(float(result[key]) for result in results) / len(results)
