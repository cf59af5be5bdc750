"""Who stands so far from where it is told to that none of its tracks is near those of others."""

import numpy as np
from numpy.typing import NDArray

from trackweave.arrays import FloatArray, IntArray
from trackweave.estimation.common_objects import Courses, courses_of
from trackweave.estimation.moving_alike import moving_alike, usual_reach
from trackweave.estimation.sightings import EAST, N_BIASES, NORTH, Sightings
from trackweave.estimation.trees import n_within, tree_of

__all__ = ["displaced"]

# So many pairs differ by the same way, and so many times as many as differ by any other.
FEWEST, TIMES = 6, 2.0


def displaced(sightings: Sightings, may: NDArray[np.bool_]) -> FloatArray:
    """Return how far off sensors stand, roughly, as biases [m], shape (sensors, 6); 0 for none."""
    # Only those of whom both numbers ``may`` be other than told, shape (sensors, 6).
    found = np.zeros((sightings.n_sensors, N_BIASES))
    courses = courses_of(sightings, found)
    reach = usual_reach(courses)
    for sensor in np.unique(sightings.track_sensor)[::-1].tolist():
        if not may[sensor, [EAST, NORTH]].all():
            continue
        shift = _displacement(courses, sightings.track_sensor, sensor, reach)
        if shift is not None and np.linalg.norm(shift) > 2.0 * reach:
            found[sensor, [EAST, NORTH]] = shift
            if np.unique(sightings.track_sensor).size == 2:
                # The other is as far off the other way: nothing tells which it is.
                break
    return found


def _displacement(
    courses: Courses, track_sensor: IntArray, sensor: int, reach: float
) -> FloatArray | None:
    """Return the way by which most pairs of tracks differ that move alike, None for none."""
    own, others = np.flatnonzero(track_sensor == sensor), np.flatnonzero(track_sensor != sensor)
    every, _ = moving_alike(courses, own, others)
    if len(every) < FEWEST:
        return None
    count = n_within(tree_of(every), every, reach)
    best = every[np.argmax(count)]
    away = np.linalg.norm(every - best, axis=1)
    rest = int(count[away > 2.0 * reach].max(initial=0))
    if count.max() < max(FEWEST, TIMES * rest):
        return None
    return np.asarray(np.median(every[away <= reach], axis=0))
