"""Coverage of uncertain positions. Nothing here checks or raises."""

import math

from trackweave.arrays import FloatArray
from trackweave.jit import jit
from trackweave.models.coverage import Coverage


@jit
def is_covered(x: float, y: float, coverage: Coverage) -> bool:
    """Tell whether a point of the plane lies in the field of view."""
    if coverage.everywhere:
        return True
    east, north = x - coverage.position[0], y - coverage.position[1]
    distance = math.sqrt(east * east + north * north)
    if distance < coverage.bounds[0] or distance > coverage.bounds[1]:
        return False
    turn = (math.atan2(east, north) - coverage.bounds[2]) % (2.0 * math.pi)
    if turn > coverage.bounds[3]:
        return False
    n_corners = coverage.polygon.shape[0]
    if n_corners == 0:
        return True
    inside = False
    previous = n_corners - 1
    for corner in range(n_corners):
        x1, y1 = coverage.polygon[corner, 0], coverage.polygon[corner, 1]
        x0, y0 = coverage.polygon[previous, 0], coverage.polygon[previous, 1]
        if (y1 > y) != (y0 > y) and x < (x0 - x1) * (y - y1) / (y0 - y1) + x1:
            inside = not inside
        previous = corner
    return inside


@jit
def covered_share(mean: FloatArray, covariance: FloatArray, coverage: Coverage) -> float:
    """Return the probability that an uncertain position lies in the field of view.

    The average over the five points of the unscented transform of the horizontal position
    (weights 1/5, spread √(5/2) standard deviations): exact far from the edge, smooth across it.
    """
    if coverage.everywhere:
        return 1.0
    sxx = math.sqrt(max(covariance[0, 0], 0.0))
    sxy = covariance[0, 1] / sxx if sxx > 0.0 else 0.0
    syy = math.sqrt(max(covariance[1, 1] - sxy * sxy, 0.0))
    spread = math.sqrt(2.5)
    share = 0.0
    for sign in (-spread, spread):
        if is_covered(mean[0] + sign * sxx, mean[1] + sign * sxy, coverage):
            share += 0.2
        if is_covered(mean[0], mean[1] + sign * syy, coverage):
            share += 0.2
    if is_covered(mean[0], mean[1], coverage):
        share += 0.2
    return share


@jit
def thin_covered(
    density: FloatArray, position: FloatArray, coverage: Coverage, factor: float
) -> None:
    """Multiply in place the density at each position in the field of view by a factor."""
    for row in range(position.shape[0]):
        if is_covered(position[row, 0], position[row, 1], coverage):
            density[row] *= factor
