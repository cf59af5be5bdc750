"""One object's states over all of its positions, where it moves at nearly constant velocity.

Rauch, Tung and Striebel's smoother, and what `_smoothing` comes to in this most frequent case;
it is compiled many times sooner. Nothing here checks.
"""

import numpy as np

from trackweave._loops import overwrite, overwrite_rows
from trackweave.arrays import FloatArray, IntArray
from trackweave.filters._kernels import add_shift, narrow, predict, update, whiten
from trackweave.filters._measuring import factorise
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
    noise = np.zeros((dim, dim))
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
                noise[axis, axis] = sigma[moment, axis] ** 2
            update(
                ahead_mean[moment], ahead[moment], position[moment], noise,
                mean[moment], covariance[moment],
            )  # fmt: skip
    cross = np.empty((size, size))
    for moment in range(length - 2, -1, -1):
        interval = time[moment + 1] - time[moment]
        if interval == 0.0:
            overwrite(mean[moment], mean[moment + 1])
            overwrite_rows(covariance[moment], covariance[moment + 1])
            continue
        for row in range(size):
            for axis in range(dim):
                speed = covariance[moment, row, dim + axis]
                cross[row, axis] = covariance[moment, row, axis] + interval * speed
                cross[row, dim + axis] = speed
        let_back(
            cross, ahead_mean[moment + 1], ahead[moment + 1], mean[moment + 1],
            covariance[moment + 1], mean[moment], covariance[moment],
        )  # fmt: skip


@jit
def let_back(
    cross: FloatArray,
    ahead_mean: FloatArray,
    ahead: FloatArray,
    later_mean: FloatArray,
    later: FloatArray,
    mean: FloatArray,
    covariance: FloatArray,
) -> None:
    """Let what a later moment knows into an earlier one, in place.

    With the gain G = C P⁻¹ of the state foreseen, P, and the root R of the later covariance this
    is (own − C P⁻¹ Cᵀ) + G R (G R)ᵀ: two parts of which neither can be negative, where
    own + G (R Rᵀ − P) Gᵀ would be what two large numbers leave of each other.
    """
    size = cross.shape[0]
    root, part, sharp = np.empty((size, size)), np.empty((size, size)), np.zeros((size, size))
    off, shift = np.empty(size), np.empty(size)
    whiten(ahead, cross, root, part)
    for row in range(size):
        off[row] = later_mean[row] - ahead_mean[row]
    add_shift(root, part, off, mean)
    narrow(covariance, part, covariance)
    factorise(later, sharp)
    for inner in range(size):
        for row in range(size):
            off[row] = sharp[row, inner]
            shift[row] = 0.0
        add_shift(root, part, off, shift)
        for row in range(size):
            for column in range(size):
                covariance[row, column] += shift[row] * shift[column]
