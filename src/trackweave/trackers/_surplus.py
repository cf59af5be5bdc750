"""Who may be at the place of whom. Nothing here checks or raises."""

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.filters._kernels import invert_sum, squared_distance
from trackweave.jit import jit


@jit
def lower_surplus(
    position: FloatArray,
    covariance: FloatArray,
    chance: FloatArray,
    weakest_first: IntArray,
    limit: float,
    is_shown: np.ndarray,
) -> None:
    """Set ``is_shown`` to False of each that is one too many, as ``surplus`` has it."""
    count, dim = position.shape
    inverse, width = np.empty((dim, dim)), np.zeros(count)
    for row in range(count):
        for axis in range(dim):
            width[row] += covariance[row, axis, axis]
    for row in weakest_first:
        n_shown, n_beside, expected, is_weakest = 0, 0, 0.0, True
        for other in range(count):
            square = 0.0
            for axis in range(dim):
                square += (position[row, axis] - position[other, axis]) ** 2
            # No direction is wider than all together: most are out of the question at once.
            if not square <= limit * (width[row] + width[other]):
                continue
            invert_sum(covariance[row], covariance, other, inverse)
            if not squared_distance(position[other], position[row], inverse) <= limit:
                continue
            n_beside += 1
            expected += chance[other]
            if is_shown[other]:
                n_shown += 1
                # Who is stronger than another that stays is not what is too much.
                is_weakest = is_weakest and chance[other] >= chance[row]
        if n_beside > 1 and is_weakest and n_shown - expected > 0.5:
            is_shown[row] = False
