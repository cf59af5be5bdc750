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


def usual_reach(courses: Courses) -> float:
    """Return how far two tracks of one object differ at most, but for biases [m]."""
    return WITHIN * float(np.sqrt(2.0 * np.median(courses.spread)))


def moving_alike(courses: Courses, first: int, others: IntArray) -> tuple[FloatArray, FloatArray]:
    """Return how far a track lies from others that move as it does, and how these move."""
    # Shape (pairs, 2) each [m] and [m/s].
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
