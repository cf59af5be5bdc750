"""About which place a beam turns whose sensor nobody has placed."""

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.estimation.rotation import rotation_of
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
# A report this near the beam fits [rad]; so many of the first have to before all are asked.
FITS, LEAST_SHARE, FIRST = 0.25, 0.6, 120
RATES = 9


def place_of_turn(time: FloatArray, place: FloatArray) -> tuple[FloatArray, Rotation] | None:
    """Return where a turning beam stands, x, y [m], and how it turns; None where none fits."""
    # Times ascend [s]; places are x, y [m], shape (reports, 2). The turn comes first: reports of
    # one object are near one another, a turn apart, wherever the sensor stands.
    period = _usual_pause(time[:REPORTS], place[:REPORTS])
    if period is None:
        return None
    low, high = place.min(axis=0), place.max(axis=0)
    middle, half = (low + high) / 2, (0.5 + BEYOND) * (high - low)
    first = slice(0, FIRST)
    for _ in range(ROUNDS):
        axes = [np.linspace(-1.0, 1.0, STEPS) * side for side in half]
        grid = middle + np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2)
        shares = [_share(time[first] - time[0], place[first] - at, period) for at in grid]
        best = np.flatnonzero(np.array(shares) >= 0.97 * max(shares))
        if max(shares) < LEAST_SHARE:
            return None
        middle, half = grid[best].mean(axis=0), FINER * half
    east, north = (place - middle).T
    found = rotation_of(time, np.arctan2(east, north), period=period)
    return None if found is None else (middle, found)


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


def _share(elapsed: FloatArray, relative: FloatArray, period: float) -> float:
    """Return the greatest share of reports that a beam fits that turns about their origin."""
    azimuth = np.arctan2(relative[:, 0], relative[:, 1])
    rates = 2 * np.pi / period * (1 + FINEST * np.linspace(-1.0, 1.0, RATES))
    off = np.exp(1j * (azimuth - np.concatenate([-rates, rates])[:, None] * elapsed))
    middle = off.mean(axis=1, keepdims=True)
    return float(np.mean(np.abs(np.angle(off * np.conj(middle))) < FITS, axis=1).max())
