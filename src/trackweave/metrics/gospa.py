"""GOSPA and OSPA."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import linear_sum_assignment

from trackweave.arrays import FloatArray
from trackweave.errors import InvalidInputError
from trackweave.metrics._distances import check_cutoff, check_order, distances, places

__all__ = ["Gospa", "gospa", "gospa_from_distances", "ospa", "ospa_from_distances"]


@dataclass(frozen=True, slots=True)
class Gospa:
    """GOSPA at one time, with its parts [m]: total^p = localisation^p + missed^p + false^p.

    Distances of pairs add ``localisation``, ``n_missed`` targets without a track ``missed``,
    ``n_false`` tracks without a target ``false``.
    """

    total: float
    localisation: float
    missed: float
    false: float
    n_missed: int
    n_false: int


def gospa(truth: ArrayLike, tracks: ArrayLike, cutoff: float = 50.0, order: float = 2.0) -> Gospa:
    """Return how far a set of tracks is from the true set, with alpha = 2 [1]_.

    Parameters
    ----------
    truth, tracks
        Positions at one time, shapes (targets, dim) and (tracks, dim) [m]; either may be empty.
    cutoff
        The greatest distance of a pair [m], and what two objects missed or false cost. Must be
        positive.
    order
        The exponent p, at least 1.

    Returns
    -------
    (Σ d^p + cutoff^p / 2 · (missed + false))^(1/p) over the pairs that make it least, with its
    parts [m].

    Raises
    ------
    InvalidInputError
        If a shape, the cutoff or the order is none of a metric's.

    References
    ----------
    .. [1] Rahmathullah, García-Fernández, Svensson, *Generalized optimal sub-pattern assignment
       metric*, FUSION 2017, definition 1 and proposition 1. doi:10.23919/ICIF.2017.8009645

    Examples
    --------
    >>> from trackweave.metrics.gospa import gospa
    >>> found = gospa([[0.0, 0.0], [100.0, 0.0]], [[3.0, 4.0]], cutoff=20.0)
    >>> round(found.total, 2), found.localisation, round(found.missed, 2), found.n_missed
    (15.0, 5.0, 14.14, 1)
    """
    return gospa_from_distances(_checked(truth, tracks, cutoff, order), cutoff, order)


def gospa_from_distances(distance: FloatArray, cutoff: float, order: float) -> Gospa:
    """Return GOSPA of checked distances, shape (targets, tracks)."""
    # In units of the cutoff, so that a high order neither overflows nor underflows.
    capped = np.minimum(distance / cutoff, 1.0) ** order
    target, track = linear_sum_assignment(capped)
    paired = capped[target, track]
    # A pair at the cutoff costs what leaving both alone costs: it is no pair.
    paired = paired[paired < 1.0]
    n_missed, n_false = distance.shape[0] - paired.size, distance.shape[1] - paired.size
    parts = np.array([paired.sum(), n_missed / 2, n_false / 2])
    localisation, missed, false = cutoff * parts ** (1 / order)
    total = cutoff * float(parts.sum()) ** (1 / order)
    return Gospa(total, float(localisation), float(missed), float(false), n_missed, n_false)


def ospa(truth: ArrayLike, tracks: ArrayLike, cutoff: float = 50.0, order: float = 2.0) -> float:
    """Return the mean distance per object of tracks from the true set [1]_.

    Parameters
    ----------
    truth, tracks, order
        As in ``gospa``, and refused as there.
    cutoff
        The greatest distance of a pair [m], and the price of an object too many or too few.

    Returns
    -------
    The distance [m], at most the cutoff; 0 of two empty sets.

    References
    ----------
    .. [1] Schuhmacher, Vo, Vo, *A consistent metric for performance evaluation of multi-object
       filters*, 2008, eq. (3). doi:10.1109/TSP.2008.920469

    Examples
    --------
    >>> from trackweave.metrics.gospa import ospa
    >>> round(ospa([[0.0, 0.0], [100.0, 0.0]], [[3.0, 4.0]], cutoff=20.0), 2)
    14.58
    """
    return ospa_from_distances(_checked(truth, tracks, cutoff, order), cutoff, order)


def ospa_from_distances(distance: FloatArray, cutoff: float, order: float) -> float:
    """Return OSPA of checked distances, shape (targets, tracks)."""
    more, fewer = max(distance.shape), min(distance.shape)
    if more == 0:
        return 0.0
    capped = np.minimum(distance / cutoff, 1.0) ** order
    paired = float(capped[linear_sum_assignment(capped)].sum())
    share = (paired + more - fewer) / more
    return float(cutoff * share ** (1 / order))


def _checked(truth: ArrayLike, tracks: ArrayLike, cutoff: float, order: float) -> FloatArray:
    """Return the distances of tracks from targets, and refuse what is none of a metric's."""
    check_cutoff(cutoff)
    check_order(order)
    true, tracked = places(truth, "truth"), places(tracks, "tracks")
    if len(true) and len(tracked) and true.shape[1] != tracked.shape[1]:
        raise InvalidInputError(
            f"tracks: {tracked.shape[1]} dimensions; expected {true.shape[1]}, as truth has"
        )
    return distances(true, tracked)
