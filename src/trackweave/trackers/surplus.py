"""Tracks that cannot be told apart: of so many, as many are shown as there are objects.

Where objects meet and one of them ends, each track may be the one whose object is gone. The
doubt is shared: of four, none may fall below one half, though only three objects are left.
"""

import numpy as np
from numpy.typing import NDArray

from trackweave.arrays import FloatArray
from trackweave.chi_squared import quantile_of
from trackweave.trackers._surplus import lower_surplus

__all__ = ["FOLLOWED", "SURE", "surplus"]

FOLLOWED = 0.5
"""A track is shown while its object more probably than not lives and is in sight."""
APART = 0.99
"""Places are told apart by a test that lets so many of those pass that are one."""
SURE = 0.95
"""Who is that certain to be there has no share in a doubt: of twenty who share one, each has."""


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
    is_followed = chance >= FOLLOWED
    rows, is_shown = np.flatnonzero(is_followed), is_followed.copy()
    weakest_first = rows[np.argsort(chance[rows], kind="stable")]
    limit = quantile_of(position.shape[1], APART)
    found = np.ascontiguousarray(position), np.ascontiguousarray(covariance)
    lower_surplus(*found, chance, weakest_first, limit, is_shown)
    return is_followed & ~is_shown
