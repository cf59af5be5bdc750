"""Tracks that cannot be told apart: of so many, as many are shown as there are objects.

Where objects meet and one of them ends, each track may be the one whose object is gone. The
doubt is shared: of four, none may fall below one half, though only three objects are left.
"""

import numpy as np
from numpy.typing import NDArray

from trackweave.arrays import FloatArray, IntArray
from trackweave.chi_squared import quantile_of

__all__ = ["FOLLOWED", "SURE", "surplus"]

FOLLOWED = 0.5
"""A track is shown while its object more probably than not lives and is in sight."""
APART = 0.99
"""Places are told apart by a test that lets so many of those pass that are one."""
SURE = 0.99
"""Who is that certain to be there has no share in a doubt."""
_MOST_AT_ONCE = 2**18
"""So many pairs are looked at at once."""


def surplus(position: FloatArray, covariance: FloatArray, chance: FloatArray) -> NDArray[np.bool_]:
    """Tell of which tracks there are too many at a place, shape (tracks,).

    Parameters
    ----------
    position, covariance
        Where each is, shapes (tracks, dim) [m] and (tracks, dim, dim) [m²].
    chance
        How probably each one's object is there to be seen; by itself it is shown from one half on.

    Returns
    -------
    Whether a track is one too many: the weakest at its place, where more would be shown than
    objects are expected there, by more than half an object.
    """
    # Each by itself would be shown where that is more probable than not; where objects may be
    # each other's, the same is asked of how many there are.
    is_shown, is_surplus = chance >= FOLLOWED, np.zeros(chance.shape[0], dtype=np.bool_)
    limit = quantile_of(position.shape[1], APART) if chance.size else 0.0
    whose, who = _beside(position, covariance, np.flatnonzero(is_shown), limit)
    end = np.searchsorted(whose, np.arange(chance.shape[0] + 1))
    # Who is alone and shown is at most half an object too many.
    crowded = np.diff(end) > 1
    for weakest in np.argsort(chance, kind="stable"):
        if not is_shown[weakest] or not crowded[weakest]:
            continue
        here = who[end[weakest] : end[weakest + 1]]
        shown = here[is_shown[here]]
        # Who is stronger than another that stays is not what is too much.
        if np.all(chance[shown] >= chance[weakest]):
            excess = shown.shape[0] - float(np.sum(chance[here]))
            is_surplus[weakest] = excess > 0.5
            is_shown[weakest] = not is_surplus[weakest]
    return is_surplus


def _beside(
    position: FloatArray, covariance: FloatArray, own: IntArray, limit: float
) -> tuple[IntArray, IntArray]:
    """Return pairs of one of some and who may be at its place, itself included, in order."""
    width = np.trace(covariance, axis1=1, axis2=2)
    together = max(1, _MOST_AT_ONCE // max(1, len(position)))
    found = [(own[:0], own[:0])]
    for begin in range(0, len(own), together):
        some = own[begin : begin + together]
        apart = np.zeros((len(some), len(position)))
        for axis in position.T:
            apart += (axis[some, None] - axis) ** 2
        # No direction is wider than all together: most are out of the question at once.
        row, other = np.nonzero(apart <= limit * (width[some, None] + width))
        one = some[row]
        away, spread = position[one] - position[other], covariance[other] + covariance[one]
        scaled = np.linalg.solve(spread, away[:, :, None])[:, :, 0]
        is_near = np.sum(away * scaled, axis=1) <= limit
        found.append((one[is_near], other[is_near]))
    whose, who = (np.concatenate(column) for column in zip(*found, strict=True))
    return whose, who
