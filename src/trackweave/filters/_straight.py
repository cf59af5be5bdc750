"""One object's states over all of its positions, where it moves at nearly constant velocity.

Rauch, Tung and Striebel's smoother, and what `_smoothing` comes to in this most frequent case;
it is compiled many times sooner. Nothing here checks.
"""

import math

import numpy as np

from trackweave._loops import overwrite, overwrite_rows
from trackweave.arrays import FloatArray, IntArray
from trackweave.filters._kernels import invert_sum, predict, update
from trackweave.filters._measuring import invert_many
from trackweave.jit import jit


@jit
def smooth_straight(
    time: FloatArray,
    has_report: IntArray,
    position: FloatArray,
    sigma: FloatArray,
    process_noise: float,
    mean: FloatArray,
    covariance: FloatArray,
) -> None:
    """Write the states at all moments; the first rows hold the state before any report."""
    length, size = mean.shape
    dim = size // 2
    ahead_mean, ahead = np.empty((length, size)), np.empty((length, size, size))
    noise, inverse = np.zeros((1, dim, dim)), np.empty((dim, dim))
    for moment in range(length):
        if moment > 0:
            predict(
                mean[moment - 1], covariance[moment - 1], time[moment] - time[moment - 1],
                process_noise, mean[moment], covariance[moment],
            )  # fmt: skip
        overwrite(ahead_mean[moment], mean[moment])
        overwrite_rows(ahead[moment], covariance[moment])
        if has_report[moment] == 1:
            for axis in range(dim):
                noise[0, axis, axis] = sigma[moment, axis] ** 2
            if invert_sum(covariance[moment], noise, 0, inverse) < math.inf:
                update(
                    ahead_mean[moment], ahead[moment], position[moment], inverse,
                    mean[moment], covariance[moment],
                )  # fmt: skip
    cross, gain, turned = np.empty((size, size)), np.empty((size, size)), np.empty((size, size))
    for moment in range(length - 2, -1, -1):
        interval = time[moment + 1] - time[moment]
        if interval == 0.0:
            overwrite(mean[moment], mean[moment + 1])
            overwrite_rows(covariance[moment], covariance[moment + 1])
            continue
        if not invert_many(ahead[moment + 1], turned) < math.inf:
            continue
        for row in range(size):
            for axis in range(dim):
                speed = covariance[moment, row, dim + axis]
                cross[row, axis] = covariance[moment, row, axis] + interval * speed
                cross[row, dim + axis] = speed
        for row in range(size):
            for column in range(size):
                value = 0.0
                for inner in range(size):
                    value += cross[row, inner] * turned[inner, column]
                gain[row, column] = value
        _step_back(gain, ahead_mean[moment + 1], ahead[moment + 1], mean, covariance, moment)


@jit
def _step_back(
    gain: FloatArray,
    ahead_mean: FloatArray,
    ahead: FloatArray,
    mean: FloatArray,
    covariance: FloatArray,
    moment: int,
) -> None:
    """Let what a later moment knows into an earlier one, in place."""
    size = gain.shape[0]
    half = np.empty((size, size))
    for row in range(size):
        for inner in range(size):
            mean[moment, row] += gain[row, inner] * (mean[moment + 1, inner] - ahead_mean[inner])
        for column in range(size):
            value = 0.0
            for inner in range(size):
                value += gain[row, inner] * (
                    covariance[moment + 1, inner, column] - ahead[inner, column]
                )
            half[row, column] = value
    for row in range(size):
        for column in range(row, size):
            value = 0.0
            for inner in range(size):
                value += half[row, inner] * gain[column, inner]
            covariance[moment, row, column] += value
            if row != column:
                covariance[moment, column, row] = covariance[moment, row, column]
