"""How far apart places are that reports come back to: rooms, cells, stations."""

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.estimation.trees import tree_of

__all__ = ["AS_NOISE", "spacing_of_places"]

AS_NOISE = 0.5
"""Who is at such a place is so far from its middle, as a share of the spacing."""
# Objects that move come to so few places, as a share of their steps, of so many at least.
FEW, FEWEST = 0.3, 20


def spacing_of_places(before: FloatArray, after: FloatArray) -> float:
    """Return how far apart the places are that objects go between [m]; 0 where they go anywhere.

    Parameters
    ----------
    before, after
        Where an object was reported and where next [m], shape (steps, dim).

    Returns
    -------
    The median distance from such a place to the nearest other.
    """
    moves = np.any(before != after, axis=1)
    n_moves = int(np.count_nonzero(moves))
    places = np.unique(after[moves], axis=0)
    if n_moves < FEWEST or not 1 < len(places) <= FEW * n_moves:
        return 0.0
    return float(np.median(tree_of(places).query(places, k=2)[0][:, 1]))
