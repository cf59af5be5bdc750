"""Where sensors stand and how they turn, as a recording or a file of keys tells it."""

from dataclasses import replace
from typing import Any

import numpy as np

from trackweave.config import Configuration
from trackweave.domain.facts import Place
from trackweave.domain.frames import LocalFrame
from trackweave.domain.reports import ReportTable
from trackweave.errors import InvalidInputError

__all__ = ["on_plane", "standing", "with_facts"]

# A position whose numbers lie so near to the latitude and longitude of the reports' plane
# [degrees] is told in degrees, unless these themselves are small.
AMONG, SMALL = 2.0, 3.0
# Fewer rows do not tell whether a sensor stands.
FEWEST_ROWS = 20


def with_facts(configuration: Configuration, reports: ReportTable) -> Configuration:
    """Return a configuration with what the recording tells of places and turns of its sensors."""
    # Places on the Earth become positions on the reports' plane, those of the file too, which come
    # before the recording's.
    sensors: dict[str, dict[str, Any]] = {}
    for name in reports.sensors:
        told, own = configuration.sensor(name), dict[str, Any]()
        place = reports.facts.places.get(name)
        if place is not None and not {"position", "place"} & set(told) and reports.frame:
            own["position"] = _position(place, reports.frame, reports.dim)
        stands = reports.facts.positions.get(name)
        if stands is not None and not {"position", "place"} & (set(told) | set(own)):
            own["position"] = [round(float(number), 3) for number in stands]
        period = reports.facts.scan_periods.get(name)
        if period is not None and "scan_period" not in told:
            own["scan_period"] = period
        if own:
            sensors[name] = own
    if sensors:
        given = configuration.table("sensors")
        merged = {name: {**given.get(name, {}), **own} for name, own in sensors.items()}
        configuration = configuration.changed(sensors={**given, **merged})
    return on_plane(configuration, reports.frame, reports.dim)


def standing(reports: ReportTable, configuration: Configuration) -> ReportTable:
    """Return reports that say of a sensor which stands where it is once, not in each row."""
    # What moves is not registered. Where a position is told as well, each row's own counts.
    if reports.platform is None:
        return reports
    platform, positions = reports.platform.copy(), dict(reports.facts.positions)
    for index, name in enumerate(reports.sensors):
        rows = np.flatnonzero(reports.sensor == index)
        is_told = {"position", "place"} & set(configuration.sensor(name))
        if is_told or name in reports.facts.places or rows.size < FEWEST_ROWS:
            continue
        first = platform[rows[0]]
        # A row that says nothing is unlike all others, and so is not a number.
        if np.all(platform[rows] == first) and not first[3:].any():
            positions[name] = (float(first[0]), float(first[1]), float(first[2]))
            platform[rows] = np.nan
    if len(positions) == len(reports.facts.positions):
        return reports
    left = None if np.isnan(platform).all() else platform
    return replace(reports, platform=left, facts=replace(reports.facts, positions=positions))


def on_plane(configuration: Configuration, frame: LocalFrame | None, dim: int) -> Configuration:
    """Return a configuration whose places on the Earth are positions.

    Parameters
    ----------
    configuration
        As read.
    frame
        The plane; None where positions are not on the Earth.
    dim
        Number of spatial dimensions.

    Returns
    -------
    The same, with ``position`` for each ``place``.

    Raises
    ------
    InvalidInputError
        If a place is told and there is no plane, or a position in degrees.
    """
    places = configuration.places()
    if frame is not None:
        _require_metres(configuration, frame)
    if not places:
        return configuration
    if frame is None:
        raise InvalidInputError(
            f"{configuration.name}: sensors.{next(iter(places))}.place: told in degrees, while "
            "x, y of the reports are on a plane of their own; expected position = [x, y] in "
            "metres there, or [frame] origin = [latitude, longitude], which lays it on the Earth"
        )
    sensors = {name: dict(own) for name, own in configuration.table("sensors").items()}
    for name, place in places.items():
        del sensors[name]["place"]
        sensors[name]["position"] = _position(place, frame, dim)
    return configuration.changed(sensors=sensors)


def _require_metres(configuration: Configuration, frame: LocalFrame) -> None:
    """Refuse positions that are latitudes and longitudes of the plane."""
    origin = np.array([frame.latitude_deg, frame.longitude_deg])
    if np.all(np.abs(origin) < SMALL):
        return
    for name, own in configuration.table("sensors").items():
        told = own.get("position")
        for order in ([0, 1], [1, 0]):
            if told is not None and np.all(np.abs(np.take(told, order) - origin) < AMONG):
                place = ", ".join(f"{told[index]:.10g}" for index in order)
                raise InvalidInputError(
                    f"{configuration.name}: sensors.{name}.position: {told}, which are degrees, "
                    "as the reports lie there; expected metres east and north of the plane's "
                    f"origin, or place = [{place}], latitude and longitude"
                )


def _position(place: Place, frame: LocalFrame, dim: int) -> list[float]:
    angles = np.array([[place.latitude_deg], [place.longitude_deg], [place.altitude_m]])
    there = frame.to_plane(*angles)[0, : 2 if dim == 2 else 3]
    return [round(float(number), 3) for number in there]
