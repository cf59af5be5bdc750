"""CLEAR MOT: who is paired with whom over time, and how often that changes."""

from dataclasses import dataclass

import numpy as np

from trackweave.metrics.moments import Moments
from trackweave.metrics.pairing import Pairs, changes, pair_over_time

__all__ = ["ClearMot", "clear_mot", "clear_mot_of_pairs"]

FOUND_SHARE = 0.5


@dataclass(frozen=True, slots=True)
class ClearMot:
    """What pairing targets with tracks over time shows.

    ``mota`` is 1 - (missed + false + switches) / target positions, ``covered`` the share of these
    that are paired; None without targets. ``motp`` is the mean distance of pairs and ``rmse`` the
    root of their mean squared one [m]; None without pairs. A switch is another track than the one
    that a target had last, a fragmentation a pairing after an interruption, by whichever track.
    ``n_missed`` and ``n_false`` are positions without a track and without a target; ``n_found``
    targets are paired for at least half of their positions.
    """

    mota: float | None
    motp: float | None
    rmse: float | None
    switches: int
    fragmentations: int
    n_pairs: int
    n_missed: int
    n_false: int
    covered: float | None
    n_found: int


def clear_mot(moments: Moments, cutoff: float = 50.0, order: float = 2.0) -> ClearMot:
    """Return the CLEAR MOT figures over all times, of the pairs of ``pair_over_time``.

    Parameters
    ----------
    moments
        Truth and tracks side by side, of ``align``.
    cutoff
        The greatest distance of a pair [m]. Must be positive.
    order
        The exponent of capped distances by which new pairs are chosen, at least 1.

    Returns
    -------
    The figures.

    Raises
    ------
    InvalidInputError
        If the cutoff is not positive, or the order is below 1.

    Examples
    --------
    >>> import trackweave as tw
    >>> from trackweave.metrics import align, clear_mot
    >>> path = [[0.0, 0.0], [10.0, 0.0], [20.0, 0.0], [30.0, 0.0]]
    >>> truth = tw.TruthTable.from_columns(range(4), ["A"] * 4, path)
    >>> broken = tw.TruthTable.from_columns(range(4), ["1", "1", "2", "2"], path)
    >>> judged = clear_mot(align(truth, broken, None))
    >>> judged.mota, judged.switches, judged.n_pairs
    (0.75, 1, 4)
    """
    return clear_mot_of_pairs(moments, pair_over_time(moments, cutoff, order))


def clear_mot_of_pairs(moments: Moments, pairs: Pairs) -> ClearMot:
    """Return the CLEAR MOT figures of pairs that are known already."""
    switches, fragmentations = (which.size for which in changes(pairs))
    n_pairs, n_positions = len(pairs), len(moments.truth.identity)
    n_missed, n_false = n_positions - n_pairs, len(moments.tracks.identity) - n_pairs
    errors = n_missed + n_false + switches
    seen = np.bincount(moments.truth.identity, minlength=moments.n_targets)
    paired = np.bincount(pairs.target, minlength=moments.n_targets)
    found = (seen > 0) & (paired >= FOUND_SHARE * seen)
    return ClearMot(
        mota=1 - errors / n_positions if n_positions else None,
        motp=float(pairs.distance.mean()) if n_pairs else None,
        rmse=float(np.sqrt(np.mean(pairs.distance**2))) if n_pairs else None,
        switches=switches,
        fragmentations=fragmentations,
        n_pairs=n_pairs,
        n_missed=n_missed,
        n_false=n_false,
        covered=n_pairs / n_positions if n_positions else None,
        n_found=int(found.sum()),
    )
