"""Identity measures: one track for each target's whole life."""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import linear_sum_assignment

from trackweave.metrics._distances import check_cutoff
from trackweave.metrics.moments import Moments

__all__ = ["Identity", "identity"]


@dataclass(frozen=True, slots=True)
class Identity:
    """How much of targets and tracks agrees under the best one-to-one naming.

    ``idp`` is the share of track positions that are with their own target, ``idr`` that of target
    positions that are with their own track, ``idf1`` their harmonic mean; None where there are
    none.
    """

    idf1: float | None
    idp: float | None
    idr: float | None


def identity(moments: Moments, cutoff: float = 50.0) -> Identity:
    """Return the identity measures over all times, of pairs closer than the cutoff [m].

    Parameters
    ----------
    moments
        Truth and tracks side by side, of ``align``.
    cutoff
        The greatest distance of a pair [m]. Must be positive.

    Returns
    -------
    The measures.

    Raises
    ------
    InvalidInputError
        If the cutoff is not a positive number.

    Examples
    --------
    >>> import trackweave as tw
    >>> from trackweave.metrics import align, identity
    >>> path = [[0.0, 0.0], [10.0, 0.0], [20.0, 0.0], [30.0, 0.0]]
    >>> truth = tw.TruthTable.from_columns(range(4), ["A"] * 4, path)
    >>> broken = tw.TruthTable.from_columns(range(4), ["1", "1", "2", "2"], path)
    >>> identity(align(truth, broken, None)).idf1
    0.5
    """
    # Ristani, Solera, Zou, Cucchiara, Tomasi, *Performance measures and a data set for
    # multi-target, multi-camera tracking*, 2016, section 3.2. doi:10.1007/978-3-319-48881-3_2
    check_cutoff(cutoff)
    together = np.zeros((moments.n_targets, moments.n_tracks))
    for moment in moments:
        near = moment.distance < cutoff
        together[np.ix_(moment.targets, moment.tracks)] += near
    # The fewest misses plus false positions are the most positions together.
    agreed = float(together[linear_sum_assignment(together, maximize=True)].sum())
    n_truth, n_tracked = len(moments.truth.identity), len(moments.tracks.identity)
    return Identity(
        idf1=2 * agreed / (n_truth + n_tracked) if n_truth + n_tracked else None,
        idp=agreed / n_tracked if n_tracked else None,
        idr=agreed / n_truth if n_truth else None,
    )
