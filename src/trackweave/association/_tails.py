"""Reports whose noise has heavy tails: most are narrow, a share is many times wider.

The contaminated normal distribution (Tukey 1960): N(0, R) with probability 1 − ε, N(0, k²R) with
ε. The density is that of the mixture, a gate lets through what either part does, and the state
after a report has the moments of both posteriors, by how probable the parts are. Without a share
of wide ones each function does what the one does that it calls. Nothing here checks or raises.
"""

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.association._nodes import Expectation, State
from trackweave.association._scoring import compare, take_in
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
