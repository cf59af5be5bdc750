"""Where a sensor's false alarms are dense: the sea about a radar, a coast, a town, a hedge.

One density for all a sensor sees makes tracks of what is dense, and with them objects look as if
they turned like false alarms. Where reports that no sure object explains are many times as dense
as on average, bells tell it, as they tell of places that come again and again.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from trackweave.arrays import FloatArray, IntArray
from trackweave.domain.reports import ReportTable
from trackweave.estimation.estimates import Estimates, SensorEstimate, digits
from trackweave.estimation.heard_at_rest import REACH, heard_at_rest
from trackweave.estimation.refine import Followed, sure_tracks
from trackweave.estimation.standing import are_in_turn, looks_of
from trackweave.estimation.trees import n_within, tree_of

__all__ = ["with_clutter_places"]

FEWEST_SCANS, FEWEST = 30, 30
"""From so many scans on, and of so many reports in a cell, a density can be told."""
DENSE = 8.0
"""A cell is dense where it has so many times as many false alarms as all have on average."""
NARROWEST = 4.0
"""No cell is narrower than so many standard deviations of the sensor's noise."""
MOST_STRANGERS = 0.2
"""A track beside more strangers than this, as near as its own reports scatter, is no sure one."""
TRAVELS = 20.0
"""What goes so many times as far as its reports scatter is itself, whoever flies beside it."""
MOST_PLACES = 150


def with_clutter_places(
    estimates: Estimates, reports: ReportTable, followed: Followed
) -> Estimates:
    """Return estimates with the places where false alarms of sensors that look are dense."""
    if reports.dim != 2:
        return estimates
    sensors = dict(estimates.sensors)
    tracks = [track.rows for track in sure_tracks(estimates, reports, followed)]
    heard = heard_at_rest(estimates, reports)
    for index, name in enumerate(reports.sensors):
        found, n_scans = sensors.get(name), followed.looks.get(name, np.empty(0)).size
        if found is None or found.scans is False:
            continue
        if found.strength is not None and found.clutter_persistence == 0.0:
            continue
        own = reports.sensor == index
        if n_scans < FEWEST_SCANS or not np.any(own):
            continue
        narrowest = NARROWEST * found.plane_sigma
        is_false = own.copy()
        # Nothing is dense if not even all reports together are.
        if _cells(reports.measurement[own], n_scans, found.clutter_density, narrowest):
            strangers = _Strangers(reports, own)
            for track in tracks:
                mine = track[own[track]]
                if mine.size and not strangers.are_near(mine):
                    is_false[mine] = False
            if len(heard):
                is_false &= (
                    n_within(tree_of(heard), reports.measurement, REACH * found.plane_sigma) == 0
                )
        rows = np.flatnonzero(is_false)
        looks = looks_of(reports, rows, followed.looks[name]), n_scans
        sensors[name] = _with_places(found, reports.measurement[rows], looks, narrowest)
    return replace(estimates, sensors=sensors)


def _with_places(
    sensor: SensorEstimate, place: FloatArray, looks: tuple[IntArray, int], narrowest: float
) -> SensorEstimate:
    """Return a sensor whose false alarms are dense at some places."""
    # ``looks`` are in which look each is, and how many there are.
    look, n_scans = looks
    cells = [
        cell
        for cell in _cells(place, n_scans, sensor.clutter_density, narrowest)
        if not are_in_turn(look[_about(place, cell, narrowest)], n_scans, sensor)
    ]
    if not cells:
        # What an earlier round took for dense has been followed since, if anything.
        return replace(sensor, echoes=())
    cells = sorted(cells, key=lambda cell: -cell.size)[:MOST_PLACES]
    bells = tuple(
        (
            *(digits(float(value), 7) for value in place[cell].mean(axis=0)),
            digits(max(float(np.sqrt(place[cell].var(axis=0).mean())), narrowest / NARROWEST), 3),
            digits(cell.size / n_scans, 3),
        )
        for cell in cells
    )
    rest = 1.0 - sum(cell.size for cell in cells) / place.shape[0]
    return replace(
        sensor,
        echoes=bells,
        clutter_density=digits(sensor.clutter_density * max(rest, 0.05)),
    )


def _about(place: FloatArray, cell: NDArray[np.intp], narrowest: float) -> NDArray[np.intp]:
    """Return the rows about a cell and over its border, which parts what stands there."""
    reach = max(float(np.ptp(place[cell], axis=0).max()), narrowest)
    away = np.linalg.norm(place - place[cell].mean(axis=0), axis=1)
    return np.flatnonzero(away <= reach)


def _cells(
    place: FloatArray, n_scans: int, density: float, narrowest: float
) -> list[NDArray[np.intp]]:
    """Return the rows in each cell of a square, halved both ways while they are many, if dense."""
    if place.shape[0] < FEWEST:
        return []
    low, width = place.min(axis=0), float(np.ptp(place, axis=0).max()) + narrowest
    open_cells, dense = [(np.arange(place.shape[0]), low, width)], []
    while open_cells:
        rows, corner, width = open_cells.pop()
        if rows.size < FEWEST:
            continue
        if rows.size >= 4 * FEWEST and width >= 2.0 * narrowest:
            width /= 2.0
            part = (place[rows] >= corner + width).astype(np.int64)
            for x, y in ((0, 0), (0, 1), (1, 0), (1, 1)):
                own = rows[(part[:, 0] == x) & (part[:, 1] == y)]
                open_cells.append((own, corner + width * np.array([x, y]), width))
        elif rows.size > DENSE * density * n_scans * width**2:
            dense.append(rows)
    return dense


class _Strangers:
    """Other reports of a sensor's scan near a track's."""

    def __init__(self, reports: ReportTable, own: NDArray[np.bool_]) -> None:
        scan = reports.look
        self._time, place = reports.time, reports.measurement
        far = 4.0 * float(np.ptp(place, axis=0).max()) + 1.0
        _, number = np.unique(scan, return_inverse=True)
        self._place = np.column_stack([place, far * number])
        self._tree = tree_of(self._place[own])

    def are_near(self, rows: IntArray) -> bool:
        """Tell whether a track might as well be made of others."""
        if rows.size < 3:
            return True
        own, time = self._place[rows, :2], self._time[rows]
        share = (np.diff(time)[:-1] / np.maximum(time[2:] - time[:-2], 1e-9))[:, None]
        apart = own[1:-1] - (own[:-2] + share * (own[2:] - own[:-2]))
        # Of the distance from the middle of two others half is theirs.
        reach = float(np.sqrt(np.mean(np.sum(apart**2, axis=1)) / 1.5))
        if np.linalg.norm(np.ptp(own, axis=0)) > TRAVELS * reach:
            return False
        near = n_within(self._tree, self._place[rows], reach) - 1
        return float(near.mean()) > MOST_STRANGERS
