"""Growth bounded where a gate is crowded. Nothing here checks or raises."""

from typing import NamedTuple

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.association._gating import is_beside
from trackweave.association._nodes import Candidates
from trackweave.jit import jit


class Crowding(NamedTuple):
    """What keeps growth bounded where a gate holds more reports than any sequence can try.

    A sequence looks at the ``looks`` reports nearest to it, or at one in so many of a scan that
    does not tell places and has more than ``looks_anywhere``, and keeps its ``children`` cheapest
    continuations. ``left_out`` takes up how many were not looked at, and how many not kept;
    ``dearest`` the entry of the dearest child of a sequence that has all it may keep.
    """

    looks: int
    looks_anywhere: int
    children: IntArray
    left_out: IntArray
    dearest: IntArray


@jit
def admit(
    candidates: Candidates, begin: int, count: int, crowding: Crowding, node: int, index: int,
    cost: float,
) -> int:  # fmt: skip
    """Write a child among those of its node, which stand from ``begin`` on; return the count.

    A node that has all the children that it may keep gives up the dearest of them.
    """
    if count - begin < crowding.children[node]:
        if count < candidates.node.shape[0]:
            candidates.node[count] = node
            candidates.report[count] = index
            candidates.cost[count] = cost
            candidates.leap[count] = False
        return count + 1
    crowding.left_out[1] += 1
    if count <= candidates.node.shape[0]:
        dearest = crowding.dearest[0]
        if dearest < begin:
            dearest = _dearest(candidates.cost, begin, count)
        if cost < candidates.cost[dearest]:
            candidates.report[dearest] = index
            candidates.cost[dearest] = cost
            dearest = _dearest(candidates.cost, begin, count)
        crowding.dearest[0] = dearest
    return count


@jit
def _dearest(cost: FloatArray, begin: int, end: int) -> int:
    """Return the last of the dearest entries of a span."""
    dearest = begin
    for entry in range(begin + 1, end):
        if cost[entry] >= cost[dearest]:
            dearest = entry
    return dearest


@jit
def nearest_of(
    position: FloatArray, low: int, high: int, most: int, gate: float, mean: FloatArray,
    covariance: FloatArray, widest: float, slack: float,
) -> tuple[int, int]:  # fmt: skip
    """Return the part of a span that has so many reports also within reach along the second axis.

    Those nearest along the first axis, by the first mode.
    """
    place = mean[0, 0]
    last = low + int(np.searchsorted(position[low:high, 0], place))
    first, found = last, 0
    while found < most and (first > low or last < high):
        if last >= high or (
            first > low and place - position[first - 1, 0] <= position[last, 0] - place
        ):
            first -= 1
            index = first
        else:
            index = last
            last += 1
        found += is_beside(position[index, 1], gate, mean, covariance, widest, slack)
    return first, last
