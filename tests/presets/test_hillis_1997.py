"""The patent to the letter, from a table of reports to tracks."""

import numpy as np
import polars as pl
import pytest

from trackweave.metrics import assignment_quality
from trackweave.presets import hillis, hillis_1997
from trackweave.run import track
from trackweave.solvers import islands

pytestmark = pytest.mark.slow

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


def test_the_one_made_for_use_follows_the_targets_and_leaves_false_alarms_alone(reports):
    usual = {key: value for key, value in CONFIG.items() if key != "search"}
    found = track(reports, usual, preset="hillis", rng=np.random.default_rng(1))
    quality = assignment_quality(found.assignments["target"], found.assignments["track"])
    default = track(reports, usual, rng=np.random.default_rng(1))
    of_default = assignment_quality(default.assignments["target"], default.assignments["track"])
    assert quality.idf1 >= 0.95 * of_default.idf1
    assert found.assignments["track"].null_count() > 0
    assert not [note for note in found.run["notes"] if "preset" in note]


def test_the_one_made_for_use_keeps_the_letters_window_and_operators():
    kept = ("method", "genotype", "selection", "crossover", "mutation", "population")
    strict, usable = hillis_1997.CONFIGURATION, hillis.CONFIGURATION
    assert strict["window"] == usable["window"]
    assert {key: strict["search"][key] for key in kept} == {
        key: usable["search"][key] for key in kept
    }


def test_islands_give_the_same_tracks_on_any_number_of_threads(reports, monkeypatch):
    values = {**CONFIG, "search": {**CONFIG["search"], "islands": 3}}
    found = []
    for count in (1, 3):
        monkeypatch.setattr(islands, "_n_processors", lambda count=count: count)
        found.append(track(reports, values, preset="hillis-1997", rng=np.random.default_rng(1)))
    assert found[0].assignments.equals(found[1].assignments)
    assert found[0].run["scans"] == found[1].run["scans"]
