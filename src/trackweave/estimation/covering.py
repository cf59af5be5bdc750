"""How far a sensor's reports reach, and how far apart they lie."""

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.estimation.trees import FEW, tree_of

__all__ = ["along_line", "covered_by", "note_on_area", "spacing_of"]

FEWEST_IN_HULL = 10
# Of the square of its extent, a line's area is less: rounding.
FLAT = 1e-12


def spacing_of(position: FloatArray) -> float:
    """Return the usual distance from a report to its nearest neighbour elsewhere [m]."""
    places = np.unique(position[:: max(position.shape[0] // 5000, 1)], axis=0)
    if places.shape[0] < 2:
        return 100.0
    distance, _ = tree_of(places).query(places, k=2)
    return max(float(np.median(distance[:, 1])), 1e-4)


def covered_by(position: FloatArray, sigma: float) -> float:
    """Return the area [m²] or volume [m³] of the hull of reports [m] with noise sigma, never 0."""
    dim = position.shape[1]
    # Reports in one place or on a line still come from a surrounding as wide as their noise.
    sides = np.maximum(np.ptp(position, axis=0), 6 * sigma)
    box = float(np.prod(sides))
    hull = _hull(position) if position.shape[0] > FEWEST_IN_HULL and dim > 1 else None
    # The outermost of n reports lie about 1/n of a side within the edges.
    margin = (1 + 2 / position.shape[0]) ** dim
    return float(np.clip(max(box if hull is None else hull, 0.1 * box) * margin, 1e-9, 1e24))


def along_line(position: FloatArray) -> FloatArray | None:
    """Return the direction of the line on which many reports lie [m], None where they do not."""
    if position.shape[0] <= FEWEST_IN_HULL or position.shape[1] < 2:
        return None
    spread, ways = np.linalg.eigh(np.cov(position.T))
    # Ascending: all but the last have to be rounding.
    return None if spread[-2] > FLAT * spread[-1] or spread[-1] <= 0.0 else ways[:, -1]


def _hull(position: FloatArray) -> float | None:
    """Return the area or volume of the reports' hull [m², m³], None where they span none."""
    places = np.unique(position, axis=0)
    if places.shape[0] <= position.shape[1]:
        return None
    if position.shape[1] == 2 and places.shape[0] <= FEW:
        return _area(places)
    from scipy.spatial import ConvexHull, QhullError

    try:
        return float(ConvexHull(places).volume)
    except QhullError:
        return None


def _area(places: FloatArray) -> float | None:
    """Return the area of the hull of sorted places [m²], None where they are on a line."""
    # Andrew's monotone chain (1979), there and back, with coordinates from the middle.
    middle = places.mean(axis=0)
    points = [(float(x), float(y)) for x, y in places - middle]
    hull: list[tuple[float, float]] = []
    for way in (points, points[::-1]):
        begin = len(hull)
        for point in way:
            while len(hull) > begin + 1 and _turn(hull[-2], hull[-1], point) <= 0.0:
                hull.pop()
            hull.append(point)
        hull.pop()
    x, y = np.array(hull).T
    area = 0.5 * float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))
    return area if area > FLAT * float(np.ptp(x)) ** 2 + FLAT * float(np.ptp(y)) ** 2 else None


def _turn(
    first: tuple[float, float], second: tuple[float, float], third: tuple[float, float]
) -> float:
    """Return twice the area of a triangle, positive where it turns left."""
    return (second[0] - first[0]) * (third[1] - first[1]) - (second[1] - first[1]) * (
        third[0] - first[0]
    )


def note_on_area(position: FloatArray, covered: float) -> str | None:
    """Return what is taken for the area of many reports that span none, None if they span one."""
    if position.shape[0] <= FEWEST_IN_HULL or position.shape[1] == 1:
        return None
    if _hull(position) is not None:
        return None
    unit = "m²" if position.shape[1] == 2 else "m³"
    return (
        "its reports lie on a line or at one place, so that no area tells how dense they are; "
        f"{covered:.3g} {unit} about them stand in"
    )
