"""Higher order tracking accuracy."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.optimize import linear_sum_assignment

from trackweave.arrays import FloatArray, IntArray
from trackweave.metrics._distances import check_cutoff
from trackweave.metrics.moments import Moments

__all__ = ["Hota", "hota"]

LEVELS = np.arange(1, 20) * 0.05
# Room for rounding, so that a pair exactly at a level belongs to it.
ROUNDING = np.finfo(np.float64).eps


FACTORS = ("hota", "deta", "assa", "loca", "detre", "detpr", "assre", "asspr")


@dataclass(frozen=True, slots=True)
class Hota:
    """HOTA and its factors, each the mean over the localisation levels.

    ``hota`` is that of the geometric means of ``deta`` (pairs over pairs, misses and false
    positions) and ``assa`` (how well the identities of pairs agree over time); ``loca`` is the
    mean similarity of pairs, 1 at a level without pairs, as in the authors' program. ``detre`` and
    ``detpr`` are the shares of target and track positions that are paired; ``assre`` and ``asspr``
    those of a target's and a track's positions that are with the pair's other half. ``by_level``
    is HOTA from the loosest to the strictest level, shape (19,).
    """

    hota: float
    deta: float
    assa: float
    loca: float
    detre: float
    detpr: float
    assre: float
    asspr: float
    by_level: tuple[float, ...]


def hota(moments: Moments, cutoff: float = 50.0) -> Hota | None:
    """Return HOTA for places, the mean over 19 levels; None without truth and tracks.

    Parameters
    ----------
    moments
        Truth and tracks side by side, of ``align``.
    cutoff
        The distance from which on places have nothing in common [m]. Must be positive.

    Returns
    -------
    HOTA and its factors.

    Raises
    ------
    InvalidInputError
        If the cutoff is not a positive number.

    Examples
    --------
    >>> import trackweave as tw
    >>> from trackweave.metrics import align, hota
    >>> path = [[0.0, 0.0], [10.0, 0.0], [20.0, 0.0], [30.0, 0.0]]
    >>> truth = tw.TruthTable.from_columns(range(4), ["A"] * 4, path)
    >>> broken = tw.TruthTable.from_columns(range(4), ["1", "1", "2", "2"], path)
    >>> judged = hota(align(truth, broken, None))
    >>> judged.deta, judged.assa
    (1.0, 0.5)
    """
    # Luiten and others, *HOTA: a higher order metric for evaluating multi-object tracking*, 2021,
    # sections 5.1-5.3 and appendix C. doi:10.1007/s11263-020-01375-2. Where boxes have their
    # overlap, places have a similarity 1 - distance / cutoff, and 0 from the cutoff on. A level α
    # therefore takes pairs closer than (1 - α) times the cutoff: with a cutoff of 50 m, the levels
    # 0.05, 0.10, …, 0.95 are distances of 47.5, 45, …, 2.5 m. At each level detection and
    # association accuracy are counted and their geometric mean taken.
    check_cutoff(cutoff)
    n_truth = np.bincount(moments.truth.identity, minlength=moments.n_targets)
    n_tracked = np.bincount(moments.tracks.identity, minlength=moments.n_tracks)
    total = int(n_truth.sum() + n_tracked.sum())
    if total == 0:
        return None
    either = (n_truth[:, None] + n_tracked[None, :]).astype(np.float64)
    cells, similarity = _matches(moments, _alignment(moments, either, cutoff), cutoff)
    counts = _Counts(n_truth, n_tracked)
    levels = np.array([counts.factors(cells, similarity, level) for level in LEVELS])
    mean = dict(zip(FACTORS, levels.mean(axis=0).tolist(), strict=True))
    return Hota(**mean, by_level=tuple(levels[:, 0].tolist()))


class _Counts(NamedTuple):
    """How many positions each target and each track has."""

    truth: IntArray
    tracked: IntArray

    def factors(self, cells: IntArray, similarity: FloatArray, level: float) -> list[float]:
        """Return the accuracies at one level, in the order of ``FACTORS``."""
        near = similarity >= level - ROUNDING
        cell, matches = np.unique(cells[near], return_counts=True)
        target, track = np.divmod(cell, max(self.tracked.size, 1))
        n_target, n_track = self.truth[target], self.tracked[track]
        n_pairs, n_truth, n_tracked = (
            int(count.sum()) for count in (matches, self.truth, self.tracked)
        )
        detection = n_pairs / (n_truth + n_tracked - n_pairs)
        # A pair weighs as often as it is matched.
        weight = matches / max(n_pairs, 1)
        association = float(weight @ (matches / (n_target + n_track - matches)))
        return [
            float(np.sqrt(detection * association)),
            detection,
            association,
            float(similarity[near].mean()) if n_pairs else 1.0,
            n_pairs / max(n_truth, 1),
            n_pairs / max(n_tracked, 1),
            float(weight @ (matches / n_target)),
            float(weight @ (matches / n_track)),
        ]


def _matches(
    moments: Moments, alignment: FloatArray, cutoff: float
) -> tuple[IntArray, FloatArray]:
    """Return each pair's cell in the flat alignment and its similarity."""
    cells, found = [np.empty(0, dtype=np.int64)], [np.empty(0)]
    for moment in moments:
        similarity = _similarity(moment.distance, cutoff)
        score = alignment[np.ix_(moment.targets, moment.tracks)] * similarity
        row, column = linear_sum_assignment(score, maximize=True)
        cells.append(moment.targets[row] * moments.n_tracks + moment.tracks[column])
        found.append(similarity[row, column])
    return np.concatenate(cells), np.concatenate(found)


def _similarity(distance: FloatArray, cutoff: float) -> FloatArray:
    return np.maximum(1 - distance / cutoff, 0.0)


def _alignment(moments: Moments, either: FloatArray, cutoff: float) -> FloatArray:
    """Return how well each target and track agree over all times, between 0 and 1."""
    shared = np.zeros(either.shape)
    for moment in moments:
        similarity = _similarity(moment.distance, cutoff)
        union = similarity.sum(axis=0)[None, :] + similarity.sum(axis=1)[:, None] - similarity
        part = np.divide(similarity, union, out=np.zeros_like(union), where=union > ROUNDING)
        shared[np.ix_(moment.targets, moment.tracks)] += part
    alignment: FloatArray = shared / np.maximum(either - shared, 1.0)
    return alignment
