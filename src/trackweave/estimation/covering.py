"""How far a sensor's reports reach, and how far apart they lie."""

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.estimation.trees import FEW, tree_of

__all__ = ["along_line", "area_of", "corners_of", "covered_by", "note_on_area", "spacing_of"]

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
    if position.shape[1] == 2:
        corners = corners_of(places)
        return None if corners is None else area_of(corners)
    from scipy.spatial import ConvexHull, QhullError

    try:
        return float(ConvexHull(places).volume)
    except QhullError:
        return None


def corners_of(places: FloatArray) -> FloatArray | None:
    """Return the corners of the hull of places on a plane, in order, leftwards around it.

    Parameters
    ----------
    places
        x, y [m], shape (places, 2), sorted by x, then y, none of them twice.

    Returns
    -------
    x, y [m], shape (corners, 2); None where all are on a line.
    """
    if places.shape[0] > FEW:
        from scipy.spatial import ConvexHull, QhullError

        try:
            return np.asarray(places[ConvexHull(places).vertices])
        except QhullError:
            return None
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
    corners = np.array(hull).reshape(-1, 2)
    x, y = np.ptp(corners, axis=0) if corners.size else (0.0, 0.0)
    return corners + middle if area_of(corners) > FLAT * (x**2 + y**2) else None


def area_of(corners: FloatArray) -> float:
    """Return the area within corners that go leftwards around it [m²]."""
    x, y = (corners - corners.mean(axis=0)).T if corners.size else corners.T
    return 0.5 * float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))


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
