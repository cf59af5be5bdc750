"""The clusters of a tracker's window: what each costs, and of which reports it is."""

from dataclasses import dataclass

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.association._inactive import label_families
from trackweave.association.inactive import InactiveClusters
from trackweave.association.tree import AssociationTree
from trackweave.trackers.report_index import ReportIndex

__all__ = ["Clusters", "clusters_of"]


@dataclass(frozen=True, slots=True, eq=False)
class Clusters:
    """What may have become of objects that compete for reports, a row for each such group."""

    cost: FloatArray  # Of its part of the last answer [nats]
    place: FloatArray  # Where its first object was last, or about where it is, x, y [m]
    report: IntArray  # The numbers of the window's reports, once or more for each cluster
    owner: IntArray  # The cluster of each of these


def clusters_of(
    held: tuple[AssociationTree, InactiveClusters] | None, index: ReportIndex
) -> Clusters:
    """Return the clusters of a tree and those that are inactive, whose costs are the answer's."""
    if held is None:
        nothing = np.empty(0, dtype=np.int64)
        return Clusters(np.empty(0), np.empty((0, 2)), nothing, nothing)
    tree, inactive = held
    nodes, n = tree.nodes, tree.n_nodes
    slots, at = tree.slots()
    label, count = label_families(nodes.family, at, n, slots.shape[0], tree.n_families)
    mine = label[nodes.family[:n]]
    chosen = np.flatnonzero(nodes.chosen[:n])
    own = np.bincount(mine[chosen], tree.totals()[chosen], count)
    # A cluster without any report is a track, one of whose sequences is chosen.
    there = np.full((count, 2), np.nan)
    there[mine[chosen[::-1]]] = nodes.mean[chosen[::-1], 0, :2]
    has = np.flatnonzero(at >= 0)
    cost, place, slot, owner = inactive.parts()
    slot = np.concatenate([nodes.report[has], slot])
    owner = np.concatenate([mine[has], owner + count])
    is_open = slot >= index.origin
    return Clusters(
        cost=np.concatenate([own, cost]),
        place=np.concatenate([there, place]),
        report=index.report[slot[is_open] - index.origin],
        owner=owner[is_open],
    )
