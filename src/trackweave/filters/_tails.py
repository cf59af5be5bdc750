"""Two parts of a mixture, a narrow and a wide one. Nothing here checks or raises."""

import math

from trackweave.arrays import FloatArray
from trackweave.jit import jit


@jit
def log_of_either(narrow: float, wide: float, share: float) -> float:
    """Return ln((1 − ε) exp(narrow) + ε exp(wide)) of two log likelihoods."""
    narrow += math.log1p(-share)
    wide += math.log(share)
    most, least = max(narrow, wide), min(narrow, wide)
    if most == -math.inf:
        return most
    return most + math.log1p(math.exp(least - most))


@jit
def share_of_wide(narrow: float, wide: float, share: float) -> float:
    """Return how probable the wide part is after a report of these log likelihoods."""
    if wide == -math.inf:
        return 0.0
    return math.exp(wide + math.log(share) - log_of_either(narrow, wide, share))


@jit
def share_after(wild: float, share: float, persistence: float) -> float:
    """Return how probable the wide part is beforehand, where it was so probable the last time.

    Of two parts that follow each other as a Markov chain, so far correlated from one to the next.
    Negative where there was no last time.
    """
    if persistence == 0.0 or wild < 0.0:
        return share
    return share + persistence * (wild - share)


@jit
def mix_with(
    mean: FloatArray, covariance: FloatArray, share: float, mean_out: FloatArray,
    covariance_out: FloatArray,
) -> None:  # fmt: skip
    """Mix a share of another state into one in place, keeping the mixture's moments."""
    size = mean.shape[0]
    for row in range(size):
        for column in range(row, size):
            apart = (mean[row] - mean_out[row]) * (mean[column] - mean_out[column])
            value = covariance_out[row, column] + share * (
                covariance[row, column] - covariance_out[row, column] + (1.0 - share) * apart
            )
            covariance_out[row, column] = covariance_out[column, row] = value
    for row in range(size):
        mean_out[row] += share * (mean[row] - mean_out[row])
