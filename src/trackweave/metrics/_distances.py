"""Distances between two sets of places, and the checks that the metrics share."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.distance import cdist

from trackweave.arrays import FloatArray, float_array, require_finite
from trackweave.errors import InvalidInputError

__all__ = ["check_cutoff", "check_order", "distances", "places"]


# Far below any distance that is measured; squares of what is smaller still vanish [m].
LEAST_CUTOFF = 1e-12


def distances(truth: FloatArray, tracks: FloatArray) -> FloatArray:
    """Return the distance [m] of each true place from each track, shape (truth, tracks)."""
    if not (len(truth) and len(tracks)):
        return np.empty((len(truth), len(tracks)))
    return np.asarray(cdist(truth, tracks), dtype=np.float64)


def places(values: ArrayLike | Sequence[Sequence[float]], name: str) -> FloatArray:
    """Return places [m] as a checked array of shape (places, dim); an empty list is none."""
    if np.size(values) == 0:
        return np.empty((0, 1))
    array = float_array(values, name, (None, None))
    require_finite(array, name)
    return array


def check_cutoff(cutoff: float) -> None:
    """Refuse a cutoff [m] that is no positive finite number."""
    if not (np.isfinite(cutoff) and cutoff >= LEAST_CUTOFF):
        raise InvalidInputError(
            f"cutoff: {cutoff}; expected a finite number above 0, of at least {LEAST_CUTOFF:g}"
        )


def check_order(order: float) -> None:
    """Refuse an order below 1, which makes no metric."""
    if not (np.isfinite(order) and order >= 1):
        raise InvalidInputError(f"order: {order}; expected a finite number of at least 1")
