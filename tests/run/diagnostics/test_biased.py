"""Where biases cannot be looked for, a sensor that sees objects beside others is told of."""

from dataclasses import replace

import numpy as np
import polars as pl
import pytest

from run.diagnostics.scenes import case_of, positions
from trackweave import track
from trackweave.run import sighting
from trackweave.run.diagnostics.biased import biased_sensors

pytestmark = pytest.mark.slow

SITES = {"a": (-1000.0, 0.0), "b": (300.0, -1200.0)}


@pytest.fixture
def torn(monkeypatch):
    """Let no track of one sensor stand out, so that biases in a crowd are not looked for."""
    monkeypatch.setattr(sighting, "_stand_out", lambda *told: False)


def said(reports, config):
    """Return what is said of biases: the sensor and the number."""
    found = track(reports, config).run["diagnostics"]
    return [(each["sensor"], each["seen"]) for each in found if each["cause"] == "bias"]


def crowd(shift=0.0):
    """Return reports of two sensors, one moved to the east, of objects that crowd."""
    rng = np.random.default_rng(8)
    start, velocity = rng.uniform(0, 600, (60, 2)), rng.normal(0, 15, (60, 2))
    parts = []
    for name, moved, begin in (("a", 0.0, 0.0), ("b", shift, 0.4)):
        for time in begin + np.arange(20.0):
            place = (start + velocity * time + (moved, 0.0))[rng.random(60) < 0.95]
            x, y = (place + rng.normal(0, 2.0, place.shape)).T
            parts.append(pl.DataFrame({"time": time, "sensor": name, "x": x, "y": y}))
    return pl.concat(parts).sort("time")


def in_ranges(reports, turn, sites=SITES):
    """Return the same as ranges and azimuths, those of one sensor too great by an angle [deg]."""
    east, north = (
        pl.col(axis) - pl.col("sensor").replace_strict({n: at[i] for n, at in sites.items()})
        for i, axis in enumerate("xy")
    )
    wrong = turn * (pl.col("sensor") == "b").cast(pl.Float64)
    return reports.select(
        "time",
        "sensor",
        range_m=(east**2 + north**2).sqrt(),
        azimuth_deg=(pl.arctan2(east, north).degrees() + wrong) % 360.0,
    )


@pytest.mark.usefixtures("torn")
def test_positions_beside_those_of_others_are_told_in_a_crowd():
    ((_, seen),) = said(crowd(8.0), {"sensors": {"default": {"sigma": 2.0, "scan_period": 1.0}}})

    assert abs(seen) == pytest.approx(8.0, abs=1.0)


@pytest.mark.usefixtures("torn")
@pytest.mark.parametrize("turn", [0.0, 0.4])
def test_a_sensor_that_is_turned_is_told_in_a_crowd_and_no_other(turn):
    sigma = {"range_m": 2.0, "azimuth_deg": 0.1}
    own = {"sigma": sigma, "scan_period": 1.0}
    config = {"sensors": {name: {**own, "position": [*at]} for name, at in SITES.items()}}
    found = [(name, np.degrees(seen)) for name, seen in said(in_ranges(crowd(), turn), config)]

    assert found == ([("b", pytest.approx(turn, abs=0.1))] if turn else [])


@pytest.mark.usefixtures("torn")
@pytest.mark.parametrize("late", [-1.0])
def test_a_clock_that_differs_is_told_in_seconds(late):
    # Each of the objects is off its own way, so that no place and no angle explains it.
    sigma = {"range_m": 2.0, "azimuth_deg": 0.1}
    own = {"sigma": sigma, "scan_period": 1.0}
    config = {"sensors": {name: {**own, "position": [*at]} for name, at in SITES.items()}}
    reports = in_ranges(crowd(), 0.0)
    is_b = pl.col("sensor") == "b"
    stamped = reports.with_columns(time=pl.col("time") + late * is_b.cast(pl.Float64))
    ((sensor, seen),) = said(stamped.sort("time"), config)

    assert seen == pytest.approx(late if sensor == "b" else -late, abs=0.1)


@pytest.mark.usefixtures("torn")
def test_a_radar_that_stands_elsewhere_is_told_where_its_objects_seem_to_be():
    own = {"sigma": {"range_m": 2.0, "azimuth_deg": 0.1}, "scan_period": 1.0}
    # In the midst of their objects, so that no range and no azimuth explains it.
    right = {"a": (0.0, 250.0), "b": (600.0, 350.0)}
    told = {**right, "b": (608.0, 350.0)}
    config = {"sensors": {name: {**own, "position": [*at]} for name, at in told.items()}}
    ((sensor, seen),) = said(in_ranges(crowd(), 0.0, right), config)

    assert seen == pytest.approx(8.0 if sensor == "b" else -8.0, abs=0.5)


def test_in_a_crowd_whose_tracks_stand_out_what_is_wrong_is_taken_out():
    run = track(crowd(8.0), {"sensors": {"default": {"sigma": 2.0, "scan_period": 1.0}}}).run
    found = run["registration"]["sensors"]["b"]["translation"]["used"]
    assert found == [pytest.approx(8.0, abs=0.5), 0.0]
    assert run["diagnostics"] == []


def test_a_wrong_place_is_no_wrong_clock_where_all_fly_one_way():
    """What flies east lies as far off under a clock that is behind."""
    rng = np.random.default_rng(3)
    start = rng.uniform(-60e3, 60e3, (24, 2))
    velocity = rng.uniform((130.0, -80.0), (230.0, 80.0), (24, 2))
    sites, parts = {"a": (0.0, 30e3), "b": (5e3, -25e3)}, []
    for name, begin in (("a", 0.0), ("b", 2.0)):
        for time in begin + np.arange(0.0, 300.0, 5.0):
            away = (start + velocity * time - sites[name])[rng.random(24) < 0.95]
            azimuth = np.degrees(np.arctan2(*away.T)) + rng.normal(0, 0.08, len(away))
            measured = np.hypot(*away.T) + rng.normal(0, 70, len(away)), azimuth % 360.0
            columns = dict(zip(("range_m", "azimuth_deg"), measured, strict=True))
            parts.append(pl.DataFrame({"time": time, "sensor": name, **columns}))
    none = {"range_bias_m": 0.0, "range_scale": 1.0, "azimuth_bias_deg": 0.0, "clock_offset": 0.0}
    sigma = {"range_m": 70.0, "azimuth_deg": 0.08}
    own = {"sigma": sigma, "scan_period": 5.0, **none, "trust": True}
    told = {"a": {**own, "position": [0.0, 30e3]}, "b": {**own, "position": [6300.0, -25e3]}}
    found = track(pl.concat(parts).sort("time"), {"sensors": told}).run["diagnostics"]
    (first,) = [each for each in found if each["cause"] in {"clock", "offset", "bias"}]

    assert first["cause"] != "clock"
    assert abs(first["seen"]) == pytest.approx(1300.0, abs=100.0)


def test_posts_that_two_sensors_see_one_after_the_other_are_no_others_beside():
    # A car passes a post each second; the one looks far ahead, the other at what is near.
    time, place, sensor, post = [], [], [], []
    rng = np.random.default_rng(2)
    for look in range(240):
        now = 0.1 * look
        for each in range(30):
            is_seen = (each - 7 <= now < each - 2, each - 1.5 <= now < each)
            for which in np.flatnonzero(is_seen):
                time.append(now)
                place.append(rng.normal([6.0, 20.0 * each], 0.5))
                sensor.append(which)
                post.append(each)
    table = positions(time, place, sensor, ("far", "near"))
    case = replace(case_of(table), unregistered={"far": "it moves", "near": "it moves"})
    assert list(biased_sensors(case)) == []
    assert list(biased_sensors(replace(case, track=np.array(post)))) == []
