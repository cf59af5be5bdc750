"""Where biases cannot be looked for, a sensor that sees objects beside others is told of."""

import numpy as np
import polars as pl
import pytest

from trackweave import track

SITES = {"a": (-1000.0, 0.0), "b": (300.0, -1200.0)}


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


def in_ranges(reports, turn):
    """Return the same as ranges and azimuths, those of one sensor too great by an angle [deg]."""
    east, north = (
        pl.col(axis) - pl.col("sensor").replace_strict({n: at[i] for n, at in SITES.items()})
        for i, axis in enumerate("xy")
    )
    wrong = turn * (pl.col("sensor") == "b").cast(pl.Float64)
    return reports.select(
        "time",
        "sensor",
        range_m=(east**2 + north**2).sqrt(),
        azimuth_deg=(pl.arctan2(east, north).degrees() + wrong) % 360.0,
    )


def test_positions_beside_those_of_others_are_told_in_a_crowd():
    ((_, seen),) = said(crowd(8.0), {"sensors": {"default": {"sigma": 2.0, "scan_period": 1.0}}})

    assert abs(seen) == pytest.approx(8.0, abs=1.0)


@pytest.mark.parametrize("turn", [0.0, 0.4])
def test_a_sensor_that_is_turned_is_told_in_a_crowd_and_no_other(turn):
    sigma = {"range_m": 2.0, "azimuth_deg": 0.1}
    own = {"sigma": sigma, "scan_period": 1.0}
    config = {"sensors": {name: {**own, "position": [*at]} for name, at in SITES.items()}}
    found = [(name, np.degrees(seen)) for name, seen in said(in_ranges(crowd(), turn), config)]

    assert found == ([("b", pytest.approx(turn, abs=0.1))] if turn else [])


@pytest.mark.parametrize("late", [-1.0, 1.0])
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
