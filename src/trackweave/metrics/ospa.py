"""The optimal sub-pattern assignment metric."""

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import linear_sum_assignment

from trackweave.arrays import FloatArray
from trackweave.errors import InvalidInputError
from trackweave.metrics._distances import check_cutoff, check_order, distances, places

__all__ = ["ospa", "ospa_from_distances"]


def ospa(truth: ArrayLike, tracks: ArrayLike, cutoff: float = 50.0, order: float = 2.0) -> float:
    """Return the mean distance per object of tracks from the true set [m], at most the cutoff."""
    # Schuhmacher, Vo, Vo, *A consistent metric for performance evaluation of multi-object
    # filters*, 2008, eq. (3). doi:10.1109/TSP.2008.920469. The cutoff is the greatest distance of
    # a pair, and the price of an object too many or too few.
    check_cutoff(cutoff)
    check_order(order)
    true, tracked = places(truth, "truth"), places(tracks, "tracks")
    if len(true) and len(tracked) and true.shape[1] != tracked.shape[1]:
        raise InvalidInputError(
            f"tracks: {tracked.shape[1]} dimensions; expected {true.shape[1]}, as truth has"
        )
    return ospa_from_distances(distances(true, tracked), cutoff, order)


def ospa_from_distances(distance: FloatArray, cutoff: float, order: float) -> float:
    """Return OSPA of checked distances, shape (targets, tracks)."""
    more, fewer = max(distance.shape), min(distance.shape)
    if more == 0:
        return 0.0
    capped = np.minimum(distance / cutoff, 1.0) ** order
    paired = float(capped[linear_sum_assignment(capped)].sum())
    share = (paired + more - fewer) / more
    return float(cutoff * share ** (1 / order))
