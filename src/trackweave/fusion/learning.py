"""What a track has learned since it was last looked at.

A track's errors at successive times are correlated, since every estimate rests on the ones
before. What a Kalman filter *learned* from one time to the next is not: it is worth one
measurement of the state whose error is that of the reports in between, independent of all others
and of the process noise that tracks of several sensors have in common.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.filters.kalman import predicted
from trackweave.fusion.pictures import LocalPicture

__all__ = ["Learned", "learned"]

_NOTHING = 1e-3
"""Share of a track's information below which what it learned along a direction is nothing."""


class Learned(NamedTuple):
    """Equivalent measurements, one row for each track of each picture.

    ``picture`` is the picture's place in the sequence. ``before`` and ``spread`` are the state as
    foreseen without the reports since then, which is independent of them: the state itself where
    a track begins. ``mean`` and ``information`` are the equivalent measurement; along directions
    in which nothing was learned the information is 0.
    """

    picture: IntArray
    track: IntArray
    before: FloatArray
    spread: FloatArray
    mean: FloatArray
    information: FloatArray


def learned(pictures: Sequence[LocalPicture], process_noise: float) -> Learned:
    """Return what each track learned between one picture and the next, picture by picture."""
    # Lin, Bar-Shalom, Kirubarajan, *Exact multisensor dynamic bias estimation with local tracks*,
    # IEEE Transactions on Aerospace and Electronic Systems 40 (2), 2004. Too great a process noise
    # [m²/s³] makes the rows correlated, too small a one loses information; neither shifts them.
    picture = np.repeat(np.arange(len(pictures)), [len(one) for one in pictures])
    track = np.concatenate([one.track for one in pictures])
    time = np.repeat([one.time for one in pictures], [len(one) for one in pictures])
    mean = np.concatenate([one.mean for one in pictures])
    covariance = np.concatenate([one.covariance for one in pictures])
    # The row of the same track in the picture before, wherever that was.
    order = np.lexsort((picture, track))
    again = np.flatnonzero(track[order][1:] == track[order][:-1])
    row, last = order[again + 1], order[again]
    before, spread = mean.copy(), covariance.copy()
    before[row], spread[row] = predicted(
        mean[last], covariance[last], time[row] - time[last], process_noise
    )
    measured, information = mean.copy(), _inverse(covariance)
    measured[row], information[row] = _difference(
        mean[row], covariance[row], before[row], spread[row]
    )
    return Learned(picture, track, before, spread, measured, information)


def _difference(
    mean: FloatArray, covariance: FloatArray, before: FloatArray, spread: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the measurement that would have made the second estimate the first."""
    root = _root(covariance)
    inverse = np.linalg.inv(root)
    # In coordinates where the estimate's covariance is the unit matrix.
    foreseen = inverse @ spread @ inverse.swapaxes(1, 2)
    value, vector = np.linalg.eigh(foreseen)
    # Less covariance than foreseen is information 1 − 1/value; more is none.
    gained = 1.0 - 1.0 / np.maximum(value, 1.0)
    gained[gained < _NOTHING] = 0.0
    shift = np.einsum("rij,rj->ri", inverse, mean - before)
    shift = np.einsum("rji,rj->ri", vector, shift)
    shift /= np.where(gained > 0.0, gained, np.inf)
    measured = before + np.einsum("rij,rjk,rk->ri", root, vector, shift)
    side = vector.swapaxes(1, 2) @ inverse
    return measured, np.einsum("rki,rk,rkj->rij", side, gained, side)


def _inverse(covariance: FloatArray) -> FloatArray:
    inverse = np.linalg.inv(_root(covariance))
    return inverse.swapaxes(1, 2) @ inverse


def _root(covariance: FloatArray) -> FloatArray:
    """Return Cholesky roots, found where metres and metres per second are of one size."""
    size = np.sqrt(np.diagonal(covariance, axis1=1, axis2=2))
    scale = size[:, :, None] * size[:, None, :]
    return np.asarray(size[:, :, None] * np.linalg.cholesky(covariance / scale))
