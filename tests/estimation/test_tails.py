"""Heavy tails are told from single reports far beside their own tracks, and from nothing else."""

from dataclasses import replace

import numpy as np
import pytest

from estimation.test_estimate import table
from trackweave.estimation.estimates import Estimates, SensorEstimate
from trackweave.estimation.refine import Followed
from trackweave.estimation.tails import fitted_tails, with_tails

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


def test_share_and_scale_of_many_reports_are_theirs():
    rng = np.random.default_rng(2)
    wide = np.where(rng.random((8000, 1)) < 0.1, 8.0, 1.0)
    share, scale = fitted_tails((wide * rng.normal(size=(8000, 2))) ** 2)
    assert share == pytest.approx(0.1, rel=0.1)
    assert scale == pytest.approx(8.0, rel=0.05)
