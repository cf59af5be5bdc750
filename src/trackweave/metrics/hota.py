"""Higher order tracking accuracy."""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import linear_sum_assignment

from trackweave.arrays import FloatArray, IntArray
from trackweave.metrics._distances import check_cutoff
from trackweave.metrics.moments import Moments

__all__ = ["Hota", "hota"]

LEVELS = np.arange(1, 20) * 0.05
# Room for rounding, so that a pair exactly at a level belongs to it.
ROUNDING = np.finfo(np.float64).eps


@dataclass(frozen=True, slots=True)
class Hota:
    """HOTA and its two factors, each the mean over the localisation levels.

    Parameters
    ----------
    hota
        Mean of the geometric means of detection and association accuracy.
    deta
        Detection accuracy: pairs over pairs, misses and false positions.
    assa
        Association accuracy: how well the identities of pairs agree over time.
    """

    hota: float
    deta: float
    assa: float


def hota(moments: Moments, cutoff: float = 50.0) -> Hota | None:
    """Return HOTA for places: a pair's similarity falls from 1 at no distance to 0 at the cutoff.

    Parameters
    ----------
    moments
        Truth and tracks at common times.
    cutoff
        Distance at which a pair has nothing in common [m]; positive.

    Returns
    -------
    The mean over the levels 0.05, 0.10, …, 0.95; None where there is neither truth nor track.

    References
    ----------
    .. [1] Luiten, Ošep, Dendorfer, Torr, Geiger, Leal-Taixé, Leibe, *HOTA: a higher order metric
       for evaluating multi-object tracking*, International Journal of Computer Vision 129, 2021,
       sections 5.1-5.3 and appendix C. doi:10.1007/s11263-020-01375-2
    """
    check_cutoff(cutoff)
    n_truth = np.bincount(moments.truth.identity, minlength=moments.n_targets)
    n_tracked = np.bincount(moments.tracks.identity, minlength=moments.n_tracks)
    total = int(n_truth.sum() + n_tracked.sum())
    if total == 0:
        return None
    either = (n_truth[:, None] + n_tracked[None, :]).astype(np.float64)
    cells, levels = _matches(moments, _alignment(moments, either, cutoff), cutoff)
    unique, place = np.unique(cells, return_inverse=True)
    detection, association = np.zeros(LEVELS.size), np.zeros(LEVELS.size)
    for level in range(LEVELS.size):
        matches = np.bincount(place[levels > level], minlength=unique.size)
        n_pairs = int(matches.sum())
        detection[level] = n_pairs / (total - n_pairs)
        agreement = matches * (matches / (either.ravel()[unique] - matches))
        association[level] = agreement.sum() / max(n_pairs, 1)
    accuracy = np.sqrt(detection * association)
    return Hota(float(accuracy.mean()), float(detection.mean()), float(association.mean()))


def _matches(moments: Moments, alignment: FloatArray, cutoff: float) -> tuple[IntArray, IntArray]:
    """Return each pair's cell in the flat alignment and how many levels its similarity reaches."""
    cells, levels = [np.empty(0, dtype=np.int64)], [np.empty(0, dtype=np.int64)]
    for moment in moments:
        similarity = _similarity(moment.distance, cutoff)
        score = alignment[np.ix_(moment.targets, moment.tracks)] * similarity
        row, column = linear_sum_assignment(score, maximize=True)
        cells.append(moment.targets[row] * moments.n_tracks + moment.tracks[column])
        levels.append(np.searchsorted(LEVELS - ROUNDING, similarity[row, column], side="right"))
    return np.concatenate(cells), np.concatenate(levels)


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
