"""A report from a mixture of narrow and wide noise, against sums over a grid."""

from itertools import pairwise, product

import numpy as np
import pytest
from scipy.stats import multivariate_normal as normal

from trackweave.domain.measurements import MeasurementKind as Kind
from trackweave.filters._smoothing import receive
from trackweave.filters._tails import log_of_either, mix_with, share_of_wide
from trackweave.filters.smoother import Readings, filtered, merged, smoothed
from trackweave.models.motion import ConstantVelocity

MEAN = np.array([100.0, 50.0, 3.0, -2.0])
ROOT = np.random.default_rng(4).normal(size=(4, 6)) * np.array([4.0, 4.0, 1.0, 1.0])[:, None]
COVARIANCE = ROOT @ ROOT.T
SIGMA, SHARE, SCALE = 3.0, 0.05, 8.0
RULE = ConstantVelocity(0.5, 50.0).rule(2)


def readings(time, seen, share=SHARE, persistence=0.0):
    length = len(time)
    return Readings(
        time=np.array(time, dtype=float),
        kind=np.full(length, int(Kind.POSITION)),
        width=np.full(length, 2),
        measurement=np.array(seen, dtype=float),
        sigma=np.full((length, 2), SIGMA),
        platform=np.zeros((length, 6)),
        tail=np.tile([share, SCALE, persistence], (length, 1)),
    )


def on_a_grid(seen):
    """Return the moments after a report, by sums over where the object may be."""
    reach = 8 * np.sqrt(np.diagonal(COVARIANCE)[:2])
    axes = np.linspace(MEAN[:2] - reach, MEAN[:2] + reach, 601).T
    place = np.stack(np.meshgrid(*axes, indexing="ij"), axis=2).reshape(-1, 2)
    weight = normal(MEAN[:2], COVARIANCE[:2, :2]).pdf(place)
    noise = np.eye(2) * SIGMA**2
    weight *= (1 - SHARE) * normal(seen, noise).pdf(place) + SHARE * normal(
        seen, SCALE**2 * noise
    ).pdf(place)
    weight /= weight.sum()
    # The velocity is normal given the place.
    gain = COVARIANCE[2:, :2] @ np.linalg.inv(COVARIANCE[:2, :2])
    whole = np.concatenate([place, MEAN[2:] + (place - MEAN[:2]) @ gain.T], axis=1)
    mean = weight @ whole
    spread = (weight[:, None] * (whole - mean)).T @ (whole - mean)
    spread[2:, 2:] += COVARIANCE[2:, 2:] - gain @ COVARIANCE[:2, 2:]
    return mean, spread


@pytest.mark.parametrize("off", [(1.0, -2.0), (14.0, 5.0), (25.0, -20.0), (60.0, 0.0)])
def test_a_report_leaves_the_moments_of_both_parts(off):
    seen = MEAN[:2] + off
    mean, covariance = merged(filtered(readings([0.0], [seen]), (MEAN, COVARIANCE), RULE))
    wanted, spread = on_a_grid(seen)
    scale = np.sqrt(np.diagonal(spread))
    np.testing.assert_allclose((mean[0] - wanted) / scale, 0.0, atol=2e-3)
    np.testing.assert_allclose((covariance[0] - spread) / np.outer(scale, scale), 0.0, atol=5e-3)


@pytest.mark.parametrize("times", [10.0, 20.0])
def test_one_wild_report_hardly_moves_the_smoothed_states(times):
    time, rng = np.arange(20.0), np.random.default_rng(3)
    seen = 100.0 + time[:, None] * [3.0, -2.0] + SIGMA * rng.normal(size=(20, 2))
    wild = seen.copy()
    wild[10] += times * SIGMA * np.array([0.6, -0.8])
    start = np.array([*seen[0], 0.0, 0.0]), np.diag([9.0, 9.0, 100.0, 100.0])
    calm, covariance = merged(smoothed(readings(time, seen), start, RULE))
    pulled, _ = merged(smoothed(readings(time, wild), start, RULE))
    apart = np.abs(pulled - calm) / np.sqrt(np.diagonal(covariance, axis1=1, axis2=2))
    assert apart.max() < 1.0
    # Without tails it would be dragged along.
    calm, covariance = merged(smoothed(readings(time, seen, 0.0), start, RULE))
    pulled, _ = merged(smoothed(readings(time, wild, 0.0), start, RULE))
    apart = np.abs(pulled - calm) / np.sqrt(np.diagonal(covariance, axis1=1, axis2=2))
    assert apart.max() > 2.0


@pytest.mark.parametrize("persistence", [0.0, 0.6, 0.95])
def test_wide_noise_follows_itself_as_a_chain(persistence):
    """Of an object that is known exactly each report's part follows from all before it."""
    rng = np.random.default_rng(8)
    length, still = 6, np.zeros(4)
    seen = SIGMA * rng.normal(size=(length, 2)) * np.array([1, 7, 5, 1, 9, 8])[:, None]
    told = readings(np.arange(6.0), seen, persistence=persistence)
    coming = (1 - persistence) * np.array([1 - SHARE, SHARE]) + persistence * np.eye(2)
    densities = [normal([0, 0], np.eye(2) * (k * SIGMA) ** 2).pdf(seen) for k in (1.0, SCALE)]
    chances = np.zeros((length, 2))
    for last in range(length):
        for chain in product((0, 1), repeat=last + 1):
            chance = [1 - SHARE, SHARE][chain[0]]
            for one, after in pairwise(chain):
                chance *= coming[one, after]
            for moment, part in enumerate(chain):
                chance *= densities[part][moment]
            chances[last, chain[-1]] += chance
    wanted = chances[:, 1] / chances.sum(axis=1)
    wild, found = -1.0, []
    for moment in range(length):
        state = still[None].copy(), 1e-12 * np.eye(4)[None], np.ones(1)
        wild = receive(told, moment, RULE, *state, wild)
        found.append(wild)
    if persistence > 0.0:
        np.testing.assert_allclose(found, wanted, rtol=1e-6)
    else:
        assert found == [-1.0] * length


def test_what_fits_neither_part_is_of_neither():
    assert log_of_either(-np.inf, -np.inf, 0.1) == -np.inf
    assert share_of_wide(-np.inf, -np.inf, 0.1) == 0.0
    assert share_of_wide(-np.inf, -3.0, 0.1) == 1.0
    assert share_of_wide(-1e6, -10.0, 0.01) == 1.0


def test_no_share_of_another_state_changes_nothing():
    mean, covariance = MEAN.copy(), COVARIANCE.copy()
    mix_with(MEAN + 5.0, 2.0 * COVARIANCE, 0.0, mean, covariance)
    np.testing.assert_array_equal(mean, MEAN)
    np.testing.assert_array_equal(covariance, COVARIANCE)
