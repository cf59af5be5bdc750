"""Two sensors' bearings cross in ghosts; the whole recording tells which were none."""

import numpy as np
import polars as pl
import pytest

import trackweave as tw
from trackweave.estimation.bearing_flights import Bearings
from trackweave.metrics import assignment_quality
from trackweave.run.deghosting import unbroken

pytestmark = pytest.mark.slow

SIGMA_DEG = 0.2


def recording(seed: int, count: int, stands=((0.0, 0.0), (3000.0, 0.0))) -> pl.DataFrame:
    """Return a minute of bearings of objects that go straight."""
    rng = np.random.default_rng(seed)
    place, velocity = rng.uniform(500.0, 2500.0, (count, 2)), rng.uniform(-12.0, 12.0, (count, 2))
    rows = []
    for now in np.arange(60.0):
        for name, (x, y) in enumerate(stands):
            for each in rng.permutation(count):
                east, north = place[each] + now * velocity[each] - (x, y)
                angle = np.degrees(np.arctan2(east, north)) + rng.normal(0.0, SIGMA_DEG)
                rows.append((now, f"s{name}", angle % 360.0, x, y, str(each)))
    names = ["time", "sensor", "bearing_deg", "sensor_x", "sensor_y", "target"]
    return pl.DataFrame(rows, names, orient="row")


def tracked(table: pl.DataFrame, config=None) -> tuple[tw.TrackingResult, float]:
    result = tw.track(table.drop("target"), config)
    idf1 = assignment_quality(table["target"].to_list(), result.reports["track"].to_list()).idf1
    assert idf1 is not None
    return result, idf1


@pytest.mark.parametrize(("seed", "count"), [(2, 2), (0, 3)])
def test_two_sensors_tell_objects_from_ghosts(seed, count):
    table = recording(seed, count)
    _, as_it_went = tracked(table, {"lifecycle": {"join": False}})
    result, idf1 = tracked(table)
    assert as_it_went < 0.7
    assert idf1 > 0.95
    told = result.run["ghosts"]
    assert len(told["tracks"]) >= 2
    assert told["gain"] > 3.0
    assert any("ghosts of two sensors' bearings" in each for each in result.run["notes"])


def test_history_follows_the_names_of_hindsight():
    table = recording(2, 2)
    rng = np.random.default_rng(2)
    place, velocity = rng.uniform(500.0, 2500.0, (2, 2)), rng.uniform(-12.0, 12.0, (2, 2))
    result, _ = tracked(table)
    for name in result.history["track"].unique():
        own = result.history.filter(pl.col("track") == name)
        path = place + own["time"].to_numpy()[:, None, None] * velocity
        off = np.hypot(*(own.select("x", "y").to_numpy()[:, None] - path).transpose(2, 0, 1))
        assert np.median(off, axis=0).min() < 15.0


def test_a_told_process_noise_is_kept():
    result, idf1 = tracked(recording(0, 2), {"motion": {"process_noise": 0.02}})
    assert idf1 > 0.95
    assert result.run["ghosts"]["process_noise"] in {0.02, 0.02e-3}


@pytest.mark.parametrize("stands", [((0.0, 0.0),), ((0.0, 0.0), (3000.0, 0.0), (0.0, 3000.0))])
def test_nothing_is_asked_but_of_two_sensors(stands):
    result, _ = tracked(recording(0, 2, stands))
    assert result.run["ghosts"] is None


def test_two_sensors_at_one_place_tell_nothing():
    result, _ = tracked(recording(0, 2, ((0.0, 0.0), (0.0, 0.0))))
    assert result.run["ghosts"] is None


def test_what_breaks_off_and_goes_on_is_one():
    time = np.repeat(np.arange(40.0), 2)
    sensor = np.tile([0, 1], 40)
    angle = np.where(sensor == 0, 0.5 + 0.01 * time, 6.0 - 0.004 * time)
    bearings = Bearings(time, np.zeros((80, 2)), angle, np.full(80, 0.003))
    track = np.where(time < 15, 3, np.where(time < 18, -1, 8))
    expected = np.where(track < 0, -1, 3)
    assert np.array_equal(unbroken(bearings, sensor, track), expected)
    # One that begins elsewhere for one of the sensors is another's.
    turned = bearings._replace(angle=angle + 0.2 * ((sensor == 1) & (time > 16)))
    assert np.array_equal(unbroken(turned, sensor, track), track)
