"""Tracking a stretch tells more than reports alone, and odd reports do no harm."""

from dataclasses import replace

import numpy as np
import polars as pl
import pytest

import trackweave as tw
from estimation.test_estimate import ODD, numbers, scene, table
from trackweave.config import load_configuration
from trackweave.estimation.estimate import estimate
from trackweave.metrics import assignment_quality
from trackweave.run.refining import estimates_for
from trackweave.simulation import simulate
from trackweave.simulation.demo import demo_scenario


def crowd() -> dict[str, float]:
    return {"n_targets": 60, "clutter": 40.0, "n_scans": 30, "detection": 0.8}


@pytest.mark.slow
def test_a_crowd_is_told_better_than_by_reports_alone() -> None:
    reports = scene(**crowd())
    found = estimates_for(reports, load_configuration(None))
    assert found is not None
    sensor = found.sensors["A"]
    assert sensor.sigma == pytest.approx(10.0, rel=0.1)
    assert sensor.detection_probability == pytest.approx(0.8, abs=0.05)
    assert sensor.clutter_density * 2000**2 == pytest.approx(40.0, rel=0.35)
    first = estimate(reports).sensors["A"]
    assert abs(sensor.detection_probability - 0.8) < abs(first.detection_probability - 0.8) + 0.01


@pytest.mark.slow
def test_false_alarms_in_a_crowd_are_told_from_objects() -> None:
    # Six of seven reports are of nobody, and each lies where an object may have come to.
    reports = scene(n_targets=10, clutter=60.0, detection=0.8)
    found = estimates_for(reports, load_configuration(None))
    assert found is not None
    assert found.sensors["A"].clutter_density * 2000**2 == pytest.approx(60.0, rel=0.35)
    assert found.sensors["A"].sigma == pytest.approx(10.0, rel=0.15)
    assert found.sensors["A"].detection_probability == pytest.approx(0.8, abs=0.06)
    assert found.max_speed < 40.0


def test_the_same_reports_give_the_same_estimates() -> None:
    reports, nothing = scene(n_scans=15), load_configuration(None)
    assert estimates_for(reports, nothing) == estimates_for(reports, nothing)


def test_nothing_is_estimated_where_all_is_given() -> None:
    given = {
        "motion": {"process_noise": 1.0, "max_speed": 10.0},
        "sensors": {
            "default": {
                "sigma": 1.0,
                "detection_probability": 0.9,
                "clutter_density": 1e-6,
                "scan_period": 1.0,
            }
        },
        "lifecycle": {"new_target_density": 1e-7},
    }
    assert estimates_for(scene(n_scans=5), load_configuration(given)) is None


def test_pauses_are_waited_for() -> None:
    rng = np.random.default_rng(1)
    times, places = [], []
    for scan in range(120):
        for target in range(8):
            # Behind something for seven scans of thirty.
            if (scan + 4 * target) % 30 >= 7:
                times.append(float(scan))
                places.append([300.0 * target + rng.normal(0, 2), 5.0 * scan + rng.normal(0, 2)])
    found = estimates_for(table(times, places), load_configuration(None))
    assert found is not None
    # Hidden for seven scans of thirty, and never missed otherwise.
    assert found.hidden_share == pytest.approx(7 / 30, rel=0.3)
    assert found.mean_silence == pytest.approx(7.0, rel=0.3)
    assert found.sensors["A"].detection_probability > 0.9
    assert found.delete_after_misses is None


@pytest.mark.slow
def test_sensors_that_mark_other_parts_of_an_object_still_agree() -> None:
    rng = np.random.default_rng(1)
    times, places, sensors = [], [], []
    for scan in range(60):
        for target in range(6):
            for sensor in (0, 1):
                # One sees the bow, the other the stern.
                off = np.array([6.0, 0.0]) * (sensor - 0.5)
                place = np.array([200.0 * target, 3.0 * scan]) + off + rng.normal(0, 0.5, 2)
                times.append(scan + 0.1 * sensor)
                places.append(place)
                sensors.append(sensor)
    found = estimates_for(table(times, places, sensors, ("A", "B")), load_configuration(None))
    assert found is not None
    for sensor in found.sensors.values():
        assert sensor.sigma > 1.5
        assert sensor.detection_probability > 0.8


def test_strengths_are_told_where_false_alarms_are_weaker() -> None:
    rng = np.random.default_rng(1)
    rows: list[tuple[float, float, float, float]] = []
    for scan in range(40):
        for target in range(8):
            x, y = np.array([200.0 * target, 5.0 * scan]) + rng.normal(0, 2, 2)
            rows.append((float(scan), x, y, rng.normal(12, 2)))
        rows += [
            (float(scan), *rng.uniform([0, 0], [1600, 400]), rng.normal(4, 2)) for _ in range(6)
        ]
    time, x, y, strength = np.array(rows).T
    reports = table(time, np.stack([x, y], axis=1))
    blind = estimates_for(reports, load_configuration(None))
    found = estimates_for(replace(reports, strength=strength), load_configuration(None))
    assert blind is not None
    assert found is not None
    assert blind.sensors["A"].strength is None
    model = found.sensors["A"].strength
    assert model is not None
    assert model.target_mean == pytest.approx(12.0, abs=0.5)
    assert model.clutter_mean == pytest.approx(4.0, abs=0.7)
    # Even ground: where false alarms do not gather, their density is that of all.
    assert found.sensors["A"].clutter_density * 1600 * 400 == pytest.approx(6.0, rel=0.4)


@pytest.mark.parametrize("name", ODD)
def test_odd_reports_give_finite_positive_values(name: str) -> None:
    found = estimates_for(table(*ODD[name]), load_configuration(None))
    assert found is not None
    values = numbers(found)
    assert np.all(np.isfinite(values))
    assert min(values) > 0


@pytest.mark.slow
@pytest.mark.parametrize("moment", [0.0, 24.0])
def test_the_fast_few_among_the_slow_set_the_greatest_speed(moment: float) -> None:
    rng = np.random.default_rng(1)
    times, places = [], []
    start = rng.uniform(-200, 200, (30, 2))
    way = rng.uniform(0, 7, 30)
    slow = 1.5 * np.stack([np.sin(way), np.cos(way)], axis=1)
    for time in np.arange(300) / 10:
        for target in np.flatnonzero(rng.random(30) < 0.9):
            times.append(float(time))
            places.append(start[target] + slow[target] * time + rng.normal(0, 0.3, 2))
        if moment <= time < moment + 5:
            times.append(float(time))
            places.append(np.array([-70.0, 40.0 + 28 * (time - moment)]) + rng.normal(0, 0.3, 2))
    found = estimates_for(table(times, places), load_configuration(None))
    assert found is not None
    assert 28.0 < found.max_speed < 45.0


@pytest.mark.slow
def test_boats_that_turn_keep_their_names() -> None:
    """Two of nine turn by 80° and more; a process noise of what the others do would lose them."""
    for seed in (2, 3):
        reports = simulate(demo_scenario(), np.random.default_rng(seed)).reports
        result = tw.track(reports)
        assert result.values.settings.motion.process_noise > 0.1
        found = result.assignments["track"].fill_null(-1).to_numpy()
        quality = assignment_quality(result.values.reports.carried["target"], found)
        assert quality.idf1 is not None
        assert quality.idf1 > 0.97


@pytest.mark.slow
@pytest.mark.parametrize("until", [40.0, 120.0])
def test_a_camera_that_loses_objects_for_long_is_taken_to_and_no_other(until):
    # Four boats before a radar of two seconds, and a camera with some false bearings.
    rng, rows = np.random.default_rng(3), []
    start = np.array([[-300.0, 400.0], [-100.0, 500.0], [100.0, 350.0], [300.0, 450.0]])
    speed = rng.normal(0.0, 1.5, start.shape)
    for look in np.arange(0.0, 120.0, 0.2):
        place = start + look * speed
        if round(10 * look) % 20 == 0:
            heard = place[rng.random(4) < 0.9]
            rows += [(look, "radar", *rng.normal(each, 4.0), None) for each in heard]
        seen = place[rng.random(4) < 0.8 * (look < until)]
        bearings = [*np.degrees(np.arctan2(*seen.T)), *rng.uniform(-60, 60, rng.poisson(1.0))]
        rows += [
            (look, "camera", None, None, (each + rng.normal(0, 0.5)) % 360.0) for each in bearings
        ]
    names = ["time", "sensor", "x", "y", "bearing_deg"]
    table = pl.DataFrame(rows, names, orient="row", infer_schema_length=None)
    told = {"camera": {"position": [0.0, 0.0]}}
    used = tw.track(table, {"sensors": told}).run["configuration"]["sensors"]
    assert used["camera"]["hidden_share"] == (0.5 if until < 120.0 else 0.0)
