"""Gates with more reports than any sequence can try."""

import numpy as np
import pytest

from oracles.windows import WIDE, Windows
from trackweave.association._crowding import Crowding, nearest_of
from trackweave.association._gating import is_beside, within_reach
from trackweave.association._growth import propose
from trackweave.association._nodes import Misses, room_for_candidates
from trackweave.association._pruning import part_ties
from trackweave.association.crowding import FEWEST_LOOKS, SHARE_IN_CROWDS
from trackweave.association.growth_limits import GrowthLimits
from trackweave.association.tree import AssociationTree


def scans_of(spread, n_reports, n_scans):
    """Return a window, and scans with all reports within ``spread`` [m] of where a track is."""
    window = Windows(1, n_known=1, times=[float(k) for k in range(n_scans)])
    inputs, _ = window.inputs()
    rng, each = np.random.default_rng(0), np.zeros(n_reports)
    scans = []
    for number, data in enumerate(inputs):
        place = window.beginning().mean[0, 0, :2] + rng.normal(0.0, 1.0, (n_reports, 2)) * spread
        place = place[np.argsort(place[:, 0], kind="stable")]
        scans.append(
            data._replace(
                slot=number * n_reports + np.arange(n_reports),
                measurement=place.copy(),
                position=place,
                position_covariance=np.tile(100.0 * np.eye(2), (n_reports, 1, 1)),
                noise=100.0 * np.eye(2)[None],
                platform=np.zeros((1, 6)),
                moment=np.full(n_reports, data.time),
                setting=np.zeros(n_reports, dtype=np.int64),
                identity=np.full(n_reports, -1),
                level=np.full(n_reports, np.nan),
                evidence=each,
                log_begin=each,
            )
        )
    return window, scans


def crowd(spread, n_reports, limits, n_scans=4):
    """Return a tree grown by such scans, and how many sequences it had after each."""
    window, scans = scans_of(spread, n_reports, n_scans)
    tree = AssociationTree(window.rule, limits)
    tree.add_tracks(window.beginning())
    sizes = []
    for scan in scans:
        tree.grow(scan, np.full(n_reports, window.log_density))
        sizes.append(tree.n_nodes)
    return tree, sizes


def children(tree, scan, most, room=100_000):
    """Return the cost of each child by parent and report, and how many were not kept."""
    n = tree.n_nodes
    candidates = room_for_candidates(room)
    missed = Misses(*(np.empty(n) for _ in Misses._fields))
    crowding = Crowding(
        10**6, 10**6, np.full(n, most), np.zeros(2, dtype=np.int64), np.zeros(1, dtype=np.int64)
    )
    count = propose(tree.nodes, n, scan, tree.rule, candidates, missed, crowding, tree.general)
    found = {
        (int(candidates.node[k]), int(candidates.report[k])): candidates.cost[k]
        for k in range(min(count, room))
    }
    return found, count, crowding.left_out


@pytest.mark.parametrize("most", [1, 2, 5])
def test_a_sequence_keeps_its_cheapest_children(most):
    tree, _ = crowd(20.0, 12, WIDE, n_scans=2)
    scan = scans_of(20.0, 12, 3)[1][2]
    everything, n_all, _ = children(tree, scan, 10**6)
    kept, n_kept, left_out = children(tree, scan, most)
    assert n_all - n_kept == left_out[1] > 0
    for node in {node for node, _ in everything}:
        own = {key: cost for key, cost in everything.items() if key[0] == node}
        cheapest = sorted(own, key=own.get)[:most]
        assert {key: kept[key] for key in cheapest} == {key: own[key] for key in cheapest}
    assert len(kept) == n_kept


def test_children_without_room_are_counted_all_the_same():
    tree, _ = crowd(20.0, 12, WIDE, n_scans=2)
    scan = scans_of(20.0, 12, 3)[1][2]
    _, count, _ = children(tree, scan, 2)
    assert children(tree, scan, 2, room=1)[1] == count > 1


@pytest.mark.parametrize("most", [1, 5, 40])
def test_the_nearest_of_a_span_are_so_many_within_reach(most):
    rng = np.random.default_rng(most)
    position = rng.uniform(-100.0, 100.0, (300, 2))
    position = position[np.argsort(position[:, 0])]
    mean, covariance = np.array([[3.0, -7.0, 0.0, 0.0]]), np.diag([60.0, 30.0, 1.0, 1.0])[None]
    reach = 16.0, mean, covariance, 100.0, 0.0
    low, high = within_reach(position, *reach)
    place, gate = position[:, 0], 16.0
    bound = np.sqrt(gate * 160.0)
    assert (low, high) == tuple(np.searchsorted(place, [3.0 - bound, 3.0 + bound]))
    first, last = nearest_of(position, low, high, most, *reach)
    beside = [is_beside(position[k, 1], *reach) for k in range(low, high)]
    inside = [k for k in range(low, high) if beside[k - low]]
    nearest = sorted(inside, key=lambda k: abs(place[k] - 3.0))[:most]
    assert [k for k in inside if first <= k < last] == sorted(nearest)


def test_of_equals_at_the_bound_only_as_many_stay_as_there_is_room():
    group = np.array([0, 1, 0, 0, 1, 0, 0])
    excess = np.array([-1.0, 0.0, 0.0, 0.0, 0.5, 0.0, -2.0])
    part_ties(group, excess, np.array([3, 1]))
    assert excess.tolist() == [-1.0, 0.0, 0.0, np.inf, 0.5, np.inf, -2.0]


@pytest.mark.parametrize("spread", [0.0, 10.0])
def test_reports_at_one_place_make_a_bounded_tree(spread):
    limits = GrowthLimits(max_nodes=4_000)
    n_reports = 200
    tree, sizes = crowd(spread, n_reports, limits)
    assert n_reports > FEWEST_LOOKS
    assert tree.is_crowded
    assert tree.n_pruned > 0
    for number, size in enumerate(sizes, start=1):
        # Beginnings never give way.
        assert size <= limits.max_nodes // SHARE_IN_CROWDS + number * n_reports + 1
    of_family = np.bincount(tree.nodes.family[: tree.n_nodes])
    assert of_family[0] <= 2 * limits.keep
    assert of_family[1:].max() <= 2 * limits.new_keep
    assert np.all(np.isfinite(tree.nodes.cost[: tree.n_nodes]))


def test_a_scan_without_a_crowd_is_looked_at_whole():
    tree, _ = crowd(300.0, 40, GrowthLimits())
    assert not tree.is_crowded
