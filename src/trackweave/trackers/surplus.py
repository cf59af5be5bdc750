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
SURE = 0.95
"""Who is that certain to be there has no share in a doubt: of twenty who share one, each has."""
AT_ONCE = 256
"""Distances of so many tracks to all others are held at once."""


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
    # each other's, the same is asked of how many there are. Who stands alone is never too many.
    is_shown, is_surplus = chance >= FOLLOWED, np.zeros(chance.shape[0], dtype=np.bool_)
    rows = np.flatnonzero(is_shown)
    here, start = _places(position, covariance, rows)
    for row in np.argsort(chance[rows], kind="stable").tolist():
        weakest, beside = rows[row], here[start[row] : start[row + 1]]
        if beside.shape[0] < 2:
            continue
        shown = beside[is_shown[beside]]
        # Who is stronger than another that stays is not what is too much.
        if np.all(chance[shown] >= chance[weakest]):
            excess = shown.shape[0] - float(np.sum(chance[beside]))
            is_surplus[weakest] = excess > 0.5
            is_shown[weakest] = not is_surplus[weakest]
    return is_surplus


def _places(
    position: FloatArray, covariance: FloatArray, rows: IntArray
) -> tuple[IntArray, IntArray]:
    """Return who may be at the place of each row, itself included, and where each one's begin."""
    limit = quantile_of(position.shape[1], APART)
    # No direction is wider than all together: most are out of the question at once.
    width = np.trace(covariance, axis1=1, axis2=2)
    found = [np.empty((2, 0), dtype=np.int64)]
    for begin in range(0, rows.size, AT_ONCE):
        some = rows[begin : begin + AT_ONCE]
        # An axis at a time: sums over two or three numbers take longer than all else here.
        square = sum(np.subtract.outer(axis[some], axis) ** 2 for axis in position.T)
        own, other = np.nonzero(square <= limit * (width[some, None] + width))
        away = position[other] - position[some[own]]
        spread = covariance[other] + covariance[some[own]]
        scaled = np.linalg.solve(spread, away[:, :, None])[:, :, 0]
        is_near = np.sum(away * scaled, axis=1) <= limit
        found.append(np.array([own + begin, other])[:, is_near])
    own, other = np.concatenate(found, axis=1)
    return other, np.searchsorted(own, np.arange(rows.size + 1))
