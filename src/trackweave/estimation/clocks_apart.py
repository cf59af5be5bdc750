"""Whose clocks differ so much that tracks of other objects lie nearer than those of the same."""

from itertools import combinations
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from trackweave.arrays import FloatArray, IntArray
from trackweave.estimation.common_objects import Courses, courses_of
from trackweave.estimation.moving_alike import moving_alike, usual_reach
from trackweave.estimation.sightings import CLOCK, EAST, N_BIASES, NORTH, Sightings

__all__ = ["clocks_apart"]

# So many pairs of tracks are the same time apart, and so many times as many as any other.
FEWEST, TIMES = 6, 2.0
# Within twice so much clocks and places are then as found.
SURE = 0.5


class _Apart(NamedTuple):
    """By how much the clocks of two sensors differ."""

    n_pairs: int  # Of tracks that say so
    ahead: float  # The second's times before the first's [s]
    within: float  # How far off that may be [s]


def clocks_apart(sightings: Sightings, may: NDArray[np.bool_]) -> tuple[FloatArray, FloatArray]:
    """Return how far off clocks are as biases, 0 for none, and how sure; shape (sensors, 6)."""
    # Only those of whom that number ``may`` be other than told, shape (sensors, 6); of others it
    # is right. Clocks that nothing but one another tells of are off by nothing on average.
    found = np.zeros((sightings.n_sensors, N_BIASES))
    courses, group = courses_of(sightings, found), np.arange(sightings.n_sensors)
    clock, sure = found[:, CLOCK], np.full(found.shape, np.inf)
    between = {
        pair: apart
        for pair in combinations(range(sightings.n_sensors), 2)
        if (apart := _apart(courses, *_tracks(sightings, pair))) is not None
    }
    for first, second in sorted(between, key=lambda pair: -between[pair].n_pairs):
        if group[first] != group[second]:
            joined, apart = group == group[second], between[first, second]
            clock[joined] += clock[first] + apart.ahead - clock[second]
            group[joined] = group[first]
            own = [first, second]
            sure[own, CLOCK] = np.minimum(sure[own, CLOCK], SURE * apart.within)
            sure[np.ix_(own, [EAST, NORTH])] = SURE * usual_reach(courses)
    for each in np.unique(group):
        own = group == each
        known = own & ~may[:, CLOCK]
        clock[own] -= np.mean(clock[known if known.any() else own])
    clock[~may[:, CLOCK]] = 0.0
    return found, sure


def _tracks(sightings: Sightings, pair: tuple[int, int]) -> list[IntArray]:
    return [np.flatnonzero(sightings.track_sensor == each) for each in pair]


def _apart(courses: Courses, own: IntArray, others: IntArray) -> _Apart | None:
    """Return by how much two sensors' clocks clearly differ, by their tracks; None for not."""
    apart, velocity = moving_alike(courses, own, others)
    speed, reach = np.hypot(*velocity.T), usual_reach(courses)
    across = (apart[:, 0] * velocity[:, 1] - apart[:, 1] * velocity[:, 0]) / speed
    near = np.abs(across) < reach
    if np.count_nonzero(near) < FEWEST:
        return None
    # Who is told later is shown farther back on its way.
    ahead = np.sort((apart * velocity).sum(axis=1)[near] / speed[near] ** 2)
    within = reach / float(np.median(speed[near]))
    last = np.searchsorted(ahead, ahead + within, "right")
    count = last - np.searchsorted(ahead, ahead - within)
    away = np.abs(ahead - ahead[np.argmax(count)])
    rest = int(count[away > 2.0 * within].max(initial=0))
    if count.max() < max(FEWEST, TIMES * rest):
        return None
    return _Apart(int(count.max()), float(np.median(ahead[away <= within])), within)
