"""The optimal sub-pattern assignment metric."""

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import linear_sum_assignment

from trackweave.arrays import FloatArray
from trackweave.errors import InvalidInputError
from trackweave.metrics._distances import check_cutoff, check_order, distances, places

__all__ = ["ospa", "ospa_from_distances"]


def ospa(truth: ArrayLike, tracks: ArrayLike, cutoff: float = 50.0, order: float = 2.0) -> float:
    """Return the mean distance per object of a set of tracks from the true set [m].

    Parameters
    ----------
    truth
        Position of each target [m], shape (targets, dim).
    tracks
        Position of each track [m], shape (tracks, dim).
    cutoff
        Greatest distance of a pair, and the price of an object too many or too few [m]; positive.
    order
        Exponent p of a distance; at least 1.

    Returns
    -------
    Between 0 and the cutoff; 0 for two empty sets.

    Raises
    ------
    InvalidInputError
        If places, cutoff or order are not usable.

    References
    ----------
    .. [1] Schuhmacher, Vo, Vo, *A consistent metric for performance evaluation of multi-object
       filters*, IEEE Transactions on Signal Processing 56(8), 2008, eq. (3).
       doi:10.1109/TSP.2008.920469
    """
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
