"""Tests of where identifiers are written."""

import numpy as np

from trackweave.plotting._canvas import CHARACTER_POINTS, LINE_POINTS, label_offsets

NOTHING = np.empty((0, 2))


def boxes(anchors: np.ndarray, offsets: np.ndarray, texts: list[str]) -> np.ndarray:
    half = np.array([[CHARACTER_POINTS * len(words) / 2, LINE_POINTS / 2] for words in texts])
    centres = anchors + offsets
    return np.concatenate([centres - half, centres + half], axis=1)


def test_a_lone_label_lies_ahead() -> None:
    offsets = label_offsets(np.zeros((1, 2)), np.array([[3.0, 0.0]]), ["12"], NOTHING)
    assert offsets[0, 0] > 0
    assert offsets[0, 1] == 0


def test_labels_of_neighbours_do_not_lie_on_each_other() -> None:
    anchors = np.array([[0.0, 0.0], [2.0, 1.0], [-3.0, 2.0], [1.0, -3.0], [4.0, 4.0]])
    texts = ["1", "22", "333", "4", "55"]
    offsets = label_offsets(anchors, np.tile([1.0, 0.0], (5, 1)), texts, NOTHING)
    found = boxes(anchors, offsets, texts)
    for number, box in enumerate(found):
        for other in found[number + 1 :]:
            apart = np.any(box[:2] >= other[2:]) or np.any(box[2:] <= other[:2])
            assert apart


def test_a_label_keeps_clear_of_lines() -> None:
    line = np.stack([np.linspace(2, 80, 60), np.zeros(60)], axis=1)
    offsets = label_offsets(np.zeros((1, 2)), np.array([[1.0, 0.0]]), ["12"], line)
    low, high = np.split(boxes(np.zeros((1, 2)), offsets, ["12"])[0], 2)
    assert not np.any(np.all((line > low) & (line < high), axis=1))


def test_a_track_that_stands_still_has_a_label_too() -> None:
    offsets = label_offsets(np.zeros((1, 2)), np.zeros((1, 2)), ["1"], NOTHING)
    assert np.linalg.norm(offsets) > 5
