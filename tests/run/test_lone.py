"""Reports of sensors that do not look, from the table to the tracks."""

import numpy as np
import polars as pl
import pytest

import trackweave as tw
from trackweave import track
from trackweave.errors import InvalidInputError
from trackweave.metrics import assignment_quality

pytestmark = pytest.mark.slow


def table(n_objects=8, until=240.0):
    """Return objects that report each at its own pace, stamps in whole seconds."""
    rng = np.random.default_rng(1)
    rows = []
    for number in range(n_objects):
        place, speed = np.array([0.0, 900.0 * number]), np.array([5.0 * (number % 2), 0.0])
        pause = rng.uniform(4, 12)
        time = rng.uniform(0, pause)
        while time < until:
            spot = place + speed * time + rng.normal(0, 5, 2)
            rows.append((float(int(time)), *spot.tolist(), number))
            time += pause * rng.uniform(0.8, 1.2)
    return pl.DataFrame(sorted(rows), schema=["time", "x", "y", "target"], orient="row")


def test_stamps_in_whole_seconds_are_no_scans():
    reports = table()
    result = track(reports)
    tracks = result.reports.group_by("target").agg(pl.col("track").n_unique())
    assert result.reports["track"].n_unique() == 8
    assert tracks["track"].to_list() == [1] * 8
    sensor = result.run["configuration"]["sensors"]["default"]
    assert sensor["scans"] is False
    assert sensor["scan_period"] is None
    (note,) = [each for each in result.run["notes"] if "taken for one that does not scan" in each]
    assert note.endswith("if it looks, give scans = true")


def test_who_said_that_a_sensor_does_not_look_is_not_asked_again():
    result = track(table(), {"sensors": {"default": {"scans": False}}})
    (note,) = [each for each in result.run["notes"] if "does not scan, as is told" in each]
    assert "scans = true" not in note


def test_rows_of_tracks_are_as_far_apart_as_reports_of_an_object():
    times = np.unique(track(table()).tracks["time"].to_numpy())
    assert 3.0 <= np.median(np.diff(times)) <= 13.0


def beside_a_radar(moved=0.0):
    """Return the same objects also seen by one that scans, whose places are off to the east."""
    rng = np.random.default_rng(2)
    moments = np.arange(0.5, 240.0, 3.0)
    row, number = np.repeat(np.arange(moments.size), 8), np.tile(np.arange(8), moments.size)
    x = moved + 5.0 * (number % 2) * moments[row] + rng.normal(0, 5, row.size)
    y = 900.0 * number + rng.normal(0, 5, row.size)
    radar = pl.DataFrame({"time": moments[row], "x": x, "y": y, "sensor": "radar"})
    heard = table().drop("target").with_columns(sensor=pl.lit("ais"))
    return pl.concat([radar, heard], how="diagonal").sort("time")


def test_beside_a_sensor_that_scans_rows_are_as_far_apart_as_its_scans():
    """Not one at each of the others' reports."""
    result = track(beside_a_radar())

    assert result.run["configuration"]["sensors"]["ais"]["scans"] is False
    assert result.run["configuration"]["output"]["period"] == pytest.approx(3.0)
    times = np.unique(result.tracks["time"].to_numpy())
    assert np.diff(times)[:-1].min() >= 2.0  # but for those at the end


def test_a_radar_that_is_off_is_told_beside_those_that_report_themselves():
    found = track(beside_a_radar(moved=400.0)).run["diagnostics"]
    (offset,) = [each for each in found if each["cause"] == "offset"]

    assert offset["seen"] == pytest.approx(400.0, abs=20.0)


def test_what_is_told_of_a_sensor_counts_before_what_its_reports_show():
    result = track(table(), {"sensors": {"default": {"scan_period": 1.0}}})
    assert result.run["configuration"]["sensors"]["default"]["scans"] is True
    few = table(n_objects=1, until=40.0)
    result = track(few, {"sensors": {"default": {"scans": False}}})
    assert result.run["configuration"]["sensors"]["default"]["scans"] is False


def test_refuses_a_scan_period_of_a_sensor_that_does_not_scan():
    told = {"sensors": {"default": {"scans": False, "scan_period": 2.0}}}
    with pytest.raises(InvalidInputError, match="scans = true with a scan_period"):
        track(table(), told)


def test_two_ships_under_one_number_make_no_noise_of_the_others() -> None:
    """One falls silent for four minutes, one lies moored, and all keep their names."""
    rng, rows = np.random.default_rng(3), []
    ships = [  # metres east and north, m/s, seconds between messages, number
        (0, 2_000, 7.0, 0.5, 6, "111"), (2_000, 11_000, 5.5, -3.0, 10, "222"),
        (14_000, 10_000, -6.0, 1.5, 6, "222"), (8_000, 13_000, 1.0, -8.0, 6, "444"),
        (6_700, 4_500, 0.0, 0.0, 180, "555"), (1_500, 7_500, 8.0, 0.0, 6, "666"),
    ]  # fmt: skip
    for ship, (east, north, right, up, period, number) in enumerate(ships):
        for time in np.arange(rng.uniform(0, period), 1500.0, period):
            if number != "666" or not 600 < time < 840:
                place = np.array([east + right * time, north + up * time])
                rows.append((round(time), *(place + rng.normal(0.0, 5.0, 2)), number, str(ship)))
    names = ["time", "x", "y", "identity", "target"]
    result = tw.track(pl.DataFrame(rows, names, orient="row").sort("time"))
    assert 3.0 < result.run["configuration"]["sensors"]["default"]["sigma"] < 8.0
    found = result.assignments
    quality = assignment_quality(found["target"].to_list(), found["track"].to_list())
    assert quality.idf1 is not None
    assert quality.idf1 > 0.99
