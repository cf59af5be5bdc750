"""What the tree keeps when it prunes, slides and is cut."""

from dataclasses import replace

import numpy as np
import pytest

from oracles.windows import WIDE, Windows
from trackweave.association._pruning import accumulate_prices, crossings
from trackweave.association.beliefs import believe
from trackweave.association.growth_limits import GrowthLimits
from trackweave.association.tree import AssociationTree
from trackweave.association.window_rule import without_reports
from trackweave.errors import InvalidInputError
from trackweave.solvers import Exact, solve

TIMES = [0.0, 1.0, 1.0, 2.0, 3.0]


def sequences(window, tree, offset=0):
    """Return cost, total, misses and place of each sequence, by the reports that it has."""
    _, reports = window.inputs()
    found = {}
    totals = tree.totals()
    for node in range(tree.n_nodes):
        track = int(tree.track[tree.nodes.family[node]])
        slots, climb = [], node
        while climb >= 0:
            if tree.nodes.report[climb] >= 0:
                slots.append(reports[tree.nodes.report[climb] + offset])
            climb = int(tree.nodes.parent[climb])
        key = track, frozenset(slots)
        assert key not in found
        found[key] = (
            tree.nodes.cost[node], totals[node], tree.nodes.misses[node], *tree.nodes.mean[node, 0]
        )  # fmt: skip
    return found


def assert_same(mine, theirs):
    assert mine.keys() == theirs.keys()
    for key, values in mine.items():
        np.testing.assert_allclose(values, theirs[key], atol=1e-9)


def grow(tree, window, inputs):
    for data in inputs:
        tree.grow(data, np.full(data.position.shape[0], window.log_density))


@pytest.mark.parametrize("seed", range(12))
def test_growing_on_after_a_slide_is_growing_anew_from_the_roots(seed):
    """Two tracks go on from their own best sequences over the first two instants."""
    window = Windows(seed, n_known=2, times=TIMES)
    inputs, _ = window.inputs()
    n_fixed = int(inputs[2].slot[-1]) + 1 if len(inputs[2].slot) else 0
    n_fixed = max(n_fixed, *(int(d.slot[-1]) + 1 if len(d.slot) else 0 for d in inputs[:3]))
    tree = AssociationTree(window.rule, WIDE)
    tree.add_tracks(window.beginning())
    grow(tree, window, inputs[:3])
    # For each track, the longest sequence that ends in the fixed part.
    root = np.full(tree.n_families, -1)
    for node in range(tree.n_nodes):
        family = tree.nodes.family[node]
        if tree.track[family] >= 0 and (
            root[family] < 0 or tree.nodes.hits[node] >= tree.nodes.hits[root[family]]
        ):
            root[family] = node
    grow(tree, window, inputs[3:])
    anew = AssociationTree(window.rule, WIDE)
    anew.add_tracks(
        window.beginning().__class__(
            track=np.array([100, 101]),
            slot=np.full(2, -1),
            **{
                name: getattr(_grown(window, inputs[:3]).nodes, name)[root[root >= 0]].copy()
                for name in window.beginning().columns()
            },
        )
    )
    grow(anew, window, inputs[3:])
    again = _grown(window, inputs)
    again.fix(_same_nodes(tree, again, root), again.track, n_fixed)
    assert_same(sequences(window, again), sequences(window, anew))
    assert again.slots()[0].min(initial=n_fixed) >= n_fixed


def _grown(window, inputs):
    tree = AssociationTree(window.rule, WIDE)
    tree.add_tracks(window.beginning())
    grow(tree, window, inputs)
    return tree


def _same_nodes(before, after, root):
    """Return the nodes of a tree grown further that are nodes of the one before."""
    found = np.full(after.n_families, -1)
    for family in np.flatnonzero(root >= 0):
        path, climb = [], root[family]
        while climb >= 0:
            path.append(int(before.nodes.report[climb]))
            climb = before.nodes.parent[climb]
        for node in range(after.n_nodes):
            own, climb = [], node
            while climb >= 0:
                own.append(int(after.nodes.report[climb]))
                climb = after.nodes.parent[climb]
            if own == path and after.nodes.family[node] == family:
                found[family] = node
    assert np.count_nonzero(found >= 0) == np.count_nonzero(root >= 0)
    return found


@pytest.mark.parametrize("seed", range(6))
def test_a_family_that_begins_later_stays_whole_when_the_past_is_fixed(seed):
    window = Windows(seed, times=TIMES)
    inputs, _ = window.inputs()
    n_fixed = sum(len(data.slot) for data in inputs[:3])
    tree = _grown(window, inputs)
    later = {key: value for key, value in sequences(window, tree).items() if min(
        place for place, _ in key[1]) >= 3}  # fmt: skip
    tree.fix(np.full(tree.n_families, -1), tree.track, n_fixed)
    assert_same(sequences(window, tree), later)


@pytest.mark.parametrize("seed", range(6))
def test_counts_every_sequence_that_it_leaves_out(seed):
    """What is there and what is counted make up all there is, where nothing grew on it."""
    window = Windows(seed, n_known=1, times=[0.0, 1.0])
    whole = window.tree()
    narrow = window.tree(GrowthLimits(margin=4.0, keep=6, new_margin=2.0, new_keep=2))
    mine, all_there = sequences(window, narrow), sequences(window, whole)
    assert mine.keys() <= all_there.keys()
    n_stopped = 0
    for key, (cost, total, _, *state) in mine.items():
        np.testing.assert_allclose([cost, *state], np.delete(all_there[key], [1, 2]), atol=1e-9)
        assert total >= all_there[key][1] - 1e-9
        n_stopped += total > all_there[key][1] + 1e-9
    assert whole.n_pruned == 0
    # What grew on something left out was never counted; with two scans that is one level.
    missing = len(all_there) - len(mine)
    assert n_stopped <= narrow.n_pruned <= missing + len(mine)
    assert (narrow.n_pruned > 0) == (missing + n_stopped > 0)


@pytest.mark.parametrize("cap", [10, 30, 100])
def test_obeys_its_cap(cap):
    window = Windows(3, n_known=2, times=[0.0, 1.0, 1.0, 2.0, 3.0, 4.0])
    assert window.tree().n_nodes > 100
    limits = GrowthLimits(1e9, 10**9, 1e9, 10**9, 1e9, cap)
    tree = window.tree(limits)
    # Of each track known beforehand one sequence stays all the same.
    n_needed = tree.n_families + 2 * 6
    assert tree.n_nodes <= max(cap, n_needed)
    assert tree.n_pruned > 0
    assert tree.n_given_way == 0


def test_counts_what_gives_way_to_a_cap_for_now_alone():
    window = Windows(3, n_known=2, times=[0.0, 1.0, 1.0, 2.0, 3.0, 4.0])
    gone = {}
    for most in (60, 59):
        tree = AssociationTree(window.rule, GrowthLimits(1e9, 10**9, 1e9, 10**9, 1e9, 60))
        tree.add_tracks(window.beginning())
        tree.limit(most)
        grow(tree, window, window.inputs()[0])
        gone[most] = tree.n_given_way
        assert tree.n_pruned > 10
    assert gone[60] == 0
    # At most one more in each scan, and what grew on it.
    assert 0 < gone[59] <= 6


def test_the_worst_sequences_give_way_under_a_cap():
    window = Windows(3, n_known=2, times=[0.0, 1.0, 1.0, 2.0, 3.0, 4.0])
    best = window.tree().totals().min()
    capped = window.tree(GrowthLimits(1e9, 10**9, 1e9, 10**9, 1e9, 60))
    assert capped.totals().min() == pytest.approx(best, abs=3.0)


def least(tree):
    """Return what the best hypothesis of a tree costs."""
    slots = tree.slots()
    return solve(tree.problem(slots, np.arange(slots[0].shape[0])), Exact()).cost


@pytest.mark.parametrize("seed", range(8))
def test_what_is_believed_stays_under_the_least_cap(seed):
    """What is left explains more than that both tracks end at once."""
    window = Windows(seed, n_known=2, times=[0.0, 1.0, 1.0, 2.0, 3.0, 4.0])
    narrow = window.tree(GrowthLimits(1e9, 10**9, 1e9, 10**9, 1e9, 1))
    assert narrow.n_nodes < window.tree().n_nodes / 4
    assert least(narrow) < 2.0 * window.rule.end_cost


LEAST = {
    "margin": GrowthLimits(margin=1e-9, new_margin=1e-9, new_ceiling=1e-9),
    "keep": GrowthLimits(keep=1, new_keep=1),
    "cap": GrowthLimits(max_nodes=1),
}


@pytest.mark.parametrize("limits", LEAST.values(), ids=LEAST)
@pytest.mark.parametrize("seed", range(6))
def test_every_track_can_live_on_unseen_whatever_the_limits(seed, limits):
    """Its best sequence without the last scan's reports stays, and may grow on."""
    window = Windows(seed, n_known=2, times=[0.0, 1.0, 2.0, 3.0])
    *before, last = window.inputs()[0]
    tree = AssociationTree(window.rule, limits)
    tree.add_tracks(window.beginning())
    grow(tree, window, before)
    _, missed = tree._propose(last)
    best = best_alive(tree, missed.tail)
    grow(tree, window, [last])
    tail = tree.nodes.tail[: tree.n_nodes].copy()
    tail[np.isin(tree.nodes.report[: tree.n_nodes], last.slot)] = np.inf
    np.testing.assert_allclose(best_alive(tree, tail), best)


def best_alive(tree, tail):
    """Return how the best living sequence of each of two tracks ranks."""
    n = tree.n_nodes
    priced = np.empty(n)
    accumulate_prices(tree.nodes, n, priced)
    rank = tree.nodes.cost[:n] + tail + priced
    return [rank[tree.nodes.family[:n] == family].min() for family in range(2)]


def test_grows_beyond_its_first_room():
    window = Windows(3, n_known=2, times=[0.0, 1.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0])
    assert window.tree().n_nodes > 256
    assert_same(sequences(window, window.tree()), sequences(window, window.tree()))


@pytest.mark.parametrize("name", sorted({*GrowthLimits.__dataclass_fields__} - {"negligible"}))
@pytest.mark.parametrize("value", [0, -1, np.nan])
def test_refuses_limits_that_leave_nothing(name, value):
    with pytest.raises(InvalidInputError, match=name):
        GrowthLimits(**{name: value})


@pytest.mark.parametrize("value", [-0.1, 1.0, np.nan])
def test_refuses_what_is_no_share_of_a_track(value):
    with pytest.raises(InvalidInputError, match="negligible"):
        GrowthLimits(negligible=value)


@pytest.mark.parametrize("seed", range(6))
def test_forgets_no_more_than_it_tells_and_leaves_the_rest_as_it_was(seed):
    window = Windows(seed, n_known=2, times=[0.0, 1.0, 2.0, 3.0])
    whole = window.tree()
    probability = believe(whole).probability
    best = np.argsort(-probability, kind="stable")[:2]
    chances = dict(zip(sequences(window, whole), probability, strict=True))
    before, tree = sequences(window, whole), window.tree()
    tree.nodes.chosen[: tree.n_nodes] = 0
    tree.nodes.chosen[best] = 1
    tree.limits = replace(tree.limits, negligible=0.05)
    told = tree.forget(probability)
    after = sequences(window, tree)
    assert 0 < len(after) < len(before)
    assert_same(after, {key: before[key] for key in after})
    assert tree.nodes.chosen[: tree.n_nodes].sum() == 2
    assert tree.n_families == whole.n_families == told.shape[0]
    assert tree.n_pruned == whole.n_pruned + len(before) - len(after)
    assert told.max() <= 0.05
    assert told.sum() == pytest.approx(sum(chances[key] for key in before.keys() - after.keys()))


def test_an_empty_scan_charges_every_sequence_a_miss():
    window = Windows(3, n_known=1)
    tree = window.tree()
    before, tails = tree.n_nodes, tree.nodes.tail[: tree.n_nodes].copy()
    in_sight = 1 - tree.nodes.hidden[:before]
    data = window.inputs()[0][-1]
    later = data.time + 1.0
    empty = without_reports(data)._replace(
        time=later, reference=later, new_instant=True, hiding=0.1, showing=0.2
    )
    tree.grow(empty, np.empty(0))
    assert tree.n_nodes == before
    in_sight = 0.9 * in_sight + 0.2 * (1 - in_sight)
    missed = 1 - empty.detection_probability * in_sight
    charged = empty.survival_cost - np.log(missed)
    np.testing.assert_allclose(tree.nodes.tail[:before] - tails, charged)
    np.testing.assert_allclose(tree.nodes.hidden[:before], (1 - in_sight) / missed)


def test_a_tree_without_anything_is_a_problem_without_anything():
    window = Windows(1)
    tree = AssociationTree(window.rule, WIDE)
    problem = tree.problem(tree.slots(), np.empty(0, dtype=np.int64))
    assert (problem.n_nodes, problem.n_items) == (0, 0)


def test_below_a_line_each_second_report_begins_a_group_of_its_own():
    #           line 0        located 5
    #       1 (a)    2 (b)        6
    #       3        4
    parent = np.array([-1, 0, 0, 1, 2, -1, 5])
    is_line = np.array([1, 0, 0, 0, 0, 0], dtype=np.int64)
    family = np.array([0, 0, 0, 0, 0, 1, 1])
    group = crossings(parent, is_line, family, 2)
    assert group[0] == 0
    assert group[5] == group[6] == 1
    assert group[1] == group[3]
    assert group[2] == group[4]
    assert len({int(group[0]), int(group[1]), int(group[2]), 1}) == 4
