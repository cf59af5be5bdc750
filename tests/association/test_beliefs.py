"""Beliefs against the sum over all joint hypotheses."""

import math

import numpy as np
import pytest

from oracles import kalman
from oracles.windows import MOTION, Windows
from trackweave.association.beliefs import believe
from trackweave.association.states import average_at


def choices(tree):
    """Return for each family what it may be: node, reports, share alive, weight."""
    families = [[] for _ in range(tree.n_families)]
    for node in range(tree.n_nodes):
        reports, climb = set(), node
        while climb >= 0:
            if tree.nodes.report[climb] >= 0:
                reports.add(int(tree.nodes.report[climb]))
            climb = tree.nodes.parent[climb]
        living = math.exp(-tree.nodes.tail[node])
        ending = min(math.exp(-tree.rule.end_cost), 1.0 - living)
        weight = math.exp(-tree.nodes.cost[node]) * (living + ending)
        families[tree.nodes.family[node]].append(
            (node, frozenset(reports), living / (living + ending), weight)
        )
    for family, track in enumerate(tree.track):
        if track < 0:
            families[family].append((-1, frozenset(), 0.0, 1.0))
    return families


def exact(tree):
    """Return each sequence's probability by summing all joint hypotheses."""
    families, probability = choices(tree), np.zeros(tree.n_nodes)

    def walk(family, taken):
        """Return the weight of all hypotheses of the families from this one on."""
        if family == len(families):
            return 1.0, {}
        total, inside = 0.0, {}
        for node, reports, _, weight in families[family]:
            if reports & taken:
                continue
            below, parts = walk(family + 1, taken | reports)
            total += weight * below
            for other, part in parts.items():
                inside[other] = inside.get(other, 0.0) + weight * part
            if node >= 0:
                inside[node] = inside.get(node, 0.0) + weight * below
        return total, inside

    total, inside = walk(0, frozenset())
    for node, part in inside.items():
        probability[node] = part / total
    return probability


def cut(window, n_reports):
    """Keep so few reports that all joint hypotheses can be summed."""
    left = n_reports
    for look in window.looks:
        count = min(left, len(look.positions))
        look.positions, look.sigmas = look.positions[:count], look.sigmas[:count]
        left -= count
    return n_reports - left


@pytest.mark.parametrize("n_known", [1, 2])
@pytest.mark.parametrize("seed", range(6))
def test_one_shared_report_is_believed_exactly(seed, n_known):
    window = Windows(seed, n_known=n_known)
    cut(window, 1)
    tree = window.tree()
    expected = exact(tree)
    beliefs = believe(tree, max_iterations=100)
    np.testing.assert_allclose(beliefs.probability, expected, atol=2e-3)


def error(window):
    """Return how far the beliefs of a window are from the exact ones, per sequence."""
    cut(window, 5)
    tree = window.tree()
    beliefs = believe(tree)
    return np.abs(beliefs.probability - exact(tree))


@pytest.mark.parametrize("seed", range(15))
def test_loops_of_tracks_apart_are_believed_nearly(seed):
    window = Windows(seed, n_known=2)
    for sign, known in zip((-1.0, 1.0), window.known, strict=True):
        known.mean[0] += sign * 50.0
    assert error(window).max() < 0.08


def test_loops_of_tracks_in_one_place_are_believed_roughly():
    """Two tracks, five reports, each in every gate: the worst there is, and far from usual."""
    errors = [error(Windows(seed, n_known=2)) for seed in range(25)]
    assert max(each.max() for each in errors) < 0.25
    assert np.mean([each.max() for each in errors]) < 0.06


def reports_of(tree, node):
    found = set()
    while node >= 0:
        if tree.nodes.report[node] >= 0:
            found.add(int(tree.nodes.report[node]))
        node = tree.nodes.parent[node]
    return found


@pytest.mark.parametrize("seed", range(10))
def test_probabilities_add_up(seed):
    window = Windows(seed, n_known=2)
    tree = window.tree()
    count = sum(len(look.positions) for look in window.looks)
    beliefs = believe(tree, max_iterations=200)
    n, family = tree.n_nodes, tree.nodes.family[: tree.n_nodes]
    of_family = np.bincount(family, beliefs.probability, minlength=tree.n_families)
    is_track = tree.track >= 0
    np.testing.assert_allclose(of_family[is_track], 1.0, atol=1e-9)
    assert np.all(of_family[~is_track] <= 1.0 + 1e-9)
    assert np.all(beliefs.existence <= of_family + 1e-9)
    of_report = np.zeros(count)
    of_edge = np.zeros(len(beliefs.edge_probability))
    for node in range(n):
        for report in reports_of(tree, node):
            of_report[report] += beliefs.probability[node]
        climb = node
        while climb >= 0:
            if beliefs.edge[climb] >= 0:
                of_edge[beliefs.edge[climb]] += beliefs.probability[node]
            climb = tree.nodes.parent[climb]
    assert np.all(of_report <= 1.0 + 1e-3)
    np.testing.assert_allclose(of_edge, beliefs.edge_probability, atol=1e-9)


@pytest.mark.parametrize("seed", range(6))
def test_the_mean_state_is_that_of_the_mixture(seed):
    window = Windows(seed, n_known=1)
    tree = window.tree()
    time = window.times[-1] + 2.0
    beliefs = believe(tree)
    families = choices(tree)
    node, source = np.arange(tree.n_nodes), (tree.nodes, tree.n_nodes, tree.n_families)
    of_family = np.unique(tree.nodes.family[node], return_index=True)[1]
    told = average_at(source, of_family, time, tree, by_belief=True)
    for family, members in enumerate(families):
        parts = []
        for node, _, alive, _ in members:
            if node >= 0:
                state = kalman.predict(
                    tree.nodes.mean[node, 0], tree.nodes.covariance[node, 0],
                    time - tree.nodes.time[node], MOTION.process_noise,
                )  # fmt: skip
                parts.append((beliefs.probability[node] * alive, *state))
        weight = sum(part[0] for part in parts)
        assert beliefs.existence[family] == pytest.approx(weight, abs=1e-12)
        mean = sum(part[0] * part[1] for part in parts) / weight
        spread = sum(
            part[0] * (part[2] + np.outer(part[1] - mean, part[1] - mean)) for part in parts
        )
        # Sequences of less than a ten-thousandth of the best are left out.
        scale = np.abs(spread).max() / weight
        np.testing.assert_allclose(told[0][family], mean, atol=0.01 * np.sqrt(scale))
        np.testing.assert_allclose(told[1][family], spread / weight, atol=0.01 * scale)
        assert np.linalg.eigvalsh(told[1][family]).min() > 0.0


def test_many_improbable_sequences_keep_their_spread():
    """No one of thousands of equal sequences can be left out of the covariance."""
    from trackweave.association._beliefs import average_states

    window = Windows(3, n_known=1)
    tree = window.tree()
    count = 20_000
    tree._reserve(count)
    nodes = tree.nodes
    nodes.family[:count], nodes.time[:count] = 0, 0.0
    nodes.mean[:count], nodes.covariance[:count] = 0.0, np.eye(4)
    nodes.weight[:count], nodes.is_line[:count] = 1.0, 0
    nodes.mean[:count, 0, 0] = np.where(np.arange(count) % 2, 3.0, -3.0)
    existence, mean, covariance = np.empty(1), np.empty((1, 4)), np.empty((1, 4, 4))
    average_states(
        nodes, count, 1, np.full(count, 1.0 / count), 0.0, window.rule.motion,
        existence, mean, covariance, None,
    )  # fmt: skip
    np.testing.assert_allclose(covariance[0], np.diag([10.0, 1.0, 1.0, 1.0]), atol=1e-6)


def test_leaves_the_prices_for_the_trees_growth():
    window = Windows(4, n_known=2)
    tree = window.tree()
    believe(tree)
    prices = tree.nodes.price[: tree.n_nodes]
    assert np.all(prices >= -1e-12)
    assert prices.max() > 0.0
    assert np.all(prices[tree.nodes.report[: tree.n_nodes] < 0] == 0.0)


@pytest.mark.parametrize("seed", range(4))
def test_probabilities_that_the_search_tells_are_summed_by_association(seed):
    window = Windows(seed, n_known=2)
    tree = window.tree()
    known = np.random.default_rng(seed).random(tree.n_nodes) / tree.n_nodes
    told = believe(window.tree(), known)
    own = believe(tree)
    wanted = np.zeros(len(own.edge_probability))
    for node in range(tree.n_nodes):
        climb = node
        while climb >= 0:
            if own.edge[climb] >= 0:
                wanted[own.edge[climb]] += known[node]
            climb = tree.nodes.parent[climb]
    np.testing.assert_allclose(told.edge_probability, wanted)
    np.testing.assert_array_equal(told.probability, own.probability)
    np.testing.assert_array_equal(told.existence, own.existence)
