"""A camera that stamps its reports one after the other is tracked as if it did not."""

import numpy as np
import polars as pl
import pytest

import trackweave as tw
from trackweave.config import load_configuration
from trackweave.metrics import assignment_quality
from trackweave.run.tracking import settings_for

pytestmark = pytest.mark.slow


def walkers(seed=1):
    """Return ten walkers in frames a second apart, with misses and false alarms."""
    rng = np.random.default_rng(seed)
    place, speed = rng.uniform(0, 100, (10, 2)), rng.normal(0, 1, (10, 2))
    rows = []
    for frame in range(80):
        place = place + speed
        rows += [
            (float(frame), *(place[each] + rng.normal(0, 0.3, 2)), str(each))
            for each in np.flatnonzero(rng.random(10) < 0.9)
        ]
        rows += [(float(frame), *rng.uniform(-50, 150, 2), "") for _ in range(rng.poisson(2))]
    return pl.DataFrame(rows, schema=["time", "x", "y", "target"], orient="row")


def stamped(reports, spread):
    late = np.random.default_rng(2).uniform(0, spread, len(reports))
    return reports.with_columns(pl.col("time") + pl.Series(late)).sort("time")


def quality(reports, told=None):
    result = tw.track(reports.drop("target"), told)
    number = result.reports["track"].fill_null(-1).to_numpy()
    return assignment_quality(reports["target"].to_list(), number).idf1, result


@pytest.mark.parametrize("spread", [0.005, 0.15])
def test_frames_whose_reports_have_times_of_their_own_are_frames(spread):
    reports = stamped(walkers(), spread)
    found, result = quality(reports)
    assert found > quality(walkers())[0] - 0.01
    sensor = result.run["configuration"]["sensors"]["default"]
    assert sensor["scan_period"] == pytest.approx(1.0, rel=0.01)
    assert [note for note in result.run["notes"] if "come in bursts of 0." in note]
    np.testing.assert_array_equal(result.reports["time"], reports["time"])


def test_who_says_that_a_sensor_does_not_look_is_heard():
    reports = tw.read_reports(stamped(walkers(), 0.1).drop("target"))
    told = load_configuration({"sensors": {"default": {"scans": False}}})
    assert settings_for(reports, told).values["sensors"]["default"]["scan_period"] is None


def test_who_says_that_nothing_turns_is_not_contradicted():
    _, result = quality(stamped(walkers(), 0.1), {"sensors": {"default": {"rotation": "none"}}})
    (note,) = [note for note in result.run["notes"] if "come in bursts" in note]
    assert "not used" not in note


def sectors(seed=1):
    """Return six ships before a radar that sends quarters of a turn, stamped as it sends."""
    rng = np.random.default_rng(seed)
    place, speed = rng.uniform(-8000, 8000, (6, 2)), rng.normal(0, 5, (6, 2))
    rows = []
    for quarter in range(400):
        for each in range(6):
            now = place[each] + quarter * speed[each]
            azimuth = np.degrees(np.arctan2(*now)) % 360
            if azimuth // 90 == quarter % 4:
                time = quarter + rng.uniform(0, 0.02)
                rows.append((time, np.hypot(*now) + rng.normal(0, 10), azimuth))
    return pl.DataFrame(sorted(rows), schema=["time", "range_m", "azimuth_deg"], orient="row")


def test_quarters_of_a_turn_are_no_frames():
    notes = tw.track(sectors()).run["notes"]
    assert not [note for note in notes if "come in bursts" in note]


def test_bursts_far_apart_are_not_set_aside_as_lone_scans():
    reports = walkers().with_columns(pl.col("time") * 900.0)
    found, result = quality(stamped(reports, 200.0))
    assert found > 0.95
    assert not [note for note in result.run["notes"] if "stand alone" in note]
