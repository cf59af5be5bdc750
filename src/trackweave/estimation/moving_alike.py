"""Tracks of two sensors that move alike, wherever they are."""

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.estimation.common_objects import Courses

__all__ = ["moving_alike", "usual_reach"]

# Two tracks are compared that are there together at so many times, and may be of one object where
# their difference drifts by no more than so many standard deviations.
FEWEST_TIMES, DRIFT = 4, 4.0
# Objects at rest drift as all others at rest do: one moves by so many deviations at least.
MOVED = 4.0
# So many deviations two tracks of one object differ at most.
WITHIN = 4.0
MOST_TRACKS = 300
"""So many of the longest tracks of either side are compared."""


def usual_reach(courses: Courses) -> float:
    """Return how far two tracks of one object differ at most, but for biases [m]."""
    return WITHIN * float(np.sqrt(2.0 * np.median(courses.spread)))


def moving_alike(
    courses: Courses, own: IntArray, others: IntArray
) -> tuple[FloatArray, FloatArray]:
    """Return how far own tracks lie from others that move as they do, and how these move."""
    # Shape (pairs, 2) each [m] and [m/s].
    lasting = np.isfinite(courses.place[:, :, 0]).sum(axis=1)
    own, others = (
        rows[np.argsort(-lasting[rows], kind="stable")[:MOST_TRACKS]] for rows in (own, others)
    )
    pairs = [_beside(courses, first, others) for first in own.tolist()]
    none = np.empty((0, 2))
    apart = np.concatenate([*(each[0] for each in pairs), none])
    return apart, np.concatenate([*(each[1] for each in pairs), none])


def _beside(courses: Courses, first: int, others: IntArray) -> tuple[FloatArray, FloatArray]:
    """Return the same of one track."""
    apart = courses.place[first] - courses.place[others]
    both = np.isfinite(apart[:, :, 0])
    count = both.sum(axis=1)
    enough = count >= FEWEST_TIMES
    apart, both, count = np.nan_to_num(apart[enough]), both[enough], count[enough]
    weight = both / np.maximum(count, 1)[:, None]
    when = np.where(both, courses.time - (weight @ courses.time)[:, None], 0.0)
    lasting = np.maximum((when**2).sum(axis=1), 1e-9)
    drift = np.einsum("pt,pti->pi", when, apart) / lasting[:, None]
    place = np.where(both[:, :, None], np.nan_to_num(courses.place[others[enough]]), 0.0)
    velocity = np.einsum("pt,pti->pi", when, place) / lasting[:, None]
    noise = (courses.spread[first] + courses.spread[others[enough]]) / lasting
    moves = (velocity**2).sum(axis=1) > MOVED**2 * noise
    alike = moves & ((drift**2).sum(axis=1) < DRIFT**2 * noise)
    return np.einsum("pt,pti->pi", weight, apart)[alike], velocity[alike]
