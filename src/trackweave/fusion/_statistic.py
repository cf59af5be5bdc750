"""The statistic of a tuple of tracks over remembered times. Nothing here checks or raises."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from trackweave.arrays import FloatArray, IntArray
from trackweave.jit import jit

CHAIN, ALL_PAIRS, FUSED_MEAN = 0, 1, 2


class Rings(NamedTuple):
    """What is remembered of tracks: one row each, one column per remembered time (slot).

    ``is_fresh`` tells where a track has an estimate of its own; ``likeness`` is how much of its
    error there was its error in the slot before: the mean square of the correlations. ``spread``
    is what the test reckons with, ``whole`` the tracks' covariances as they came.
    """

    mean: FloatArray
    spread: FloatArray
    information: FloatArray
    is_fresh: NDArray[np.bool_]
    likeness: FloatArray
    whole: FloatArray


class Form(NamedTuple):
    """Which statistic: its kind, the slots from the oldest on, and what each one weighs.

    ``is_alike`` tells to reckon with errors that are correlated in time. ``quantile[i]`` is what
    χ² with i / 4 degrees of freedom exceeds with the false-rejection rate.
    """

    kind: int
    slot: IntArray
    weight: FloatArray
    is_alike: bool
    quantile: FloatArray


class Room(NamedTuple):
    """Working memory for tuples of so many members."""

    fresh: IntArray
    difference: FloatArray
    first: FloatArray
    second: FloatArray
    root: FloatArray
    whole: FloatArray


@jit
def make_room(n_members: int, n: int) -> Room:
    """Return working memory for tuples of up to so many members with n numbers a state."""
    size = n_members * n
    return Room(
        np.empty(n_members, dtype=np.int64), np.empty((2, n)), np.empty((n, n)), np.empty((n, n)),
        np.empty((n, n)), np.empty((2, size, size)),
    )  # fmt: skip


@jit
def factor(matrix: FloatArray, root: FloatArray) -> None:
    """Write the lower Cholesky factor of a positive definite matrix."""
    n = matrix.shape[0]
    for row in range(n):
        for column in range(row + 1):
            rest = matrix[row, column]
            for k in range(column):
                rest -= root[row, k] * root[column, k]
            if row == column:
                root[row, row] = math.sqrt(max(rest, 1e-300))
            else:
                root[row, column] = rest / root[column, column]


@jit
def weigh(root: FloatArray, vector: FloatArray) -> float:
    """Return vᵀ A⁻¹ v for the factor of A; the vector is overwritten."""
    total = 0.0
    for row in range(vector.shape[0]):
        rest = vector[row]
        for k in range(row):
            rest -= root[row, k] * vector[k]
        vector[row] = rest / root[row, row]
        total += vector[row] * vector[row]
    return total


@jit
def invert(root: FloatArray, inverse: FloatArray) -> None:
    """Write A⁻¹ for the factor of A."""
    n = root.shape[0]
    for column in range(n):
        for row in range(n):
            inverse[row, column] = 0.0
        inverse[column, column] = 1.0
        for row in range(n):
            rest = inverse[row, column]
            for k in range(row):
                rest -= root[row, k] * inverse[k, column]
            inverse[row, column] = rest / root[row, row]
        for row in range(n - 1, -1, -1):
            rest = inverse[row, column]
            for k in range(row + 1, n):
                rest -= root[k, row] * inverse[k, column]
            inverse[row, column] = rest / root[row, row]


@jit
def _fused_mean(rings: Rings, slot: int, room: Room, n_fresh: int) -> float:
    """Return the weighted distance of the fresh estimates to their fused mean.

    From the first estimate on, so that large coordinates do not cost digits:
    Σ dᵀ Y d − (Σ Y d)ᵀ (Σ Y)⁻¹ (Σ Y d) with the information Y of each.
    """
    n = rings.mean.shape[2]
    first = room.fresh[0]
    total, pull, d = room.first, room.difference[0], room.difference[1]
    for row in range(n):
        pull[row] = 0.0
        for column in range(n):
            total[row, column] = rings.information[first, slot, row, column]
    distance = 0.0
    for place in range(1, n_fresh):
        track = room.fresh[place]
        for row in range(n):
            d[row] = rings.mean[track, slot, row] - rings.mean[first, slot, row]
        for row in range(n):
            weighted = 0.0
            for column in range(n):
                value = rings.information[track, slot, row, column]
                total[row, column] += value
                weighted += value * d[column]
            pull[row] += weighted
            distance += weighted * d[row]
    factor(total, room.root)
    return max(distance - weigh(room.root, pull), 0.0)


@jit
def _apart(rings: Rings, slot: int, a: int, b: int, room: Room, inverse: FloatArray) -> float:
    """Return the squared distance of two tracks, and write the inverse of their covariances' sum.

    The sum's factor stays in ``room.root``.
    """
    n = rings.mean.shape[2]
    d = room.difference[1]
    for row in range(n):
        d[row] = rings.mean[a, slot, row] - rings.mean[b, slot, row]
        for column in range(n):
            inverse[row, column] = (
                rings.spread[a, slot, row, column] + rings.spread[b, slot, row, column]
            )
    factor(inverse, room.root)
    distance = weigh(room.root, d)
    invert(room.root, inverse)
    return distance


@jit
def _chain(rings: Rings, slot: int, room: Room, n_fresh: int) -> tuple[float, float]:
    """Return the sum of squared distances of neighbours, and how far they are correlated.

    Neighbouring differences share a track s: the second is 2 Σ tr(C⁻¹ P_s C′⁻¹ P_s).
    """
    n = rings.mean.shape[2]
    distance, shared = 0.0, 0.0
    before, now = room.first, room.second
    for place in range(1, n_fresh):
        left, right = room.fresh[place - 1], room.fresh[place]
        distance += _apart(rings, slot, left, right, room, now)
        if place > 1:
            spread = rings.spread[left, slot]
            for i in range(n):
                for j in range(n):
                    a, b = 0.0, 0.0
                    for k in range(n):
                        a += before[i, k] * spread[k, j]
                        b += now[j, k] * spread[k, i]
                    shared += 2.0 * a * b
        before, now = now, before
    return distance, shared


@jit
def _all_pairs(rings: Rings, slot: int, room: Room, n_fresh: int) -> tuple[float, float, float]:
    """Return the sum of all squared distances, and the sums of its eigenvalues² and ³."""
    n = rings.mean.shape[2]
    size = n_fresh * n
    form, square = room.whole[0], room.whole[1]
    form[:size, :size] = 0.0
    distance = 0.0
    for a in range(n_fresh):
        for b in range(a):
            distance += _apart(rings, slot, room.fresh[a], room.fresh[b], room, room.first)
            for i in range(n):
                for j in range(n):
                    form[a * n + i, a * n + j] += room.first[i, j]
                    form[b * n + i, b * n + j] += room.first[i, j]
                    form[a * n + i, b * n + j] -= room.first[i, j]
                    form[b * n + i, a * n + j] -= room.first[i, j]
    # The form times the block diagonal of covariances, in place: its eigenvalues are wanted.
    for i in range(size):
        for b in range(n_fresh):
            spread = rings.spread[room.fresh[b], slot]
            for j in range(n):
                total = 0.0
                for k in range(n):
                    total += form[i, b * n + k] * spread[k, j]
                room.difference[0, j] = total
            for j in range(n):
                form[i, b * n + j] = room.difference[0, j]
    second, third = 0.0, 0.0
    for i in range(size):
        for j in range(size):
            total = 0.0
            for k in range(size):
                total += form[i, k] * form[k, j]
            square[i, j] = total
    for i in range(size):
        second += square[i, i]
        for j in range(size):
            third += square[i, j] * form[j, i]
    return distance, second, third


@jit
def evaluate(
    rings: Rings, form: Form, members: IntArray, room: Room
) -> tuple[float, float, float, float]:
    """Return a tuple's statistic and the sums of its null distribution's weights, their ² and ³.

    Under the hypothesis of one object the statistic is a sum of weighted χ² of one degree of
    freedom each. Entries of ``members`` below 0 are none.
    """
    n = rings.mean.shape[2]
    value, first, second, third = 0.0, 0.0, 0.0, 0.0
    # With errors correlated in time, the slots' sums so far, weighted by their likeness to now.
    carried = 0.0
    for place in range(form.slot.shape[0]):
        slot, weight = form.slot[place], form.weight[place]
        n_fresh, likeness = 0, 0.0
        for column in range(members.shape[0]):
            track = members[column]
            if track >= 0 and rings.is_fresh[track, slot]:
                room.fresh[n_fresh] = track
                n_fresh += 1
                likeness += rings.likeness[track, slot]
        if n_fresh:
            carried *= likeness / n_fresh
        if n_fresh < 2 or weight <= 0.0:
            continue
        now = float(n * (n_fresh - 1))
        squares, cubes = now, now
        if form.kind == FUSED_MEAN:
            value += weight * _fused_mean(rings, slot, room, n_fresh)
        elif form.kind == CHAIN:
            distance, shared = _chain(rings, slot, room, n_fresh)
            value += weight * distance
            squares, cubes = now + shared, now + 3.0 * shared
        else:
            distance, squares, cubes = _all_pairs(rings, slot, room, n_fresh)
            value += weight * distance
            now = float(n * (n_fresh * (n_fresh - 1) // 2))
        first += weight * now
        second += weight * weight * squares
        third += weight**3 * cubes
        if form.is_alike:
            scale = weight * math.sqrt(squares)
            second += 2.0 * scale * carried
            carried += scale
    if form.is_alike and first > 0.0:
        third = second * second / first
    return value, first, second, third


@jit
def threshold(quantile: FloatArray, first: float, second: float, third: float) -> float:
    """Return what a sum of weighted χ² exceeds with the false-rejection rate, by three moments.

    After Imhof (1961) and Pearson (1959): a χ² of h = c₂³ / c₃² degrees of freedom, shifted and
    stretched to the same mean, variance and skewness. Exact where all weights are equal.
    """
    if first <= 0.0:
        return 0.0
    freedom = second**3 / (third * third)
    place = min(4.0 * freedom, quantile.shape[0] - 1.000001)
    low = int(place)
    at = quantile[low] + (place - low) * (quantile[low + 1] - quantile[low])
    limit: float = first + math.sqrt(second / freedom) * (at - freedom)
    return limit


@jit
def evaluate_all(
    rings: Rings, form: Form, members: IntArray, value: FloatArray, limit: FloatArray
) -> None:
    """Write the statistic and the threshold of each row of ``members``."""
    room = make_room(members.shape[1], rings.mean.shape[2])
    for row in range(members.shape[0]):
        value[row], first, second, third = evaluate(rings, form, members[row], room)
        limit[row] = threshold(form.quantile, first, second, third)
