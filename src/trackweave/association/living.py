"""How probable it is that the object of a sequence still lives."""

import math
from collections.abc import Sequence

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.association._rhythm import (
    CHANGED,
    COUNT,
    INTERVAL,
    LOST,
    MOST_COUNT,
    SENSOR,
    TIME,
)

__all__ = ["intervals_since", "log_weights", "still_lives", "usual_interval"]

SILENT = 15.0
"""Who falls silent does so for about so many of its reporting intervals."""
NEARLY_ALL, FEWEST, AS_OTHERS = 0.9, 5, 2.0
"""The usual interval is above that of such a share of at least so many objects; it counts as so
many of an object's own."""


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


def usual_interval(rhythms: Sequence[tuple[FloatArray, IntArray]]) -> float:
    """Return within how long nearly every object reports itself again [s], 0 for unknown."""
    # Of rooms the rhythms and an object's row each. Most have none, where sensors look by turns.
    known = np.concatenate([
        rhythm[rows[rhythm[rows, COUNT] >= MOST_COUNT], INTERVAL] for rhythm, rows in rhythms
    ])  # fmt: skip
    return math.exp(float(np.quantile(known, NEARLY_ALL))) if known.size >= FEWEST else 0.0


def intervals_since(rhythm: FloatArray, rows: IntArray, time: float, usual: float) -> FloatArray:
    """Return for how many of its own intervals each row's object was not heard, 0 for unknown."""
    # Whose few reports tell little of its interval is taken for one of the others, whose
    # interval is the ``usual`` one [s].
    since, count = np.zeros(rows.shape[0]), rhythm[rows, COUNT]
    is_known = count > 0.0
    if usual > 0.0:
        is_known |= rhythm[rows, SENSOR] >= 0.0
    if not is_known.any():
        return since
    heard = np.flatnonzero(is_known)
    own, count = rhythm[rows[heard]], count[heard]
    interval = own[:, INTERVAL]
    if usual > 0.0:
        # No more than that: who reports often is known soon.
        others = (count * interval + AS_OTHERS * math.log(usual)) / (count + AS_OTHERS)
        is_few = (count < MOST_COUNT) & ((count == 0.0) | (others < interval))
        interval = np.where(is_few, others, interval)
    since[heard] = np.maximum((time - own[:, TIME]) * np.exp(-interval), 0.0)
    return since


def still_lives(lives: FloatArray, since: FloatArray) -> FloatArray:
    """Return how probable it is that objects live that report themselves, after that silence."""
    if not since.any():
        return lives
    # Reports are lost one by one, or its object fell silent, or it lives no more.
    heard = LOST ** np.maximum(since - 1.0, 0.0) + CHANGED * np.exp(-since / SILENT)
    alive = lives * np.minimum(heard, 1.0)
    return np.asarray(alive / np.maximum(alive + 1.0 - lives, 1e-300))
