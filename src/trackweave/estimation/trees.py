"""Who is near whom: SciPy's trees, and for few points their distances."""

import math
from typing import TYPE_CHECKING, TypeAlias, TypeGuard, Union

import numpy as np

from trackweave.arrays import FloatArray, IntArray

if TYPE_CHECKING:
    from scipy.spatial import cKDTree

__all__ = [
    "FEW",
    "FewPoints",
    "Tree",
    "all_within",
    "ball_volume",
    "n_within",
    "pairs_within",
    "tree_of",
]

FEW = 512
"""Of so many points all distances are sooner there than SciPy is imported."""

# Length, area and volume of the ball of radius 1, by dimension.

Tree: TypeAlias = Union["FewPoints", "cKDTree"]


class FewPoints:
    """What a tree tells of points, shape (points, dim), from the distances of all pairs.

    Of points that are as near as each other the first comes first.
    """

    def __init__(self, position: FloatArray) -> None:
        self.data = position

    def query(
        self, position: FloatArray, k: int = 1, distance_upper_bound: float = np.inf
    ) -> tuple[FloatArray, IntArray]:
        """Find the nearest points of each position.

        Parameters
        ----------
        position
            Where from, shape (positions, dim).
        k
            How many.
        distance_upper_bound
            Only what is nearer counts.

        Returns
        -------
        Distances and indices, shape (positions, k), or (positions,) of one nearest. Where there
        are no more, the distance is infinite and the index the number of points.
        """
        size = self.data.shape[0]
        if position.shape[0] > FEW:
            distance, index = _grown(self).query(
                position, k=k, distance_upper_bound=distance_upper_bound
            )
            return distance, index
        square = _squares(position, self.data)
        square[square >= distance_upper_bound**2] = np.inf
        index = square.argmin(axis=1)[:, None] if k == 1 < size else _order(square)[:, :k]
        square = np.take_along_axis(square, index, axis=1)
        missing = ((0, 0), (0, k - square.shape[1]))
        index = np.pad(index, missing)
        square = np.pad(square, missing, constant_values=np.inf)
        index[np.isinf(square)] = size
        distance = np.sqrt(square)
        return (distance[:, 0], index[:, 0]) if k == 1 else (distance, index)


def tree_of(position: FloatArray) -> Tree:
    """Return a tree of points, shape (points, dim)."""
    few = FewPoints(position)
    return few if position.shape[0] <= FEW else _grown(few)


def all_within(tree: Tree, position: FloatArray, radius: float) -> list[IntArray]:
    """Return which points of a tree lie within a radius of each position."""
    if _is_few(tree, position):
        near = _squares(position, tree.data) <= radius * radius
        return [np.flatnonzero(each) for each in near]
    found = _grown(tree).query_ball_point(position, radius)
    return [np.array(each, dtype=np.int64) for each in found]


def n_within(tree: Tree, position: FloatArray, radius: float) -> IntArray:
    """Return how many points of a tree lie within a radius of each position."""
    if _is_few(tree, position):
        return np.asarray(np.sum(_squares(position, tree.data) <= radius * radius, axis=1))
    found: IntArray = _grown(tree).query_ball_point(position, radius, return_length=True)
    return found


def pairs_within(first: Tree, second: Tree, radii: FloatArray) -> IntArray:
    """Return how many pairs of a point of each tree are within each radius, rising."""
    if isinstance(first, FewPoints) and isinstance(second, FewPoints):
        square = np.sort(_squares(first.data, second.data), axis=None)
        return np.searchsorted(square, radii * radii, side="right")
    found: IntArray = _grown(first).count_neighbors(_grown(second), radii)
    return found


def _is_few(tree: Tree, position: FloatArray) -> TypeGuard[FewPoints]:
    return isinstance(tree, FewPoints) and position.shape[0] <= FEW


def _grown(tree: Tree) -> "cKDTree":
    """Return SciPy's tree of the same points."""
    if not isinstance(tree, FewPoints):
        return tree
    # A run that has little to estimate, or nothing, need not wait for this import.
    from scipy.spatial import cKDTree

    return cKDTree(tree.data)


def _squares(first: FloatArray, second: FloatArray) -> FloatArray:
    """Return squared distances, shape (first, second)."""
    # Summed from the first coordinate on, as trees do.
    total = np.zeros((first.shape[0], second.shape[0]))
    for axis in range(first.shape[1]):
        total += np.subtract.outer(first[:, axis], second[:, axis]) ** 2
    return total


def _order(square: FloatArray) -> IntArray:
    return np.argsort(square, axis=1, kind="stable")


def ball_volume(radius: FloatArray | float, dim: int) -> FloatArray:
    """Return the volume of a ball [m² or m³; of range rates beside places, another axis]."""
    unit = math.pi ** (dim / 2) / math.gamma(dim / 2 + 1)
    return np.asarray(unit * np.asarray(radius) ** dim)
