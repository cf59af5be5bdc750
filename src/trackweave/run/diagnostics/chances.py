"""When a sensor could have seen a track, and whether it did."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trackweave.arrays import FloatArray
from trackweave.estimation import covered
from trackweave.run.diagnostics.case import Case, Path

__all__ = ["Chances", "chances_of"]

MOST_PATHS, MOST_LOOKS = 120, 200


@dataclass(frozen=True, slots=True, eq=False)
class Chances:
    """A sensor's looks while tracks were there, between their first and last reports."""

    place: FloatArray  # Where the track was [m], shape (chances, 2)
    is_hit: NDArray[np.bool_]  # Whether the sensor reported it, shape (chances,)


def chances_of(case: Case, index: int) -> Chances:
    """Return the chances that a sensor had to see the tracks; none if nobody knows its looks."""
    places, hits, times = [np.empty((0, 2))], [np.empty(0, dtype=bool)], [np.empty(0)]
    for path in case.paths[:MOST_PATHS]:
        looks, near = _looks(case, index, path)
        if looks.size == 0:
            continue
        own = path.rows[case.reports.sensor[path.rows] == index]
        time = case.reports.time[own]
        at = np.searchsorted(time, looks - near)
        hits.append((at < time.size) & (time[np.minimum(at, time.size - 1)] <= looks + near)
                    if time.size else np.zeros(looks.size, dtype=bool))  # fmt: skip
        places.append(path.at(looks))
        times.append(looks)
    place, is_hit = np.concatenate(places), np.concatenate(hits)
    known = ~np.isnan(place[:, 0])
    view = case.sensors[index].field_of_view
    if view is not None:
        known &= covered(place, _platform(case, index, np.concatenate(times)), view.coverage())
    return Chances(place[known], is_hit[known])


def _platform(case: Case, index: int, time: FloatArray) -> FloatArray:
    """Return where a sensor was at some times [m]."""
    rows = case.rows[index]
    where = [np.interp(time, case.reports.time[rows], axis) for axis in case.platform[rows].T]
    return np.stack(where, axis=1)


def _looks(case: Case, index: int, path: Path) -> tuple[FloatArray, float]:
    """Return when a sensor looked at a track's place, and how far off a report's time may be."""
    sensor, time = case.sensors[index], case.reports.time[path.rows]
    first, last = float(time[0]), float(time[-1])
    period = sensor.scan_period
    if sensor.rotation is not None and period:
        # Once in a turn, whenever its report comes.
        return np.arange(first + 1.5 * period, last - 1.5 * period, period), 0.5 * period
    if period is None or sensor.name not in case.looks:
        return np.empty(0), 0.0
    looks = case.looks[sensor.name]
    # The first and the last report are why the track is there, and say nothing.
    looks = looks[np.searchsorted(looks, first, "right") : np.searchsorted(looks, last)]
    # A numbered scan ends after its reports.
    near = 0.5 * period if case.reports.scan is not None else 1e-9 * max(abs(last), 1.0)
    return looks[:: -(-max(looks.size, 1) // MOST_LOOKS)], near
