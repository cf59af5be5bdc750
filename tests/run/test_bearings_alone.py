"""Bearings of several stations and nothing else: what they tell by being tracked."""

from typing import Any

import numpy as np
import polars as pl
import pytest

import trackweave as tw
from trackweave.metrics import assignment_quality

pytestmark = pytest.mark.slow

STATIONS = np.array([[-3000.0, -2000.0], [4000.0, -2500.0], [500.0, 4500.0]])
SIGMA = 0.5  # Degrees


def bearings(
    seed: int, *, seconds: int = 60, sigma: float = SIGMA, scale: float = 1.0, period: float = 1.0
) -> tuple[pl.DataFrame, Any]:
    """Return what three stations report of three objects and of nobody, and whose each is."""
    # Everything is ``scale`` times as far away, and looked at every ``period`` seconds.
    rng = np.random.default_rng(seed)
    place, velocity = scale * rng.uniform(-2500, 2500, (3, 2)), rng.normal(0, 12, (3, 2))
    velocity *= scale / period
    rows, whose = [], []
    for second in period * np.arange(seconds):
        for number, station in enumerate(scale * STATIONS):
            east, north = (place + second * velocity - station).T
            seen = np.flatnonzero(rng.uniform(size=3) < 0.9)
            angles = np.degrees(np.arctan2(east, north))[seen] + rng.normal(0, sigma, seen.size)
            false = rng.uniform(0, 360, rng.poisson(0.5))
            whose += [*map(str, seen), *([""] * false.size)]
            for angle in (*angles, *false):
                rows.append((float(second), f"s{number}", angle % 360.0, *station))
    columns = ["time", "sensor", "bearing_deg", "sensor_x", "sensor_y"]
    return pl.DataFrame(rows, schema=columns, orient="row"), whose


def quality(result: tw.TrackingResult[Any], whose: list[str]) -> float:
    track = result.assignments["track"].fill_null(-1).to_numpy()
    return float(assignment_quality(whose, track).idf1)


@pytest.mark.parametrize("seed", [2])
def test_all_that_a_run_needs_is_learned(seed):
    reports, whose = bearings(seed)
    result = tw.track(reports)
    assert quality(result, whose) > 0.85
    used, sources = result.run["configuration"], result.run["sources"]
    for number in range(3):
        sensor = used["sensors"][f"s{number}"]
        assert 0.5 <= sensor["sigma"]["bearing_deg"] / SIGMA <= 2.0
        assert 0.8 <= sensor["detection_probability"] <= 0.96
        # Half a false alarm a scan, from all around.
        assert 0.5 <= sensor["clutter_density"] / (0.5 / (2 * np.pi)) <= 1.7
    estimated = ("motion.process_noise", "motion.max_speed", "lifecycle.new_target_density")
    assert {sources[key] for key in estimated} == {"estimated"}
    assert not any("do not tell" in note for note in result.run["notes"])


def test_noise_that_rows_tell_is_theirs():
    reports, _ = bearings(3, seconds=30)
    result = tw.track(reports.with_columns(sigma_bearing_deg=pl.lit(SIGMA)))
    assert result.run["sources"]["sensors.s0.sigma"] == "default"
    assert not any("do not tell" in note for note in result.run["notes"])


def test_what_is_told_stays():
    reports, _ = bearings(3, seconds=30)
    told = {
        "motion": {"process_noise": 0.3},
        "sensors": {"default": {"sigma": {"bearing_deg": 0.7}, "clutter_density": 0.2}},
    }
    result = tw.track(reports, told)
    used = result.run["configuration"]
    assert used["motion"]["process_noise"] == 0.3
    assert used["sensors"]["s1"]["sigma"] == {"bearing_deg": 0.7}
    assert used["sensors"]["s1"]["clutter_density"] == 0.2
    assert result.run["sources"]["sensors.s1.detection_probability"] == "estimated"


@pytest.mark.parametrize(
    "some",
    [
        lambda reports: reports.head(20),
        lambda reports: reports.filter(pl.col("sensor") == "s0"),
        lambda reports: reports.with_columns(sensor_x=pl.lit(0.0), sensor_y=pl.lit(0.0)),
    ],
    ids=["few", "one station", "all at one place"],
)
def test_too_little_tells_nothing_and_says_so(some):
    result = tw.track(some(bearings(4, seconds=30)[0]))
    assert result.run["sources"]["motion.process_noise"] == "default"
    assert any("do not tell sigma" in note for note in result.run["notes"])


def test_objects_are_found_however_far():
    # Stations 190 km apart.
    reports, whose = bearings(1, scale=40.0, period=3.0)
    result = tw.track(reports)
    assert quality(result, whose) > 0.85
    view = result.run["configuration"]["sensors"]["s0"]["field_of_view"]
    assert view["max_range_m"] > 150_000
    assert any("objects are looked for up to" in note for note in result.run["notes"])


def test_objects_are_found_however_fast():
    reports, whose = bearings(2, scale=12.0, period=0.4, sigma=0.1)
    result = tw.track(reports)
    assert quality(result, whose) > 0.85
    assert result.run["configuration"]["motion"]["max_speed"] > 200


@pytest.mark.parametrize("times", [0.1])
def test_noise_that_is_told_far_off_is_not_used(times):
    reports, whose = bearings(2)
    told = {"sensors": {f"s{n}": {"sigma": {"bearing_deg": times * SIGMA}} for n in range(3)}}
    result = tw.track(reports, told)
    assert quality(result, whose) > 0.85
    used = result.run["configuration"]["sensors"]["s0"]["sigma"]["bearing_deg"]
    assert 0.4 <= used / SIGMA <= 2.5
    assert result.run["sources"]["sensors.s0.sigma"] == "estimated"
    (judged,) = [each for each in result.run["told"] if each["key"] == "sensors.s0.sigma"]
    assert judged == {
        "key": "sensors.s0.sigma",
        "told": {"bearing_deg": times * SIGMA},
        "learned": {"bearing_deg": used},
        "used": {"bearing_deg": used},
    }
    assert any("sigma is told as" in note and "is used" in note for note in result.run["notes"])


def test_noise_that_is_told_far_off_and_trusted_is_used():
    reports, _ = bearings(2, seconds=30)
    own = {"sigma": {"bearing_deg": 10.0 * SIGMA}, "trust": ["sigma"]}
    run = tw.track(reports, {"sensors": {f"s{n}": own for n in range(3)}}).run
    assert run["configuration"]["sensors"]["s0"]["sigma"] == own["sigma"]
