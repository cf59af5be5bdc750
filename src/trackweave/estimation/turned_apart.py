"""Whose north is so far off that none of its tracks is near those of others.

Turned about the sensor by the right angle its tracks are those of others: as far from it at the
same times, and in directions that differ by that angle.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from trackweave.arrays import FloatArray
from trackweave.estimation.common_objects import FEWEST_TIMES, Courses, courses_of
from trackweave.estimation.moving_alike import MOST_TRACKS, usual_reach
from trackweave.estimation.sightings import AZIMUTH, N_BIASES, RANGE, USUAL_BIASES, Sightings

__all__ = ["turned_apart"]

# So many pairs of tracks are the same angle apart, and so many times as many as any other; by so
# much at least, in units of how exact that is.
FEWEST, TIMES, CLEAR = 6, 2.0, 2.0
# Within twice so much north is then as found.
SURE = 0.5
# Ranges may be wrong by so many of the usual biases as well, and by so much that no height is told
# of [m].
LONGER, HIGH = 2.0, 1500.0
# Nearer than so many times the reach of two tracks a direction tells nothing.
FAR = 5.0


class _Turn(NamedTuple):
    """By how much a sensor's azimuths are too great."""

    n_pairs: int  # Of tracks that say so
    angle: float  # [rad]
    within: float  # How far off that may be [rad]


def turned_apart(sightings: Sightings, may: NDArray[np.bool_]) -> tuple[FloatArray, FloatArray]:
    """Return how far off azimuths are as biases, 0 for none, and how sure; shape (sensors, 6)."""
    # Only those of whom that number ``may`` be other than told, shape (sensors, 6).
    found = np.zeros((sightings.n_sensors, N_BIASES))
    sure = np.full(found.shape, np.inf)
    sees = np.bincount(sightings.track_sensor, minlength=sightings.n_sensors) > 0
    left = np.flatnonzero(sees & sightings.is_polar & may[:, AZIMUTH]).tolist()
    while left:
        courses = courses_of(sightings, found)
        turns = {
            each: turn for each in left if (turn := _turn(sightings, courses, each)) is not None
        }
        if not turns:
            break
        most = max(turns, key=lambda each: turns[each].n_pairs)
        left.remove(most)
        found[most, AZIMUTH] = turns[most].angle
        sure[most, AZIMUTH] = SURE * turns[most].within
    return found, sure


def _turn(sightings: Sightings, courses: Courses, sensor: int) -> _Turn | None:
    """Return by how much a sensor is clearly turned beside all others; None for not."""
    centre = np.median(sightings.centre[sightings.sensor == sensor], axis=0)
    reach = usual_reach(courses)
    lasting = np.isfinite(courses.place[:, :, 0]).sum(axis=1)
    order = np.argsort(-lasting, kind="stable")
    is_own = sightings.track_sensor[order] == sensor
    own, others = order[is_own][:MOST_TRACKS], order[~is_own][:MOST_TRACKS]
    away = courses.place - centre
    distance, azimuth = (
        np.hypot(away[..., 0], away[..., 1]),
        np.arctan2(away[..., 0], away[..., 1]),
    )
    angles, widths = [np.empty(0)], [np.empty(0)]
    high = HIGH if np.isnan(sightings.height).all() else 0.0
    slack = reach + LONGER * USUAL_BIASES[RANGE] + high
    for each in own.tolist():
        off = np.abs(distance[each] - distance[others])
        far = distance[others] > FAR * reach
        both = np.isfinite(off) & far
        count = both.sum(axis=1)
        near = (off <= slack) | ~both
        fits = (count >= FEWEST_TIMES) & near.all(axis=1)
        for other in np.flatnonzero(fits).tolist():
            at = both[other]
            turn = azimuth[each, at] - azimuth[others[other], at]
            mean = float(np.angle(np.exp(1j * turn).mean()))
            width = reach / float(np.median(distance[others[other], at]))
            if np.abs(np.angle(np.exp(1j * (turn - mean)))).max() <= width:
                angles.append(np.array([mean]))
                widths.append(np.array([width]))
    return _voted(np.concatenate(angles), np.concatenate(widths))


def _voted(angle: FloatArray, width: FloatArray) -> _Turn | None:
    """Return the angle that most pairs tell, if clearly more than any other; None for none."""
    if angle.size < FEWEST:
        return None
    within = float(np.median(width))
    apart = np.abs(np.angle(np.exp(1j * (angle[:, None] - angle[None, :]))))
    count = (apart <= within).sum(axis=1)
    best = int(np.argmax(count))
    rest = int(count[apart[best] > 2.0 * within].max(initial=0))
    if count[best] < max(FEWEST, TIMES * rest):
        return None
    own = apart[best] <= within
    turn = float(angle[best] + np.median(np.angle(np.exp(1j * (angle[own] - angle[best])))))
    if abs(turn) < CLEAR * within:
        return None
    return _Turn(int(count[best]), turn, within)
