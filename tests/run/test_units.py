"""Numbers without a unit may be of any: what is the same but for that is tracked the same."""

import numpy as np
import polars as pl
import pytest

from trackweave import track
from trackweave.metrics import assignment_quality

pytestmark = pytest.mark.slow


def cells(seed=1):
    """Return wandering objects seen in frames, with misses and false alarms."""
    rng = np.random.default_rng(seed)
    place, rows = rng.uniform(0, 200, (15, 2)), []
    speed = rng.normal(0, 8, place.shape)
    for frame in range(60):
        speed += rng.normal(0, 1.5, speed.shape)
        place = place + 0.1 * speed
        seen = np.flatnonzero(rng.random(15) < 0.9)
        rows += [(0.1 * frame, *(place[each] + rng.normal(0, 0.3, 2)), str(each)) for each in seen]
        rows += [(0.1 * frame, *rng.uniform(0, 200, 2), "") for _ in range(rng.poisson(4))]
    return pl.DataFrame(rows, schema=["time", "x", "y", "target"], orient="row")


def collars(seed=1):
    """Return animals that report themselves by their places every 20 minutes or so."""
    rng = np.random.default_rng(seed)
    rows = []
    for each in range(8):
        time = rng.uniform(0, 1200)
        place, speed = rng.uniform(0, 5000, 2), rng.normal(0, 0.1, 2)
        while time < 120_000:
            rows.append((time, *(place + rng.normal(0, 10, 2)), str(each)))
            wait = rng.uniform(1000, 1400)
            speed = speed + rng.normal(0, 0.02, 2)
            place, time = place + speed * wait, time + wait
    return pl.DataFrame(sorted(rows), schema=["time", "x", "y", "target"], orient="row")


def quality(reports):
    result = track(reports.drop("target"))
    number = result.reports["track"].fill_null(-1).to_numpy()
    return assignment_quality(reports["target"].to_list(), number).idf1, result


@pytest.mark.parametrize(
    ("length", "moment"), [(1e3, 1.0), (1e6, 1.0), (1e-6, 1.0), (1.0, 1 / 86_400), (1e3, 1 / 60)]
)
def test_frames_are_tracked_in_any_unit(length, moment):
    reports = cells()
    usual, _ = quality(reports)
    other = reports.with_columns(pl.col("x", "y") * length, pl.col("time") * moment)
    found, result = quality(other)
    assert found > usual - 0.01
    assert not [note for note in result.run["notes"] if "stands in" in note]


@pytest.mark.parametrize("seed", [1, 2])
def test_who_reports_every_twenty_minutes_keeps_its_name(seed):
    assert quality(collars(seed))[0] > 0.95


def boats(lengths=1.0, times=1.0):
    """Return boats that two sensors see, the second with units of its own."""
    rng = np.random.default_rng(2)
    start, velocity = rng.uniform(-2e4, 2e4, (8, 2)), rng.uniform(-15, 15, (8, 2))
    parts = []
    for name, begin, length, unit in (("a", 0.0, 1.0, 1.0), ("b", 2.0, lengths, times)):
        for time in np.arange(begin, 300.0, 5.0):
            place = (start + velocity * time)[rng.random(8) < 0.9]
            place = length * (place + rng.normal(0, 20, place.shape))
            columns = {"x": place[:, 0], "y": place[:, 1]}
            parts.append(pl.DataFrame({"time": time * unit, "sensor": name, **columns}))
    return pl.concat(parts).sort("time")


@pytest.mark.parametrize(
    ("units", "words"),
    [
        ({"lengths": 1 / 1852.0}, "sensor b: its positions seem to be in nautical miles"),
        ({"lengths": 1e-3}, "kilometres"),
        ({"times": 1e3}, "sensor b: its times seem to be in milliseconds"),
    ],
)
def test_units_of_one_sensor_are_told_by_the_others(units, words):
    assert words in track(boats(**units)).run["diagnostics"][0]["sentence"]


@pytest.mark.parametrize(("name", "is_asked"), [(("x", "y"), True), (("lon", "lat"), False)])
def test_degrees_that_are_called_metres_are_asked_about(name, is_asked):
    rng = np.random.default_rng(1)
    start, velocity = rng.uniform(0, 0.1, (4, 2)), rng.uniform(-2e-5, 2e-5, (4, 2))
    parts = []
    for time in np.arange(0.0, 200.0, 10.0):
        place = [4.0, 52.0] + start + velocity * time + rng.normal(0, 1e-5, (4, 2))
        parts.append(pl.DataFrame({"time": time, name[0]: place[:, 0], name[1]: place[:, 1]}))
    causes = [each["cause"] for each in track(pl.concat(parts)).run["diagnostics"]]
    assert ("degrees" in causes) == is_asked
