"""About which place a beam turns whose sensor nobody has placed."""

import numpy as np
from numpy.typing import NDArray

from trackweave.arrays import FloatArray
from trackweave.estimation.rotation import loose_rotation_of, rotation_of
from trackweave.models.rotation import Rotation

__all__ = ["place_of_turn"]

# So many successive reports are looked at, each beside so many later ones.
REPORTS, LATER = 300, 90
# Nearer than this share of what they fill, two are taken for reports of one object.
NEAR = 0.02
# The pause between them is a turn or several, but for chance: it is found to such a share.
FINEST = 0.04
# Places are tried on a grid over what reports fill and this much beyond, then on finer ones.
BEYOND, STEPS, FINER, ROUNDS = 0.5, 24, 0.25, 4
# A report this near the beam fits [rad], or with a loose stamp; so many of the first have to
# before all are asked.
FITS, LOOSELY, LEAST_SHARE, FIRST = 0.25, 0.75, 0.6, 120
RATES = 9
# One object alone, whose pause seems to be a turn, is no beam: that has so many in a turn.
LEAST_IN_TURN = 1.5
# Place and turn are made exact by so many reports at most, in so many steps, of which those count
# that are off by less than so many times as much as usual.
MOST_REPORTS, ITERATIONS, OUTLYING = 5000, 12, 4.0


def place_of_turn(time: FloatArray, place: FloatArray) -> tuple[FloatArray, Rotation] | None:
    """Return where a turning beam stands, x, y [m], and how it turns; None where none fits."""
    # Times ascend [s]; places are x, y [m], shape (reports, 2). The turn comes first: reports of
    # one object are near one another, a turn apart, wherever the sensor stands.
    period = _usual_pause(time[:REPORTS], place[:REPORTS])
    if period is None:
        return None
    # Nor are frames, that hold all objects at once and have one to a "turn".
    gaps = np.diff(time[:REPORTS])
    if period < LEAST_IN_TURN * float(np.median(gaps[gaps > 0])):
        return None
    middle = _middle(time, place, period, FITS)
    if middle is None:
        middle = _middle(time, place, period, LOOSELY)
    found = None if middle is None else _turn_about(time, place, middle, period)
    if middle is None or found is None:
        return None
    nearer = _refined(time, place, middle, found)
    better = _turn_about(time, place, nearer, found.period)
    return (middle, found) if better is None else (nearer, better)


def _middle(time: FloatArray, place: FloatArray, period: float, fits: float) -> FloatArray | None:
    """Return the place about which most of the first reports follow a beam, None for too few."""
    low, high = place.min(axis=0), place.max(axis=0)
    middle, half = (low + high) / 2, (0.5 + BEYOND) * (high - low)
    elapsed, there = time[:FIRST] - time[0], place[:FIRST]
    rates = 2 * np.pi / period * (1 + FINEST * np.linspace(-1.0, 1.0, RATES))
    back = np.exp(1j * np.concatenate([rates, -rates])[:, np.newaxis] * elapsed)
    for _ in range(ROUNDS):
        axes = [np.linspace(-1.0, 1.0, STEPS) * side for side in half]
        grid = middle + np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2)
        shares = np.array([_share(there - at, back, fits) for at in grid])
        best = np.flatnonzero(shares >= 0.97 * shares.max())
        if shares.max() < LEAST_SHARE:
            return None
        middle, half = grid[best].mean(axis=0), FINER * half
    return np.asarray(middle)


def _turn_about(
    time: FloatArray, place: FloatArray, at: FloatArray, period: float
) -> Rotation | None:
    """Return how a beam turns about a place, None where none does."""
    east, north = (place - at).T
    azimuth = np.arctan2(east, north)
    exact = rotation_of(time, azimuth, period=period)
    return loose_rotation_of(time, azimuth, period=period) if exact is None else exact


def _refined(time: FloatArray, place: FloatArray, at: FloatArray, turn: Rotation) -> FloatArray:
    """Return the place about which reports are least off a steady turn, by least squares."""
    chosen = np.linspace(0, time.size - 1, min(time.size, MOST_REPORTS)).astype(np.int64)
    moment, there = turn.turned(time[chosen]), place[chosen]
    moment = 2.0 * np.pi * turn.direction * (moment - moment[0])
    for _ in range(ITERATIONS):
        east, north = (there - at).T
        off = np.arctan2(east, north) - moment
        off = np.angle(np.exp(1j * (off - np.angle(np.exp(1j * off).sum()))))
        square = np.maximum(east**2 + north**2, 1e-300)
        slope = np.stack([-north / square, east / square, -np.ones_like(off), -moment], axis=1)
        near = np.abs(off) <= OUTLYING * float(np.median(np.abs(off)))
        step, *_ = np.linalg.lstsq(slope[near], -off[near], rcond=None)
        at = at + step[:2]
    return at


def _usual_pause(time: FloatArray, place: FloatArray) -> float | None:
    """Return the shortest pause that stands out between reports that are near one another [s]."""
    extent = float(np.linalg.norm(np.ptp(place, axis=0)))
    ahead = [
        (time[k:] - time[:-k])[np.linalg.norm(place[k:] - place[:-k], axis=1) < NEAR * extent]
        for k in range(1, min(LATER, time.size))
    ]
    pauses = np.sort(np.concatenate(ahead or [np.empty(0)]))
    pauses = pauses[pauses > 0]
    if pauses.size < FIRST // 4:
        return None
    near = np.searchsorted(pauses, (1 + FINEST) * pauses) - np.searchsorted(
        pauses, (1 - FINEST) * pauses
    )
    chance = pauses.size * 2 * FINEST * pauses / pauses[-1]
    return float(pauses[np.argmax((near - chance) / np.sqrt(chance + 1.0))])


def _share(relative: FloatArray, back: NDArray[np.complex128], fits: float) -> float:
    """Return the greatest share of reports that a beam fits that turns about their origin."""
    # Each rate's turn is taken back, shape (rates, reports); what is left points one way. Of unit
    # vectors the cosine says how far apart they are, without an angle of any.
    side = relative[:, 1] + 1j * relative[:, 0]
    off = back * (side / np.maximum(np.abs(side), 1e-300))
    middle = off.mean(axis=1, keepdims=True)
    apart = (off * np.conj(middle)).real > np.cos(fits) * np.abs(middle)
    return float(apart.mean(axis=1).max())
