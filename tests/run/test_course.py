"""Runs that fuse plots of several sensors first."""

import numpy as np
import polars as pl
import pytest

from trackweave.metrics import assignment_quality
from trackweave.run import track

SENSOR = {
    "sigma": 5.0,
    "detection_probability": 0.9,
    "clutter_density": 2e-6,
    "scan_period": 1.0,
}
CONFIG = {
    "motion": {"process_noise": 0.1, "max_speed": 20.0},
    "sensors": {"default": SENSOR},
    "lifecycle": {"new_target_density": 1e-6, "initial_target_density": 5e-6},
}


def reports(names="ABC", lags=(), periods=(), n_scans=12, seed=5):
    """Return scans of three targets by several sensors, with misses and false alarms."""
    rng = np.random.default_rng(seed)
    start = np.array([[0.0, 0.0], [0.0, 120.0], [300.0, 0.0]])
    speed = np.array([[10.0, 5.0], [10.0, -5.0], [0.0, 10.0]])
    rows = []
    for index, name in enumerate(names):
        period = periods[index] if periods else 1.0
        for number in range(n_scans):
            time = number * period + (lags[index] if lags else 0.0)
            for target in np.flatnonzero(rng.random(3) < 0.9):
                place = start[target] + time * speed[target] + rng.normal(0, 5.0, 2)
                rows.append((time, name, *place, str(target)))
            for _ in range(rng.poisson(0.7)):
                rows.append((time, name, *rng.uniform(-100, 500, 2), ""))
    return pl.DataFrame(rows, schema=["time", "sensor", "x", "y", "target"], orient="row")


def run(table, preset=None, seed=1, **tables):
    return track(table, CONFIG | tables, preset=preset, rng=np.random.default_rng(seed))


def quality(result):
    real = result.assignments.filter(pl.col("target") != "")
    return assignment_quality(real["target"].to_numpy(), real["track"].to_numpy()).idf1


@pytest.mark.parametrize("kind", ["multi-hypothesis", "nearest-neighbour"])
@pytest.mark.parametrize("cost", ["evidence", "equation-1"])
def test_objects_are_told_apart_by_their_fused_plots(kind, cost):
    table = reports()
    result = run(table, tracker={"kind": kind}, plots={"fuse": True, "cost": cost})
    assert quality(result) > 0.85
    scans = result.run["scans"]
    assert len(scans) == 12
    assert {scan["sensor"] for scan in scans} == {"A+B+C"}
    assert sum(scan["reports"] for scan in scans) == table.height
    assert all(scan["fused"] <= scan["tuples"] for scan in scans)
    assert result.run["sources"]["tracker.kind"] == "file"
    assert result.run["sources"]["plots.within"] == "default"
    assert result.run["configuration"]["plots"]["within"] == pytest.approx(0.1)
    assert result.run["configuration"]["plots"]["object_density"] == 5e-6
    assert any("field_of_view" in note for note in result.run["notes"]) == (cost == "equation-1")


def test_nearest_neighbour_tracks_scan_by_scan_without_fusing():
    result = run(reports(), tracker={"kind": "nearest-neighbour"})
    assert quality(result) > 0.8
    assert {scan["sensor"] for scan in result.run["scans"]} == set("ABC")
    assert "tuples" not in result.run["scans"][0]
    assert result.run["configuration"]["tracker"]["pairing"] == "one-to-one"
    # What no confirmed track holds is a false alarm, in the assignments too.
    known = set(result.tracks.filter(result.tracks["status"] != "tentative")["track"].to_list())
    assert set(result.assignments["track"].drop_nulls().to_list()) <= known


def test_nothing_is_entered_that_nobody_asked_for():
    record = run(reports("A")).run
    assert not {"tracker", "plots"} & set(record["configuration"])
    assert not [key for key in record["sources"] if key.startswith(("tracker", "plots"))]
    assert "tuples" not in record["scans"][0]


@pytest.mark.parametrize(
    ("table", "note"),
    [
        (reports("A"), "only sensor A"),
        (reports("AB", lags=(0.0, 0.4)), "no two sensors' scans are within 0.1 s"),
    ],
)
def test_with_nothing_to_fuse_reports_are_tracked_scan_by_scan(table, note):
    result = run(table, plots={"fuse": True})
    plain = run(table)
    assert any(note in each for each in result.run["notes"])
    assert result.tracks.equals(plain.tracks)
    assert run(table, preset="wiranto-2018").run["scans"][0]["sensor"] == "A"


def test_a_clock_that_is_late_is_brought_to_one_time():
    result = run(reports("AB", lags=(0.0, 0.4)), plots={"fuse": True, "within": 0.5})
    assert [scan["sensor"] for scan in result.run["scans"]] == ["A+B"] * 12
    assert result.run["scans"][0]["time"] == pytest.approx(0.4)
    assert quality(result) > 0.85


def test_instants_of_one_sensor_are_counted():
    table = reports("AB", periods=(1.0, 1.3), n_scans=14)
    sensors = {"default": SENSOR, "B": {"scan_period": 1.3}}
    result = run(table, plots={"fuse": True}, sensors=sensors)
    names = [scan["sensor"] for scan in result.run["scans"]]
    assert {"A", "B", "A+B"} == set(names)
    alone = len(names) - names.count("A+B")
    assert any(f"at {alone} of {len(names)} instants" in note for note in result.run["notes"])


def test_too_many_plots_in_one_cell_take_bounded_time_and_prove_nothing():
    rng = np.random.default_rng(2)
    rows = [(0.0, name, *rng.uniform(0, 1.0, 2), "") for name in "ABC" for _ in range(1000)]
    table = pl.DataFrame(rows, schema=["time", "sensor", "x", "y", "target"], orient="row")
    result = run(
        table, plots={"fuse": True, "max_tuples": 3000}, search={"method": "greedy"},
        tracker={"kind": "nearest-neighbour"},
    )  # fmt: skip
    (scan,) = result.run["scans"]
    assert 0 < scan["tuples"] <= 3000
    assert scan["status"] == "feasible"
    assert not np.isfinite(scan["lower_bound"])
    assert result.run["totals"]["proven_scans"] == 0
    assert any("plots.max_tuples" in note for note in result.run["notes"])


def test_the_documents_method_tracks_and_repeats():
    table = reports()
    first, again = (run(table, preset="wiranto-2018") for _ in range(2))
    assert first.tracks.equals(again.tracks)
    assert quality(first) > 0.7
    configuration, sources = first.run["configuration"], first.run["sources"]
    assert configuration["search"]["method"] == "ant-system"
    assert configuration["search"]["decompose"] is False
    assert configuration["tracker"] == {"kind": "nearest-neighbour", "pairing": "nearest"}
    assert configuration["plots"]["cost"] == "equation-1"
    assert sources["tracker.pairing"] == sources["plots.cost"] == "preset"
    assert all(scan["amendments"] == 0 for scan in first.run["scans"])
    assert {scan["stop_reason"] for scan in first.run["scans"]} <= {
        "converged", "cycles", "evaluations", "gap closed",
    }  # fmt: skip


def test_the_file_comes_before_the_document():
    result = run(
        reports(), preset="wiranto-2018", tracker={"pairing": "one-to-one"},
        plots={"cost": "evidence"}, search={"method": "auto"},
    )  # fmt: skip
    assert result.run["configuration"]["tracker"]["pairing"] == "one-to-one"
    assert result.run["configuration"]["plots"]["cost"] == "evidence"
    assert result.run["totals"]["proven_scans"] == 12
