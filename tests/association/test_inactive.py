"""Where components may be seen, and what waiting costs them."""

from dataclasses import replace

import numpy as np
import pytest

from oracles.windows import WIDE, Windows
from trackweave.association import inactive
from trackweave.association._gating import most_moved
from trackweave.association._inactive import Whereabouts, concerned, label_families, locate
from trackweave.association._nodes import bare
from trackweave.association.inactive import InactiveClusters
from trackweave.association.tree import AssociationTree
from trackweave.association.window_rule import without_reports
from trackweave.filters._kernels import predict
from trackweave.models._kernels import is_covered
from trackweave.models.coverage import FieldOfView, everywhere


def nowhere(scan, after):
    """Return a scan without reports that looks where nothing of the windows is."""
    far = FieldOfView((1e6, 1e6), max_range=10.0).coverage()
    later = scan.time + after
    return without_reports(scan)._replace(
        time=later, reference=later, coverage=far, new_instant=True
    )


@pytest.mark.parametrize("seed", range(40))
def test_whatever_meets_the_coverage_is_concerned(seed):
    rng = np.random.default_rng(seed)
    start, width = rng.uniform(0.0, 360.0), rng.uniform(1.0, 359.0)
    low = rng.uniform(0.0, 500.0)
    view = FieldOfView(
        tuple(rng.uniform(-500, 500, 2)),
        low,
        low + rng.uniform(1.0, 1000.0),
        (start, start + width),
    )
    place, radius = rng.uniform(-2000.0, 2000.0, (1, 2)), rng.uniform(0.0, 800.0, 1)
    known = Whereabouts(np.zeros(1), place, place, radius)
    told = concerned(known, 1, view.coverage(), 1.0, 10.0, 0.0)[0]
    turn, out = rng.uniform(0.0, 2 * np.pi, 4000), radius * np.sqrt(rng.random(4000))
    points = place + np.column_stack([out * np.cos(turn), out * np.sin(turn)])
    meets = any(is_covered(x, y, view.coverage()) for x, y in points)
    assert told or not meets


def test_what_is_far_from_the_coverage_is_not_concerned():
    view = FieldOfView(max_range=100.0, azimuth_deg=(0.0, 45.0)).coverage()
    place = np.array([[0.0, 300.0], [60.0, -30.0], [30.0, 60.0], [-5.0, 50.0], [0.0, -5.0]])
    known = Whereabouts(np.zeros(5), place, place, np.full(5, 10.0))
    assert concerned(known, 5, view, 1.0, 10.0, 0.0).tolist() == [False, False, True, True, True]


def test_a_component_is_looked_for_on_its_way():
    view = FieldOfView(max_range=100.0).coverage()
    known = Whereabouts(
        np.zeros(1), np.array([[-1000.0, 0.0]]), np.array([[1000.0, 0.0]]), np.array([50.0])
    )
    told = [bool(concerned(known, 1, view, time, 10.0, 0.0)[0]) for time in (0.0, 3.0, 5.0, 8.0)]
    assert told == [False, False, True, False]
    assert concerned(known, 1, view, 3.0, 10.0, 600.0)[0]


def test_what_waited_for_a_horizon_is_concerned_by_whatever_comes():
    view = FieldOfView(max_range=1.0).coverage()
    place = np.full((1, 2), 1e5)
    for radius in (1.0, -np.inf):
        known = Whereabouts(np.zeros(1), place, place, np.array([radius]))
        assert not concerned(known, 1, view, 9.9, 10.0, 0.0)[0]
        assert concerned(known, 1, view, 10.0, 10.0, 0.0)[0]


@pytest.mark.parametrize("seed", range(8))
def test_families_that_share_reports_are_one_component(seed):
    window = Windows(seed, n_known=2)
    tree = window.tree()
    slots, place = tree.slots()
    family = tree.nodes.family[: tree.n_nodes]
    label, count = label_families(family, place, tree.n_nodes, slots.size, tree.n_families)
    groups = [{int(family)} for family in range(tree.n_families)]
    for slot in range(slots.size):
        sharing = set(family[place == slot].tolist())
        touched = [group for group in groups if group & sharing]
        groups = [group for group in groups if not group & sharing] + [set().union(*touched)]
    assert count == len(groups)
    for group in groups:
        assert len({int(label[member]) for member in group}) == 1


@pytest.mark.parametrize("seed", range(8))
def test_growing_sequences_stay_in_their_circle(seed):
    window = Windows(seed, n_known=2)
    tree = window.tree()
    label, motion = np.zeros(tree.n_families, dtype=np.int64), window.rule.motion
    begin, horizon = window.times[-1], 5.0
    known = locate(tree.nodes, np.arange(tree.n_nodes), label, 1, begin, horizon, motion, None)
    mean, covariance = np.empty(4), np.empty((4, 4))
    for after in (0.0, 1.0, 3.0, 5.0):
        share = after / horizon
        center = known.begin[0] + share * (known.end[0] - known.begin[0])
        for node in range(tree.n_nodes):
            if np.isfinite(tree.nodes.tail[node]):
                predict(
                    tree.nodes.mean[node, 0], tree.nodes.covariance[node, 0],
                    begin + after - tree.nodes.time[node], motion.noise[0, 0], mean, covariance,
                )  # fmt: skip
                spread = np.sqrt(np.linalg.eigvalsh(covariance[:2, :2]).max())
                apart = np.linalg.norm(mean[:2] - center)
                assert apart + 2.0 * spread <= known.radius[0] + 1e-6


@pytest.mark.parametrize("seed", range(6))
def test_comes_back_as_it_was_and_older(monkeypatch, seed):
    """Living on is charged, whoever waits; nothing else happens to what no scan concerns."""
    monkeypatch.setattr(inactive, "LITTLE", 0)
    window = Windows(seed, n_known=2)
    tree, same = window.tree(), window.tree()
    last = window.inputs()[0][-1]
    aside = InactiveClusters(window.rule, 100.0)
    aside.exchange(tree, last, 0.0)
    for after in (1.0, 2.0, 3.0):
        scan = nowhere(last, after)
        aside.exchange(tree, scan, 0.0)
        for each in (tree, same):
            each.grow(scan, np.empty(0))
    assert (tree.n_nodes, aside.n_nodes) == (0, same.n_nodes)
    aside.bring_back(tree, last.time + 4.0)
    assert (tree.n_nodes, aside.n_nodes) == (same.n_nodes, 0)
    assert sorted(tree.track.tolist()) == sorted(same.track.tolist())
    _assert_same(tree, same)


@pytest.mark.parametrize("seed", range(12))
def test_what_stays_is_what_a_scan_may_see_of_all_sequences(monkeypatch, seed):
    monkeypatch.setattr(inactive, "LITTLE", 0)
    rng, window = np.random.default_rng(seed), Windows(seed, n_known=12)
    apart = [np.concatenate([rng.normal(scale=600.0, size=2), np.zeros(2)]) for _ in range(12)]
    window.known = [
        replace(known, mean=known.mean + offset)
        for known, offset in zip(window.known, apart, strict=True)
    ]
    tree, last = window.tree(), window.inputs()[0][-1]
    aside = InactiveClusters(window.rule, 4.0)
    aside.exchange(tree, last, 0.0)
    low = rng.uniform(50.0, 400.0)
    view = FieldOfView(tuple(rng.uniform(-600.0, 600.0, 2)), low, 2.0 * low)
    scan = nowhere(last, 1.0)._replace(coverage=view.coverage())
    nodes, n = tree.nodes, tree.n_nodes
    slots, place = tree.slots()
    label, count = label_families(nodes.family, place, n, slots.shape[0], tree.n_families)
    motion = window.rule.motion
    known = locate(nodes, np.arange(n), label, count, last.time, 4.0, motion, None)
    slack = float(most_moved(bare(scan), motion.max_speed))
    told = concerned(known, count, scan.coverage, scan.reference, 4.0, slack)
    assert 0 < np.count_nonzero(told) < count
    expected = np.sort(nodes.mean[:n, 0][told[label[nodes.family[:n]]]], axis=0)
    aside.exchange(tree, scan, 0.0)
    assert np.array_equal(np.sort(tree.nodes.mean[: tree.n_nodes, 0], axis=0), expected)


def _assert_same(tree, same):
    """Compare sequences, each by its reports and the track it began with."""
    mine, theirs = _sequences(tree), _sequences(same)
    assert mine.keys() == theirs.keys()
    for key, values in mine.items():
        np.testing.assert_allclose(values, theirs[key], atol=1e-9)


def _sequences(tree):
    found = {}
    for node in range(tree.n_nodes):
        slots, climb = [], node
        while climb >= 0:
            slots.append(int(tree.nodes.report[climb]))
            climb = int(tree.nodes.parent[climb])
        key = int(tree.track[tree.nodes.family[node]]), tuple(slots)
        assert key not in found
        found[key] = (
            tree.nodes.cost[node], tree.nodes.tail[node], tree.nodes.misses[node],
            *tree.nodes.mean[node, 0], tree.nodes.hits[node],
        )  # fmt: skip
    return found


def test_a_scan_of_everything_brings_everything_back(monkeypatch):
    monkeypatch.setattr(inactive, "LITTLE", 0)
    window = Windows(1, n_known=2)
    tree, last = window.tree(), window.inputs()[0][-1]
    count = tree.n_nodes
    aside = InactiveClusters(window.rule, 100.0)
    aside.exchange(tree, last, 0.0)
    aside.exchange(tree, nowhere(last, 1.0), 0.0)
    assert tree.n_nodes == 0
    aside.exchange(tree, nowhere(last, 2.0)._replace(coverage=everywhere()), 0.0)
    assert (tree.n_nodes, aside.n_nodes) == (count, 0)


def test_a_gap_is_owed_until_all_that_had_it_are_back(monkeypatch):
    monkeypatch.setattr(inactive, "LITTLE", 0)
    window = Windows(1, n_known=2)
    tree, last = window.tree(), window.inputs()[0][-1]
    aside = InactiveClusters(window.rule, 100.0)
    aside.exchange(tree, last, 0.0)
    aside.exchange(tree, nowhere(last, 1.0), 3.5)
    assert aside.gap == 3.5
    aside.exchange(tree, nowhere(last, 2.0), 0.0)
    assert aside.gap == 3.5
    aside.bring_back(tree, last.time + 3.0)
    assert aside.gap == 0.0


def test_a_tree_of_little_is_left_alone():
    window = Windows(1, n_known=2)
    tree, last = AssociationTree(window.rule, WIDE), window.inputs()[0][-1]
    tree.add_tracks(window.beginning())
    aside = InactiveClusters(window.rule, 100.0)
    aside.exchange(tree, nowhere(last, 1.0), 0.0)
    assert (tree.n_nodes, aside.n_nodes) == (2, 0)
