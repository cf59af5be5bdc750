"""Smoothing against all states at once, against all sequences of modes, and against the truth."""

from itertools import product

import numpy as np
import pytest

from oracles import motion as textbook
from oracles import sensing
from trackweave.domain.measurements import MeasurementKind as Kind
from trackweave.filters.smoother import Readings, filtered, merged, smoothed
from trackweave.models.motion import (
    ConstantAcceleration,
    ConstantVelocity,
    CoordinatedTurn,
    Imm,
    RandomWalk,
)

LINEAR = {
    "cv": ConstantVelocity(0.3, 50.0),
    "ca": ConstantAcceleration(0.2, 50.0, 5.0),
    "rw": RandomWalk(9.0, 50.0),
}


def readings(time, kind, measurement, sigma, platform=None):
    """Return the moments of an object that is reported at those where a measurement is no NaN."""
    length, width = measurement.shape
    seen = np.isfinite(measurement[:, 0])
    return Readings(
        time=time,
        kind=np.where(seen, int(kind), -1),
        width=np.full(length, width),
        measurement=measurement,
        sigma=np.broadcast_to(sigma, measurement.shape).copy(),
        platform=np.zeros((length, 6)) if platform is None else platform,
        tail=np.zeros((length, 3)),
    )


def least_squares(moments, start, steps):
    """Return mean and covariance of all states at once; steps are F and Q between them."""
    size, length = start[0].size, moments.time.size
    information = np.zeros((length * size, length * size))
    vector = np.zeros(length * size)
    information[:size, :size] += np.linalg.inv(start[1])
    vector[:size] += np.linalg.inv(start[1]) @ start[0]
    for k in range(length):
        block = slice(k * size, (k + 1) * size)
        if moments.kind[k] >= 0:
            pick = np.eye(moments.width[k], size)
            weight = np.diag(moments.sigma[k] ** -2.0)
            information[block, block] += pick.T @ weight @ pick
            vector[block] += pick.T @ weight @ moments.measurement[k]
        if k + 1 < length:
            step, noise = steps[k]
            weight = np.linalg.inv(noise)
            after = slice((k + 1) * size, (k + 2) * size)
            information[block, block] += step.T @ weight @ step
            information[after, after] += weight
            information[block, after] -= step.T @ weight
            information[after, block] -= weight @ step
    joint = np.linalg.inv(information)
    means = (joint @ vector).reshape(length, size)
    return means, np.array(
        [joint[k * size : (k + 1) * size, k * size : (k + 1) * size] for k in range(length)]
    )


def random_track(rule, rng, length=7):
    """Return positions at uneven times, some missing, and a start."""
    time = np.cumsum(rng.uniform(0.5, 2.0, length))
    position = rng.normal(0, 20, (length, rule.dim))
    position[2] = position[5] = np.nan
    start = rng.normal(0, 5, rule.prior.size), np.diag(rng.uniform(5, 50, rule.prior.size))
    return readings(time, Kind.POSITION, position, rng.uniform(2, 6, position.shape)), start


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("name", LINEAR)
def test_one_mode_equals_least_squares_over_all_states(name, dim):
    rule = LINEAR[name].rule(dim)
    moments, start = random_track(rule, np.random.default_rng(dim))
    steps = [textbook.linear(rule, 0, interval) for interval in np.diff(moments.time)]
    wanted = least_squares(moments, start, steps)
    mean, covariance = merged(smoothed(moments, start, rule))
    np.testing.assert_allclose(mean, wanted[0], rtol=1e-6, atol=1e-6)
    np.testing.assert_allclose(covariance, wanted[1], rtol=1e-6, atol=1e-6)


def test_the_last_state_is_the_filter_s():
    rule = LINEAR["ca"].rule(2)
    moments, start = random_track(rule, np.random.default_rng(4))
    forward, back = filtered(moments, start, rule), smoothed(moments, start, rule)
    np.testing.assert_array_equal(forward.mean[-1], back.mean[-1])
    assert np.all(forward.mean[0] != back.mean[0])


def test_reports_of_one_moment_are_all_taken():
    rule = LINEAR["cv"].rule(2)
    moments, start = random_track(rule, np.random.default_rng(4))
    twice = Readings(*(np.repeat(part, 2, axis=0) for part in moments))
    once = moments._replace(sigma=moments.sigma / np.sqrt(2))
    mean, covariance = merged(smoothed(twice, start, rule))
    wanted = merged(smoothed(once, start, rule))
    np.testing.assert_allclose(mean[::2], wanted[0], rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(covariance[::2], wanted[1], rtol=1e-9, atol=1e-9)
    np.testing.assert_array_equal(mean[::2], mean[1::2])


def test_a_motion_without_noise_is_smoothed_too():
    rule = ConstantVelocity(0.0, 50.0).rule(2)
    time = np.arange(6.0)
    truth = np.outer(time, [3.0, -2.0])
    moments = readings(time, Kind.POSITION, truth, 1.0)
    mean, _ = merged(smoothed(moments, (np.zeros(4), np.eye(4) * 1e6), rule))
    np.testing.assert_allclose(mean[:, :2], truth, atol=1e-4)
    np.testing.assert_allclose(mean[:, 2:], [[3.0, -2.0]] * 6, atol=1e-4)


def test_leaves_its_input_alone():
    rule = Imm((LINEAR["cv"], LINEAR["rw"]), (10.0, 5.0)).rule(2)
    moments, start = random_track(rule, np.random.default_rng(4))
    copies = [part.copy() for part in (*moments, *start)]
    smoothed(moments, start, rule)
    for part, copy in zip((*moments, *start), copies, strict=True):
        np.testing.assert_array_equal(part, copy)


def all_sequences(moments, start, rule, sojourn_time):
    """Return the exact states and modes: each sequence of modes on its own, weighted."""
    length, n_modes = moments.time.size, rule.kind.size
    intervals = np.diff(moments.time)
    means, spreads, modes, logs = [], [], [], []
    for sequence in product(range(n_modes), repeat=length):
        log = np.log(rule.share[sequence[0]])
        steps = []
        for k, interval in enumerate(intervals):
            change = textbook.transitions(sojourn_time, interval)
            log += np.log(change[sequence[k], sequence[k + 1]])
            steps.append(textbook.linear(rule, sequence[k + 1], interval))
        mean, covariance = least_squares(moments, start, steps)
        # The evidence, by the filter's innovations.
        x, p = start
        for k in range(length):
            if k > 0:
                x, p = steps[k - 1][0] @ x, steps[k - 1][0] @ p @ steps[k - 1][0].T
                p = p + steps[k - 1][1]
            spread = p[:2, :2] + np.diag(moments.sigma[k] ** 2)
            apart = moments.measurement[k] - x[:2]
            log -= (apart @ np.linalg.solve(spread, apart) + np.linalg.slogdet(spread)[1]) / 2
            gain = np.linalg.solve(spread, p[:2]).T
            x, p = x + gain @ apart, p - gain @ p[:2]
        means.append(mean)
        spreads.append(covariance)
        modes.append(sequence)
        logs.append(log)
    weight = np.exp(np.array(logs) - np.max(logs))
    weight /= weight.sum()
    modes = np.array(modes)
    share = np.array([(weight[:, None] * (modes == mode)).sum(axis=0) for mode in range(n_modes)])
    moments_of = [textbook.combine(np.array(means)[:, k], np.array(spreads)[:, k], weight)
                  for k in range(length)]  # fmt: skip
    return np.array([m for m, _ in moments_of]), np.array([p for _, p in moments_of]), share.T


@pytest.mark.parametrize("seed", range(5))
def test_several_modes_come_near_the_weighted_sum_over_all_sequences_of_modes(seed):
    rng = np.random.default_rng(seed)
    times = (6.0, 4.0)
    rule = Imm((ConstantVelocity(0.05, 30.0), ConstantVelocity(60.0, 30.0)), times).rule(2)
    time = np.arange(7.0)
    speed = np.array([[10.0, 0.0]] * 3 + [[-8.0, 14.0]] * 4)
    position = np.cumsum(speed, axis=0) + rng.normal(0, 1.5, (7, 2))
    moments = readings(time, Kind.POSITION, position, 1.5)
    start = np.r_[position[0], 0.0, 0.0], np.diag([9.0, 9.0, 225.0, 225.0])
    course = smoothed(moments, start, rule)
    mean, covariance = merged(course)
    exact, spread, share = all_sequences(moments, start, rule, times)
    deviation = np.sqrt(np.diagonal(spread, axis1=1, axis2=2))
    assert np.max(np.abs(mean - exact) / deviation) < 0.5
    assert np.mean(np.abs(mean - exact) / deviation) < 0.1
    ratio = np.sqrt(np.diagonal(covariance, axis1=1, axis2=2)) / deviation
    assert np.all((ratio > 0.7) & (ratio < 1.4))
    assert np.mean(np.abs(course.weight - share)) < 0.12


def bent_path(rng, length=60, turn=(20, 40), rate=0.15):
    """Return the true states of an object that turns for a while, one a second."""
    state = np.array([3000.0, 4000.0, 180.0, 60.0, 0.0])
    rule = CoordinatedTurn(0.0, 0.0, 300.0, 0.3).rule(2)
    states = [state]
    for k in range(1, length):
        state = state.copy()
        state[4] = rate if turn[0] <= k < turn[1] else 0.0
        state = textbook.turn(state, 1.0, rule)
        state[2:4] += rng.normal(0, 0.3, 2)
        states.append(state)
    return np.array(states)


@pytest.mark.slow
@pytest.mark.parametrize("unscented", [False, True])
@pytest.mark.parametrize(
    ("kind", "sigma"),
    [(Kind.POSITION, [30.0, 30.0]), (Kind.RANGE_AZIMUTH, [30.0, 0.005]),
     (Kind.RANGE_AZIMUTH_RATE, [30.0, 0.005, 1.0])],
)  # fmt: skip
def test_later_reports_better_the_states_of_a_turning_object(kind, sigma, unscented):
    rng = np.random.default_rng(3)
    pair = Imm(
        (ConstantVelocity(0.1, 300.0), CoordinatedTurn(0.1, 1e-4, 300.0, 0.3)), (40.0, 20.0)
    )
    rule = pair.rule(2, unscented=unscented)
    errors, consistent, modes = np.zeros((2, 2)), [], []
    for _ in range(20):
        truth = bent_path(rng)
        seen = np.array([sensing.expected(kind, x, np.zeros(6), 2) for x in truth])
        seen += rng.normal(size=seen.shape) * sigma
        moments = readings(np.arange(60.0), kind, seen, np.array(sigma))
        variance = np.r_[400.0, 400.0, np.full(2, 2500.0), rule.prior[4]]
        first = truth[0] + rng.normal(size=5) * np.sqrt(variance)
        first[4] = 0.0
        start = first, np.diag(variance)
        for row, states in enumerate((filtered, smoothed)):
            course = states(moments, start, rule)
            mean, covariance = merged(course)
            apart = mean[:, :4] - truth[:, :4]
            errors[row] += (apart[:, :2] ** 2).sum(), (apart[:, 2:] ** 2).sum()
        inverse = np.linalg.inv(covariance[:, :4, :4])
        consistent.append(np.einsum("ti,tij,tj->t", apart, inverse, apart).mean())
        modes.append(course.weight[:, 1])
    # Nothing is gained at the last moment; over the whole path positions and speeds are.
    assert np.all(errors[1] < 0.6 * errors[0])
    assert 1.5 < np.mean(consistent) < 6.0
    share = np.mean(modes, axis=0)
    assert share[24:36].mean() > 0.8 > 0.4 > share[3:15].mean()
