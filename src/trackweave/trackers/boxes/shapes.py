"""Boxes as what a filter follows: centre, logarithms of the extents, and yaw in 3-D."""

import numpy as np

from trackweave.arrays import FloatArray

__all__ = [
    "Camera",
    "boxes_of",
    "n_places",
    "overlaps",
    "parts_of",
    "turned",
]

IMAGE, SOLID = 4, 7


def n_places(n_columns: int) -> int:
    """Return the number of dimensions of boxes by their number of columns."""
    return 2 if n_columns == IMAGE else 3


def parts_of(boxes: FloatArray) -> FloatArray:
    """Return centre and logarithms of the extents, and yaw of boxes in 3-D, a row a box."""
    if boxes.shape[1] == IMAGE:
        low, high = boxes[:, :2], boxes[:, 2:]
        return np.hstack([(low + high) / 2, _logarithms(high - low)])
    return np.hstack([boxes[:, :3], _logarithms(boxes[:, 3:6]), boxes[:, 6:]])


def _logarithms(extents: FloatArray) -> FloatArray:
    """Return logarithms; boxes cut to nothing at an image's edge count as very thin."""
    return np.log(np.maximum(extents, max(1e-3 * extents.max(initial=0.0), 1e-9)))


def boxes_of(parts: FloatArray) -> FloatArray:
    """Return the boxes that parts stand for."""
    if parts.shape[1] == IMAGE:
        half = np.exp(parts[:, 2:]) / 2
        return np.hstack([parts[:, :2] - half, parts[:, :2] + half])
    return np.hstack([parts[:, :3], np.exp(parts[:, 3:6]), turned(parts[:, 6:], 2 * np.pi)])


def turned(angle: FloatArray, period: float) -> FloatArray:
    """Return angles about zero, at most half a period from it."""
    return angle - period * np.round(angle / period)


def overlaps(first: FloatArray, second: FloatArray) -> FloatArray:
    """Return intersection over union of every pair of boxes in the image."""
    low = np.maximum(first[:, None, :2], second[None, :, :2])
    high = np.minimum(first[:, None, 2:], second[None, :, 2:])
    common = np.maximum(high - low, 0.0).prod(axis=2)
    area = [(box[:, 2:] - box[:, :2]).prod(axis=1) for box in (first, second)]
    return np.asarray(common / (area[0][:, None] + area[1][None, :] - common))


class Camera:
    """What takes parts as this frame sees them to the first frame, and back.

    Parameters
    ----------
    matrix
        From this frame to the first: (2, 3) for images, (4, 4) for 3-D.
    """

    def __init__(self, matrix: FloatArray) -> None:
        dim = 2 if matrix.shape == (2, 3) else 3
        self.dim, self.linear, self.shift = dim, matrix[:dim, :dim], matrix[:dim, dim]
        self.growth = float(np.log(np.linalg.det(self.linear)) / dim)
        self.turn = float(np.arctan2(self.linear[1, 0], self.linear[0, 0])) if dim == 3 else 0.0

    def to_first(self, parts: FloatArray) -> FloatArray:
        """Return parts of this frame as the first would see them."""
        taken, dim = parts.copy(), self.dim
        taken[:, :dim] = parts[:, :dim] @ self.linear.T + self.shift
        taken[:, dim : 2 * dim] += self.growth
        taken[:, 2 * dim :] += self.turn
        return taken

    def from_first(self, parts: FloatArray) -> FloatArray:
        """Return parts of the first frame as this one sees them."""
        taken, dim = parts.copy(), self.dim
        taken[:, :dim] = np.linalg.solve(self.linear, (parts[:, :dim] - self.shift).T).T
        taken[:, dim : 2 * dim] -= self.growth
        taken[:, 2 * dim :] -= self.turn
        return taken
