"""States ahead in time against matrix exponentials, differences and plain mixing."""

import numpy as np
import pytest

from oracles import kalman, motion
from trackweave.filters import _states as states
from trackweave.filters._turns import factors
from trackweave.models.motion import (
    ConstantAcceleration,
    ConstantVelocity,
    CoordinatedTurn,
    Imm,
    RandomWalk,
)

STRAIGHT = ConstantVelocity(2.0, 300.0)
PULLING = ConstantAcceleration(0.5, 300.0, 30.0)
TURNING = CoordinatedTurn(2.0, 1e-4, 300.0, 0.2)
WALKING = RandomWalk(40.0, 20.0)
ALL = Imm((STRAIGHT, PULLING, TURNING, WALKING), (60.0, 10.0, 25.0, 5.0))
LINEAR = {"cv": STRAIGHT, "ca": PULLING, "rw": WALKING}
INTERVALS = [1e-3, 0.7, 4.0, 60.0]


def random_state(rule, rng):
    """Return a state of every mode, all components correlated."""
    size, n_modes = rule.prior.size, rule.kind.size
    scale = np.sqrt(np.where(rule.prior > 0, rule.prior, 1e4))
    mean = rng.normal(size=(n_modes, size)) * scale
    root = rng.normal(size=(n_modes, size, size + 2)) * 0.2 * scale[:, None]
    return mean, root @ root.transpose(0, 2, 1), rng.dirichlet(np.ones(n_modes))


def advance(state, interval, rule):
    """Return what the kernel writes; it leaves its input alone."""
    before = [part.copy() for part in state]
    after = tuple(np.full_like(part, np.nan) for part in state)
    states.advance(*state, interval, rule, *after)
    for part, kept in zip(state, before, strict=True):
        np.testing.assert_array_equal(part, kept)
    return after


def assert_close(came, wanted, tolerance=1e-10):
    """Compare covariances or means, each entry on the scale of the largest of its kind."""
    size = np.sqrt(np.abs(np.diagonal(wanted))) if wanted.ndim == 2 else np.abs(wanted) + 1.0
    scale = np.outer(size, size) + 1e-30 if wanted.ndim == 2 else size
    assert np.max(np.abs(came - wanted) / scale) < tolerance


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("interval", INTERVALS)
@pytest.mark.parametrize("name", LINEAR)
def test_one_linear_mode_moves_as_its_matrix_exponential_says(name, interval, dim):
    rule = LINEAR[name].rule(dim)
    state = random_state(rule, np.random.default_rng(dim))
    mean, covariance, weight = advance(state, interval, rule)
    moving, noise = motion.linear(rule, 0, interval)
    assert_close(mean[0], moving @ state[0][0])
    assert_close(covariance[0], moving @ state[1][0] @ moving.T + noise)
    np.testing.assert_array_equal(weight, state[2])


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("interval", INTERVALS)
@pytest.mark.parametrize("mode", [0, 1, 3])
def test_what_a_mode_does_not_use_is_forgotten(mode, interval, dim):
    rule = ALL.rule(dim)
    state = random_state(rule, np.random.default_rng(dim))
    mean, covariance = np.full(rule.prior.size, np.nan), np.full_like(state[1][0], np.nan)
    states.move(mode, state[0][mode], state[1][mode], interval, rule, mean, covariance)
    moving, noise = motion.linear(rule, mode, interval)
    assert_close(mean, moving @ state[0][mode])
    assert_close(covariance, moving @ state[1][mode] @ moving.T + noise)


@pytest.mark.parametrize("dim", [2, 3])
def test_constant_velocity_moves_as_the_matrices_do(dim):
    rule = STRAIGHT.rule(dim)
    state = random_state(rule, np.random.default_rng(dim))
    mean, covariance, _ = advance(state, 3.7, rule)
    wanted = kalman.predict(state[0][0], state[1][0], 3.7, 2.0)
    np.testing.assert_allclose(mean[0], wanted[0], rtol=1e-13)
    np.testing.assert_allclose(covariance[0], wanted[1], rtol=1e-10, atol=1e-9)


@pytest.mark.parametrize("model", [STRAIGHT, PULLING, TURNING, WALKING, ALL])
def test_no_time_changes_nothing(model):
    rule = model.rule(2)
    state = random_state(rule, np.random.default_rng(4))
    for came, wanted in zip(advance(state, 0.0, rule), state, strict=True):
        np.testing.assert_array_equal(came, wanted)


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("rate", [0.0, 1e-5, 0.009, -0.011, 0.2, -1.5])
def test_a_turn_rotates_the_velocity_clockwise(rate, dim):
    rule = TURNING.rule(dim)
    mean, covariance, weight = random_state(rule, np.random.default_rng(7))
    mean[0, rule.turn_at] = rate
    # Of a rate that is known for certain.
    covariance[0, rule.turn_at] = covariance[0, :, rule.turn_at] = 0.0
    after, spread, _ = advance((mean, covariance, weight), 5.0, rule)
    np.testing.assert_allclose(after[0], motion.turn(mean[0], 5.0, rule), rtol=1e-10, atol=1e-9)
    step = np.where(np.arange(mean.shape[1]) == rule.turn_at, 1e-5, 1e-3)
    slope = motion.slopes(lambda x: motion.turn(x, 5.0, rule), mean[0], step)
    noise = np.full_like(spread[0], np.nan)
    moving, ahead = np.full_like(noise, np.nan), np.full_like(mean[0], np.nan)
    states.linearise(0, mean[0], covariance[0], 5.0, rule, ahead, moving, noise)
    np.testing.assert_allclose(moving, slope, rtol=1e-6, atol=1e-5)
    assert_close(spread[0], moving @ covariance[0] @ moving.T + noise)


def test_the_noise_of_a_turn_is_that_of_the_linear_system_about_a_straight_path():
    rule = TURNING.rule(2)
    mean = np.array([0.0, 0.0, 120.0, -80.0, 0.0])
    drift, diffusion = np.zeros((2, 5, 5))
    drift[0, 2] = drift[1, 3] = 1.0
    # The velocity's change by a turn rate: clockwise, across it.
    drift[2, 4], drift[3, 4] = mean[3], -mean[2]
    diffusion[2, 2] = diffusion[3, 3] = 2.0
    diffusion[4, 4] = 1e-4
    moving, noise = motion.discretise(drift, diffusion, 6.0)
    came, wide, ahead = np.zeros((5, 5)), np.zeros((5, 5)), np.zeros(5)
    states.linearise(0, mean, np.zeros((5, 5)), 6.0, rule, ahead, wide, came)
    assert_close(came, noise)
    np.testing.assert_allclose(wide, moving, rtol=1e-10, atol=1e-9)


@pytest.mark.parametrize("angle", [1e-9, 0.00999, 0.01001, 0.3, -0.00999, -0.01001, -2.0])
def test_the_factors_of_a_turn_do_not_lose_digits_where_it_is_slight(angle):
    # The mean of cos, sin and their derivatives along the path, by Gauss's rule of many points.
    points, weights = np.polynomial.legendre.leggauss(30)
    part, weights = (points + 1) / 2, weights / 2
    wanted = (
        weights @ np.cos(angle * part),
        weights @ np.sin(angle * part),
        -weights @ (part * np.sin(angle * part)),
        weights @ (part * np.cos(angle * part)),
    )
    assert factors(angle) == pytest.approx(wanted, rel=1e-10)


@pytest.mark.parametrize("dim", [2, 3])
def test_a_turn_of_uncertain_rate_moves_as_each_sigma_point_does(dim):
    rule = TURNING.rule(dim)._replace(noise=np.zeros((1, 2)))
    mean, covariance, weight = random_state(rule, np.random.default_rng(3))
    after, spread, _ = advance((mean, covariance, weight), 4.0, rule)
    wanted = motion.turn_by_points(mean[0], covariance[0], 4.0, rule)
    assert_close(after[0], wanted[0])
    assert_close(spread[0], wanted[1])


def test_a_turn_of_unknown_rate_ends_where_many_samples_do():
    rule = TURNING.rule(2)._replace(noise=np.zeros((1, 2)))
    mean = np.array([[0.0, 0.0, 150.0, 40.0, 0.05]])
    covariance = np.diag([100.0, 100.0, 4.0, 4.0, 0.04**2])[None]
    rng = np.random.default_rng(11)
    samples = rng.multivariate_normal(mean[0], covariance[0], size=4_000)
    after = np.array([motion.turn(sample, 10.0, rule) for sample in samples])
    deviation = after.std(axis=0)
    came, spread, _ = advance((mean, covariance, np.ones(1)), 10.0, rule)
    centre = after.mean(axis=0)
    np.testing.assert_allclose((came[0] - centre) / deviation, 0.0, atol=0.06)
    # The mean's own path ends outside the arc of all ends.
    assert np.max(np.abs(motion.turn(mean[0], 10.0, rule) - centre) / deviation) > 0.2
    wide = np.outer(deviation, deviation)
    np.testing.assert_allclose(spread[0] / wide, np.cov(after.T) / wide, atol=0.1)


def test_sigma_points_and_derivatives_agree_where_a_turn_is_nearly_certain():
    mean, covariance, weight = random_state(TURNING.rule(2), np.random.default_rng(3))
    covariance *= 1e-8
    by_points = advance((mean, covariance, weight), 5.0, TURNING.rule(2))
    covariance[0, 4] = covariance[0, :, 4] = 0.0
    by_slopes = advance((mean, covariance, weight), 5.0, TURNING.rule(2))
    assert_close(by_points[0][0], by_slopes[0][0], 1e-5)
    assert_close(by_points[1][0], by_slopes[1][0], 1e-3)


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("interval", INTERVALS)
def test_several_modes_are_mixed_and_moved_as_the_textbook_says(interval, dim):
    rule = ALL.rule(dim)
    state = random_state(rule, np.random.default_rng(dim))
    mean, covariance, weight = advance(state, interval, rule)
    transition = motion.transitions(ALL.sojourn_time, interval)
    mixed_mean, mixed, wanted = motion.mix(*state, transition)
    np.testing.assert_allclose(weight, wanted, rtol=1e-10)
    for mode in range(4):
        ahead, spread = np.empty_like(mean[0]), np.empty_like(covariance[0])
        states.move(mode, mixed_mean[mode], mixed[mode], interval, rule, ahead, spread)
        assert_close(mean[mode], ahead, 1e-9)
        assert_close(covariance[mode], spread, 1e-9)
        np.testing.assert_array_equal(covariance[mode], covariance[mode].T)


def test_two_short_intervals_change_modes_as_one_long_interval():
    rule = ALL.rule(2)
    state = random_state(rule, np.random.default_rng(5))
    twice = advance(advance(state, 3.0, rule), 4.5, rule)
    once = advance(state, 7.5, rule)
    np.testing.assert_allclose(twice[2], once[2], rtol=1e-12)


def test_after_a_long_time_the_modes_have_their_shares():
    rule = ALL.rule(2)
    _, _, weight = advance(random_state(rule, np.random.default_rng(5)), 1e5, rule)
    np.testing.assert_allclose(weight, rule.share, atol=1e-12)


def test_a_mode_of_no_probability_does_no_harm():
    rule = ALL.rule(2)
    # No time to enter it: all it has come from is nothing.
    rule = rule._replace(decay=np.zeros(4))
    mean, covariance, _ = random_state(rule, np.random.default_rng(6))
    after = advance((mean, covariance, np.array([0.3, 0.7, 0.0, 0.0])), 2.0, rule)
    assert all(np.all(np.isfinite(part)) for part in after)
    assert after[2] == pytest.approx([0.3, 0.7, 0.0, 0.0], abs=1e-12)


def test_combining_modes_gives_the_moments_of_the_mixture():
    rule = ALL.rule(3)
    state = random_state(rule, np.random.default_rng(8))
    centre, spread = np.empty(rule.prior.size), np.empty_like(state[1][0])
    states.combine(*state, centre, spread)
    wanted = motion.combine(*state)
    np.testing.assert_allclose(centre, wanted[0], rtol=1e-12, atol=1e-12)
    assert_close(spread, wanted[1], 1e-12)


def test_combining_one_mode_copies_it():
    rule = PULLING.rule(2)
    state = random_state(rule, np.random.default_rng(8))
    centre, spread = np.empty(rule.prior.size), np.empty_like(state[1][0])
    states.combine(*state, centre, spread)
    np.testing.assert_array_equal(centre, state[0][0])
    np.testing.assert_array_equal(spread, state[1][0])
