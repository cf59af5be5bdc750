"""Where to write identifiers so that they do not lie on each other."""

import numpy as np

from trackweave.arrays import FloatArray

__all__ = ["label_offsets"]

CHARACTER_POINTS, LINE_POINTS = 6.6, 12.0  # with the frame around the text
REACH_POINTS = 10.0
# Turns from the direction of movement, in the order of preference [degrees].
TURNS_DEG = (0.0, 45.0, -45.0, 90.0, -90.0, 135.0, -135.0, 180.0)
SIZES = (1.0, 1.8, 2.8)


def label_offsets(
    anchors: FloatArray, directions: FloatArray, texts: list[str], obstacles: FloatArray
) -> FloatArray:
    """Return where the middle of each text goes, relative to its anchor [points]."""
    # It is for each text in turn the candidate that covers the fewest others, the first of equals.
    # Obstacles are places on paper that texts should rather not cover; directions are where texts
    # would like to lie from their anchors, of any length.
    offsets = np.zeros((len(texts), 2))
    boxes = np.empty((0, 4))
    for number, words in enumerate(texts):
        half = np.array([CHARACTER_POINTS * len(words), LINE_POINTS]) / 2
        tries = _candidates(directions[number], half)
        centres = anchors[number] + tries
        trial = np.concatenate([centres - half, centres + half], axis=1)
        price = 20.0 * _overlaps(trial, boxes) + _covered(trial, obstacles)
        best = int(np.argmin(price + 0.1 * np.arange(len(tries))))
        offsets[number] = tries[best]
        boxes = np.concatenate([boxes, trial[best : best + 1]])
    return offsets


def _candidates(direction: FloatArray, half: FloatArray) -> FloatArray:
    angle = np.arctan2(direction[1], direction[0])
    turned = angle + np.radians(np.array(TURNS_DEG))
    unit = np.stack([np.cos(turned), np.sin(turned)], axis=1)
    # The text's own half width and height keep its edge, not its middle, at the reach.
    return np.concatenate([unit * (half + size * REACH_POINTS) for size in SIZES])


def _overlaps(trial: FloatArray, boxes: FloatArray) -> FloatArray:
    """Return how many boxes each trial box touches."""
    apart = (trial[:, None, :2] >= boxes[None, :, 2:]) | (trial[:, None, 2:] <= boxes[None, :, :2])
    return np.asarray((~apart.any(axis=2)).sum(axis=1), dtype=np.float64)


def _covered(trial: FloatArray, obstacles: FloatArray) -> FloatArray:
    """Return how many obstacles each trial box covers."""
    inside = (obstacles[None] > trial[:, None, :2]) & (obstacles[None] < trial[:, None, 2:])
    return np.asarray(inside.all(axis=2).sum(axis=1), dtype=np.float64)
