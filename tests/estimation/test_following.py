"""A beam whose speed wanders is followed from turn to turn."""

import numpy as np
import pytest

from trackweave.estimation.rotation import rotation_of, wanders
from trackweave.models.rotation import FollowedRotation, Rotation


def drifting(
    *, direction: int = 1, n_objects: int = 10, odd: float = 0.03, silent: range = range(0),
    start: float = 0.0, wander: float = 0.0015, n_turns: int = 300,
):  # fmt: skip
    """Objects seen when a beam of some 4 s a turn passes them; when its turns begin."""
    rng = np.random.default_rng(3)
    place, drift = rng.uniform(0, 2 * np.pi, n_objects), rng.normal(0, 0.02, n_objects)
    time, azimuth, begins, speed = [], [], [start], 0.0
    for turn in range(n_turns):
        speed = 0.95 * speed + rng.normal(0, wander)
        length = 4.0 * (1 + speed)
        true = place + drift * turn
        when = begins[-1] + (direction * true / (2 * np.pi)) % 1.0 * length
        seen = true + rng.normal(0, 0.005, n_objects)
        seen = np.where(rng.random(n_objects) < odd, rng.uniform(0, 6, n_objects), seen)
        keep = rng.random(n_objects) < (0.0 if turn in silent else 0.9)
        time.append(when[keep])
        azimuth.append(seen[keep])
        begins.append(begins[-1] + length)
    time, azimuth = np.concatenate(time), np.concatenate(azimuth) % (2 * np.pi)
    order = np.argsort(time, kind="stable")
    return time[order], azimuth[order], np.array(begins)


def errors(found: Rotation, time, begins):
    """Return how far a turn is off at some times [turns]."""
    true = np.interp(time, begins, np.arange(begins.size))
    off = found.turned(time) + found.direction * found.phase / (2 * np.pi) - true
    return np.abs(off - np.round(off))


@pytest.mark.slow
@pytest.mark.parametrize(
    "scene",
    [
        {},
        {"direction": -1},
        {"n_objects": 3, "odd": 0.0},
        {"odd": 0.2},
        {"silent": range(100, 101)},
        {"silent": range(100, 160)},
        {"start": 1.62e9},
    ],
    ids=["", "reversed", "three", "false alarms", "a turn", "four minutes", "since 1970"],
)
def test_follows_a_turn_that_wanders(scene):
    time, azimuth, begins = drifting(**scene)
    found = rotation_of(time, azimuth)
    assert isinstance(found, FollowedRotation)
    assert found.direction == scene.get("direction", 1)
    assert found.wander == pytest.approx(np.std(np.diff(begins)) / 4.0, rel=0.3)
    off = errors(found, time, begins)
    assert np.quantile(off, 0.95) < 0.003
    assert off.max() < 0.04


def gusty(share: float, n_objects: int, *, seed: int = 3):
    """Objects seen by an antenna in the wind, each of whose turns has a length of its own."""
    rng = np.random.default_rng(seed)
    place = rng.uniform(0, 2 * np.pi, n_objects)
    begins = np.r_[0.0, np.cumsum(4.0 * (1.0 + share * rng.normal(size=300)))]
    time = begins[:-1, None] + place / (2 * np.pi) * np.diff(begins)[:, None]
    azimuth = place + rng.normal(0, 0.005, time.shape)
    keep = rng.random(time.shape) < 0.9
    order = np.argsort(time[keep], kind="stable")
    return time[keep][order], azimuth[keep][order] % (2 * np.pi), begins


@pytest.mark.parametrize("n_objects", [10, 40])
@pytest.mark.parametrize("share", [0.02, 0.05])
def test_follows_turns_each_of_which_has_a_length_of_its_own(share, n_objects):
    time, azimuth, begins = gusty(share, n_objects)
    found = rotation_of(time, azimuth)
    assert isinstance(found, FollowedRotation)
    assert found.wander == pytest.approx(share, rel=0.3)
    off = errors(found, time, begins)
    assert np.quantile(off, 0.95) < 0.01
    assert off.max() < 0.05


@pytest.mark.parametrize("told", [3.8, 4.0, 4.2])
def test_a_period_told_wrongly_does_no_harm(told):
    time, azimuth, begins = drifting()
    found = rotation_of(time, azimuth, period=told)
    assert found is not None
    assert errors(found, time, begins).max() < 0.01
    assert found.period == pytest.approx(np.median(np.diff(begins)), rel=0.005)


@pytest.mark.parametrize("n_objects", [2, 5, 30])
def test_a_steady_turn_stays_one(n_objects):
    time, azimuth, begins = drifting(wander=0.0, n_objects=n_objects, odd=0.1)
    found = rotation_of(time, azimuth)
    assert type(found) is Rotation
    assert not wanders(time, azimuth, found)
    assert errors(found, time, begins).max() < 0.001


def test_a_followed_beam_never_turns_back_and_goes_on_for_ever():
    time, azimuth, _ = drifting(silent=range(100, 130))
    found = rotation_of(time, azimuth)
    moments = np.linspace(time[0] - 100.0, time[-1] + 100.0, 20_000)
    turned = found.turned(moments)
    assert np.all(np.diff(turned) > 0)
    np.testing.assert_allclose(found.when(turned), moments, atol=1e-6)
    assert np.diff(turned[[-1, -1_000]])[0] == pytest.approx(
        (moments[-1_000] - moments[-1]) / found.period
    )


def test_each_object_is_in_a_turn_once():
    time, azimuth, begins = drifting(odd=0.0)
    found = rotation_of(time, azimuth)
    place = np.searchsorted(begins, time, side="right")
    turn = np.floor(found.turned(time) + 1e-3)
    assert np.mean(turn - turn[0] == place - place[0]) > 0.99
