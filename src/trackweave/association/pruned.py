"""How probable it is that what a tree left out was right."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.association._beliefs import find_edges
from trackweave.association._pruning import Cut, accumulate_prices, add_above
from trackweave.association.beliefs import Beliefs
from trackweave.association.certificate import Certificate, Status
from trackweave.association.living import log_weights
from trackweave.association.tree import AssociationTree

__all__ = ["PrunedProbability", "forget_negligible", "judged", "pruned_shares"]

ENOUGH = 0.01
"""A hypothesis counts as the best of all where no family lost more of its probability."""


class PrunedProbability(NamedTuple):
    """How much of each family's probability was left out at a scan.

    A family is what may have become of one track, or of one object that begins in the window.
    """

    worst: float  # The greatest share of all families
    sum: float  # The sum of all shares


NOTHING = PrunedProbability(0.0, 0.0)


def forget_negligible(tree: AssociationTree | None, beliefs: Beliefs | None) -> PrunedProbability:
    """Forget what a search found negligible, before the tree grows on; return how much it was."""
    # Without beliefs nothing is known to be negligible.
    if tree is None or beliefs is None or tree.limits.negligible == 0.0:
        return NOTHING
    share = tree.forget(beliefs.probability)
    return PrunedProbability(float(share.max(initial=0.0)), float(share.sum()))


def judged(
    tree: AssociationTree,
    beliefs: Beliefs | None,
    certificate: Certificate,
    forgotten: PrunedProbability = NOTHING,
) -> tuple[PrunedProbability | None, Certificate]:
    """Return what a tree left out at its last scan, and forget it; and the certificate."""
    # Every sequence is ranked with the prices of now, which its beliefs left in the tree; without
    # beliefs nothing tells how much. What was forgotten before the scan came is told with it.
    # The certificate, that of an answer over the sequences kept, has another status where that is
    # too much to speak of the rest.
    told = None
    if beliefs is not None:
        share = pruned_shares(tree, beliefs)
        # The family that lost most at one may have lost most at the other.
        worst = min(1.0, float(share.max(initial=0.0)) + forgotten.worst)
        told = PrunedProbability(worst, float(share.sum()) + forgotten.sum)
    elif tree.cut is None or not tree.cut.family.shape[0]:
        told = NOTHING
    tree.cut = None
    # Nothing tells of reports that no sequence looked at.
    is_enough = told is not None and told.worst <= ENOUGH and not tree.is_crowded
    if is_enough or certificate.status is not Status.OPTIMAL:
        return told, certificate
    return told, replace(certificate, status=Status.OPTIMAL_AMONG_KEPT)


def pruned_shares(tree: AssociationTree, beliefs: Beliefs) -> FloatArray:
    """Return the share of each family's probability that a tree left out at its last scan."""
    # The tree holds the prices of these beliefs.
    cut, n, n_families = tree.cut, tree.n_nodes, tree.n_families
    if cut is None or not cut.family.shape[0]:
        return np.zeros(n_families)
    kept_family, is_new = tree.nodes.family[:n], tree.track < 0
    kept = log_weights(tree.nodes.cost[:n], tree.nodes.tail[:n], tree.rule.end_cost)[0]
    priced = np.empty(n)
    accumulate_prices(tree.nodes, n, priced)
    kept -= priced
    along = _own_prices(tree, beliefs, cut)
    add_above(cut.above, priced, along)
    lost = cut.log_weight - along
    # A new object may also be none, with weight 1.
    most = np.where(is_new, 0.0, -np.inf)
    np.maximum.at(most, kept_family, kept)
    np.maximum.at(most, cut.family, lost)
    left = np.bincount(kept_family, np.exp(kept - most[kept_family]), n_families)
    left += np.where(is_new, np.exp(-np.maximum(most, 0.0)), 0.0)
    gone = np.bincount(cut.family, np.exp(lost - most[cut.family]), n_families)
    return np.asarray(gone / (gone + left))


def _own_prices(tree: AssociationTree, beliefs: Beliefs, cut: Cut) -> FloatArray:
    """Return what holding its own report against others is worth to each sequence left out."""
    nodes, n = tree.nodes, tree.n_nodes
    slots, place = tree.slots()
    if not slots.shape[0]:
        return np.zeros(cut.family.shape[0])
    at = np.minimum(np.searchsorted(slots, cut.report), slots.shape[0] - 1)
    # Nobody else wants a report that no sequence has any more.
    cut_place = np.where(slots[at] == cut.report, at, -1)
    both = np.concatenate([nodes.family[:n], cut.family])
    places = np.concatenate([place, cut_place])
    edges = find_edges(both, places, both.shape[0], slots.shape[0], tree.n_families)
    # A family that was left no sequence with a report faces the claims of all others.
    price = np.log1p(beliefs.claims)[edges.report]
    has = place >= 0
    price[edges.of_node[:n][has]] = nodes.price[:n][has]
    own = edges.of_node[n:]
    return np.where(own >= 0, price[own], 0.0) if price.shape[0] else np.zeros(own.shape[0])
