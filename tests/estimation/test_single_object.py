"""One object at rest, or slow in its noise, is told from false alarms and several objects."""

import numpy as np
import polars as pl
import pytest

import trackweave as tw
from trackweave.estimation.single_object import single_object

COUNT = 200


def _rest(rng: np.random.Generator, count: int = COUNT) -> np.ndarray:
    return np.asarray(rng.normal(0.0, 3.0, (count, 2)))


def _moments(rng: np.random.Generator, kind: str, count: int = COUNT) -> np.ndarray:
    if kind == "chance":
        return np.sort(rng.uniform(0.0, 5.0 * count, count))
    return np.asarray(5.0 * np.arange(count) + (rng.normal(0, 1, count) if kind == "loose" else 0))


@pytest.mark.parametrize("kind", ["even", "loose", "chance"])
@pytest.mark.parametrize("seed", range(5))
def test_reports_about_one_place_are_of_one_object(kind: str, seed: int) -> None:
    rng = np.random.default_rng(seed)
    time = np.sort(_moments(rng, kind))
    found = single_object(time, _rest(rng))
    assert found is not None
    assert found.own.mean() > 0.97
    assert found.sigma == pytest.approx(3.0, rel=0.2)
    assert found.speed == 0.0


def test_what_lies_far_off_is_of_nobody() -> None:
    rng = np.random.default_rng(3)
    position, wild = _rest(rng), np.arange(COUNT) % 25 == 0
    position[wild] = rng.uniform(-500.0, 500.0, (wild.sum(), 2))
    found = single_object(_moments(rng, "even"), position)
    assert found is not None
    np.testing.assert_array_equal(found.own, ~wild)


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("scene", ["turns", "chance", "two", "beside one that moves", "drifts"])
def test_others_are_not(scene: str, seed: int) -> None:
    rng = np.random.default_rng(seed)
    time, position = _moments(rng, "chance"), _rest(rng)
    if scene == "turns":
        position += 40.0 * np.column_stack([np.cos(time / 60.0), np.sin(time / 60.0)])
    elif scene == "chance":
        position = rng.uniform(-9.0, 9.0, (COUNT, 2))
    elif scene == "two":
        position[:, 0] += 20.0 * (rng.random(COUNT) < 0.5)
    elif scene == "drifts":
        position = np.cumsum(rng.normal(0.0, 1.0, (COUNT, 2)), axis=0)
    else:
        moves = np.arange(COUNT) % 10 == 0
        position[moves] += np.column_stack([5.0 * time[moves] - 2000.0, time[moves]])
    assert single_object(time, position) is None


def test_two_at_each_instant_are_not_one() -> None:
    rng = np.random.default_rng(1)
    assert single_object(np.repeat(np.arange(100.0), 2), _rest(rng)) is None


@pytest.mark.parametrize("place", [(0.0, 0.0), (1e3, -2e3)])
@pytest.mark.parametrize("count", [0, 9])
def test_too_few_or_all_alike_say_nothing(count: int, place: tuple[float, float]) -> None:
    assert single_object(np.arange(float(count)), np.zeros((count, 2))) is None
    assert single_object(np.arange(50.0), np.tile(place, (50, 1))) is None


@pytest.mark.parametrize("bend", [0.0, 2e-4])
@pytest.mark.parametrize("seed", range(5))
def test_a_slow_way_in_its_noise_is_of_one_object(bend: float, seed: int) -> None:
    rng = np.random.default_rng(seed)
    time = _moments(rng, "even", 60)
    position = _rest(rng, 60) + np.column_stack([0.1 * time, 0.5 * bend * time**2])
    found = single_object(time, position)
    assert found is not None
    assert found.sigma == pytest.approx(3.0, rel=0.3)
    assert 0.05 < found.speed < 0.3


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["even", "loose"])
@pytest.mark.parametrize("told", [{}, {"sigma": 1.5}, {"sigma": 3.0}, {"sigma": 6.0}])
@pytest.mark.parametrize("count", [15, 60, COUNT])
def test_a_receiver_that_lies_still_is_one_track(kind: str, told: dict, count: int) -> None:
    rng = np.random.default_rng(11)
    time = np.sort(_moments(rng, kind, count))
    table = pl.DataFrame({"time": time, **dict(zip("xy", _rest(rng, count).T, strict=True))})
    result = tw.track(table, {"sensors": {"default": told}})
    assert result.reports["track"].drop_nulls().to_list().count(1) > 0.97 * count


def test_reports_of_its_own_are_one_track_where_it_is_told_so() -> None:
    rng = np.random.default_rng(12)
    time = np.sort(_moments(rng, "loose"))
    table = pl.DataFrame({"time": time, **dict(zip("xy", _rest(rng).T, strict=True))})
    result = tw.track(table, {"sensors": {"default": {"scans": False}}})
    assert result.reports["track"].drop_nulls().value_counts()["count"].max() > 0.97 * COUNT


def test_a_noise_told_too_small_of_one_object_is_doubted_unless_trusted() -> None:
    rng = np.random.default_rng(13)
    frame = pl.DataFrame(
        {"time": np.arange(40.0), **dict(zip("xy", _rest(rng, 40).T, strict=True))}
    )
    result = tw.track(frame, {"sensors": {"default": {"sigma": 1.5}}})
    (entry,) = [each for each in result.run["told"] if each["key"] == "sensors.default.sigma"]
    assert entry["told"] == 1.5
    assert entry["used"] == pytest.approx(3.0, rel=0.3)
    assert any("sigma is told as 1.5" in note for note in result.run["notes"])
    kept = tw.track(frame, {"sensors": {"default": {"sigma": 1.5, "trust": True}}})
    assert kept.run["configuration"]["sensors"]["default"]["sigma"] == 1.5
