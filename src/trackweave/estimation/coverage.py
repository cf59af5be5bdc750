"""Where sensors see, as far as their reports tell beside those of others."""

from collections.abc import Collection

import numpy as np
from numpy.typing import NDArray

from trackweave.arrays import FloatArray, IntArray
from trackweave.domain.reports import ReportTable
from trackweave.estimation.covering import area_of, corners_of
from trackweave.models._kernels import is_covered
from trackweave.models.coverage import Coverage, FieldOfView

__all__ = ["covered", "fields_of_view", "in_view", "reach_of_bearings"]

# Silence tells of an edge where so many of others' reports lie beyond it, and so many of the
# sensor's own would if it saw there as it does inside.
FEWEST, EXPECTED = 50, 20.0
BEYOND = 1.1
# Of the farthest, so many or this share may stand alone: false alarms, or errors.
LONE, LONE_SHARE, APART = 3, 0.002, 1.2
# Edges lie a little outside the outermost report: an object is not known better.
RANGE_MARGIN, HULL_MARGIN, ANGLE_MARGIN = 0.01, 0.05, np.radians(2.0)
NARROWEST_GAP = np.radians(30.0)
DIGITS = 5
# Bearings tell of places within so many times the distance of the stations from their middle.
REACH = 3.0


def covered(place: FloatArray, platform: FloatArray, view: Coverage) -> NDArray[np.bool_]:
    """Tell which places, shape (places, 2) [m], a view holds that goes with its sensor."""
    # ``platform`` is where the sensor was then, of the same shape; the view is that about where it
    # stands usually.
    about = place - platform + view.position
    return np.array([is_covered(east, north, view) for east, north in about], dtype=bool)


def in_view(
    view: FieldOfView, reports: ReportTable, sensor: int, track: IntArray, looks: FloatArray
) -> NDArray[np.bool_]:
    """Tell at which looks [s] of a sensor a track, rows by time, was where it sees."""

    def at_looks(rows: IntArray, where: FloatArray) -> FloatArray:
        axes = [np.interp(looks, reports.time[rows], axis) for axis in where[rows, :2].T]
        return np.stack(axes, axis=1)

    coverage = view.coverage()
    platform = np.broadcast_to(coverage.position, (looks.size, 2))
    if reports.platform is not None:
        platform = at_looks(np.flatnonzero(reports.sensor == sensor), reports.platform)
    return covered(at_looks(track, reports.measurement), platform, coverage)


def reach_of_bearings(platform: FloatArray) -> float:
    """Return how far from stations, x, y first [m], bearings alone tell of places [m]."""
    apart = np.linalg.norm(platform[:, :2] - platform[:, :2].mean(axis=0), axis=1)
    return float(f"{REACH * float(apart.max()):.{DIGITS}g}")


def fields_of_view(
    reports: ReportTable,
    platform: FloatArray,
    standing: Collection[str],
    told: Collection[str] = (),
) -> dict[str, FieldOfView]:
    """Return where sensors see whose reports end although those of others go on."""
    # Silence tells of an edge only where others see something beyond it. All of a sensor's own
    # reports lie inside, but for a few that stand alone far off. ``platform`` is where each
    # report's sensor was, x, y first [m]. Sensors that are known to be standing see so far, and in
    # a sector where others see more in the rest; what others see lies in the hull of their
    # reports. A sensor without an edge is left out, and those of which it is told.
    found = {}
    for index, name in enumerate(reports.sensors):
        if name in told:
            continue
        own = np.flatnonzero(reports.sensor == index)
        if own.size < FEWEST:
            continue
        time = reports.time[own]
        during = (reports.time >= time.min()) & (reports.time <= time.max())
        beside = np.flatnonzero(during & (reports.sensor != index))
        if beside.size < FEWEST:
            continue
        place, others = reports.measurement[own, :2], reports.measurement[beside, :2]
        if name in standing:
            there = platform[own, :2]
            order = np.argsort(time, kind="stable")
            then = [np.interp(reports.time[beside], time[order], axis) for axis in there[order].T]
            stays = bool(np.all(np.ptp(there, axis=0) < 1.0))
            view = _ring(place - there, others - np.stack(then, axis=1), stays=stays)
        else:
            view = _patch(place, others)
        if view is not None:
            found[name] = view
    return found


def _ring(own: FloatArray, others: FloatArray, *, stays: bool) -> FieldOfView | None:
    """Return a sector about a sensor from places relative to it, None for everywhere."""
    away, distance = np.linalg.norm(own, axis=1), np.linalg.norm(others, axis=1)
    edge = _edge(away)
    inside = distance <= edge
    is_bounded = _is_silent(away.size, inside, distance > BEYOND * edge)
    farthest = edge * (1 + RANGE_MARGIN + 1 / away.size) if is_bounded else np.inf
    azimuth = np.sort(_azimuth(own[away <= edge]))
    gaps = np.diff(azimuth, append=azimuth[0] + 2 * np.pi)
    widest = int(np.argmax(gaps))
    begin, width = azimuth[widest] + ANGLE_MARGIN, gaps[widest] - 2 * ANGLE_MARGIN
    turn = (0.0, 360.0)
    # What moves turns as well, and its sector with it.
    if stays and width > NARROWEST_GAP:
        in_gap = inside & ((_azimuth(others) - begin) % (2 * np.pi) < width)
        if _is_silent(away.size, inside & ~in_gap, in_gap):
            turn = (_rounded(np.degrees(begin + width) % 360), _rounded(np.degrees(begin) % 360))
    if not is_bounded and turn == (0.0, 360.0):
        return None
    return FieldOfView(max_range=_rounded(farthest), azimuth_deg=turn)


def _patch(own: FloatArray, others: FloatArray) -> FieldOfView | None:
    """Return the hull of places, None where others see nothing beyond or they span none."""
    away = np.linalg.norm(own - np.median(own, axis=0), axis=1)
    places = np.unique(own[away <= _edge(away)], axis=0)
    hull = corners_of(places)
    if hull is None:
        return None
    corners = hull.mean(axis=0) + (1 + HULL_MARGIN) * (hull - hull.mean(axis=0))
    # Half-planes about each side, the inner side below zero.
    side = np.roll(hull, -1, axis=0) - hull
    outward = np.stack([side[:, 1], -side[:, 0]]) / np.linalg.norm(side, axis=1)
    beyond = (others @ outward - np.sum(hull.T * outward, axis=0)).max(axis=1)
    margin = HULL_MARGIN * float(np.sqrt(area_of(hull)))
    if not _is_silent(own.shape[0], beyond <= 0, beyond > margin):
        return None
    return FieldOfView(polygon=[(_rounded(x), _rounded(y)) for x, y in corners])


def _is_silent(n_own: int, inside: NDArray[np.bool_], beyond: NDArray[np.bool_]) -> bool:
    """Tell whether a sensor would have reported beyond an edge, if it saw as it does inside."""
    count, seen = int(np.count_nonzero(beyond)), int(np.count_nonzero(inside))
    return count >= FEWEST and n_own / max(seen, 1) * count >= EXPECTED


def _edge(away: FloatArray) -> float:
    """Return the farthest distance, without the few that stand alone beyond all others."""
    ordered = np.sort(away)
    n_lone = min(max(LONE, int(LONE_SHARE * ordered.size)), ordered.size - 1)
    for kept in range(ordered.size - n_lone, ordered.size):
        if ordered[kept] > APART * ordered[kept - 1]:
            return float(ordered[kept - 1])
    return float(ordered[-1])


def _azimuth(offset: FloatArray) -> FloatArray:
    """Return the direction of each offset [rad, clockwise from north]."""
    return np.asarray(np.arctan2(offset[:, 0], offset[:, 1]))


def _rounded(value: float) -> float:
    return float(f"{value:.{DIGITS}g}")
