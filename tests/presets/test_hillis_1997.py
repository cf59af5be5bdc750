"""The patent to the letter, from a table of reports to tracks."""

import numpy as np
import polars as pl
import pytest

from trackweave.metrics import assignment_quality
from trackweave.run import track

CONFIG = {
    "motion": {"process_noise": 0.1, "max_speed": 20.0},
    "sensors": {
        "default": {
            "sigma": 5.0,
            "detection_probability": 0.9,
            "clutter_density": 2e-6,
            "scan_period": 1.0,
        }
    },
    "lifecycle": {"new_target_density": 1e-6},
    "search": {"generations": 40, "population": 40},
}


@pytest.fixture(scope="module")
def reports():
    """Return twelve scans of three targets, two of which cross, with misses and false alarms."""
    rng = np.random.default_rng(5)
    start = np.array([[0.0, 0.0], [0.0, 120.0], [300.0, 0.0]])
    speed = np.array([[10.0, 5.0], [10.0, -5.0], [0.0, 10.0]])
    rows = []
    for time in range(12):
        seen = np.flatnonzero(rng.random(3) < 0.9)
        for target in seen:
            place = start[target] + time * speed[target] + rng.normal(0, 5.0, 2)
            rows.append((float(time), *place, str(target)))
        rows += [(float(time), *rng.uniform(-100, 500, 2), "") for _ in range(rng.poisson(0.7))]
    return pl.DataFrame(rows, schema=["time", "x", "y", "target"], orient="row")


@pytest.fixture(scope="module")
def result(reports):
    return track(reports, CONFIG, preset="hillis-1997", rng=np.random.default_rng(1))


def test_every_report_is_in_a_track_even_alone(result, reports):
    assert result.assignments["track"].null_count() == 0
    assert result.run["totals"]["assigned_reports"] == reports.height
    per_track = result.assignments["track"].value_counts()["count"]
    assert per_track.min() == 1


def test_the_targets_are_told_apart(result):
    real = result.assignments.filter(pl.col("target") != "")
    quality = assignment_quality(real["target"].to_numpy(), real["track"].to_numpy())
    assert quality.idf1 > 0.9


def test_the_window_is_five_scans_deep_and_the_search_runs(result):
    assert result.run["configuration"]["window"]["depth"] == 5
    assert result.run["sources"]["window.depth"] == "preset"
    assert result.run["configuration"]["search"]["settle"] is False
    scans = result.run["scans"]
    assert all(scan["evaluations"] >= 40 for scan in scans if scan["reports"])
    assert {scan["stop_reason"] for scan in scans} <= {"generations", "converged", "gap closed"}


def test_the_file_comes_before_the_preset(result):
    assert result.run["configuration"]["search"]["generations"] == 40
    assert result.run["sources"]["search.generations"] == "file"


def test_tells_no_probabilities_because_the_document_has_none(result):
    known = result.assignments["probability"]
    assert known.is_null().sum() + known.is_nan().sum() == known.len()


def test_the_same_seed_gives_the_same_tracks(result, reports):
    again = track(reports, CONFIG, preset="hillis-1997", rng=np.random.default_rng(1))
    assert again.tracks.equals(result.tracks)
    assert again.assignments.equals(result.assignments)
