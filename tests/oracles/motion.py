"""Motion as textbooks write it: matrix exponentials, derivatives by differences, plain mixing."""

import itertools

import numpy as np
from scipy.linalg import expm

from trackweave.models.motion import (
    CONSTANT_ACCELERATION,
    CONSTANT_VELOCITY,
    MotionRule,
)


def discretise(drift, diffusion, interval):
    """Return F and Q of dx = A x dt + white noise, by Van Loan's matrix exponential."""
    size = drift.shape[0]
    block = np.zeros((2 * size, 2 * size))
    block[:size, :size], block[:size, size:] = -drift, diffusion
    block[size:, size:] = drift.T
    raised = expm(block * interval)
    moving = raised[size:, size:].T
    return moving, moving @ raised[:size, size:]


def linear(rule: MotionRule, mode: int, interval: float):
    """Return F and Q of a mode that does not turn, what it does not use forgotten."""
    dim, size, kind = rule.dim, rule.prior.size, rule.kind[mode]
    drift, diffusion = np.zeros((2, size, size))
    if kind == CONSTANT_VELOCITY:
        blocks = [0, dim]
    elif kind == CONSTANT_ACCELERATION:
        blocks = [0, dim, rule.acceleration_at]
    else:
        blocks = [0]
    for lower, upper in itertools.pairwise(blocks):
        drift[lower : lower + dim, upper : upper + dim] = np.eye(dim)
    last = slice(blocks[-1], blocks[-1] + dim)
    diffusion[last, last] = rule.noise[mode, 0] * np.eye(dim)
    moving, noise = discretise(drift, diffusion, interval)
    used = np.concatenate([np.arange(at, at + dim) for at in blocks])
    for row in np.setdiff1d(np.arange(size), used):
        moving[row] = 0.0
        noise[row, row] = rule.prior[row]
    return moving, noise


def turn(state, interval, rule: MotionRule):
    """Return where a turn takes a state: the velocity's direction rotates clockwise."""
    dim, at = rule.dim, rule.turn_at
    rate = state[at]
    drift = np.zeros((dim + dim, dim + dim))
    drift[:dim, dim:] = np.eye(dim)
    drift[dim, dim + 1], drift[dim + 1, dim] = rate, -rate
    after = np.zeros_like(state)
    after[: 2 * dim] = expm(drift * interval) @ state[: 2 * dim]
    after[at] = rate
    return after


def slopes(function, state, step):
    """Return the derivatives of a function by central differences."""
    columns = []
    for index in range(state.size):
        up, down = state.copy(), state.copy()
        up[index] += step[index]
        down[index] -= step[index]
        columns.append((function(up) - function(down)) / (2 * step[index]))
    return np.array(columns).T


def combine(mean, covariance, weight):
    """Return the moments of a mixture."""
    centre = weight @ mean
    apart = mean - centre
    return centre, np.einsum("k,kij->ij", weight, covariance) + (weight * apart.T) @ apart


def transitions(sojourn_time, interval):
    """Return how modes change, from row to column, all changes being equally likely."""
    stay = np.asarray(sojourn_time)
    rates = np.full((stay.size, stay.size), 1 / (stay.size - 1)) / stay[:, None]
    np.fill_diagonal(rates, -1 / stay)
    return expm(rates * interval)


def mix(mean, covariance, weight, transition):
    """Return each mode's mixed start and weight."""
    n_modes = weight.size
    after = weight @ transition
    moments = [
        combine(mean, covariance, weight * transition[:, mode] / after[mode])
        for mode in range(n_modes)
    ]
    return np.array([m for m, _ in moments]), np.array([p for _, p in moments]), after


def turn_by_points(mean, covariance, interval, rule: MotionRule):
    """Return the moments of a turn without noise over sigma points of velocity and turn rate."""
    bending = [rule.dim, rule.dim + 1, rule.turn_at]
    root = np.linalg.cholesky(covariance[np.ix_(bending, bending)])
    # How everything goes with the three: what is left beyond them moves in a straight line.
    spread = covariance[:, bending] @ np.linalg.inv(root).T * np.sqrt(3)
    points = np.concatenate([mean + spread.T, mean - spread.T])
    after = np.array([turn(point, interval, rule) for point in points])
    rest = covariance - spread @ spread.T / 3
    drift, _ = linear(rule._replace(kind=np.array([CONSTANT_VELOCITY])), 0, interval)
    apart = after - after.mean(axis=0)
    return after.mean(axis=0), apart.T @ apart / 6 + drift @ rest @ drift.T
