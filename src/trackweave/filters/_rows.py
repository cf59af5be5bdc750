"""Many states at once, each by the kernels for one. Nothing here checks or raises."""

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.filters._kernels import correct
from trackweave.filters._smoothing import Readings, receive
from trackweave.filters._states import advance
from trackweave.filters._straight import let_back
from trackweave.jit import jit
from trackweave.models.motion import MotionRule


@jit
def advance_rows(
    mean: FloatArray,
    covariance: FloatArray,
    weight: FloatArray,
    interval: FloatArray,
    motion: MotionRule,
    mean_out: FloatArray,
    covariance_out: FloatArray,
    weight_out: FloatArray,
) -> None:
    """Write each state after its interval, as ``advance`` does."""
    for row in range(interval.shape[0]):
        advance(
            mean[row], covariance[row], weight[row], interval[row], motion,
            mean_out[row], covariance_out[row], weight_out[row],
        )  # fmt: skip


@jit
def let_back_rows(
    cross: FloatArray,
    ahead_mean: FloatArray,
    ahead: FloatArray,
    later_mean: FloatArray,
    later: FloatArray,
    mean: FloatArray,
    covariance: FloatArray,
) -> None:
    """Let what each later state knows into the earlier one, in place, as ``let_back`` does."""
    for row in range(mean.shape[0]):
        let_back(
            cross[row], ahead_mean[row], ahead[row], later_mean[row], later[row],
            mean[row], covariance[row],
        )  # fmt: skip


@jit
def correct_rows(
    mean: FloatArray,
    covariance: FloatArray,
    weight: FloatArray,
    innovation: FloatArray,
    spread: FloatArray,
    cross: FloatArray,
    log_likelihood: FloatArray,
) -> None:
    """Take each row's report into all modes of its state, in place.

    ``log_likelihood`` is that of the report by mode, shape (rows, modes); minus infinity in all
    of them leaves a state as it is.
    """
    rows, modes = log_likelihood.shape
    for row in range(rows):
        best = -np.inf
        for mode in range(modes):
            if weight[row, mode] > 0.0:
                log_likelihood[row, mode] += np.log(weight[row, mode])
                best = max(best, log_likelihood[row, mode])
            else:
                log_likelihood[row, mode] = -np.inf
        if best == -np.inf:
            continue
        total = 0.0
        for mode in range(modes):
            correct(
                mean[row, mode], covariance[row, mode], innovation[row, mode], spread[row, mode],
                cross[row, mode], mean[row, mode], covariance[row, mode],
            )  # fmt: skip
            weight[row, mode] = np.exp(log_likelihood[row, mode] - best)
            total += weight[row, mode]
        for mode in range(modes):
            weight[row, mode] /= total


@jit
def receive_rows(
    readings: Readings,
    motion: MotionRule,
    mean: FloatArray,
    covariance: FloatArray,
    weight: FloatArray,
) -> None:
    """Take each row's report, of a kind of ours, into its state in place, as ``receive`` does."""
    for row in range(readings.kind.shape[0]):
        # Of the reports before nothing is known here: each is wide with the share of all.
        receive(readings, row, motion, mean[row], covariance[row], weight[row], -1.0)
