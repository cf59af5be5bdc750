"""What may be reached at all, and that looking there first leaves nobody out."""

import numpy as np
import pytest

from oracles.windows import MOTION, Windows
from trackweave.association._gating import is_any_reachable, is_reachable, widest
from trackweave.association.window_rule import Context, scan_input
from trackweave.domain.scans import Scan


def wide_scan(window, rng):
    """Return a scan of reports far and near, two seconds after a window."""
    sensor, count = window.sensors[0], int(rng.integers(1, 6))
    places = rng.normal(size=(count, window.dim)) * 200.0
    scan = Scan(window.times[-1] + 2.0, sensor.name, places, rng.uniform(3.0, 40.0, places.shape))
    return scan_input(scan, sensor, 0.001, Context(MOTION, window.dim))[0]


@pytest.mark.parametrize("dim", [2, 3])
def test_any_report_is_reachable_where_one_is(dim):
    told = []
    for seed in range(20):
        window, rng = Windows(seed, dim=dim, n_known=2), np.random.default_rng(seed)
        tree, scan = window.tree(), wide_scan(window, rng)
        nodes = tree.nodes
        for node in range(tree.n_nodes):
            reach = MOTION.max_speed * (scan.time - nodes.time[node])
            state = nodes.mean, nodes.covariance, nodes.weight, node
            reports = scan.position, scan.position_covariance
            scale = 3.0 if node % 2 else 1.0
            each = [
                is_reachable(*state, *reports, index, reach, scale)
                for index in range(len(scan.position))
            ]
            broad = widest(scan, dim) * scale**2
            told.append(is_any_reachable(*state, *reports, broad, reach, scale))
            assert told[-1] == any(each)
    assert 0.1 < np.mean(told) < 0.9


@pytest.mark.parametrize("seed", range(8))
def test_where_silence_tells_nothing_the_same_continuations_are_proposed(seed):
    window = Windows(seed, n_known=3)
    scan = wide_scan(window, np.random.default_rng(seed))
    told, _ = window.tree()._propose(scan)
    lone, missed = window.tree()._propose(scan._replace(is_silence_telling=False))
    for wanted, got in zip(told, lone, strict=True):
        np.testing.assert_array_equal(got, wanted)
    alive = np.isfinite(missed.tail)
    before = window.tree().nodes.tail[: alive.shape[0]]
    np.testing.assert_array_equal(missed.tail[alive], before[alive] + scan.survival_cost)
