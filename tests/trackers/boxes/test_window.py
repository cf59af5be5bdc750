"""Several explanations of the last frames."""

import numpy as np
import pytest

import trackweave as tw
from trackweave.trackers.boxes.window import MOST


def walk(seed: int, n_frames: int = 25) -> list[np.ndarray]:
    """Return boxes of six people who walk close together and are often missed."""
    rng = np.random.default_rng(seed)
    frames = []
    for k in range(n_frames):
        place = np.column_stack([3.0 * k + rng.normal(0, 1, 6), 12.0 * np.arange(6)])
        place += rng.normal(0, 2.0, place.shape)
        middle = place[rng.random(6) < 0.75]
        half = np.array([10.0, 20.0])
        frames.append(np.hstack([middle - half, middle + half]))
    return frames


@pytest.mark.parametrize("depth", [0, 1, 3])
def test_chosen_leaves_are_of_different_objects_and_share_no_box(depth: int) -> None:
    tracker = tw.BoxTracker(window=depth)
    for boxes in walk(1):
        tracker.update(boxes, np.full(len(boxes), 0.9))
        window = tracker._window
        chosen = window.chosen
        assert np.unique(window._family[chosen]).size == chosen.size
        for column in window._path[chosen].T:
            had = column[column >= 0]
            assert np.unique(had).size == had.size


def test_leaves_and_families_stay_few() -> None:
    tracker = tw.BoxTracker(window=3)
    for boxes in walk(2, 60):
        tracker.update(boxes, np.full(len(boxes), 0.9))
        window = tracker._window
        sizes = np.bincount(window._family)
        assert sizes.max() <= MOST + window._depth + 3
        assert len(window.moments) <= window._depth + 1
        assert window._n_families == sizes.size
        assert np.abs(window._score).max() < 1e3


def test_a_deeper_window_explains_some_boxes_in_another_way() -> None:
    told = []
    for depth in (0, 3):
        tracker = tw.BoxTracker(window=depth, delay=depth)
        frames = [tracker.update(boxes, np.full(len(boxes), 0.9)) for boxes in walk(3)]
        frames = [frame for frame in frames if frame.number >= 0] + tracker.rest()
        told.append([frame.identifiers.tolist() for frame in frames])
    assert [len(one) for one in told[0]] == [len(one) for one in told[1]]
    assert told[0] != told[1]
