"""Coverage of uncertain positions. Nothing here checks or raises."""

import math

from trackweave.arrays import FloatArray
from trackweave.jit import jit
from trackweave.models.coverage import Coverage

SURE = 4.0
"""So many standard deviations from an edge nothing is on its other side."""


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
    return coverage.polygon.shape[0] == 0 or is_inside(x, y, coverage.polygon)


@jit
def is_inside(x: float, y: float, polygon: FloatArray) -> bool:
    """Tell whether a point of the plane lies in a polygon."""
    n_corners = polygon.shape[0]
    inside = False
    previous = n_corners - 1
    for corner in range(n_corners):
        x1, y1 = polygon[corner, 0], polygon[corner, 1]
        x0, y0 = polygon[previous, 0], polygon[previous, 1]
        if (y1 > y) != (y0 > y) and x < (x0 - x1) * (y - y1) / (y0 - y1) + x1:
            inside = not inside
        previous = corner
    return inside


@jit
def covered_share(mean: FloatArray, covariance: FloatArray, coverage: Coverage) -> float:
    """Return the probability that what is reported of an uncertain position lies in the view.

    Ranges and azimuths are normal about the position's own, by its covariance and the coverage's
    ``blur``; a polygon takes the average over the five points of the unscented transform of the
    horizontal position (weights 1/5, spread √(5/2) standard deviations).
    """
    if coverage.everywhere:
        return 1.0
    east, north = mean[0] - coverage.position[0], mean[1] - coverage.position[1]
    distance = math.sqrt(east * east + north * north)
    # Along and across the line of sight; at the sensor itself there is none.
    east, north = (east / distance, north / distance) if distance > 0.0 else (0.0, 1.0)
    xx, xy, yy = covariance[0, 0], covariance[0, 1], covariance[1, 1]
    along = east * east * xx + 2.0 * east * north * xy + north * north * yy
    across = north * north * xx - 2.0 * east * north * xy + east * east * yy
    angle, length, beside = coverage.blur
    along = math.sqrt(max(along, 0.0) + length * length)
    across = math.sqrt(max(across, 0.0) + beside * beside + (angle * distance) ** 2)
    low, high, first, width = coverage.bounds
    share = 1.0
    if low > 0.0 or high < math.inf:
        share = normal_between(low if low > 0.0 else -math.inf, high, distance, along)
    if width < 2.0 * math.pi and share > 0.0:
        if across > distance:
            share *= width / (2.0 * math.pi)
        else:
            turn = math.atan2(east, north)
            share *= share_between(turn, across / distance, first, width)
    if share > 0.0 and coverage.polygon.shape[0] > 0:
        share *= share_inside(mean, covariance, coverage)
    return share


@jit
def share_between(turn: float, sigma: float, first: float, width: float) -> float:
    """Return how probably an azimuth is within a sector: first edge, clockwise, and width."""
    if width > math.pi:
        # Beyond the one edge of what is left out lies the other.
        return 1.0 - share_between(turn, sigma, first + width, 2.0 * math.pi - width)
    off = (turn - first - 0.5 * width + math.pi) % (2.0 * math.pi) - math.pi
    return normal_between(-0.5 * width, 0.5 * width, off, sigma)


@jit
def normal_between(low: float, high: float, mean: float, sigma: float) -> float:
    """Return how probably a normal number lies between two others; 0 and 1 where that is sure."""
    if sigma <= 0.0 or mean < low - SURE * sigma or mean > high + SURE * sigma:
        return 1.0 if low <= mean <= high else 0.0
    if low + SURE * sigma < mean < high - SURE * sigma:
        return 1.0
    scale = sigma * math.sqrt(2.0)
    return 0.5 * (math.erf((high - mean) / scale) - math.erf((low - mean) / scale))


@jit
def share_inside(mean: FloatArray, covariance: FloatArray, coverage: Coverage) -> float:
    """Return the share of the unscented transform's five points that lie in the polygon."""
    sxx = math.sqrt(max(covariance[0, 0], 0.0))
    sxy = covariance[0, 1] / sxx if sxx > 0.0 else 0.0
    syy = math.sqrt(max(covariance[1, 1] - sxy * sxy, 0.0))
    spread = math.sqrt(2.5)
    share = 0.2 if is_inside(mean[0], mean[1], coverage.polygon) else 0.0
    for sign in (-spread, spread):
        if is_inside(mean[0] + sign * sxx, mean[1] + sign * sxy, coverage.polygon):
            share += 0.2
        if is_inside(mean[0], mean[1] + sign * syy, coverage.polygon):
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
