"""Biases that change during a recording, as after maintenance, which heights seem to explain.

From then on what two sensors see of one object lies apart, and a height for each object, of which
each has its own, brings it together. Where objects on the ground, beside one bias of each sensor
before a time and one after it, lie as near each other, no height is told.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.estimation.height_pairs import WORST, Fit, Moments, OnGround, on_ground
from trackweave.estimation.sightings import (
    CLOCK,
    EAST,
    N_BIASES,
    NORTH,
    SCALE,
    USUAL_BIASES,
)

__all__ = ["BiasChange", "explained_by_biases"]

# A change is looked for at so many times, none of them within this part of the ends.
N_TIMES, NEAREST = 15, 0.1
# Biases explain what is seen where so little more is left than beside heights, of so many pairs;
# they change where that leaves so much less, and such a part, of what is left if they do not
# [variances].
AS_GOOD, FEWEST_PAIRS, LESS, LESS_BY = 1.5, 3, 100.0, 0.8
ROUNDS, HUBER = 4, 2.5
# A change of so many standard deviations is clear, of what maintenance changes: where north is,
# and where ranges begin.
CLEAR = 10.0


class BiasChange(NamedTuple):
    """When biases change, and by how much."""

    time: float  # [s]
    step: FloatArray  # Those after it less those before where clear, shape (sensors, 6)
    n_pairs: int  # Of tracks that tell


class _Rows(NamedTuple):
    """What all pairs tell at all moments."""

    moment: IntArray
    off: FloatArray
    slope: FloatArray
    variance: FloatArray

    @classmethod
    def of(cls, pairs: Sequence[OnGround]) -> "_Rows":
        return cls(*(np.concatenate(each) for each in zip(*pairs, strict=True)))

    def part(self, is_before: bool, moment: int) -> "_Rows":
        own = (self.moment < moment) == is_before
        return _Rows(*(each[own] for each in self))

    def cost(self, moment: int) -> float:
        """Return what is left if biases change at a moment."""
        return sum(self.part(is_before, moment).fitted()[0] for is_before in (True, False))

    def fitted(self) -> tuple[float, FloatArray, FloatArray]:
        """Return what is left beside the best biases, in variances, these, and how sure."""
        bias = np.zeros(self.slope.shape[2])
        precision = 1.0 / np.tile(USUAL_BIASES, bias.size // N_BIASES) ** 2
        for _ in range(ROUNDS):
            far = np.sqrt(self._squared(bias))
            weight = 1.0 / self.variance / np.maximum(1.0, far / HUBER)
            weighed = weight[:, None, None] * self.slope
            matrix = np.einsum("tin,tim->nm", weighed, self.slope) + np.diag(precision)
            bias = np.linalg.solve(matrix, -np.einsum("tin,ti->n", weighed, self.off))
        sure = np.sqrt(np.diagonal(np.linalg.inv(matrix)))
        return float(np.minimum(self._squared(bias), WORST).sum()), bias, sure

    def _squared(self, bias: FloatArray) -> FloatArray:
        return np.asarray(np.sum((self.off + self.slope @ bias) ** 2, axis=1) / self.variance)


def explained_by_biases(moments: Moments, fits: Sequence[Fit]) -> tuple[bool, BiasChange | None]:
    """Return whether biases explain pairs as heights do, and when they change, if they do.

    Parameters
    ----------
    moments
        Tracks at common times, whose biases are as told.
    fits
        Tracks of two sensors that are taken for one object, and what is left beside its heights.

    Returns
    -------
    With the likeliest time of a change by how much the biases differ then.
    """
    if len(fits) < FEWEST_PAIRS:
        return False, None
    rows = _Rows.of([on_ground(moments, fit.pair) for fit in fits])
    left = sum(fit.cost for fit in fits)
    begin, end = np.quantile(rows.moment, [NEAREST, 1.0 - NEAREST])
    # First roughly, then about the best.
    for _ in range(2):
        step = (end - begin) / (N_TIMES - 1)
        tried = [round(begin + step * number) for number in range(N_TIMES)]
        costs = [rows.cost(each) for each in tried]
        best = int(np.argmin(costs))
        begin, end = tried[best] - step, tried[best] + step
    unchanged = rows.fitted()[0]
    if min(unchanged, costs[best]) > AS_GOOD * left:
        return False, None
    if costs[best] > min(unchanged - LESS, LESS_BY * unchanged):
        return True, None
    at = tried[best]
    (_, early, sure), (_, late, surely) = (rows.part(each, at).fitted() for each in (True, False))
    # How objects fly, and neighbouring moments alike, make biases less sure than that.
    clear = np.abs(late - early) > CLEAR * np.hypot(sure, surely)
    step = np.where(clear, late - early, 0.0).reshape(-1, N_BIASES)
    step[:, [SCALE, EAST, NORTH, CLOCK]] = 0.0
    change = BiasChange(moments.begin + moments.step * at, step, len(fits))
    return True, change if step.any() else None
