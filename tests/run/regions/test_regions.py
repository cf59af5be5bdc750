"""Regions on workers give one picture, whoever does the work."""

import os
import signal
import threading
import time
from multiprocessing import active_children

import numpy as np
import polars as pl
import pytest

import trackweave as tw
from trackweave.errors import InvalidInputError
from trackweave.run.regions import cutting

SIDE, SPEED, SCANS = 20_000.0, 200.0, 12
CONFIG = {
    "motion": {"process_noise": 1.0, "max_speed": 300.0},
    "sensors": {"default": {"sigma": 20.0, "detection_probability": 0.95, "scan_period": 1.0,
                            "clutter_density": 1e-9}},
    "lifecycle": {"new_target_density": 1e-9},
}  # fmt: skip


def lanes(n: int, *, east: bool) -> pl.DataFrame:
    """Objects far apart on straight lines, flying north or, across the cut, east."""
    rng = np.random.default_rng(3)
    x = np.linspace(-SIDE, SIDE, n) + 137.0
    y = rng.permutation(np.linspace(-SIDE / 8, SIDE / 8, n))
    rows = []
    for scan in range(SCANS):
        move = SPEED * scan
        at = np.column_stack([x + (move if east else 0.0), y + (0.0 if east else move)])
        seen = rng.random(n) < 0.95
        for number in np.flatnonzero(seen):
            place = at[number] + rng.normal(0.0, 20.0, 2)
            rows.append((float(scan), place[0], place[1], int(number)))
    return pl.DataFrame(rows, schema=["time", "x", "y", "target"], orient="row")


def ships(n: int, pause: float) -> tuple[pl.DataFrame, dict]:
    """Ships that report by themselves, and pass the cut both ways between two of their reports."""
    rng = np.random.default_rng(1)
    # Buoys keep the window short.
    buoys = [(-25e3, -9e3), (25e3, 130e3), (-25e3, 130e3), (25e3, -9e3)]
    rows = [(5.0 * k, *(buoys[k % 4] + rng.normal(0.0, 8.0, 2)).tolist(), -1 - k % 4)
            for k in range(720)]  # fmt: skip
    for number in range(n):
        at, ahead = np.array([60e3 * number / (n - 1) - 30e3, 6e3 * number]), (-1) ** number
        time = rng.uniform(0.0, pause)
        while time < 3600.0:
            way = np.array([15.0 * ahead * time, 0.0])
            place = at + way + rng.normal(0.0, 8.0, 2)
            rows.append((float(int(time)), *place.tolist(), number))
            time += pause * rng.uniform(0.8, 1.2)
    heard = {"sigma": 8.0, "detection_probability": 0.9, "clutter_density": 1e-13, "scans": False}
    config = {"motion": {"process_noise": 0.01, "max_speed": 25.0}, "sensors": {"default": heard},
              "lifecycle": {"new_target_density": 1e-12}, "window": {"depth": 2}}  # fmt: skip
    return pl.DataFrame(sorted(rows), schema=["time", "x", "y", "target"], orient="row"), config


@pytest.fixture
def small(monkeypatch):
    """Regions of few reports."""
    monkeypatch.setattr(cutting, "LEAST", 100)
    monkeypatch.setattr(cutting, "CROWD", 0)


def partition(result):
    """Return the sets of reports of each track."""
    sets = {}
    for row, track in result.values.assignment.items():
        sets.setdefault(track, set()).add(row)
    return {frozenset(each) for each in sets.values()}


def test_objects_that_cross_the_cut_keep_one_name(small):
    reports = lanes(40, east=True)
    alone = tw.track(reports, CONFIG)
    apart = tw.track(reports, CONFIG, engine="local", workers=2)
    assert apart.run["regions"]["count"] > 1
    assert apart.run["regions"]["joined"] > 0
    assert partition(apart) == partition(alone)
    assert apart.history.height == alone.history.height
    keys = ["time", "x", "y", "vx", "vy"]
    one, two = alone.tracks.sort(keys[:3]), apart.tracks.sort(keys[:3])
    assert one.height == two.height
    np.testing.assert_allclose(one.select(keys), two.select(keys), atol=1e-6)


def test_reports_that_tell_more_than_places_are_tracked_as_by_one_process(small):
    reports = lanes(40, east=True).with_columns(
        height_m=1_000.0 + 300.0 * pl.col("target"), strength=20.0 + pl.col("target") % 3,
        identity=pl.format("MMSI {}", "target"), sigma=pl.lit(20.0),
    )  # fmt: skip
    alone = tw.track(reports, CONFIG)
    apart = tw.track(reports, CONFIG, engine="local", workers=2)
    assert apart.run["regions"]["count"] > 1
    assert partition(apart) == partition(alone)


@pytest.mark.slow
def test_the_same_bytes_for_any_number_of_workers_and_after_a_kill(small):
    reports = lanes(40, east=True)
    first = tw.track(reports, CONFIG, engine="local", workers=1)
    stop, killed = threading.Event(), []

    def kill() -> None:
        while not stop.is_set() and len(killed) < 1:
            for child in active_children()[:1]:
                time.sleep(0.3)
                os.kill(child.pid, signal.SIGKILL)
                killed.append(child.pid)
            time.sleep(0.02)

    thread = threading.Thread(target=kill)
    thread.start()
    second = tw.track(reports, CONFIG, engine="local", workers=2)
    stop.set()
    thread.join()
    assert killed
    for name in ("tracks.csv", "assignments.csv", "history.csv"):
        assert first.files()[name] == second.files()[name]


@pytest.mark.slow
def test_ships_that_report_by_themselves_are_those_of_one_process(small):
    reports, config = ships(20, pause=250.0)
    alone, apart = tw.track(reports, config), tw.track(reports, config, engine="local", workers=2)
    assert apart.run["regions"]["count"] > 1
    assert apart.run["regions"]["joined"] > 0
    assert len(partition(alone)) == 24
    assert partition(apart) == partition(alone)
    assert apart.tracks.height == alone.tracks.height


def test_a_recording_of_one_region_is_as_without_an_engine():
    reports = lanes(12, east=False)
    alone, engine = tw.track(reports, CONFIG), tw.track(reports, CONFIG, engine="local", workers=2)
    assert engine.run["regions"]["count"] == 1
    for name in ("tracks.csv", "assignments.csv", "history.csv"):
        assert alone.files()[name] == engine.files()[name]


def test_regions_cover_the_plane_once_and_hold_alike_many():
    rng = np.random.default_rng(1)
    position = rng.normal(0.0, 1e6, (60_000, 2))
    regions = cutting.cut(position, 100.0)
    inside = np.array([region.holds(position) for region in regions])
    assert len(regions) > 4
    assert np.all(inside.sum(axis=0) == 1)
    assert inside.sum(axis=1).min() >= cutting.LEAST
    far = np.array([[1e9, -1e9], [-1e9, 0.0]])
    assert np.all(sum(region.holds(far).astype(int) for region in regions) == 1)


def test_a_scan_of_which_nothing_is_left_is_still_a_scan():
    scan = tw.Scan(3.0, "a", [[1.0, 2.0], [5.0, 6.0]], report=[7, 4], moments=[2.0, 3.0])
    none, number = np.array([False, False]), np.array([0, 0])
    empty = cutting.part_of(scan, tw.Sensor("a"), none, number)
    assert (len(empty), empty.time, empty.sensor) == (0, 3.0, "a")
    one = cutting.part_of(scan, tw.Sensor("a"), ~none & [False, True], number)
    assert one.report.tolist() == [0]
    assert one.measurement.tolist() == [[5.0, 6.0]]
    assert one.moments.tolist() == [3.0]


@pytest.mark.parametrize(
    ("sensor", "n_reports", "tells"),
    [
        (tw.Sensor("a", scans=False), 2, False),
        (tw.Sensor("a", scans=True), 1, True),
        (tw.Sensor("a"), 1, False),
        (tw.Sensor("a"), 2, True),
    ],
)
def test_a_part_of_a_scan_says_what_all_of_it_said_of_who_was_missed(sensor, n_reports, tells):
    scan = tw.Scan(3.0, "a", np.zeros((n_reports, 2)), report=np.arange(n_reports))
    for n_kept in range(n_reports + 1):
        keep = np.arange(n_reports) < n_kept
        part = cutting.part_of(scan, sensor, keep, np.arange(n_reports))
        assert (len(part), part.tells_silence) == (n_kept, tells)


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({"engine": "cloud"}, "expected local, ray"),
        ({"engine": "local", "workers": 0}, "workers: 0"),
        ({"workers": 2}, "expected an engine"),
        ({"engine": "local", "preset": "huo-2008"}, "preset"),
        ({"engine": "local", "deadline": 1.0}, "deadline"),
    ],
)
def test_refuses_what_regions_cannot_follow(given, told):
    with pytest.raises(InvalidInputError, match=told):
        tw.track(lanes(5, east=False), CONFIG, **given)


def test_refuses_reports_without_a_place():
    reports = pl.DataFrame({"time": [0.0, 1.0, 2.0], "bearing_deg": [1.0, 2.0, 3.0],
                            "sensor_x": [0.0] * 3, "sensor_y": [0.0] * 3})  # fmt: skip
    config = {"motion": CONFIG["motion"], "lifecycle": CONFIG["lifecycle"],
              "sensors": {"default": {"sigma": {"bearing_deg": 0.1}, "clutter_density": 1e-3,
                                      "detection_probability": 0.9, "scan_period": 1.0}},
              }  # fmt: skip
    with pytest.raises(InvalidInputError, match="tells no places"):
        tw.track(reports, config, engine="local", workers=1)


def test_few_reports_a_step_are_not_parted():
    rng = np.random.default_rng(1)
    position = rng.uniform(0.0, 1e6, (60_000, 2))
    crowded = np.repeat(np.arange(60), 1_000)
    assert len(cutting.cut(position, 100.0, crowded)) > 4
    lone = np.arange(60_000) // cutting.CROWD
    assert len(cutting.cut(position, 100.0, lone)) == 1
    assert "reports a step" in cutting.why_whole(position, 100.0)
    # As many in a step as there have to be, in each of two halves.
    halves = np.where(position[:, 0] < np.median(position[:, 0]), 0, 30_000)
    own = (halves + np.argsort(np.argsort(position[:, 0])) % 30_000) // cutting.CROWD
    assert len(cutting.cut(position, 100.0, own)) == 2
