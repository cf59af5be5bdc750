"""How probable it is that the object of a sequence still lives."""

import math

import numpy as np

from trackweave.arrays import FloatArray

__all__ = ["log_weights"]


def log_weights(
    cost: FloatArray, tail: FloatArray, end_cost: float
) -> tuple[FloatArray, FloatArray]:
    """Return each sequence's log weight, and the share of it in which the object still lives."""
    # Where an object ended, none of its misses counts, but the end. It has ended since its last
    # report with 1 - p_s once a scan period has passed, with less before, and surely not at the
    # time of the report: with no more than what living on has cost by then leaves over.
    living = np.exp(-tail)
    both = living + np.minimum(math.exp(-end_cost), -np.expm1(-tail))
    return np.log(both) - cost, living / both
