"""Reports whose noise has heavy tails: most are narrow, a share is many times wider.

The contaminated normal distribution (Tukey 1960): N(0, R) with probability 1 − ε, N(0, k²R) with
ε. The density is that of the mixture, a gate lets through what either part does, and the state
after a report has the moments of both posteriors, by how probable the parts are. Without a share
of wide ones each function does what the one does that it calls. Nothing here checks or raises.
"""

import math

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.association._nodes import Expectation, State
from trackweave.association._scoring import LOG_TWO_PI, compare, take_in
from trackweave.filters._measuring import invert
from trackweave.filters._tails import log_of_either, mix_with, share_of_wide
from trackweave.jit import jit


@jit
def compare_either(
    kind: int,
    measurement: FloatArray,
    index: int,
    weight: FloatArray,
    expected: Expectation,
    noise: FloatArray,
    share: float,
    scale: float,
) -> tuple[float, float]:
    """Return the least squared distance of a report in either part, and its log likelihood."""
    distance, narrow = compare(
        kind, measurement, index, weight, expected.mean, expected.inverse,
        expected.log_determinant, expected.innovation,
    )  # fmt: skip
    if share == 0.0:
        return distance, narrow
    modes, width = expected.mean.shape
    spread, inverse = np.empty((width, width)), np.empty((modes, width, width))
    log_determinant = np.empty(modes)
    for mode in range(modes):
        for row in range(width):
            for column in range(width):
                spread[row, column] = (
                    expected.spread[mode, row, column] + (scale * scale - 1.0) * noise[row, column]
                )
        log_determinant[mode] = invert(spread, inverse[mode])
    far, wide = compare(
        kind, measurement, index, weight, expected.mean, inverse, log_determinant,
        expected.innovation,
    )  # fmt: skip
    return min(distance, far), log_of_either(narrow, wide, share)


@jit
def compare_in_plane(
    measurement: FloatArray,
    index: int,
    noise: FloatArray,
    setting: int,
    mean: FloatArray,
    covariance: FloatArray,
    weight: FloatArray,
    share: float,
    scale: float,
) -> tuple[float, float]:
    """Return what `compare_either` does of a position of two numbers, several times as fast."""
    nearest, narrow = math.inf, -math.inf
    for part in range(1 if share == 0.0 else 2):
        wider = part * (scale * scale - 1.0)
        largest, total = -math.inf, 0.0
        for mode in range(weight.shape[0]):
            s00 = covariance[mode, 0, 0] + noise[setting, 0, 0] + wider * noise[setting, 0, 0]
            s01 = covariance[mode, 0, 1] + noise[setting, 0, 1] + wider * noise[setting, 0, 1]
            s11 = covariance[mode, 1, 1] + noise[setting, 1, 1] + wider * noise[setting, 1, 1]
            determinant = s00 * s11 - s01 * s01
            if not (s00 > 0.0 and determinant > 0.0):
                continue
            x, y = measurement[index, 0] - mean[mode, 0], measurement[index, 1] - mean[mode, 1]
            distance = (s11 / determinant * x - s01 / determinant * y) * x + (
                s00 / determinant * y - s01 / determinant * x
            ) * y
            nearest = min(nearest, distance)
            value = -0.5 * (distance + math.log(determinant) + 2 * LOG_TWO_PI)
            if weight.shape[0] > 1:
                value += math.log(weight[mode]) if weight[mode] > 0.0 else -math.inf
            if value > largest:
                total = total * math.exp(largest - value) + 1.0
                largest = value
            elif value > -math.inf:
                total += math.exp(value - largest)
        either = largest + math.log(total) if total > 0.0 else -math.inf
        if part == 0:
            narrow = either
    return nearest, narrow if share == 0.0 else log_of_either(narrow, either, share)


@jit
def take_in_either(
    kind: int,
    measurement: FloatArray,
    noise: FloatArray,
    platform: FloatArray,
    state: State,
    dim: int,
    unscented: bool,
    expected: Expectation,
    share: float,
    scale: float,
    mean_out: FloatArray,
    covariance_out: FloatArray,
    weight_out: FloatArray,
) -> float:
    """Write the state after a report; return how probable the wide part is then."""
    narrow = take_in(
        kind, measurement, noise, platform, state, dim, unscented, expected,
        mean_out, covariance_out, weight_out,
    )  # fmt: skip
    if share == 0.0:
        return 0.0
    mean, covariance = np.empty_like(mean_out), np.empty_like(covariance_out)
    weight = np.empty_like(weight_out)
    wide = take_in(
        kind, measurement, scale * scale * noise, platform, state, dim, unscented, expected,
        mean, covariance, weight,
    )  # fmt: skip
    part = share_of_wide(narrow, wide, share)
    for mode in range(weight.shape[0]):
        near, far = (1.0 - part) * weight_out[mode], part * weight[mode]
        weight_out[mode] = near + far
        own = far / (near + far) if near + far > 0.0 else part
        mix_with(mean[mode], covariance[mode], own, mean_out[mode], covariance_out[mode])
    return part
