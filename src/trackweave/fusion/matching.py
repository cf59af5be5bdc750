"""Which tracks of two sensors are one object, for a given bias of the second."""

from collections.abc import Sequence

import numpy as np
from scipy.optimize import linear_sum_assignment
from scipy.spatial import KDTree
from scipy.special import chdtri

from trackweave.arrays import FloatArray, IntArray
from trackweave.fusion.bias import BiasModel
from trackweave.fusion.pictures import LocalPicture

__all__ = ["match_tracks", "unbiased"]

_REJECTED = 1e-3
"""Probability that a right pair is farther apart than the gate."""
_WIDE = 95.0
"""Percentile of the other sensor's uncertainties that are looked for around each track."""


def unbiased(
    picture: LocalPicture, model: BiasModel, bias: FloatArray, covariance: FloatArray
) -> LocalPicture:
    """Return a picture without a bias, as uncertain as that leaves it."""
    moved = model.gradient(picture.mean, bias)
    spread = moved.by_state @ picture.covariance @ moved.by_state.swapaxes(1, 2)
    spread += moved.by_bias @ covariance @ moved.by_bias.swapaxes(1, 2)
    return LocalPicture(
        picture.sensor, picture.time, picture.track, moved.mean,
        (spread + spread.swapaxes(1, 2)) / 2.0,
    )  # fmt: skip


def match_tracks(reference: Sequence[LocalPicture], other: Sequence[LocalPicture]) -> IntArray:
    """Return the pairs of tracks that agree best over all times, each track once."""
    # A time at which both tracks are there speaks for the pair by as much as their squared
    # distance falls short of the gate, or against it.
    mine, yours = (
        np.unique(np.concatenate([p.track for p in side])) for side in (reference, other)
    )
    there = [np.zeros((len(reference), numbers.shape[0])) for numbers in (mine, yours)]
    n = reference[0].mean.shape[1]
    gate = float(chdtri(n, _REJECTED))
    worth = np.zeros((mine.shape[0], yours.shape[0]))
    near = np.zeros_like(worth)
    for time, (first, second) in enumerate(zip(reference, other, strict=True)):
        at = np.searchsorted(mine, first.track), np.searchsorted(yours, second.track)
        there[0][time, at[0]] = there[1][time, at[1]] = 1.0
        row, column, squared = _near(first, second, gate)
        worth[at[0][row], at[1][column]] += gate - np.minimum(squared, 2.0 * gate)
        near[at[0][row], at[1][column]] += 1.0
    worth -= gate * (there[0].T @ there[1] - near)
    rows, columns = linear_sum_assignment(np.minimum(-worth, 0.0))
    is_pair = worth[rows, columns] > 0.0
    return np.stack([mine[rows[is_pair]], yours[columns[is_pair]]], axis=1)


def _near(
    first: LocalPicture, second: LocalPicture, gate: float
) -> tuple[IntArray, IntArray, FloatArray]:
    """Return pairs of tracks that may be near each other, and their squared distances."""
    dim = first.dim
    none = np.empty(0, dtype=np.int64)
    if not len(first) or not len(second):
        return none, none, np.empty(0)
    reach = [np.linalg.eigvalsh(p.covariance[:, :dim, :dim])[:, -1] for p in (first, second)]
    radius = np.sqrt(gate * (reach[0] + np.percentile(reach[1], _WIDE)))
    found = KDTree(second.mean[:, :dim]).query_ball_point(first.mean[:, :dim], radius)
    row = np.repeat(np.arange(len(first)), [len(one) for one in found])
    column = np.concatenate([none, *(np.array(one, dtype=np.int64) for one in found)])
    spread = first.covariance[row] + second.covariance[column]
    apart = second.mean[column] - first.mean[row]
    weighted = np.linalg.solve(spread, apart[:, :, None])[:, :, 0]
    return row, column, np.einsum("ri,ri->r", apart, weighted)
