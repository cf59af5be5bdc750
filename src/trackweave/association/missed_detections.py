"""Tracks that wait: what scans without a report of them add to their costs."""

from collections.abc import Collection
from dataclasses import replace

import numpy as np

from trackweave.arrays import IntArray
from trackweave.association._nodes import Misses, ScanInput, WindowRule, room_for_candidates
from trackweave.association.crowding import crowding_of
from trackweave.association.foreign_growth import proposed
from trackweave.association.growth_limits import GrowthLimits
from trackweave.association.initial_tracks import InitialTracks
from trackweave.association.tree import AssociationTree
from trackweave.association.window_rule import without_reports

__all__ = ["waited"]


def waited(
    initial: InitialTracks, first: IntArray, scans: Collection[ScanInput], rule: WindowRule
) -> InitialTracks:
    """Return tracks, with tails, misses and how probably hidden, after scans without reports."""
    # ``first`` is, for each track, the first of the scans, in order of time, that may have missed
    # it: 0, or the one behind that of its last report. Nothing is given up here.
    count = initial.track.shape[0]
    tree = AssociationTree(rule, GrowthLimits())
    tree.add_tracks(initial)
    nodes = tree.nodes
    nodes.counted[:count] = first > 0
    patient = rule._replace(most_tail=np.inf, max_misses=np.inf, max_unseen=np.inf)
    nobody = room_for_candidates(0)
    for place, scan in enumerate(scans):
        missed = Misses(*(np.empty(count) for _ in Misses._fields))
        unseen = without_reports(scan)
        general = tree.general_for(unseen)
        crowding = crowding_of(nodes, count, tree.track < 0, tree.limits)
        proposed((nodes, count, patient), unseen, (nobody, missed), crowding, general)
        concerned = np.flatnonzero(first <= place)
        for name in ("tail", "hidden", "misses", "counted"):
            getattr(nodes, name)[concerned] = getattr(missed, name)[concerned]
        if scan.column >= 0:
            nodes.unseen[concerned, scan.column] = missed.unseen[concerned]
    kept = ("tail", "hidden", "unseen", "misses")
    waiting = {name: getattr(nodes, name)[:count].copy() for name in kept}
    return replace(initial, **waiting)
