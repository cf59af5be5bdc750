"""Filters believe their states as much as they may: NEES and NIS within their χ² bounds."""

import numpy as np
import pytest
from scipy.stats import chi2

from oracles import motion as textbook
from oracles import sensing
from trackweave.domain.measurements import MeasurementKind as Kind
from trackweave.filters import _measuring as measuring
from trackweave.filters import _states as states
from trackweave.filters._kernels import correct
from trackweave.models.motion import (
    ConstantAcceleration,
    ConstantVelocity,
    CoordinatedTurn,
    Imm,
    RandomWalk,
)

RUNS, STEPS = 40, 20
MODELS = {
    "cv": ConstantVelocity(1.0, 250.0),
    "ca": ConstantAcceleration(0.05, 250.0, 10.0),
    "ct": CoordinatedTurn(1.0, 2e-5, 250.0, 0.1),
    "rw": RandomWalk(400.0, 250.0),
}
SIGMA = {
    Kind.POSITION: [20.0, 20.0],
    Kind.RANGE_AZIMUTH: [20.0, 0.003],
    Kind.RANGE_AZIMUTH_RATE: [20.0, 0.003, 1.0],
    Kind.BEARING: [0.005],
    Kind.RANGE_AZIMUTH_ELEVATION: [20.0, 0.003, 0.003],
    Kind.RANGE_AZIMUTH_ELEVATION_RATE: [20.0, 0.003, 0.003, 1.0],
}
PLATFORM = np.array([100.0, -200.0, 10.0, 3.0, -2.0, 0.0])
CASES = [(name, kind, 2) for name in MODELS for kind in list(SIGMA)[:4]]
CASES += [(name, kind, 3) for name in ("cv", "ca", "ct") for kind in list(SIGMA)[4:]]


def turn(state, interval, rule, rng):
    """Return where turns really end, by many small steps."""
    dim, fine = rule.dim, 40
    step = interval / fine
    state = state.copy()
    for _ in range(fine):
        before = state[:, dim : 2 * dim].copy()
        across = np.exp(-1j * state[:, rule.turn_at] * step)
        heading = (before[:, 0] + 1j * before[:, 1]) * across
        state[:, dim], state[:, dim + 1] = heading.real, heading.imag
        state[:, dim : 2 * dim] += rng.normal(size=before.shape) * np.sqrt(rule.noise[0, 0] * step)
        state[:, :dim] += (before + state[:, dim : 2 * dim]) / 2 * step
        state[:, rule.turn_at] += rng.normal(size=len(state)) * np.sqrt(rule.noise[0, 1] * step)
    return state


def move(state, interval, rule, rng):
    """Return where the motion really takes states, by its own equations."""
    if rule.turn_at >= 0:
        return turn(state, interval, rule, rng)
    moving, noise = textbook.linear(rule, 0, interval)
    kicks = rng.multivariate_normal(np.zeros(state.shape[1]), noise, size=RUNS)
    return state @ moving.T + kicks


def begin(rule, kind, rng):
    """Return a true state, and what a filter knows of it at first."""
    dim, size = rule.dim, rule.prior.size
    mean = np.zeros(size)
    mean[:dim] = [6000.0, 8000.0, 3000.0][:dim]
    mean[dim : dim + 2] = [-100.0, 60.0]
    # A bearing filter needs a place to begin with.
    variance = np.where(np.arange(size) < dim, 100.0**2, 10.0**2)
    if rule.acceleration_at >= 0:
        variance[rule.acceleration_at : rule.acceleration_at + dim] = 1.0
    if rule.turn_at >= 0:
        variance[rule.turn_at] = 0.02**2
    if kind is Kind.BEARING:
        variance[:dim] = 300.0**2
        # Nor do bearings from one place tell a turn from an approach.
        variance[2 * dim :] *= 0.05**2
    if rule.kind[0] == 3:
        mean[dim : 2 * dim], variance[dim : 2 * dim] = 0.0, rule.prior[dim : 2 * dim]
    truth = mean + rng.normal(size=(RUNS, size)) * np.sqrt(variance)
    return truth, mean, np.diag(variance)


def take_in(state, kind, seen, rule):
    """Take a report into a state of one mode in place; return its NIS."""
    sigma = np.array(SIGMA[kind])
    width, size = sigma.size, state[0].shape[1]
    foreseen, spread = np.empty(width), np.empty((width, width))
    cross, inverse, apart = np.empty((size, width)), np.empty((width, width)), np.empty(width)
    measuring.measure(
        int(kind), state[0][0], state[1][0], PLATFORM, rule.dim, rule.unscented, foreseen,
        spread, cross,
    )  # fmt: skip
    spread += np.diag(sigma**2)
    measuring.invert(spread, inverse)
    measuring.innovation(int(kind), seen, foreseen, apart)
    mean, covariance = state[0][0], state[1][0]
    correct(mean, covariance, apart, spread, cross, mean, covariance)
    return apart @ inverse @ apart


def follow(rule, kind, rng):
    """Return NEES and NIS of runs of a filter of one mode, and how many numbers each is of."""
    truth, mean, covariance = begin(rule, kind, rng)
    sigma = np.array(SIGMA[kind])
    runs = [(mean[None].copy(), covariance[None].copy(), np.ones(1)) for _ in range(RUNS)]
    # A random walk has no velocity that could be right or wrong.
    told = rule.dim if rule.kind[0] == 3 else mean.size
    nees, nis = [], []
    for _ in range(STEPS):
        interval = rng.uniform(0.5, 3.0)
        truth = move(truth, interval, rule, rng)
        for run, state in enumerate(runs):
            after = tuple(np.empty_like(part) for part in state)
            states.advance(*state, interval, rule, *after)
            seen = sensing.expected(kind, truth[run], PLATFORM, rule.dim)
            nis.append(take_in(after, kind, seen + rng.normal(size=sigma.size) * sigma, rule))
            error = (truth[run] - after[0][0])[:told]
            nees.append(error @ np.linalg.solve(after[1][0][:told, :told], error))
            runs[run] = after
    return (nees, told), (nis, sigma.size)


def assert_consistent(values, size, slack):
    """Compare the mean over all runs and steps with its bounds; slack is for what is not linear.

    The steps of a run are correlated: as if only every fifth of them counted.
    """
    count = RUNS * STEPS / 5
    low, high = chi2.ppf([1e-4, 1 - 1e-4], count * size) / count
    assert low / (1 + slack) < np.mean(values) < high * (1 + slack)


@pytest.mark.parametrize("unscented", [False, True])
@pytest.mark.parametrize(("name", "kind", "dim"), CASES)
def test_one_mode_is_as_certain_as_it_may_be(name, kind, dim, unscented):
    rule = MODELS[name].rule(dim, unscented=unscented)
    if kind is Kind.BEARING and name == "ct":
        rule = rule._replace(noise=np.array([[1.0, 1e-8]]))
    nees, nis = follow(rule, kind, np.random.default_rng(17))
    slack = 0.0 if kind is Kind.POSITION and name != "ct" else 0.1
    assert_consistent(*nees, slack)
    assert_consistent(*nis, slack)


def take_in_modes(state, kind, seen, rule):
    """Take a report into a state of several modes in place; return the NIS of their mixture."""
    sigma = np.array(SIGMA[kind])
    modes, width, size = state[0].shape[0], sigma.size, state[0].shape[1]
    parts = np.empty((modes, width)), np.empty((modes, width, width))
    fits = np.empty(modes)
    for mode in range(modes):
        cross, inverse, apart = (
            np.empty((size, width)), np.empty((width, width)), np.empty(width)
        )  # fmt: skip
        measuring.measure(
            int(kind), state[0][mode], state[1][mode], PLATFORM, rule.dim, rule.unscented,
            parts[0][mode], parts[1][mode], cross,
        )  # fmt: skip
        parts[1][mode] += np.diag(sigma**2)
        log_determinant = measuring.invert(parts[1][mode], inverse)
        measuring.innovation(int(kind), seen, parts[0][mode], apart)
        parts[0][mode] = apart
        correct(
            state[0][mode], state[1][mode], apart, parts[1][mode], cross,
            state[0][mode], state[1][mode],
        )  # fmt: skip
        fits[mode] = np.exp(-0.5 * (apart @ inverse @ apart + log_determinant))
    centre, spread = textbook.combine(*parts, state[2])
    state[2][:] = state[2] * fits / (state[2] @ fits)
    return centre @ np.linalg.solve(spread, centre)


@pytest.mark.parametrize(
    ("kind", "unscented"),
    [(Kind.POSITION, False), (Kind.RANGE_AZIMUTH, True), (Kind.RANGE_AZIMUTH_RATE, False)],
)
@pytest.mark.parametrize("other", ["ca", "ct", "rough"])
def test_several_modes_are_about_as_certain_as_they_may_be(other, kind, unscented):
    """The true mode changes as the chain says; merging modes costs some of the certainty."""
    rng = np.random.default_rng(23)
    rough = ConstantVelocity(50.0, 250.0)
    pair = Imm((MODELS["cv"], MODELS.get(other, rough)), (30.0, 15.0))
    rule = pair.rule(2, unscented=unscented)
    sigma, size = np.array(SIGMA[kind]), rule.prior.size
    nees, nis = [], []
    intervals = (1.0, 2.0)
    changes = {t: textbook.transitions(pair.sojourn_time, t) for t in intervals}
    linear = {(t, k): textbook.linear(rule, k, t) for t in intervals for k in (0, 1)}
    for _ in range(24):
        mean = np.zeros(size)
        mean[:4] = [6000.0, 8000.0, -100.0, 60.0]
        variance = np.where(rule.prior > 0, rule.prior, 100.0**2)
        variance[2:4] = 10.0**2
        truth = mean + rng.normal(size=size) * np.sqrt(variance)
        mode = int(rng.random() > rule.share[0])
        state = np.tile(mean, (2, 1)), np.tile(np.diag(variance), (2, 1, 1)), rule.share.copy()
        for _ in range(25):
            interval = float(rng.choice(intervals))
            mode = int(rng.choice(2, p=changes[interval][mode]))
            if rule.kind[mode] == 2:
                own = rule._replace(noise=rule.noise[mode : mode + 1])
                truth = turn(truth[None], interval, own, rng)[0]
            else:
                moving, noise = linear[interval, mode]
                truth = moving @ truth + rng.multivariate_normal(np.zeros(size), noise)
            after = tuple(np.empty_like(part) for part in state)
            states.advance(*state, interval, rule, *after)
            seen = sensing.expected(kind, truth, PLATFORM, 2) + rng.normal(size=sigma.size) * sigma
            nis.append(take_in_modes(after, kind, seen, rule))
            centre, spread = textbook.combine(*after)
            error = (truth - centre)[:4]
            nees.append(error @ np.linalg.solve(spread[:4, :4], error))
            state = after
    assert 0.8 * 4 < np.mean(nees) < 1.3 * 4
    assert 0.8 * sigma.size < np.mean(nis) < 1.25 * sigma.size
