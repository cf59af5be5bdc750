"""How probable it is that the object of a sequence still lives."""

import math

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.association._rhythm import CHANGED, COUNT, INTERVAL, LOST, TIME

__all__ = ["intervals_since", "log_weights", "still_lives"]

SILENT = 15.0
"""Who falls silent does so for about so many of its reporting intervals."""


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


def intervals_since(rhythm: FloatArray, rows: IntArray, time: float) -> FloatArray:
    """Return for how many of its own intervals each row's object was not heard, 0 for unknown."""
    since, count = np.zeros(rows.shape[0]), rhythm[rows, COUNT]
    if not count.any():
        return since
    heard = np.flatnonzero(count > 0.0)
    own = rhythm[rows[heard]]
    since[heard] = np.maximum((time - own[:, TIME]) * np.exp(-own[:, INTERVAL]), 0.0)
    return since


def still_lives(lives: FloatArray, since: FloatArray) -> FloatArray:
    """Return how probable it is that objects live that report themselves, after that silence."""
    if not since.any():
        return lives
    # Reports are lost one by one, or its object fell silent, or it lives no more.
    heard = LOST ** np.maximum(since - 1.0, 0.0) + CHANGED * np.exp(-since / SILENT)
    alive = lives * np.minimum(heard, 1.0)
    return np.asarray(alive / np.maximum(alive + 1.0 - lives, 1e-300))
