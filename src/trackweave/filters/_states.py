"""States ahead in time, of one way to move or several; see ``models.motion.MotionRule``.

A state has a row per mode: means of shape (modes, n), covariances (modes, n, n) and the modes'
probabilities (modes,). Nothing here checks or raises; outputs must not be the inputs.
"""

import math

import numpy as np

from trackweave._loops import overwrite, overwrite_rows
from trackweave.arrays import ROUNDING, FloatArray
from trackweave.filters._kernels import predict_first
from trackweave.filters._turns import signed_noise, turn
from trackweave.jit import jit
from trackweave.models.motion import (
    CONSTANT_ACCELERATION,
    CONSTANT_VELOCITY,
    COORDINATED_TURN,
    RANDOM_WALK,
    MotionRule,
)


@jit
def advance(
    mean: FloatArray,
    covariance: FloatArray,
    weight: FloatArray,
    interval: float,
    motion: MotionRule,
    mean_out: FloatArray,
    covariance_out: FloatArray,
    weight_out: FloatArray,
) -> None:
    """Write the state after an interval [s]; 0 copies it.

    A negative one tells the state of before, as far as what has come since does not: the noise
    of the way back is as large as that of the way there.

    Several modes are mixed first, as the interacting multiple model does (Blom & Bar-Shalom 1988).
    """
    n_modes = mean.shape[0]
    if interval == 0.0:
        overwrite_rows(mean_out, mean)
        for mode in range(n_modes):
            overwrite_rows(covariance_out[mode], covariance[mode])
        overwrite(weight_out, weight)
        return
    if n_modes == 1:
        weight_out[0] = weight[0]
        move(0, mean[0], covariance[0], interval, motion, mean_out[0], covariance_out[0])
        return
    mix(
        mean, covariance, weight, interval, motion.basis, motion.decay,
        mean_out, covariance_out, weight_out,
    )  # fmt: skip
    for mode in range(n_modes):
        mixed_mean, mixed = mean_out[mode], covariance_out[mode]
        # These can be moved in place, and without handing over a whole motion, which costs more.
        if motion.kind[mode] == CONSTANT_VELOCITY:
            _move_straight(
                motion.dim, mixed_mean, mixed, interval, motion.noise[mode, 0], motion.prior,
                mixed_mean, mixed,
            )  # fmt: skip
        elif motion.kind[mode] == RANDOM_WALK:
            _stay(
                motion.dim, mixed_mean, mixed, interval, motion.noise[mode, 0], motion.prior,
                mixed_mean, mixed,
            )  # fmt: skip
        else:
            move(
                mode, mixed_mean.copy(), mixed.copy(), interval, motion, mixed_mean, mixed
            )  # fmt: skip


@jit
def is_straight(motion: MotionRule) -> bool:
    """Tell whether there is one mode, and a state is what `_kernels.predict` moves."""
    if motion.kind.shape[0] > 1 or motion.kind[0] != CONSTANT_VELOCITY:
        return False
    return bool(2 * motion.dim == motion.prior.shape[0])


@jit
def mix(
    mean: FloatArray,
    covariance: FloatArray,
    weight: FloatArray,
    interval: float,
    basis: FloatArray,
    decay: FloatArray,
    mean_out: FloatArray,
    covariance_out: FloatArray,
    weight_out: FloatArray,
) -> None:
    """Write what each mode starts from, and the modes' probabilities after the interval.

    A mode starts from the mixture of all modes that an object may have come from.
    """
    n_modes = mean.shape[0]
    coming = np.empty((n_modes, n_modes))
    changes(weight, interval, basis, decay, coming)
    for mode in range(n_modes):
        total = 0.0
        for before in range(n_modes):
            total += coming[mode, before]
        weight_out[mode] = total
        for before in range(n_modes):
            # Into a mode of no probability all come as they are.
            coming[mode, before] = coming[mode, before] / total if total > 0.0 else weight[before]
        combine(mean, covariance, coming[mode], mean_out[mode], covariance_out[mode])


@jit
def changes(
    weight: FloatArray,
    interval: float,
    basis: FloatArray,
    decay: FloatArray,
    coming_out: FloatArray,
) -> None:
    """Write how probable it is to be in a mode (row) after the interval and in another before."""
    n_modes = weight.shape[0]
    coming_out[:, :] = 0.0
    for index in range(n_modes):
        left = math.exp(-decay[index] * abs(interval))
        for mode in range(n_modes):
            for before in range(n_modes):
                coming_out[mode, before] += basis[0, before, index] * left * basis[1, index, mode]
    for mode in range(n_modes):
        for before in range(n_modes):
            # Over next to no time rounding may leave a chance a hair below nothing.
            coming_out[mode, before] = weight[before] * max(coming_out[mode, before], 0.0)


@jit
def combine(
    mean: FloatArray,
    covariance: FloatArray,
    weight: FloatArray,
    mean_out: FloatArray,
    covariance_out: FloatArray,
) -> None:
    """Write the mean and covariance of the mixture of all modes."""
    n_modes, size = mean.shape
    if n_modes == 1:
        overwrite(mean_out, mean[0])
        overwrite_rows(covariance_out, covariance[0])
        return
    for row in range(size):
        total = 0.0
        for mode in range(n_modes):
            total += weight[mode] * mean[mode, row]
        mean_out[row] = total
    for row in range(size):
        for column in range(row, size):
            total = 0.0
            for mode in range(n_modes):
                total += weight[mode] * (
                    covariance[mode, row, column]
                    + (mean[mode, row] - mean_out[row]) * (mean[mode, column] - mean_out[column])
                )
            covariance_out[row, column] = total
            covariance_out[column, row] = total


@jit
def move(
    mode: int,
    mean: FloatArray,
    covariance: FloatArray,
    interval: float,
    motion: MotionRule,
    mean_out: FloatArray,
    covariance_out: FloatArray,
) -> None:
    """Write the state of one mode after an interval other than 0 [s]."""
    if motion.kind[mode] == CONSTANT_VELOCITY:
        _move_straight(
            motion.dim, mean, covariance, interval, motion.noise[mode, 0], motion.prior,
            mean_out, covariance_out,
        )  # fmt: skip
        return
    if motion.kind[mode] == RANDOM_WALK:
        _stay(
            motion.dim, mean, covariance, interval, motion.noise[mode, 0], motion.prior,
            mean_out, covariance_out,
        )  # fmt: skip
        return
    size = mean.shape[0]
    moving, half = np.empty((size, size)), np.empty((size, size))
    linearise(mode, mean, covariance, interval, motion, mean_out, moving, covariance_out)
    for row in range(size):
        half[row, :] = 0.0
        for inner in range(size):
            factor = moving[row, inner]
            if factor != 0.0:
                for column in range(size):
                    half[row, column] += factor * covariance[inner, column]
    for row in range(size):
        for column in range(row, size):
            total = covariance_out[row, column]
            for inner in range(size):
                total += half[row, inner] * moving[column, inner]
            if row == column:
                total *= 1.0 + ROUNDING
            covariance_out[row, column] = total
            covariance_out[column, row] = total


@jit
def _move_straight(
    dim: int,
    mean: FloatArray,
    covariance: FloatArray,
    interval: float,
    process_noise: float,
    prior: FloatArray,
    mean_out: FloatArray,
    covariance_out: FloatArray,
) -> None:
    """Write the state of an object driven by white acceleration; the rest is forgotten.

    The outputs may be the inputs.
    """
    size = mean.shape[0]
    process_noise = process_noise if interval >= 0.0 else -process_noise
    predict_first(dim, mean, covariance, interval, process_noise, mean_out, covariance_out)
    for row in range(2 * dim, size):
        mean_out[row] = 0.0
        for column in range(size):
            covariance_out[row, column] = 0.0
            covariance_out[column, row] = 0.0
        covariance_out[row, row] = prior[row]


@jit
def _stay(
    dim: int,
    mean: FloatArray,
    covariance: FloatArray,
    interval: float,
    process_noise: float,
    prior: FloatArray,
    mean_out: FloatArray,
    covariance_out: FloatArray,
) -> None:
    """Write the state of an object that diffuses; the rest is forgotten.

    The outputs may be the inputs.
    """
    for row in range(mean.shape[0]):
        mean_out[row] = mean[row] if row < dim else 0.0
        for column in range(row, mean.shape[0]):
            value = covariance[row, column] if column < dim else 0.0
            if row == column:
                value = value + process_noise * abs(interval) if row < dim else prior[row]
                value *= 1.0 + ROUNDING
            covariance_out[row, column] = covariance_out[column, row] = value


@jit
def linearise(
    mode: int,
    mean: FloatArray,
    covariance: FloatArray,
    interval: float,
    motion: MotionRule,
    mean_out: FloatArray,
    moving_out: FloatArray,
    noise_out: FloatArray,
) -> None:
    """Write a mode's state ahead, and the matrices F and Q of P ahead = F P Fᵀ + Q.

    What the mode does not use is forgotten: rows of zeros in F and its prior in Q.
    """
    dim = motion.dim
    kind = motion.kind[mode]
    process_noise = signed_noise(mode, 0, interval, motion)
    moving_out[:, :] = 0.0
    noise_out[:, :] = 0.0
    mean_out[:] = 0.0
    for row in range(dim, mean.shape[0]):
        noise_out[row, row] = motion.prior[row]
    if kind == CONSTANT_ACCELERATION:
        at = motion.acceleration_at
        for axis in range(dim):
            place, speed, pull = axis, dim + axis, at + axis
            moving_out[place, place] = moving_out[speed, speed] = moving_out[pull, pull] = 1.0
            moving_out[place, speed] = moving_out[speed, pull] = interval
            moving_out[place, pull] = interval * interval / 2.0
            mean_out[place] = (
                mean[place] + interval * mean[speed] + interval * interval / 2.0 * mean[pull]
            )
            mean_out[speed] = mean[speed] + interval * mean[pull]
            mean_out[pull] = mean[pull]
            noise_out[place, place] = process_noise * interval**5 / 20.0
            noise_out[place, speed] = noise_out[speed, place] = process_noise * interval**4 / 8.0
            noise_out[place, pull] = noise_out[pull, place] = process_noise * interval**3 / 6.0
            noise_out[speed, speed] = process_noise * interval**3 / 3.0
            noise_out[speed, pull] = noise_out[pull, speed] = process_noise * interval**2 / 2.0
            noise_out[pull, pull] = process_noise * interval
        return
    for axis in range(dim):
        moving_out[axis, axis] = 1.0
        mean_out[axis] = mean[axis]
    if kind in (CONSTANT_VELOCITY, COORDINATED_TURN):
        for axis in range(dim):
            moving_out[axis, dim + axis] = interval
            moving_out[dim + axis, dim + axis] = 1.0
            mean_out[axis] += interval * mean[dim + axis]
            mean_out[dim + axis] = mean[dim + axis]
            noise_out[axis, axis] = process_noise * interval**3 / 3.0
            noise_out[axis, dim + axis] = process_noise * interval**2 / 2.0
            noise_out[dim + axis, axis] = process_noise * interval**2 / 2.0
            noise_out[dim + axis, dim + axis] = process_noise * interval
        if kind == COORDINATED_TURN:
            turn(mode, mean, covariance, interval, motion, mean_out, moving_out, noise_out)
        return
    for axis in range(dim):
        noise_out[axis, axis] = process_noise * interval
