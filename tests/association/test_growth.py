"""The tree's sequences against the enumeration of all there are."""

import numpy as np
import pytest

from oracles.sequences import every_sequence
from oracles.windows import Windows


def assert_same(window):
    tree = window.tree()
    expected = every_sequence(window.looks, window.rules, window.known)
    keys = [window.key(tree, node) for node in range(tree.n_nodes)]
    assert len(set(keys)) == len(keys)
    assert set(keys) == set(expected)
    totals = tree.totals()
    for node, key in enumerate(keys):
        wanted = expected[key]
        assert tree.nodes.cost[node] == pytest.approx(wanted.cost, abs=1e-9)
        assert totals[node] == pytest.approx(wanted.total, abs=1e-9)
        np.testing.assert_allclose(tree.nodes.mean[node, 0], wanted.mean, atol=1e-8)
        np.testing.assert_allclose(tree.nodes.covariance[node, 0], wanted.covariance, atol=1e-7)
    return tree


@pytest.mark.parametrize("seed", range(40))
def test_holds_every_sequence_at_its_cost(seed):
    assert_same(Windows(seed))


@pytest.mark.parametrize("seed", range(20))
def test_holds_every_sequence_of_tracks_from_before(seed):
    assert_same(Windows(seed, n_known=2))


@pytest.mark.parametrize("seed", range(30))
def test_holds_every_sequence_of_sensors_with_an_edge(seed):
    assert_same(Windows(seed, n_known=1, views=True))


@pytest.mark.parametrize("seed", range(30))
def test_holds_every_sequence_of_sensors_that_lose_objects_for_a_while(seed):
    assert_same(Windows(seed, n_known=1, views=seed % 2 == 0, lost=True))


@pytest.mark.parametrize("seed", range(15))
def test_holds_every_sequence_in_three_dimensions(seed):
    assert_same(Windows(seed, dim=3, n_known=1))


@pytest.mark.parametrize("seed", range(15))
def test_gives_up_after_so_many_misses(seed):
    assert_same(Windows(seed, n_known=2, max_misses=1.0))
    assert_same(Windows(seed, n_known=1, max_misses=2.0, views=True))


@pytest.mark.parametrize("seed", range(15))
def test_holds_every_sequence_of_objects_that_report_themselves(seed):
    times = np.random.default_rng(seed).choice([0.0, 2.0, 2.1, 4.2, 7.0], size=5).cumsum()
    assert_same(Windows(seed, n_known=1, heard=True, times=times.tolist()))
