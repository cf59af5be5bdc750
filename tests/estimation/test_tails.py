"""Heavy tails are told from single reports far beside their own tracks, and from nothing else."""

from dataclasses import replace
from itertools import pairwise, product

import numpy as np
import pytest

from estimation.test_estimate import table
from trackweave.estimation.estimates import Estimates, SensorEstimate
from trackweave.estimation.refine import Followed
from trackweave.estimation.tails import (
    LEAST_SHARED,
    USUAL_PERSISTENCE,
    fitted_persistence,
    fitted_tails,
    with_tails,
)

SENSOR = SensorEstimate(1.0, 10.0, 0.9, 1e-9, 1e8, 8.0, density=8e-8)
GUESS = Estimates({"A": SENSOR}, 0.1, 100.0, 1e-9, 1e-8)


def learned(share=0.0, *, turning=0.0, known=GUESS, place=None, n_scans=60):
    """Return what is found of eight objects, of whose reports a share is 15 times as wide."""
    rng = np.random.default_rng(5)
    moments, number = np.arange(float(n_scans)), np.arange(8)
    heading = rng.uniform(0, 2 * np.pi, 8) + turning * moments[:, None]
    step = 100.0 * np.stack([np.sin(heading), np.cos(heading)], axis=2)
    true = rng.uniform(-3e4, 3e4, (8, 2)) + np.cumsum(step, axis=0)
    wide = np.where(rng.random((n_scans, 8, 1)) < share, 15.0, 1.0)
    if place is None:
        seen = true + 10.0 * wide * rng.normal(size=true.shape)
    else:
        # Reports in the tail are off in azimuth alone.
        noise = rng.normal(size=true.shape) * np.concatenate([np.ones_like(wide), wide], axis=2)
        distance = np.hypot(*(true - place).transpose(2, 0, 1)) + 10.0 * noise[..., 0]
        azimuth = np.arctan2(*(true - place).transpose(2, 0, 1)) + 0.001 * noise[..., 1]
        seen = place + distance[..., None] * np.stack([np.sin(azimuth), np.cos(azimuth)], axis=2)
    reports = table(np.repeat(moments, 8), seen.reshape(-1, 2))
    followed = Followed(np.tile(number, n_scans), {"A": moments})
    places = None if place is None else {"A": place}
    found = with_tails(known, reports, followed, places).sensors["A"]
    return found.tail_share, found.tail_scale


def test_share_and_scale_of_wide_noise_are_found():
    share, scale = learned(0.04)
    assert share == pytest.approx(0.04, rel=0.5)
    assert scale == pytest.approx(15.0, rel=0.4)


def test_normal_noise_has_no_tails():
    assert learned() == (0.0, None)


def test_few_reports_tell_of_no_tails():
    assert learned(0.04, n_scans=12) == (0.0, None)


def test_turns_are_no_tails():
    """At 20° a second an object is 17 m beside a straight way between its reports."""
    assert learned(turning=np.radians(20.0)) == (0.0, None)


def test_a_sigma_too_small_is_no_tail():
    small = replace(GUESS, sensors={"A": replace(SENSOR, sigma=3.0)})
    assert learned(known=small) == (0.0, None)


def test_strangers_in_a_crowd_are_no_tails():
    crowd = replace(GUESS, sensors={"A": replace(SENSOR, density=1e-4)})
    assert learned(0.04, known=crowd) == (0.0, None)


def test_a_tail_of_the_azimuth_alone_is_found():
    sensor = replace(SENSOR, sigma=(10.0, 0.001), density=1e-9)
    polar = replace(GUESS, sensors={"A": sensor})
    share, scale = learned(0.04, known=polar, place=np.array([1e5, 0.0]))
    assert share == pytest.approx(0.04, rel=0.5)
    # As wide in both as makes the azimuth's width likeliest.
    assert scale == pytest.approx(15.0 / np.sqrt(2.0), rel=0.4)


def test_noise_of_few_bad_objects_is_a_tail():
    """Their noise is in that of all tracks, which no report is far beyond."""
    sensor = replace(SENSOR, sigma=(10.0, 0.003), sigma_of_most=(10.0, 0.001))
    mixed = replace(GUESS, sensors={"A": sensor})
    share, scale = learned(known=mixed, place=np.array([1e5, 0.0]))
    assert 0.0 < share <= 0.01
    assert scale == pytest.approx(12.0, rel=0.01)
    alike = replace(GUESS, sensors={"A": replace(sensor, sigma_of_most=(9.0, 0.002))})
    assert learned(known=alike, place=np.array([1e5, 0.0])) == (0.0, None)


@pytest.mark.parametrize("is_wild", [False, True])
def test_radars_that_turn_have_tails_though_no_sure_track_shows_them(is_wild):
    """Of a stretch whose transponders are good; elsewhere in the same sky some are not."""
    rng = np.random.default_rng(8)
    moments, velocity = np.arange(40.0), rng.uniform(-100.0, 100.0, (8, 2))
    places = {"A": np.array([1e5, 0.0]), "B": np.array([0.0, 1e5])}
    start = rng.uniform(-3e4, 3e4, (8, 2))
    seen = []
    for lag, place in zip((0.0, 0.5), places.values(), strict=True):
        away = start + velocity * (moments[:, None, None] + lag) - place
        distance = np.hypot(away[..., 0], away[..., 1]) + 10.0 * rng.normal(size=(40, 8))
        azimuth = np.arctan2(away[..., 0], away[..., 1]) + 0.001 * rng.normal(size=(40, 8))
        seen.append(
            place + distance[..., None] * np.stack([np.sin(azimuth), np.cos(azimuth)], axis=2)
        )
    time = np.concatenate([np.repeat(moments, 8), np.repeat(moments + 0.5, 8)])
    position = np.concatenate([each.reshape(-1, 2) for each in seen])
    reports = table(time, position, np.repeat([0, 1], 320), names=("A", "B"))
    good = replace(SENSOR, sigma=(20.0, 0.005), sigma_of_most=(10.0, 0.001), density=1e-10)
    known = replace(GUESS, sensors={"A": good, "B": good})
    looks = {"A": moments, "B": moments + 0.5}
    order = np.lexsort((np.repeat([0, 1], 320), time))
    followed = Followed(np.tile(np.arange(8), 80)[order], looks, is_wild=is_wild)
    for found in with_tails(known, reports, followed, places).sensors.values():
        shown = found.sigma, found.tail_share, found.tail_persistence
        expected = ((10.0, 0.001), LEAST_SHARED, USUAL_PERSISTENCE)
        assert shown == (expected if is_wild else ((20.0, 0.005), 0.0, 0.0))


def test_share_and_scale_of_many_reports_are_theirs():
    rng = np.random.default_rng(2)
    wide = np.where(rng.random((8000, 1)) < 0.1, 8.0, 1.0)
    share, scale = fitted_tails((wide * rng.normal(size=(8000, 2))) ** 2)
    assert share == pytest.approx(0.1, rel=0.1)
    assert scale == pytest.approx(8.0, rel=0.05)


def chains(persistence, *, share=0.1, scale=10.0, n_tracks=40):
    """Return squares of tracks of several lengths whose wide noise persists, and whose each is."""
    rng = np.random.default_rng(6)
    lengths = rng.integers(5, 60, n_tracks)
    wide = []
    for length in lengths:
        is_wide = rng.random() < share
        for _ in range(length):
            if rng.random() >= persistence:
                is_wide = rng.random() < share
            wide.append(is_wide)
    times = np.where(wide, scale, 1.0)[:, None]
    square = (times * rng.normal(size=(len(wide), 2))) ** 2
    return square, np.repeat(3 * np.arange(n_tracks), lengths)


@pytest.mark.parametrize("true", [0.0, 0.5, 0.9, 0.98])
@pytest.mark.parametrize("usual", [0.0, 0.95])
def test_how_far_wide_noise_persists_is_found(true, usual):
    found = fitted_persistence(*chains(true), (0.1, 10.0), usual)
    assert found == pytest.approx(true, abs=0.11)


@pytest.mark.parametrize("usual", [0.0, 0.95])
def test_few_reports_leave_persistence_as_usual(usual):
    square, track = chains(0.5, n_tracks=1)
    assert fitted_persistence(square[:6], track[:6], (0.1, 10.0), usual) == usual


def test_the_likelihood_of_a_persistence_is_the_sum_over_all_chains():
    """A track of narrow reports, then wide ones: what all ways to it weigh decides."""
    share, scale = 0.1, 10.0
    square = np.array([[1.0, 1.0]] * 4 + [[90.0, 70.0]] * 5)
    odds = np.exp(0.5 * square.sum(axis=1) * (1 - scale**-2)) / scale**2
    weights = []
    for persistence in (0.0, 0.5, 0.8, 0.9, 0.95, 0.98):
        coming = (1 - persistence) * np.array([1 - share, share]) + persistence * np.eye(2)
        total = 0.0
        for chain in product((0, 1), repeat=9):
            steps = [coming[a, b] for a, b in pairwise(chain)]
            total += [1 - share, share][chain[0]] * np.prod(steps) * np.prod(odds**chain)
        weights.append(np.log(total))
    best = int(np.argmax(weights))
    assert weights[best] - weights[0] > 3.0
    found = fitted_persistence(square, np.zeros(9, dtype=np.int64), (share, scale), 0.0)
    assert found == (0.0, 0.5, 0.8, 0.9, 0.95, 0.98)[best]
