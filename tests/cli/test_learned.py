"""What one recording told serves the next: ``init --learn``, ``track --learned``."""

import json
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl
import pytest

from cli.conftest import Run
from trackweave.config import load_configuration, with_learned


def recording(path: Path, seed: int, scans: int = 60) -> Path:
    """Write reports of twelve objects that go straight, with false alarms."""
    rng = np.random.default_rng(seed)
    place = rng.uniform(0.0, 4000.0, (12, 2))
    velocity = rng.normal(0.0, 10.0, (12, 2))
    rows = []
    for time in range(scans):
        seen = place + time * velocity + rng.normal(0.0, 5.0, (12, 2))
        false = rng.uniform(0.0, 4000.0, (3, 2))
        rows += [(float(time), *at) for at in [*seen[rng.random(12) < 0.9], *false]]
    frame = pl.DataFrame(rows, schema=["time", "x", "y"], orient="row")
    frame.write_csv(path)
    return path


@pytest.fixture
def learned(tmp_path: Path, run: Run) -> Path:
    place = tmp_path / "learned.toml"
    done = run("init", recording(tmp_path / "day.csv", 1), "--learn", place)
    assert done.exit_code == 0, done.stderr
    return place


def test_writes_what_reports_told_and_nothing_else(learned: Path) -> None:
    tables = tomllib.loads(learned.read_text())
    assert set(tables) == {"motion", "lifecycle", "sensors"}
    sensor = tables["sensors"]["default"]
    assert sensor["sigma"] == pytest.approx(5.0, rel=0.2)
    assert sensor["detection_probability"] == pytest.approx(0.9, abs=0.05)
    assert "initial_target_density" not in tables["lifecycle"]
    assert not (learned.parent / "tracker.toml").exists()
    load_configuration(learned)


def test_counts_where_the_configuration_is_silent(learned: Path, tmp_path: Path, run: Run) -> None:
    short = recording(tmp_path / "next.csv", 2, scans=8)
    config = tmp_path / "tracker.toml"
    config.write_text("[motion]\nmax_speed = 70.0\n")
    done = run("track", short, "--config", config, "--learned", learned, "--out", tmp_path / "o")
    assert done.exit_code == 0, done.stderr
    record: dict[str, Any] = json.loads((tmp_path / "o" / "run.json").read_text())
    known = tomllib.loads(learned.read_text())
    used = record["configuration"]
    assert used["motion"]["max_speed"] == 70.0
    assert record["sources"]["motion.max_speed"] == "file"
    assert used["motion"]["process_noise"] == known["motion"]["process_noise"]
    assert record["sources"]["motion.process_noise"] == "learned"
    assert used["sensors"]["default"]["sigma"] == known["sensors"]["default"]["sigma"]
    assert record["sources"]["sensors.default.sigma"] == "learned"
    assert record["sources"]["lifecycle.initial_target_density"] == "default"


def test_is_refused_by_name_where_it_is_no_configuration(tmp_path: Path, run: Run) -> None:
    other = tmp_path / "other.toml"
    other.write_text("[sensors.default]\nsigma = -3.0\n")
    reports = recording(tmp_path / "next.csv", 2, scans=4)
    done = run("track", reports, "--learned", other, "--out", tmp_path / "o")
    assert done.exit_code == 2
    assert "other.toml" in done.stderr
    assert "sigma" in done.stderr
    assert not (tmp_path / "o").exists()


WAYS = ["constant-velocity", "coordinated-turn"]
LEARNED = {
    "motion": {"process_noise": 0.5, "model": "imm", "imm": {"models": WAYS}},
    "sensors": {
        "north": {"sigma": 7.0, "clutter_density": 1e-6, "detection_probability": 0.8},
        "south": {"sigma": 9.0},
    },
}


@pytest.mark.parametrize(
    ("told", "expected"),
    [
        ({"sensors": {"default": {"sigma": 3.0}}}, {"north": None, "south": None}),
        ({"sensors": {"north": {"sigma": 3.0}}}, {"north": 3.0, "south": 9.0}),
        ({}, {"north": 7.0, "south": 9.0}),
    ],
)
def test_what_is_told_of_all_sensors_counts_before_what_was_learned_of_one(
    told: dict[str, Any], expected: dict[str, float | None]
) -> None:
    both = with_learned(load_configuration(told), load_configuration(LEARNED))
    assert {name: both.table("sensors", name).get("sigma") for name in expected} == expected


def test_what_is_told_otherwise_takes_what_belongs_to_it_along() -> None:
    told = {
        "motion": {"model": "constant-velocity"},
        "sensors": {"north": {"clutter_per_scan": 2.0}},
    }
    both = with_learned(load_configuration(told), load_configuration(LEARNED))
    assert both.table("motion") == {"process_noise": 0.5, "model": "constant-velocity"}
    assert "clutter_density" not in both.table("sensors", "north")
    assert both.table("sensors", "north")["detection_probability"] == 0.8
    assert "sensors.north.sigma" in both.learned
    assert "motion.model" not in both.learned


def test_too_little_to_learn_from_is_refused(tmp_path: Path, run: Run) -> None:
    done = run("init", recording(tmp_path / "r.csv", 1, scans=2), "--learn", tmp_path / "l.toml")
    assert done.exit_code == 2
    assert "are in tracks; expected at least 40 to learn from" in " ".join(done.stderr.split())
    assert not (tmp_path / "l.toml").exists()
