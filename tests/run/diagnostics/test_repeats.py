"""Sensors that copy others, and reports that come all at once, are told."""

import numpy as np
import polars as pl
import pytest

import trackweave as tw
from run.diagnostics.scenes import case_of, positions
from trackweave.metrics import assignment_quality
from trackweave.run.diagnostics.scans import copied_sensors, single_times


def test_identical_times_of_all_reports_are_one_scan_and_told() -> None:
    place = [[float(k), 0.0] for k in range(12)]
    (found,) = single_times(case_of(positions([3.5] * 12, place)))
    assert found.sentence == (
        "sensor lidar: all 12 reports have the time 3.5 s, so that they are one scan"
    )
    assert list(single_times(case_of(positions([3.5] * 5, place[:5])))) == []


def test_a_sensor_that_copies_another_is_told_once_with_any_delay() -> None:
    rng = np.random.default_rng(1)
    place = rng.uniform(0, 100, (30, 2))
    time = np.concatenate([np.arange(30.0), np.arange(30.0) + 0.4])
    order = np.argsort(time, kind="stable")
    sensor = np.repeat([0, 1], 30)[order]
    both = np.concatenate([place, place])[order]
    reports = positions(time[order], both, sensor, ("a", "b"))
    (found,) = copied_sensors(case_of(reports))
    assert found.cause == "copies"
    assert "30 of 30 of its reports are number for number those of sensor" in found.sentence
    both[sensor == 1] += rng.normal(0, 1e-3, (30, 2))
    assert list(copied_sensors(case_of(positions(time[order], both, sensor, ("a", "b"))))) == []


def test_numbers_on_a_coarse_grid_are_no_copies() -> None:
    place = np.random.default_rng(1).integers(0, 3, (60, 2)).astype(float)
    reports = positions(np.arange(60.0), place, np.arange(60) % 2, ("a", "b"))
    assert list(copied_sensors(case_of(reports))) == []


def lidar(per_object: int) -> pl.DataFrame:
    """Return half a minute of seven cars, of which each gives so many reports a scan."""
    rng = np.random.default_rng(4)
    rows = []
    for scan in range(150):
        for car in range(7):
            for _ in range(per_object):
                x = 20.0 * car - 60.0 + (4.0 + car) * 0.2 * scan + rng.uniform(-2.2, 2.2)
                rows.append(
                    (0.2 * scan, x + rng.normal(0, 0.1), 12.0 * car + rng.uniform(-0.9, 0.9))
                )
    return pl.DataFrame(rows, schema=["time", "x", "y"], orient="row")


EACH = {"sensors": {"default": {"extent": 0.0}}}


@pytest.mark.slow
def test_objects_that_give_several_reports_a_scan_are_told() -> None:
    notes = tw.track(lidar(4), EACH).run["notes"]
    (told,) = [note for note in notes if "lie beside another of their scan" in note]
    assert "if objects give several reports a scan" in told


@pytest.mark.slow
def test_objects_that_give_one_report_a_scan_are_not() -> None:
    notes = tw.track(lidar(1)).run["notes"]
    assert not any("of their scan" in note for note in notes)


@pytest.mark.slow
def test_frames_that_rounded_times_put_together_are_told() -> None:
    rng = np.random.default_rng(1)
    place, speed = rng.uniform(0, 200, (12, 2)), rng.normal(0, 3, (12, 2))
    rows = [
        (0.4 * frame, *(place[each] + 0.4 * frame * speed[each] + rng.normal(0, 0.5, 2)))
        for frame in range(150)
        for each in np.flatnonzero(rng.random(12) < 0.9)
    ]
    fine = pl.DataFrame(rows, schema=["time", "x", "y"], orient="row")
    for reports, is_told in ((fine, False), (fine.with_columns(pl.col("time").floor()), True)):
        notes = tw.track(reports, EACH).run["notes"]
        assert any("or where times are rounded" in note for note in notes) == is_told


@pytest.mark.slow
def test_frames_that_rounded_times_put_together_are_tracked_all_the_same() -> None:
    rng = np.random.default_rng(1)
    place, speed = rng.uniform(0, 200, (12, 2)), rng.normal(0, 3, (12, 2))
    rows = [
        (
            0.4 * frame,
            *(place[each] + 0.4 * frame * speed[each] + rng.normal(0, 0.5, 2)),
            str(each),
        )
        for frame in range(150)
        for each in np.flatnonzero(rng.random(12) < 0.9)
    ]
    frame = pl.DataFrame(rows, schema=["time", "x", "y", "target"], orient="row")
    found = tw.track(frame.with_columns(pl.col("time").floor()))
    assert any("or times are rounded" in note for note in found.run["notes"])
    track = found.reports["track"].fill_null(-1).to_numpy()
    quality = assignment_quality(frame["target"].to_list(), track).idf1
    assert quality is not None
    assert quality > 0.9
