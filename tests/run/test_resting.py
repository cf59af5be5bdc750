"""Objects at rest that report themselves have names of their own in hindsight."""

import numpy as np
import polars as pl
import pytest

import trackweave as tw
from trackweave.metrics import assignment_quality

pytestmark = pytest.mark.slow

SIGMA = 5.0
ALL_TOLD = {
    "motion": {"process_noise": 0.01, "max_speed": 5.0},
    "sensors": {
        "default": {
            "sigma": SIGMA, "scans": False, "detection_probability": 0.1, "clutter_density": 1e-12,
        }
    },
    "lifecycle": {"new_target_density": 1e-11, "initial_target_density": 1e-8},
}  # fmt: skip

WAITING = {**ALL_TOLD, "motion": {"process_noise": 2.0, "max_speed": 80.0}}


def moving(rng: np.random.Generator, speed: float) -> tuple[np.ndarray, np.ndarray]:
    time = np.arange(rng.uniform(0.0, 10.0), 3600.0, 10.0)
    heading = rng.uniform(0.0, 2 * np.pi) + np.cumsum(rng.normal(0.0, 0.02, time.size))
    steps = speed * 10.0 * np.stack([np.sin(heading), np.cos(heading)], axis=1)
    return time, rng.uniform(-3000.0, 3000.0, 2) + np.cumsum(steps, axis=0)


def lying(rng: np.random.Generator, where: tuple[float, float]) -> tuple[np.ndarray, np.ndarray]:
    interval = rng.uniform(20.0, 120.0)
    time = np.cumsum(interval * (1.0 + 0.01 * rng.standard_normal(int(3600 / interval))))
    time = time[rng.random(time.size) < 0.85]
    return time, np.tile(where, (time.size, 1))


def harbour(seed: int, count: int, apart: float, slow: float | None = None) -> pl.DataFrame:
    """Return an hour of four that move and some that lie beside each other."""
    rng = np.random.default_rng(seed)
    objects = [moving(rng, speed) for speed in (3.0, 5.0, 8.0, slow or 6.0)]
    objects += [lying(rng, (k * apart, 0.0)) for k in range(count)]
    rows = [
        (when, *(place + rng.normal(0.0, SIGMA, 2)), str(number))
        for number, (time, places) in enumerate(objects)
        for when, place in zip(time, places, strict=True)
    ]
    table = pl.DataFrame(rows, ["time", "x", "y", "target"], orient="row").sort("time")
    return table.with_columns(pl.col("time").round(1), pl.col("x", "y").round(2))


def idf1(table: pl.DataFrame, result: tw.TrackingResult) -> float:
    found = assignment_quality(table["target"].to_list(), result.reports["track"].to_list()).idf1
    assert found is not None
    return found


@pytest.fixture(scope="module")
def crowded() -> tuple[pl.DataFrame, tw.TrackingResult]:
    table = harbour(2, 5, 14.0)
    return table, tw.track(table.drop("target"))


def test_those_side_by_side_have_names_of_their_own(crowded):
    table, result = crowded
    as_it_went = tw.track(table.drop("target"), {"lifecycle": {"join": False}})
    assert as_it_went.run["resting"] is None
    assert idf1(table, as_it_went) < 0.9
    assert idf1(table, result) > 0.97
    told = result.run["resting"]
    assert told["places"] == 1
    assert len(told["tracks"]) == 5
    assert sum("at rest" in note for note in result.run["notes"]) == 1


def test_history_has_the_same_names_and_lies_where_they_lie(crowded):
    _, result = crowded
    history = result.history.filter(pl.col("track").is_in(result.run["resting"]["tracks"]))
    assert set(history["status"]) <= {"confirmed", "coasting"}
    places = history.group_by("track").agg(pl.col("x", "y").median()).sort("x")
    assert np.allclose(places["x"], 14.0 * np.arange(5), atol=4.0)
    assert np.allclose(places["y"], 0.0, atol=4.0)


def test_probabilities_are_those_of_now(crowded):
    _, result = crowded
    own = result.assignments.filter(pl.col("track").is_in(result.run["resting"]["tracks"]))
    probability = own["probability"]
    assert probability.null_count() == 0
    assert probability.min() > 0.0
    assert probability.max() <= 1.0


def test_who_comes_to_rest_or_leaves_keeps_its_name():
    rng, rows = np.random.default_rng(1), []

    def heard(name: str, time: np.ndarray, where: np.ndarray) -> None:
        place = where + rng.normal(0.0, SIGMA, where.shape)
        rows.extend((t, x, y, name) for t, (x, y) in zip(time, place, strict=True))

    for k in range(3):
        time = np.arange(rng.uniform(0.0, 180.0), 7200.0, 180.0)
        heard(f"moored {k}", time, np.tile((25.0 * k, 0.0), (time.size, 1)))
    for k, turn in enumerate((1500.0, 4000.0)):
        berth, out = np.array([12.5 + 25.0 * k, 20.0]), np.array([3000.0 - 6000.0 * k, 2500.0])
        way = np.arange(rng.uniform(0.0, 30.0), turn, 30.0)
        moving = berth + (out - berth) * (1.0 - way[:, np.newaxis] / turn)
        stay = np.arange(turn + rng.uniform(20.0, 180.0), 7200.0, 180.0)
        lying = np.tile(berth, (stay.size, 1))
        if k:  # this one leaves: the same backwards
            way, stay = 7200.0 - way[::-1], 7200.0 - stay[::-1]
            moving = moving[::-1]
        heard(f"ship {k}", way, moving)
        heard(f"ship {k}", stay, lying)
    table = pl.DataFrame(rows, ["time", "x", "y", "target"], orient="row").sort("time")
    table = table.with_columns(pl.col("time").round(1), pl.col("x", "y").round(2))
    result = tw.track(table.drop("target"), ALL_TOLD)
    told = result.run["resting"]
    assert told is not None
    assert idf1(table, result) > 0.97
    assert len(told["tracks"]) == 5


def test_who_waits_in_a_queue_and_goes_on_keeps_its_name():
    rng, rows = np.random.default_rng(4), []
    for k in range(10):
        # Taxi to the holding point, wait beside others, take off.
        wait, begin = 100.0 + rng.uniform(0.0, 30.0), 60.0 * k
        since = np.cumsum(1.0 + rng.normal(0.0, 0.05, int(wait + 150.0)))
        taxied, gone = np.clip(since, 0.0, 90.0), np.clip(since - 90.0 - wait, 0.0, None)
        x = -9.0 * (90.0 - taxied) + 20.0 * (k % 3)
        place = np.stack([x + 2.0 * gone, 1.2 * gone**1.5], axis=1)
        seen = place + rng.normal(0.0, SIGMA, place.shape)
        rows += [(begin + t, *at, f"aircraft {k}") for t, at in zip(since, seen, strict=True)]
    table = pl.DataFrame(rows, ["time", "x", "y", "target"], orient="row").sort("time")
    result = tw.track(table.drop("target"), WAITING)
    assert result.run["resting"] is None
    assert idf1(table, result) > 0.85


def test_who_moves_slowly_is_left_as_it_was():
    table = harbour(3, 0, 0.0, slow=0.2)
    told = {**ALL_TOLD, "motion": {"process_noise": 1.0, "max_speed": 10.0}}
    result = tw.track(table.drop("target"), told)
    assert result.run["resting"] is None
    assert idf1(table, result) > 0.97


def test_identities_tell_who_is_who():
    table = harbour(2, 4, 14.0)
    result = tw.track(table.rename({"target": "identity"}))
    assert result.run["resting"] is None


def test_scans_are_left_as_they_were():
    rng = np.random.default_rng(1)
    rows = [
        (float(scan), 12.0 * k + rng.normal(0.0, SIGMA), rng.normal(0.0, SIGMA))
        for scan in range(60)
        for k in range(3)
    ]
    result = tw.track(pl.DataFrame(rows, ["time", "x", "y"], orient="row"))
    assert result.run["resting"] is None


def test_scraps_are_joined_though_what_speaks_for_them_goes_in_circles():
    # Process noise is told so far too small that tracks break at each turn.
    motion = {**ALL_TOLD["motion"], "trust": True}
    result = tw.track(harbour(3, 0, 0.0, slow=0.2).drop("target"), {**ALL_TOLD, "motion": motion})
    assert result.run["joins"]["list"]
    assert all(0.0 <= each["probability"] <= 1.0 for each in result.run["joins"]["list"])


def test_who_is_seen_aside_for_a_while_stays_one():
    """A tag that reflections put elsewhere for seconds, time and again."""
    rng = np.random.default_rng(3)
    time = np.cumsum(1.0 + 0.05 * rng.standard_normal(600))
    time = time[rng.random(time.size) < 0.9]
    places = np.zeros((time.size, 2))
    for begin in np.arange(40.0, 580.0, 40.0):
        places[(time >= begin) & (time < begin + 12.0)] = rng.normal(0.0, 40.0, 2)
    places += rng.normal(0.0, SIGMA, places.shape)
    rows = [(when, *where, "tag") for when, where in zip(time, places, strict=True)]
    sailing = zip(*moving(rng, 5.0), strict=True)
    rows += [(when, *where, "mover") for when, where in sailing if when < 600.0]
    table = pl.DataFrame(rows, ["time", "x", "y", "target"], orient="row").sort("time")
    result = tw.track(table.drop("target"), ALL_TOLD)
    assert result.run["resting"] is None
