"""Points of frames linked by their distances alone."""

import time
from itertools import permutations

import numpy as np
import pytest

from trackweave.trackers.frame_linking import linked


def scattered(
    seed: int, n_frames: int = 6, n: int = 5, side: float = 10.0
) -> tuple[np.ndarray, np.ndarray]:
    """As many points in each frame, anywhere in a square, in no order."""
    rng = np.random.default_rng(seed)
    frame = rng.permutation(np.repeat(np.arange(n_frames), n))
    return frame, rng.uniform(0.0, side, (frame.size, 2))


def steps(frame: np.ndarray, position: np.ndarray, owner: np.ndarray) -> np.ndarray:
    """Frames and distances between successive points of each object, shape (links, 2)."""
    found = []
    for each in np.unique(owner):
        rows = np.flatnonzero(owner == each)
        rows = rows[np.argsort(frame[rows])]
        apart = np.linalg.norm(np.diff(position[rows], axis=0), axis=1)
        found.append(np.stack([np.diff(frame[rows]), apart], axis=1))
    return np.concatenate(found)


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize("memory", [0, 2])
def test_no_step_is_longer_than_the_range_and_no_gap_than_the_memory(seed, memory):
    frame, position = scattered(seed)
    frame *= 1 + seed % 2
    found = steps(frame, position, linked(frame, position, 3.0, memory))
    assert (found[:, 0] >= 1).all()
    assert (found[:, 0] <= memory + 1).all()
    assert (found[:, 1] <= 3.0 + 1e-8).all()


@pytest.mark.parametrize("seed", range(20))
def test_two_frames_are_linked_at_the_least_cost_of_all_ways(seed):
    reach, n = 4.0, 5
    frame, position = scattered(seed, n_frames=2, n=n)
    found = steps(frame, position, linked(frame, position, reach))
    cost = (found[:, 1] ** 2).sum() + (n - len(found)) * reach**2
    first, second = position[frame == 0], position[frame == 1]
    squares = ((first[:, None] - second[None]) ** 2).sum(axis=2).clip(max=reach**2)
    least = min(squares[range(n), list(order)].sum() for order in permutations(range(n)))
    assert cost == pytest.approx(least)


def test_a_step_of_the_whole_range_is_one_at_any_scale():
    for scale in (1e-9, 1.0, 1e9):
        frame, position = np.array([0, 1]), scale * np.array([[0.0, 0.0], [0.3, 0.4]])
        assert linked(frame, position, 0.5 * scale).tolist() == [0, 0]
        assert linked(frame, position, 0.499 * scale).tolist() == [0, 1]


def test_what_is_remembered_is_looked_for_where_it_was_last_seen():
    frame = np.array([0, 1, 3, 4])
    position = np.array([[0.0], [1.0], [2.5], [3.0]])
    assert linked(frame, position, 2.0, 1).tolist() == [0, 0, 0, 0]
    assert linked(frame, position, 1.4, 1).tolist() == [0, 0, 1, 1]
    assert linked(frame, position, 2.0, 0).tolist() == [0, 0, 1, 1]


def test_crowds_take_no_longer_than_a_moment():
    for n, n_frames in ((100, 50), (2000, 10)):
        frame, position = scattered(1, n_frames, n, side=(n / 0.022) ** 0.5)
        linked(frame[:n], position[:n], 10.0)
        begun = time.process_time()
        linked(frame, position, 10.0)
        assert time.process_time() - begun < 5.0
