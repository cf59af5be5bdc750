"""What looks wrong with reports is said."""

import numpy as np
import pytest

from trackweave.domain.measurements import MeasurementKind as Kind
from trackweave.domain.reports import ReportTable
from trackweave.models.sensors import Sensor
from trackweave.run.doubts import doubts_on

LIDAR = Sensor("lidar", sigma=1.0)
CAMERA = Sensor(
    "camera", sigma=(np.radians(1.0),), measurement=Kind.BEARING, position=(50.0, -20.0)
)


def watched(turned) -> ReportTable:
    """Two walkers seen by a lidar, and their bearings from a camera."""
    time = np.repeat(np.arange(40.0), 2)
    east = np.where(np.arange(80) % 2, 100.0 + 2 * time, 30.0 - time)
    north = np.where(np.arange(80) % 2, 40.0, 90.0 - 3 * time)
    bearing = np.arctan2(east - 50.0, north + 20.0)
    bearing += np.random.default_rng(1).normal(0, np.radians(1.0), 80)
    measurement = np.stack([east, north], axis=-1)
    seen = np.stack([turned(bearing) % (2 * np.pi), np.full(80, np.nan)], axis=-1)
    order = np.lexsort((np.repeat([1, 0], 80), np.tile(time, 2)))
    return ReportTable(
        time=np.tile(time, 2)[order],
        sensor=np.repeat([1, 0], 80)[order],
        sensors=("camera", "lidar"),
        measurement=np.concatenate([measurement, seen])[order],
        sigma=np.full((160, 2), np.nan),
        report=np.arange(160).astype(str).astype(object),
        kinds=(Kind.BEARING, Kind.POSITION),
        space=2,
    )


def test_bearings_in_the_right_sense_are_beyond_doubt():
    assert doubts_on(watched(lambda angle: angle), [CAMERA, LIDAR]) == []


@pytest.mark.parametrize(
    ("turned", "sense"),
    [
        (lambda angle: -angle, "counter-clockwise from north"),
        (lambda angle: np.pi / 2 - angle, "counter-clockwise from east"),
        (lambda angle: angle + np.pi, "clockwise from south"),
    ],
)
def test_bearings_in_another_sense_are_noted(turned, sense):
    (note,) = doubts_on(watched(turned), [CAMERA, LIDAR])
    assert note.startswith("sensor camera: its bearings fit the other sensors' positions when ")
    assert f"counted {sense} (" in note


def positions(time: list[float], place: list[list[float]]) -> ReportTable:
    n = len(time)
    return ReportTable(
        time=np.array(time, float),
        sensor=np.zeros(n, np.int64),
        sensors=("lidar",),
        measurement=np.array(place, float),
        sigma=np.full((n, 2), np.nan),
        report=np.arange(n).astype(str).astype(object),
    )


def test_a_feed_that_comes_twice_is_noted():
    twice = positions(
        [0.0, 0.0, 1.0, 1.0, 2.0, 2.0], [[1, 2], [1, 2], [2, 2], [2, 2], [3, 2], [3, 2]]
    )
    (note,) = doubts_on(twice, [LIDAR])
    assert note.startswith("sensor lidar: 3 of 6 reports are equal to another of the same time")
    assert doubts_on(positions([0.0, 1.0, 2.0, 3.0], [[1, 2]] * 4), [LIDAR]) == []


def test_identical_times_of_all_reports_are_one_scan_and_noted():
    place = [[float(k), 0.0] for k in range(12)]
    (note,) = doubts_on(positions([3.5] * 12, place), [LIDAR])
    assert note == ("sensor lidar: all 12 reports have the time 3.5 s, so that they are one scan")
    assert doubts_on(positions([3.5] * 5, place[:5]), [LIDAR]) == []
