"""Points of frames linked by their distances alone, one frame after the other.

Every point that was seen last is followed by at most one of the next frame, within a range, so
that the sum of squared distances is least, where to be followed by none costs the square of the
range [1]_. Unlike the other trackers this one assumes nothing of how objects move, and knows
neither misses nor false points but by the frames for which it remembers.

References
----------
.. [1] J. C. Crocker, D. G. Grier, Methods of digital video microscopy for colloidal studies,
   *Journal of Colloid and Interface Science* 179 (1), 1996, pp. 298-310, section 3.
"""

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.estimation.trees import all_within, tree_of
from trackweave.trackers.pairing import Offers, one_to_one

__all__ = ["linked"]

ALONE = 1.0 + 1e-9
"""Squared ranges that it costs to be followed by none: a step of the whole range is still one."""


def linked(frame: IntArray, position: FloatArray, reach: float, memory: int = 0) -> IntArray:
    """Return which object each point is of.

    Parameters
    ----------
    frame
        The frame of each point, shape (points,).
    position
        Where it is, shape (points, dim).
    reach
        The farthest from one point of an object to the next, > 0.
    memory
        For how many frames an object may be unseen.

    Returns
    -------
    Numbers from 0, shape (points,).

    Examples
    --------
    >>> import numpy as np
    >>> linked(np.array([0, 0, 1]), np.array([[1.0], [9.0], [8.5]]), 2.0)
    array([0, 1, 1])
    """
    owner = np.full(frame.shape[0], -1, dtype=np.int64)
    order = np.argsort(frame, kind="stable")
    begins = np.flatnonzero(np.diff(frame[order], prepend=frame.min(initial=0) - 1))
    scaled = position / reach
    known, n_objects = np.empty(0, dtype=np.int64), 0  # Last points of objects that are remembered
    for here in np.split(order, begins[1:]):
        known = known[frame[here[:1]] - frame[known] <= memory + 1]
        taken = _followed(scaled[known], scaled[here])
        follows = np.flatnonzero(taken >= 0)
        owner[here[follows]] = owner[known[taken[follows]]]
        new = here[taken < 0]
        owner[new] = np.arange(n_objects, n_objects + new.size)
        n_objects += new.size
        known = np.concatenate([np.delete(known, taken[follows]), here])
    return owner


def _followed(known: FloatArray, here: FloatArray) -> IntArray:
    """Return which known point each new one follows, -1 for none; lengths are in ranges."""
    if not (len(known) and len(here)):
        return np.full(len(here), -1, dtype=np.int64)
    near = all_within(tree_of(here), known, ALONE)
    row = np.repeat(np.arange(len(known)), [len(each) for each in near])
    column = np.concatenate(near)
    square = np.sum((known[row] - here[column]) ** 2, axis=1)
    fits = square <= ALONE
    offers = Offers(row[fits], column[fits], square[fits], np.full(len(known), ALONE), len(here))
    return one_to_one(offers).holder
