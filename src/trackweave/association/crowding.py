"""How much growth there may be where there is more than can be told apart."""

import numpy as np
from numpy.typing import NDArray

from trackweave.arrays import FloatArray, IntArray
from trackweave.association._crowding import Crowding
from trackweave.association._nodes import Nodes
from trackweave.association._pruning import raise_ancestors
from trackweave.association.growth_limits import GrowthLimits

__all__ = ["crowding_of", "give_way", "room_in"]

CHILDREN, LOOKS = 4, 10
"""Continuations kept and reports looked at in a scan, by all sequences, for each of the greatest
number of sequences: so a gate with thousands of reports takes bounded time and memory."""
BOUNDLESS = 2**40
SHARE_IN_CROWDS = 4
"""Of the greatest number of sequences no more than this part is kept where some could not look at
all reports in their gate: what is to be told apart there cannot be, and costs most to solve."""
FEWEST, FEWEST_LOOKS, FEWEST_ANYWHERE = 4, 32, 1_000
"""What every sequence may keep and look at all the same; the last of scans that do not tell
places, where the nearest reports cannot be picked out."""


def crowding_of(
    nodes: Nodes, n_nodes: int, is_new: NDArray[np.bool_], limits: GrowthLimits
) -> Crowding:
    """Return what a sequence may look at and keep of a scan, so that all of them can."""
    # ``is_new`` says of each sequence whether its object begins in the window.
    n_growing = max(1, int(np.count_nonzero(np.isfinite(nodes.tail[:n_nodes]))))
    # A greatest number so large that none is meant has to fit into a kernel's all the same.
    room = min(limits.max_nodes, BOUNDLESS)
    most = max(FEWEST, CHILDREN * room // n_growing)
    # No family keeps more children of a sequence than sequences in all.
    children = np.minimum(np.where(is_new, limits.new_keep, limits.keep), most)
    # Below a line every child is a group of its own.
    children[nodes.is_line[:n_nodes] == 1] = most
    return Crowding(
        max(FEWEST_LOOKS, LOOKS * room // n_growing), FEWEST_ANYWHERE, children,
        np.zeros(2, dtype=np.int64), np.zeros(1, dtype=np.int64),
    )  # fmt: skip


def room_in(limits: GrowthLimits, *, is_crowded: bool) -> int:
    """Return how many sequences there may be; crowded, some could not look at all their gates."""
    return limits.max_nodes // (SHARE_IN_CROWDS if is_crowded else 1)


def give_way(kept: NDArray[np.bool_], parent: IntArray, behind: FloatArray, room: int) -> int:
    """Keep only the most probable sequences, and all that have to stay; return how many go."""
    # ``kept`` changes in place. ``parent`` is -1 for none; ``behind`` how far each lies behind the
    # best of its group [nats], minus infinity if it has to stay.
    n_before = int(np.count_nonzero(kept))
    behind = np.where(kept, behind, np.inf)
    raise_ancestors(parent, behind)
    inside = np.isneginf(behind)
    inside[np.argsort(behind, kind="stable")[:room]] = True
    kept &= inside
    return n_before - int(np.count_nonzero(kept))
