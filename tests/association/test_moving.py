"""Nodes by their sequences."""

import numpy as np

from trackweave.association._moving import paths_up


def test_a_path_leads_from_the_last_node_to_the_first():
    parent = np.array([-1, 0, -1, 1, 3, 2])
    path = paths_up(parent, np.array([4, 5, 0]))
    np.testing.assert_array_equal(path, [[4, 5, 0], [3, 2, -1], [1, -1, -1], [0, -1, -1]])


def test_no_sequences_have_one_empty_level():
    assert paths_up(np.array([-1]), np.empty(0, dtype=np.int64)).shape == (1, 0)
