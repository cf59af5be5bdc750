"""Positions that a turning beam made, as the ranges and azimuths that it measured."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.config import Configuration
from trackweave.domain.measurements import MeasurementKind
from trackweave.domain.reports import ReportTable
from trackweave.run.beams import loose_turn
from trackweave.run.observing import observe

__all__ = ["as_measured", "with_ranges"]

POLAR = MeasurementKind.RANGE_AZIMUTH
# Who tells one of these speaks of positions.
OF_POSITIONS = {"clutter_density", "clutter_per_scan", "echoes", "measurement", "sigma"}
HERE = (0.0, 0.0)


def as_measured(reports: ReportTable, told: Callable[[str], Mapping[str, Any]]) -> ReportTable:
    """Return reports in which the positions of sensors told to measure ranges are such.

    Parameters
    ----------
    reports
        As read.
    told
        Returns what is told of a sensor of some name; who stands nowhere is at the origin.

    Returns
    -------
    The same table where there are none.
    """
    kinds = [reports.kind_of(index) for index in range(len(reports.sensors))]
    measurement = reports.measurement.copy()
    for index, name in enumerate(reports.sensors):
        said = told(name)
        if said.get("measurement") == POLAR.word and _may_be_polar(reports, index):
            own = reports.part(np.flatnonzero(reports.sensor == index))
            measurement[reports.sensor == index] = _polar(own, said.get("position") or HERE)
            kinds[index] = POLAR
    if all(kind is reports.kind_of(index) for index, kind in enumerate(kinds)):
        return reports
    return replace(reports, measurement=measurement, kinds=tuple(kinds), space=reports.dim)


def with_ranges(
    reports: ReportTable, configuration: Configuration, *, unplaced: bool = True
) -> tuple[ReportTable, Configuration, tuple[str, ...]]:
    """Return reports in which positions that beams made are ranges and azimuths, and whose."""
    # Their noise lies along and across the beam and grows with the range: as positions of one
    # noise near reports would count too little, and those far away too much. With ``unplaced``
    # sensors of which nobody says where they stand are looked at as well, as if at the origin.
    may = [
        (index, name)
        for index, name in enumerate(reports.sensors)
        if not _is_told(configuration.sensor(name)) and _may_be_polar(reports, index)
        if unplaced or "position" in configuration.sensor(name)
    ]
    if not may or reports.scan is not None:
        return reports, configuration, ()
    sensors = {name: dict(table) for name, table in configuration.table("sensors").items()}
    seen, found, notes = observe(reports, configuration), list[str](), list[str]()
    for index, name in may:
        said = configuration.sensor(name)
        if seen[name].rotation is None and not _turns_loosely(reports, index, said):
            continue
        place = said.get("position") or HERE
        own = {"measurement": POLAR.word, "position": list(place)}
        sensors[name] = {**sensors.get(name, {}), **own}
        found.append(name)
        notes.append(
            f"sensor {name}: its positions count as the ranges and azimuths that a beam which "
            f"turns about {place[0]:.10g}, {place[1]:.10g} m measured; where they are as exact "
            f"everywhere, give sigma in [sensors.{name}]"
        )
    if not found:
        return reports, configuration, ()
    configuration = configuration.changed(sensors=sensors)
    reports = replace(reports, notes=(*reports.notes, *notes))
    return as_measured(reports, configuration.sensor), configuration, tuple(found)


def _may_be_polar(reports: ReportTable, index: int) -> bool:
    """Tell whether a sensor's reports are positions on a plane, of a noise that nobody tells."""
    rows = reports.sensor == index
    is_flat = reports.kind_of(index).is_position and reports.dim == 2
    if not is_flat or reports.platform is not None or reports.unavailable is not None:
        return False
    return bool(rows.any() and np.isnan(reports.sigma[rows]).all())


def _is_told(said: Mapping[str, Any]) -> bool:
    """Tell whether what is told of a sensor speaks of positions, or of no turn."""
    is_still = said.get("rotation") == "none" or said.get("scans") is False
    return is_still or bool(said.get("trust")) or not OF_POSITIONS.isdisjoint(said)


def _turns_loosely(reports: ReportTable, index: int, said: Mapping[str, Any]) -> bool:
    """Tell whether a sensor's stamps follow a beam loosely that turns where it stands."""
    rows = reports.sensor == index
    if reports.identity is not None and np.any(reports.identity[rows] >= 0):
        # Who says who it is may report at moments of its own, whose order looks like a turn.
        return False
    azimuth = np.arctan2(*(reports.measurement[rows, :2] - (said.get("position") or HERE)[:2]).T)
    return loose_turn(said, reports.time[rows], azimuth) is not None


def _polar(reports: ReportTable, place: Sequence[float]) -> FloatArray:
    """Return ranges [m] and azimuths [rad] that ``laid`` puts where the positions are."""
    there, level = reports.measurement[:, :2], np.full(len(reports), [*place, 0.0][2])
    told = level if reports.height is None else reports.height
    height = np.where(np.isnan(told), level, told)
    if reports.frame is None:
        away = there - np.asarray(place[:2])
        slant, azimuth = np.hypot(np.hypot(*away.T), height - level), np.arctan2(*away.T)
    else:
        import pymap3d

        latitude, longitude, _ = reports.frame.to_geodetic(there)
        at = reports.frame.to_geodetic(np.array([place[:2]], dtype=float))
        degrees, _, slant = pymap3d.geodetic2aer(
            latitude, longitude, height, at[0], at[1], level[:1]
        )
        azimuth = np.radians(degrees)
    return np.stack([np.asarray(slant), np.asarray(azimuth) % (2 * np.pi)], axis=1)
