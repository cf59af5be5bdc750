"""Noise of positions that is not the same everywhere."""

from collections.abc import Sequence

import numpy as np

from trackweave.arrays import FloatArray

__all__ = ["local_noise"]

# Places whose noise is mixed at once, so that a recording of millions of reports fits.
BLOCK = 20_000


def local_noise(places: Sequence[Sequence[float]], position: FloatArray) -> FloatArray:
    """Return the noise along each axis [m] of reports at positions, shape (reports, dim)."""
    # Each of the places holds x, y [m] and its noise along each axis [m]; positions have the shape
    # (reports, dim). In between, logarithms are weighed by distance (Shepard, 1968), so that none
    # is less or more than that of some place.
    known = np.asarray(places, dtype=float)
    square = np.sum((known[:, None, :2] - known[None, :, :2]) ** 2, axis=2)
    np.fill_diagonal(square, np.inf)
    # A place speaks for half the way to its neighbours.
    near = 0.25 * float(np.median(square.min(axis=1))) if len(known) > 1 else 1.0
    noise = np.log(known[:, 2:])
    found = np.empty((len(position), noise.shape[1]))
    for start in range(0, len(position), BLOCK):
        block = slice(start, start + BLOCK)
        apart = np.sum((position[block, None, :2] - known[None, :, :2]) ** 2, axis=2)
        weight = (near / (near + apart)) ** 2
        found[block] = weight @ noise / weight.sum(axis=1, keepdims=True)
    return np.exp(found)
