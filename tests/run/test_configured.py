"""From a configuration to the live tracker that a run would take."""

import numpy as np
import polars as pl
import pytest

import trackweave as tw
from oracles.scenes import scene
from trackweave.errors import InvalidInputError
from trackweave.formats.reading import read_reports
from trackweave.run.scans import complete_scans

SENSOR = {
    "sigma": 10.0, "detection_probability": 0.9, "clutter_density": 2e-6, "scan_period": 1.0,
}  # fmt: skip
FULL = {
    "motion": {"process_noise": 0.05, "max_speed": 30.0},
    "sensors": {"default": SENSOR},
    "search": {"method": "genetic", "population": 10},
    "lifecycle": {"new_target_density": 1e-6},
}
KINDS = {
    "multi-hypothesis": tw.MultiHypothesisTracker,
    "nearest-neighbour": tw.NearestNeighbourTracker,
}


def reports(names=("a", "b")):
    rows = [
        (each.time, each.sensor, *place)
        for each in scene(2, names=names, objects=4, times=range(14))
        for place in each.measurement.tolist()
    ]
    return pl.DataFrame(rows, schema=["time", "sensor", "x", "y"], orient="row")


def stepped(tracker, table, periods, seed):
    rng = np.random.default_rng(seed)
    return [tracker.step(each, rng=rng) for each in complete_scans(table, periods)]


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("config", [FULL, {}], ids=["full", "empty"])
def test_the_live_tracker_says_what_the_run_says(kind, config):
    frame = reports()
    config = config | {"tracker": {"kind": kind}}
    result = tw.track(frame, config, rng=np.random.default_rng(7))
    tracker = KINDS[kind].from_config(config, reports=frame)
    periods = {sensor.name: sensor.scan_period for sensor in result.values.settings.sensors}
    hypotheses = stepped(tracker, read_reports(frame), periods, 7)
    assert [each.certificate.cost for each in hypotheses] == [
        each["cost"] for each in result.run["scans"]
    ]
    assert [each.n_sequences for each in hypotheses] == [
        each["sequences"] for each in result.run["scans"]
    ]
    last = {each.time: each.tracks for each in hypotheses}
    means = np.concatenate([each.mean for each in last.values()])
    assert means.tobytes() == result.values.tracks.mean.tobytes()


def test_without_reports_what_a_configuration_says_is_enough():
    sensors = {"a": SENSOR, "b": SENSOR | {"sigma": 20.0}}
    frame = reports()
    with_reports = tw.MultiHypothesisTracker.from_config(FULL | {"sensors": sensors}, frame)
    without = tw.MultiHypothesisTracker.from_config(FULL | {"sensors": sensors})
    periods, table = {"a": 1.0, "b": 1.0}, read_reports(frame)
    for one, other in zip(
        stepped(with_reports, table, periods, 1), stepped(without, table, periods, 1), strict=True
    ):
        assert one.tracks.mean.tobytes() == other.tracks.mean.tobytes()


def test_one_sensor_may_go_by_default_alone(tmp_path):
    path = tmp_path / "tracker.toml"
    path.write_text("[sensors.default]\nsigma = 10.0\nclutter_density = 1e-6\nscan_period = 1.0\n")
    tracker = tw.MultiHypothesisTracker.from_config(path)
    for time in range(5):
        scan = tw.Scan(float(time), "default", [[5.0 * time, 0.0]])
        hypothesis = tracker.step(scan, rng=np.random.default_rng(1))
    assert len(hypothesis.tracks) == 1


@pytest.mark.parametrize(
    ("config", "message"),
    [
        ({}, "sensors.NAME, a table for each sensor left out"),
        (
            {"sensors": {"a": {"scan_period": 1.0}, "b": {"sigma": 3.0}}},
            "sensors.a.sigma, sensors.a.clutter_density, sensors.b.clutter_density left out",
        ),
        (
            {"sensors": {"a": {"measurement": "range-azimuth", "clutter_per_scan": 3.0}}},
            "sensors.a.clutter_density (clutter_per_scan needs a field_of_view) left out",
        ),
        (
            {"sensors": {"a": {"sigma": 1.0, "clutter_per_scan": 3.0}}},
            "sensors.a.clutter_density (clutter_per_scan needs a field_of_view) left out",
        ),
        (FULL | {"plots": {"fuse": True}}, "plots.fuse: true; expected false"),
        (
            FULL | {"tracker": {"kind": "nearest-neighbour"}},
            "NearestNeighbourTracker; expected that of a MultiHypothesisTracker",
        ),
        ("nowhere.toml", "no such file"),
    ],
)
def test_refuses_what_makes_no_such_tracker_by_the_keys(config, message):
    with pytest.raises(InvalidInputError) as err:
        tw.MultiHypothesisTracker.from_config(config)
    assert message in str(err.value)


def test_the_other_class_refuses_too():
    with pytest.raises(InvalidInputError, match=r"MultiHypothesisTracker\.from_config"):
        tw.NearestNeighbourTracker.from_config(FULL)


@pytest.mark.parametrize(
    "sensor",
    [
        {"measurement": "bearing", "clutter_density": 0.1},
        {"measurement": "range-azimuth", "clutter_density": 1e-6, "scan_period": 4.0},
        {
            "measurement": "range-azimuth", "clutter_per_scan": 3.0, "scan_period": 4.0,
            "field_of_view": {"max_range_m": 9000.0}, "rotation": "clockwise",
        },
        {"measurement": "range-azimuth-elevation", "clutter_density": 1e-6},
    ],
)  # fmt: skip
def test_sensors_of_every_kind_need_no_reports(sensor):
    sensors = {"a": sensor, "b": SENSOR}
    sensors["a"] = sensor | {"position": [0.0, 0.0, 0.0]}
    tracker = tw.MultiHypothesisTracker.from_config({"sensors": sensors})
    assert len(tracker.step(tw.Scan(0.0, "a", []), rng=np.random.default_rng(1)).tracks) == 0


def test_max_ahead_comes_from_the_file():
    tracker = tw.MultiHypothesisTracker.from_config(FULL | {"live": {"max_ahead": 5.0}})
    rng = np.random.default_rng(1)
    tracker.step(tw.Scan(0.0, "default", []), rng=rng)
    assert tracker.step(tw.Scan(6.0, "default", []), rng=rng).held
