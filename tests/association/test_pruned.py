"""How probable it is that what a tree left out was right."""

from dataclasses import replace

import numpy as np
import pytest

from oracles.windows import WIDE, Windows
from trackweave.association.beliefs import believe
from trackweave.association.certificate import Certificate, Status
from trackweave.association.growth_limits import GrowthLimits
from trackweave.association.pruned import (
    PrunedProbability,
    forget_negligible,
    judged,
    pruned_shares,
)
from trackweave.association.tree import AssociationTree
from trackweave.association.window_rule import without_reports

PROVEN = Certificate(-3.0, -3.0, Status.OPTIMAL)


def grown(window, limits):
    """Return the tree of a window that prunes at the last scan alone, and what is believed."""
    tree = AssociationTree(window.rule, WIDE)
    tree.add_tracks(window.beginning())
    *before, last = window.inputs()[0]
    for data in before:
        tree.grow(data, np.full(data.position.shape[0], window.log_density))
    believe(tree)
    tree.limits = limits
    tree.grow(last, np.full(last.position.shape[0], window.log_density))
    return tree, believe(tree)


def sequences(tree):
    """Return the node of each sequence by its family and its slots."""
    found = {}
    for node in range(tree.n_nodes):
        slots, climb = [], node
        while climb >= 0:
            slots.append(int(tree.nodes.report[climb]))
            climb = int(tree.nodes.parent[climb])
        found[int(tree.nodes.family[node]), tuple(slot for slot in slots[::-1] if slot >= 0)] = (
            node
        )
    return found


def shares_by_hand(window, tree, beliefs):
    """Return the shares left out, over all sequences there are, one by one."""
    whole, _ = grown(window, WIDE)
    slots, _ = tree.slots()
    price = {}
    for (family, own), node in sequences(tree).items():
        if own:
            price[family, own[-1]] = tree.nodes.price[node]
    claims = dict(zip(slots.tolist(), beliefs.claims, strict=True))
    left, gone = (tree.track < 0).astype(float), np.zeros(tree.n_families)
    mine = sequences(tree)
    for (family, own), node in sequences(whole).items():
        prices = [price.get((family, slot), np.log1p(claims[slot])) for slot in own]
        cost = whole.nodes.cost[node] + sum(prices)
        living = np.exp(-whole.nodes.tail[node])
        alive = np.exp(-cost) * living
        ended = np.exp(-cost) * min(np.exp(-window.rule.end_cost), 1.0 - living)
        twin = mine.get((family, own))
        (gone if twin is None else left)[family] += ended
        is_open = twin is not None and np.isfinite(tree.nodes.tail[twin])
        (left if is_open else gone)[family] += alive
    return gone / (gone + left)


@pytest.mark.parametrize(
    "limits",
    [
        GrowthLimits(margin=2.0, new_margin=1.0, new_ceiling=1.0),
        GrowthLimits(keep=2, new_keep=2),
        GrowthLimits(1e9, 10**9, 1e9, 10**9, 1e9, 12),
    ],
    ids=["margin", "keep", "cap"],
)
@pytest.mark.parametrize("seed", range(6))
def test_the_share_left_out_is_that_of_all_sequences_one_by_one(seed, limits):
    window = Windows(seed, n_known=2, times=[0.0, 1.0, 2.0])
    tree, beliefs = grown(window, limits)
    share = pruned_shares(tree, beliefs)
    np.testing.assert_allclose(share, shares_by_hand(window, tree, beliefs), atol=1e-9)
    told, _ = judged(tree, beliefs, PROVEN)
    assert told == pytest.approx((share.max(), share.sum()))


def test_of_a_scan_that_is_not_the_last_of_a_step_nothing_is_noted():
    window = Windows(3, n_known=2, times=[0.0, 1.0, 2.0])
    tree, _ = grown(window, GrowthLimits(keep=1, new_keep=1))
    last = window.inputs()[0][-1]._replace(time=3.0, reference=3.0)
    tree.grow(without_reports(last), np.empty(0), is_last=False)
    assert tree.cut is None


def test_something_is_left_out_there():
    window = Windows(3, n_known=2, times=[0.0, 1.0, 2.0])
    assert pruned_shares(*grown(window, GrowthLimits(keep=1, new_keep=1))).max() > 0.01


def test_nothing_left_out_is_no_share_and_stays_proven():
    window = Windows(3, n_known=2, times=[0.0, 1.0, 2.0])
    tree, beliefs = grown(window, WIDE)
    assert judged(tree, beliefs, PROVEN) == ((0.0, 0.0), PROVEN)
    tree, _ = grown(window, WIDE)
    assert judged(tree, None, PROVEN) == ((0.0, 0.0), PROVEN)


def test_what_was_forgotten_before_a_scan_is_told_with_what_it_left_out():
    window = Windows(3, n_known=2, times=[0.0, 1.0, 2.0])
    tree, beliefs = grown(window, WIDE)
    tree.limits = replace(WIDE, negligible=0.05)
    forgotten = forget_negligible(tree, beliefs)
    assert 0.01 < forgotten.worst <= 0.05
    told, certificate = judged(tree, believe(tree), PROVEN, forgotten)
    assert told.worst >= forgotten.worst
    assert told.sum >= forgotten.sum
    assert certificate.status is Status.OPTIMAL_AMONG_KEPT


def test_nothing_is_forgotten_of_which_nothing_is_known():
    window = Windows(3, n_known=2, times=[0.0, 1.0, 2.0])
    tree, beliefs = grown(window, WIDE)
    count = tree.n_nodes
    assert forget_negligible(tree, beliefs) == PrunedProbability(0.0, 0.0)
    tree.limits = replace(WIDE, negligible=0.05)
    assert forget_negligible(tree, None) == PrunedProbability(0.0, 0.0)
    assert forget_negligible(None, None) == PrunedProbability(0.0, 0.0)
    assert tree.n_nodes == count


def test_what_is_best_of_little_is_optimal_only_among_what_was_kept():
    window = Windows(3, n_known=2, times=[0.0, 1.0, 2.0])
    limits = GrowthLimits(keep=1, new_keep=1)
    told, certificate = judged(*grown(window, limits), PROVEN)
    assert told.worst > 0.01
    assert certificate.status is Status.OPTIMAL_AMONG_KEPT
    assert (certificate.cost, certificate.lower_bound) == (-3.0, -3.0)
    # Where nothing tells how much it was, nothing is proven of all there is either.
    told, certificate = judged(grown(window, limits)[0], None, PROVEN)
    assert told is None
    assert certificate.status is Status.OPTIMAL_AMONG_KEPT
    open_yet = Certificate(-3.0, -4.0, Status.FEASIBLE)
    assert judged(*grown(window, limits), open_yet)[1] == open_yet
