"""Tracks as they were before scans that had no report of them."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from trackweave.association._growth import Candidates, Misses, ScanInput, WindowRule, propose
from trackweave.association.tree import AssociationTree, Beginning, GrowthLimits

__all__ = ["rewound"]


def rewound(beginning: Beginning, scans: Sequence[ScanInput], rule: WindowRule) -> Beginning:
    """Return tracks without what the last scans, all missed, added to their costs.

    Parameters
    ----------
    beginning
        The tracks after the scans; a ``tail`` is infinite where the track had been given up.
    scans
        The scans in order of time, none before a track's own time.
    rule
        What a miss costs.

    Returns
    -------
    The tracks before the scans. Those given up have a tail of 0, because why is not known.
    """
    count, dim = beginning.track.shape[0], beginning.mean.shape[1] // 2
    zero = np.zeros(count)
    tree = AssociationTree(dim, rule, GrowthLimits())
    tree.add_tracks(replace(beginning, tail=zero, misses=zero))
    patient = rule._replace(max_misses=np.inf, max_unseen=np.inf)
    nobody = np.empty(0, dtype=np.int64)
    for scan in scans:
        missed = Misses(np.empty(count), np.empty(count), np.empty(count))
        unseen = scan._replace(
            position=scan.position[:0], sigma=scan.sigma[:0], slot=scan.slot[:0]
        )
        propose(tree.nodes, count, unseen, patient, Candidates(nobody, nobody, zero[:0]), missed)
        tree.nodes.tail[:count] = missed.tail
        tree.nodes.misses[:count] = missed.misses
        tree.nodes.counted[:count] = missed.counted
    was_given_up = np.isinf(beginning.tail)
    tail = np.where(was_given_up, 0.0, beginning.tail - tree.nodes.tail[:count])
    misses = np.maximum(beginning.misses - tree.nodes.misses[:count], 0.0)
    return replace(beginning, tail=np.maximum(tail, 0.0), misses=misses)
