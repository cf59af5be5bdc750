"""Trees of points, for who is near whom."""

from typing import TYPE_CHECKING

from trackweave.arrays import FloatArray

if TYPE_CHECKING:
    from scipy.spatial import cKDTree

__all__ = ["tree_of"]


def tree_of(position: FloatArray) -> "cKDTree":
    """Return SciPy's tree of points, shape (points, dim)."""
    # A run that has nothing to estimate need not wait for this import.
    from scipy.spatial import cKDTree

    return cKDTree(position)
