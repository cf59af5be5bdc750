"""Sensors that copy others, and reports that come all at once, are told."""

import numpy as np

from run.diagnostics.scenes import case_of, positions
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
