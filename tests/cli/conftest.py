"""Small files to run commands on."""

import csv
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner, Result

from trackweave.cli.app import app

Run = Callable[..., Result]


@pytest.fixture
def run() -> Run:
    """Return what runs a command in this process."""
    runner = CliRunner()

    def invoke(*arguments: object) -> Result:
        return runner.invoke(app, [str(argument) for argument in arguments])

    return invoke


def write_reports(path: Path, *, n_scans: int = 12) -> Path:
    """Two objects side by side, a miss and a false alarm now and then."""
    rng = np.random.default_rng(5)
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["time", "x", "y", "target", "colour"])
        for scan in range(n_scans):
            for target, north in (("a", 0.0), ("b", 300.0)):
                if rng.random() < 0.9:
                    x, y = 10.0 * scan + rng.normal(0, 3), north + rng.normal(0, 3)
                    writer.writerow([scan, x, y, target, "red"])
            if scan % 3 == 0:
                writer.writerow([scan, *rng.uniform(-100, 400, 2), "", "grey"])
    return path


@pytest.fixture
def reports(tmp_path: Path) -> Path:
    return write_reports(tmp_path / "reports.csv")


@pytest.fixture
def config(tmp_path: Path) -> Path:
    """Return a configuration that leaves nothing to estimate."""
    path = tmp_path / "tracker.toml"
    path.write_text(
        "[motion]\nprocess_noise = 0.1\nmax_speed = 30.0\n"
        "[sensors.default]\nsigma = 3.0\ndetection_probability = 0.9\n"
        "clutter_density = 2e-6\nscan_period = 1.0\n"
        "[lifecycle]\nnew_target_density = 1e-6\n"
    )
    return path
