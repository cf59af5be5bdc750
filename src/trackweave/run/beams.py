"""Turning beams that nobody told of: where they stand, and when they were where reports are."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.config import Configuration
from trackweave.config.sensing import sense_of, told_rotation
from trackweave.domain.measurements import MeasurementKind
from trackweave.domain.reports import ReportTable
from trackweave.estimation.rotation import loose_rotation_of, off_turn, wander_of
from trackweave.estimation.turning_place import place_of_turn
from trackweave.models.rotation import Rotation
from trackweave.run.observing import azimuth_of, positions_in
from trackweave.run.polar_to_cartesian import platforms_of

__all__ = ["loose_turn", "with_beam_places", "with_beam_times"]

# Stamps that are off a beam by less than this as a median [rad] are of when it was there.
EXACT = 0.02
# A place elsewhere is believed where reports are so many times nearer to the beam than about 0, 0;
# and loosely, where what so many of them are off by is hardly what they are a turn later.
CLEARLY_NEARER, FEWEST_COMPARED, MOST_COMPARED, MOST_ALIKE = 0.5, 20, 1000, 0.5
# So far may the beam itself be off its turn [rad], and by this share of what stamps are.
STEADY, MOST_WANDER = 0.03, 0.3


def with_beam_places(
    reports: ReportTable, configuration: Configuration
) -> tuple[ReportTable, Configuration, tuple[str, ...]]:
    """Return reports with a note on each sensor that was placed, its place told, and its name."""
    # Of positions on a plane that does not count from their radar. Without its place nothing tells
    # which of them make a turn.
    sensors = {name: dict(table) for name, table in configuration.table("sensors").items()}
    placed, notes = list[str](), list[str]()
    told = positions_in(reports, configuration)
    for index, name in enumerate(reports.sensors):
        rows, said = np.flatnonzero(reports.sensor == index), configuration.sensor(name)
        is_open = reports.kind_of(index).is_position and reports.platform is None
        if name in told or reports.scan is not None or not is_open or _is_still(said):
            continue
        time, place = reports.time[rows], reports.measurement[rows, :2]
        here = loose_rotation_of(time, np.arctan2(*place.T))
        off_here = np.inf if here is None else _usually_off(time, place, here)
        found = place_of_turn(time, place) if off_here > EXACT else None
        if found is None or not _is_beam(time, place - found[0], found[1], off_here):
            continue
        at = [round(float(number), 1) for number in found[0]]
        sensors[name] = {**sensors.get(name, {}), "position": at}
        placed.append(name)
        notes.append(
            f"sensor {name}: its reports come as from a beam that turns {sense_of(found[1])} in "
            f"{found[1].period:.4g} s about {at[0]:.10g}, {at[1]:.10g} m, where it is taken to "
            f"stand; give its position in [sensors.{name}] where that is known better"
        )
    if not placed:
        return reports, configuration, ()
    reports = replace(reports, notes=(*reports.notes, *notes))
    return reports, configuration.changed(sensors=sensors), tuple(placed)


def _usually_off(time: FloatArray, relative: FloatArray, turn: Rotation) -> float:
    """Return how far reports are off a beam at their origin as a median [rad]."""
    return float(np.median(np.abs(off_turn(time, np.arctan2(*relative.T), turn))))


def _is_beam(time: FloatArray, relative: FloatArray, turn: Rotation, beside: float) -> bool:
    """Tell whether a turn about reports' origin is a beam's, not of what reports by itself."""
    # Objects that report once a period, each at a moment of its own, lie around some place in the
    # order of these moments. What one is off by then, it is again a period later.
    usual = _usually_off(time, relative, turn)
    if usual > CLEARLY_NEARER * beside:
        return False
    if usual < EXACT:
        return True
    off = off_turn(time, np.arctan2(*relative.T), turn)
    after = np.searchsorted(time, time + 0.75 * turn.period)
    until = np.searchsorted(time, time + 1.25 * turn.period)
    rows = np.flatnonzero(until > after)
    if rows.size < FEWEST_COMPARED:
        return False
    next_one = [
        after[row] + np.argmin(np.sum((relative[after[row] : until[row]] - relative[row]) ** 2, 1))
        for row in rows[:MOST_COMPARED].tolist()
    ]
    alike = np.corrcoef(off[rows[: len(next_one)]], off[np.array(next_one, dtype=np.int64)])[0, 1]
    return bool(alike < MOST_ALIKE)


def _is_still(said: Mapping[str, Any]) -> bool:
    """Tell whether a sensor is told not to turn."""
    return said.get("rotation") == "none" or said.get("scans") is False


def with_beam_times(reports: ReportTable, configuration: Configuration) -> ReportTable:
    """Return reports timed by the beams that they follow, with a note on each such sensor."""
    # Stamps of when a report was received, or of whole seconds, are off by more than an object
    # needs for its own noise, and put it into the wrong sector. Where the beam turns steadily, its
    # azimuth tells the time better; up to a whole latency, which is the same for all.
    if reports.scan is not None:
        return reports
    platform = platforms_of(reports, positions_in(reports, configuration))
    time, notes = reports.time.copy(), list[str]()
    for index, name in enumerate(reports.sensors):
        kind, rows = reports.kind_of(index), np.flatnonzero(reports.sensor == index)
        if not isinstance(kind, MeasurementKind) or rows.size == 0:
            continue
        azimuth = azimuth_of(kind, reports.measurement[rows], platform[rows])
        turn = loose_turn(configuration.sensor(name), reports.time[rows], azimuth)
        if turn is None:
            continue
        late = turn.period * off_turn(reports.time[rows], azimuth, turn) / (2.0 * np.pi)
        time[rows] += late
        notes.append(
            f"sensor {name}: its beam turns {sense_of(turn)} in {turn.period:.5g} s, and times "
            f"are {float(np.median(np.abs(late))):.2g} s off that as a median; each report counts "
            "as of when the beam was at its azimuth"
        )
    if not notes:
        return reports
    return replace(reports, notes=(*reports.notes, *notes)).retimed(time)


def loose_turn(said: Mapping[str, Any], time: FloatArray, azimuth: FloatArray) -> Rotation | None:
    """Return the turn of a beam that stamps follow loosely only, None for any other sensor."""
    if _is_still(said) or told_rotation(said):
        return None
    period = said.get("scan_period")
    # What was heard twice tells nothing twice, and several reports of one stamp something else.
    _, once = np.unique(np.stack([time, azimuth]), axis=1, return_index=True)
    heard = time[np.sort(once)], azimuth[np.sort(once)]
    found = loose_rotation_of(*heard, period=period) or loose_rotation_of(*heard)
    if found is None:
        return None
    # A beam that wanders by more than that is followed from turn to turn instead.
    usual = float(np.median(np.abs(off_turn(*heard, found))))
    is_steady = wander_of(*heard, found) < max(STEADY, MOST_WANDER * usual)
    return found if usual > EXACT and is_steady else None
