"""Real aircraft, identities hidden: whether the reports of each are given to one track."""

import argparse
import time
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl
from bench_data import BESIDE
from scipy.optimize import linear_sum_assignment
from text_tables import heading, table

from trackweave import ReportTable, read_reports, track
from trackweave.metrics import assignment_quality

RECORDING = BESIDE / "data" / "opensky" / "OpenSky_Plane_States.csv"
CONFIGURATION = Path(__file__).with_name("opensky.toml")
GATE = 16.0
MOST_MISSES = 5
# As an engineer might tell.
TOLD = {"motion": {"process_noise": 10.0}, "sensors": {"default": {"sigma": 100.0}}}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--recording", type=Path, default=RECORDING)
    parser.add_argument("--config", type=Path, default=CONFIGURATION)
    arguments = parser.parse_args()
    if not arguments.recording.exists():
        raise SystemExit(f"{arguments.recording}: not there; name a recording with --recording")
    recording = pl.read_csv(arguments.recording)
    identity = recording["icao24"].to_list()
    reports = read_reports(recording.select("time", "lat", "lon"))
    given = tomllib.loads(arguments.config.read_text(encoding="utf-8"))
    _tracked(reports, given)  # compiles
    usual = track(reports, None, rng=np.random.default_rng(1)).run["configuration"]
    estimated = {"motion": usual["motion"], "sensors": {"default": usual["sensors"]["default"]}}
    runs = {
        "trackweave, `opensky.toml`": lambda: _tracked(reports, given),
        "trackweave, sigma 100 m and process noise 10 m²/s³": lambda: _tracked(reports, TOLD),
        "trackweave, no configuration": lambda: _tracked(reports, None),
        "plain GNN, motion and noise of `opensky.toml`": lambda: _gnn(reports, given),
        "plain GNN, motion and noise as estimated": lambda: _gnn(reports, estimated),
    }
    rows = []
    for name, run in runs.items():
        begun = time.process_time()
        found = run()
        cpu = time.process_time() - begun
        # Rows of the table are sorted; the recording's are named by ``report``.
        tracks = np.full(len(identity), -1)
        tracks[reports.report.astype(int) - 1] = found
        quality = assignment_quality(identity, tracks)
        rows.append(
            [
                name, f"{quality.idf1:.3f}", f"{quality.purity:.4f}",
                np.unique(tracks[tracks >= 0]).size, int(np.count_nonzero(tracks < 0)),
                f"{cpu:.2f}",
            ]
        )  # fmt: skip
    print(heading("python benchmarks/opensky.py"), end="\n\n")
    text = f"{len(identity)} reports of {len(set(identity))} aircraft, no false alarms."
    print(text, end="\n\n")
    head = ["method", "IDF1 of reports", "purity", "tracks", "reports on no track", "CPU s"]
    print(table(head, rows))


def _tracked(reports: ReportTable, configuration: Any) -> np.ndarray[Any, Any]:
    result = track(reports, configuration, rng=np.random.default_rng(1))
    found = np.full(len(reports), -1)
    for row, number in result.values.assignment.items():
        found[row] = number
    return found


@dataclass
class _Plain:
    """A track of the plain tracker."""

    number: int
    mean: np.ndarray[Any, Any]
    covariance: np.ndarray[Any, Any]
    time: float
    misses: int = 0

    def ahead(self, now: float, noise: float) -> None:
        """Predict to a time."""
        dt = now - self.time
        step = np.kron(np.array([[1.0, dt], [0.0, 1.0]]), np.eye(2))
        drift = np.kron(np.array([[dt**3 / 3, dt**2 / 2], [dt**2 / 2, dt]]), np.eye(2))
        self.mean = step @ self.mean
        self.covariance = step @ self.covariance @ step.T + noise * drift
        self.time = now

    def take(self, report: np.ndarray[Any, Any], variance: float) -> None:
        """Update by a report."""
        spread = self.covariance[:2, :2] + variance * np.eye(2)
        gain = np.linalg.solve(spread, self.covariance[:2]).T
        self.mean = self.mean + gain @ (report - self.mean[:2])
        self.covariance = self.covariance - gain @ self.covariance[:2]
        self.misses = 0


def _gnn(reports: ReportTable, values: Mapping[str, Any]) -> np.ndarray[Any, Any]:
    """Return the track of each report: gate, one-to-one assignment scan by scan, Kalman filter."""
    noise, top_speed = values["motion"]["process_noise"], values["motion"]["max_speed"]
    variance = values["sensors"]["default"]["sigma"] ** 2
    found = np.full(len(reports), -1)
    alive: list[_Plain] = []
    n_tracks = 0
    for now in np.unique(reports.time):
        rows = np.flatnonzero(reports.time == now)
        for plain in alive:
            plain.ahead(now, noise)
            plain.misses += 1
        for plain, row in _pairs(alive, reports.measurement, rows, variance):
            plain.take(reports.measurement[row], variance)
            found[row] = plain.number
        alive = [plain for plain in alive if plain.misses < MOST_MISSES]
        for row in rows[found[rows] < 0]:
            n_tracks += 1
            found[row] = n_tracks
            mean = np.concatenate([reports.measurement[row], np.zeros(2)])
            spread = np.diag([variance] * 2 + [top_speed**2 / 4] * 2)
            alive.append(_Plain(n_tracks, mean, spread, now))
    return found


def _pairs(
    alive: list[_Plain], position: Any, rows: Any, variance: float
) -> list[tuple[_Plain, int]]:
    """Return the tracks and reports that the cheapest one-to-one assignment pairs."""
    if not alive or not rows.size:
        return []
    distance = np.empty((len(alive), rows.size))
    for place, plain in enumerate(alive):
        off = position[rows] - plain.mean[:2]
        spread = plain.covariance[:2, :2] + variance * np.eye(2)
        distance[place] = np.sum(off * np.linalg.solve(spread, off.T).T, axis=1)
    first, second = linear_sum_assignment(np.minimum(distance, 10 * GATE))
    near = distance[first, second] <= GATE
    return [(alive[a], int(rows[b])) for a, b in zip(first[near], second[near], strict=True)]


if __name__ == "__main__":
    main()
