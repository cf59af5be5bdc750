"""How much of what a sensor measures its field of view holds."""

from itertools import pairwise

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.domain.measurements import MeasurementKind
from trackweave.models.coverage import Coverage

__all__ = ["extent"]

N_NODES = 64
"""Azimuths between two corners of a polygon, at the nodes of a Gauss-Legendre rule."""


def extent(coverage: Coverage, kind: MeasurementKind) -> float | None:
    """Return the size of a field of view in the units of what is measured in the plane."""
    # Range rates and elevations are left out. The size is in m² for positions, in m·rad for range
    # and azimuth, and in rad for bearings; None where the field of view has no bound.
    if coverage.everywhere:
        return 2.0 * np.pi if kind.is_bearing_only else None
    low, high, start, width = coverage.bounds
    corners = coverage.polygon - coverage.position
    if corners.shape[0] == 0:
        if kind.is_bearing_only:
            return float(width)
        return float(width * _within(high, low, kind)) if np.isfinite(high) else None
    # Between the azimuths of two corners, how far the edges are changes smoothly.
    turns = (np.arctan2(corners[:, 0], corners[:, 1]) - start) % (2.0 * np.pi)
    breaks = np.unique(np.concatenate([[0.0, width], turns[turns < width]]))
    nodes, weights = np.polynomial.legendre.leggauss(N_NODES)
    total = 0.0
    for first, last in pairwise(breaks):
        half = (last - first) / 2.0
        azimuths = start + first + half * (1.0 + nodes)
        total += half * float(weights @ _seen(azimuths, corners, (low, high), kind))
    return total


def _within(distance: FloatArray | float, low: float, kind: MeasurementKind) -> FloatArray | float:
    """Return the extent per radian of a ray between two distances."""
    if kind.is_position:
        return (distance - low) * (distance + low) / 2.0
    return distance - low


def _seen(
    azimuths: FloatArray,
    corners: FloatArray,
    limits: tuple[float, float],
    kind: MeasurementKind,
) -> FloatArray:
    """Return the extent per radian of what rays from the sensor see of a polygon."""
    sine, cosine = np.sin(azimuths)[:, None], np.cos(azimuths)[:, None]
    after = np.roll(corners, -1, axis=0)
    # How far the ends of each edge lie beside each ray and along it, and where the two cross.
    aside = cosine * corners[:, 0] - sine * corners[:, 1]
    after_aside = cosine * after[:, 0] - sine * after[:, 1]
    ahead = sine * corners[:, 0] + cosine * corners[:, 1]
    after_ahead = sine * after[:, 0] + cosine * after[:, 1]
    crosses = (aside > 0.0) != (after_aside > 0.0)
    share = aside / np.where(crosses, aside - after_aside, 1.0)
    distance = np.where(crosses, ahead + share * (after_ahead - ahead), 0.0)
    # Up to its farthest crossing a ray is inside, then outside up to the next nearer, and so on.
    farthest_first = -np.sort(-np.clip(distance, *limits), axis=1)
    signs = 1.0 - 2.0 * (np.arange(corners.shape[0]) % 2)
    seen: FloatArray = _within(farthest_first, limits[0], kind) @ signs
    return np.asarray(seen > 0.0, dtype=np.float64) if kind.is_bearing_only else seen
