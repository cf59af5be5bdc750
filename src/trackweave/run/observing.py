"""What sensors' reports show before anything is estimated, and the settings that follow."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackweave.arrays import FloatArray
from trackweave.config import Configuration
from trackweave.config.fill import Settings, fill, needs_estimates
from trackweave.config.sensing import (
    ObservedSensor,
    is_period,
    require_places,
    told_rotation,
    view_keys,
)
from trackweave.domain.foreign_kind import ForeignKind
from trackweave.domain.measurements import MeasurementKind
from trackweave.domain.reports import ReportTable
from trackweave.errors import InvalidInputError
from trackweave.estimation.estimates import Estimates
from trackweave.estimation.frames import scan_period, scan_times
from trackweave.estimation.rotation import rotation_of, wanders
from trackweave.models.rotation import Rotation
from trackweave.run.kept import Kept
from trackweave.run.noting import note_on_speed, notes_on_sensors
from trackweave.run.polar_to_cartesian import in_turns, laid, placed, platforms_of
from trackweave.run.views import are_bearings, with_reach, with_views

__all__ = [
    "azimuth_of",
    "filled",
    "observe",
    "positions_in",
    "require_told",
    "settle",
]


def require_told(reports: ReportTable, configuration: Configuration) -> None:
    """Refuse a configuration that leaves open what no report of a kind from outside can tell."""
    kinds = dict(zip(reports.sensors, reports.kinds, strict=False))
    foreign = {name: kind for name, kind in kinds.items() if isinstance(kind, ForeignKind)}
    missing = []
    for index, name in enumerate(reports.sensors):
        if name in foreign:
            own = reports.sigma[reports.sensor == index][:, : foreign[name].n_components(2)]
            missing += _missing(
                configuration, name, foreign[name], is_sigma_told=not np.isnan(own).any()
            )
    if foreign and len(foreign) == len(reports.sensors):
        motion = configuration.table("motion")
        if configuration.plugins.motion is None:
            keys = ("process_noise", "max_speed")
            missing += [f"motion.{key}" for key in keys if key not in motion]
        if configuration.said("lifecycle", "new_target_density") is None:
            missing.append("lifecycle.new_target_density")
    if missing:
        words = sorted({kind.word for kind in foreign.values()})
        raise InvalidInputError(
            f"{configuration.name}: {', '.join(missing)} left out; expected to be told, because "
            f"nothing can be estimated from reports of measurement {', '.join(words)}, which is a "
            "plug-in"
        )


def _missing(
    configuration: Configuration, name: str, kind: ForeignKind, *, is_sigma_told: bool
) -> list[str]:
    """Return the keys of a sensor that are left out."""
    own = configuration.sensor(name)
    given = {
        "sigma": "sigma" in own or is_sigma_told or kind.has_own_covariance,
        "detection_probability": "detection_probability" in own,
        "clutter_density": "clutter_density" in own or "clutter_per_scan" in own,
        "scan_period (or scans = false)": "scan_period" in own or "scans" in own,
    }
    return [f"sensors.{name}.{key}" for key, is_given in given.items() if not is_given]


# From so many moments on it can be told whether reports come one by one.
FEWEST_MOMENTS = 20
# Under a beam an object reports in every turn or second one, not so many turns apart as a median.
SELDOM = 2.5
# A gap between directions is a sector that is not watched where chance would not leave it [rad].
WIDEST_CHANCE_GAP = np.radians(60.0)
NARROWEST, SHALLOWEST, SLOWEST = 0.05, 0.05, 1.0
MARGIN = 1.05
MOST_SENSORS = 2_000
_MOST_SHOWN = 5


def settle(
    reports: ReportTable,
    configuration: Configuration,
    *,
    preset: str | None = None,
    to_be_edited: bool = False,
    kept: Kept | None = None,
) -> tuple[Settings, Estimates | None]:
    """Return a configuration whose gaps are filled from the reports, and what was estimated."""
    # There are no estimates where none were needed or no report tells a position. To be edited, a
    # note is enough where only a person can know, such as where a sensor stands. ``kept`` is what
    # attempts of one run share.
    _require_few_sensors(reports, configuration)
    require_told(reports, configuration)
    if reports.row is None:
        # By it what becomes of a report is found again.
        reports = replace(reports, row=np.arange(1, len(reports) + 1))
    observed = observe(reports, configuration)
    places = positions_in(reports, configuration)
    unplaced = [
        name
        for name, seen in observed.items()
        if seen.needs_place and not seen.says_where and name not in places
    ]
    if unplaced:
        observed |= {n: replace(observed[n], plane=_plane_in_words(reports)) for n in unplaced}
    if to_be_edited:
        observed |= {name: replace(observed[name], needs_place=False) for name in unplaced}
    require_places(places.get, observed)
    rotations = {
        name: seen.rotation for name, seen in observed.items() if seen.rotation is not None
    }
    # What it says of heights and ranges is said when reports are tracked.
    table = placed(laid(reports, places)[0], places)
    # Of sensors that stand nobody knows where, nor is it known where on the plane they see.
    observed = observed if unplaced else with_views(observed, table, configuration, places)
    observed = with_reach(observed, reports, configuration, places)
    if len(rotations) == 1:
        # Nobody else tells where an object was meanwhile: a turn serves as one instant.
        table = in_turns(table, rotations)
    estimates = None
    if len(table) and needs_estimates(configuration, reports.sensors):
        # A complete configuration takes nothing of what estimates.
        from trackweave.run.directed import directions_of
        from trackweave.run.likelier import told_by_tracks
        from trackweave.run.refining import Looking, estimates_for

        directions = directions_of(reports, configuration, observed, places)
        told = _of_positions(configuration, observed)
        scanning = {
            name: scans
            for name in reports.sensors
            if (scans := _is_known_to_scan(reports, configuration, name, rotations)) is not None
        }
        kept = kept or Kept()
        looking = Looking(scanning, rotations if len(rotations) > 1 else {})
        estimates = estimates_for(table, told, directions, looking, kept)
        estimates = _as_placed(told_by_tracks(estimates, table, told, kept, scanning), unplaced)
    elif are_bearings(observed) and needs_estimates(configuration, reports.sensors):
        from trackweave.run.bearings_alone import estimates_of_bearings

        estimates = estimates_of_bearings(reports, configuration, observed, places)
    filled = fill(configuration, estimates, reports.sensors, preset=preset, observed=observed)
    notes = [f"sensors.{name}.position: give where it stands" for name in unplaced]
    notes += notes_on_sensors(reports, configuration, observed, filled, places)
    notes += note_on_speed(configuration, estimates)
    return replace(filled, notes=(*filled.notes, *notes)), estimates


def _as_placed(estimates: Estimates | None, unplaced: Sequence[str]) -> Estimates | None:
    """Return estimates without what one sensor sees and another does not, if any has no place."""
    if estimates is None or not unplaced:
        return estimates
    sensors = {
        name: replace(each, hidden_share=0.0, mean_silence=None)
        for name, each in estimates.sensors.items()
    }
    return replace(estimates, sensors=sensors, hidden_share=None, mean_silence=None)


def _plane_in_words(reports: ReportTable) -> str:
    """Return what whoever says where sensors stand has to know of the plane."""
    frame, known = reports.frame, reports.facts.places
    if frame is None:
        return (
            "x counts east and y north of one point for all, any that you like, which "
            "[frame] origin = [latitude, longitude] lays on the Earth"
        )
    words = (
        f"x counts east and y north of latitude {frame.latitude_deg:g}, longitude "
        f"{frame.longitude_deg:g}, where the plane touches the Earth; [frame] origin = [latitude, "
        "longitude] puts that elsewhere"
    )
    told = [
        f"{name} at {place.latitude_deg:.5f}, {place.longitude_deg:.5f}"
        for name, place in known.items()
    ]
    if told:
        more = ", …" if len(told) > _MOST_SHOWN else ""
        words += f". The recording tells that of {', '.join(told[:_MOST_SHOWN])}{more}"
    return words


def _is_known_to_scan(
    reports: ReportTable,
    configuration: Configuration,
    name: str,
    rotations: Mapping[str, Rotation],
) -> bool | None:
    """Tell whether a sensor looks, as file and columns say; None where they do not."""
    section = configuration.sensor(name)
    if "scans" in section:
        return bool(section["scans"])
    is_turning = name in rotations or section.get("rotation", "none") != "none"
    if is_turning or "scan_period" in section or reports.scan is not None:
        return True
    return None


def _require_few_sensors(reports: ReportTable, configuration: Configuration) -> None:
    """Refuse to estimate thousands of sensors: the work grows with their number's square."""
    count = len(reports.sensors)
    if count > MOST_SENSORS and needs_estimates(configuration, reports.sensors):
        raise InvalidInputError(
            f"column sensor: {count} sensors; expected at most {MOST_SENSORS} where anything is "
            "estimated, or a configuration with all keys of [sensors.default], process_noise, "
            "max_speed and new_target_density"
        )


def positions_in(
    reports: ReportTable, configuration: Configuration
) -> dict[str, tuple[float, ...]]:
    """Return where sensors are said to stand, x, y[, z] [m]; those without are left out."""
    given = {name: configuration.sensor(name).get("position") for name in reports.sensors}
    return {name: tuple(place) for name, place in given.items() if place is not None}


def observe(reports: ReportTable, configuration: Configuration) -> dict[str, ObservedSensor]:
    """Return what each sensor's reports show, given what is said of its place and turning."""
    platform = platforms_of(reports, positions_in(reports, configuration))
    observed = {}
    for index, name in enumerate(reports.sensors):
        rows = reports.sensor == index
        kind = reports.kind_of(index)
        measured = reports.measurement[rows]
        says_where = reports.platform is not None and not np.isnan(reports.platform[rows, 0]).any()
        is_alone = len(reports.sensors) == 1 and reports.frame is None
        turns, is_sure = None, True
        if isinstance(kind, MeasurementKind):
            turns, is_sure = _rotation(
                configuration.sensor(name),
                reports.time[rows],
                azimuth_of(kind, measured, platform[rows]),
                numbered=reports.scan is not None,
            )
            is_told = not {"rotation", "scan_period"}.isdisjoint(configuration.sensor(name))
            if turns is not None and not is_told and _are_seldom(reports, rows, turns.period):
                turns, is_sure = None, True
        moments = scan_times(reports, index)
        n_scans = moments.size
        if turns is not None:
            span = float(np.ptp(reports.time[rows])) / turns.period
            n_scans = min(n_scans, round(span) + 1)
        observed[name] = ObservedSensor(
            measurement=kind,
            dim=reports.dim,
            says_where=says_where,
            needs_place=kind.needs_place and not is_alone,
            extent=filled(kind, measured),
            usual_range=_usual_range(kind, measured),
            reports_per_scan=float(rows.sum() / max(n_scans, 1)),
            scan_period=scan_period(moments),
            rotation=turns,
            is_turn_sure=is_sure,
        )
    return observed


def _of_positions(
    configuration: Configuration, observed: Mapping[str, ObservedSensor]
) -> Configuration:
    """Return the configuration as it applies to reports that were placed on the plane."""
    sensors = {name: dict(table) for name, table in configuration.table("sensors").items()}
    for name, table in sensors.items():
        seen = observed.get(name)
        configuration.plugins.take_out(name, table)
        table.pop("measurement", None)
        table.pop("rotation", None)
        sigma = table.get("sigma")
        if isinstance(sigma, Mapping) and "x" not in sigma:
            table.pop("sigma")
        if seen is not None and not seen.measurement.is_position:
            table.pop("clutter_density", None)
            table.pop("clutter_per_scan", None)
    for name, seen in observed.items():
        if seen.field_of_view is not None:
            sensors.setdefault(name, {})["field_of_view"] = view_keys(seen.field_of_view)
    return configuration.changed(sensors=sensors)


def azimuth_of(kind: MeasurementKind, measured: FloatArray, platform: FloatArray) -> FloatArray:
    """Return the direction of each report from its sensor [rad, clockwise from north]."""
    if kind.is_position:
        east, north = (measured[:, :2] - platform[:, :2]).T
        return np.asarray(np.arctan2(east, north))
    return measured[:, kind.azimuth]


def _rotation(
    said: Mapping[str, Any], time: FloatArray, azimuth: FloatArray, *, numbered: bool
) -> tuple[Rotation | None, bool]:
    """Return how a beam turns, as told or shown by lone reports, and whether these show it."""
    word, given = said.get("rotation"), said.get("scan_period")
    if word == "none" or said.get("scans") is False:
        return None, True
    told = told_rotation(said)
    if told is not None:
        return told, True
    moments, sizes = np.unique(time, return_counts=True)
    is_lone = not numbered and moments.size >= FEWEST_MOMENTS and np.median(sizes) <= 1
    if word is None and not is_lone:
        return None, True
    direction = None if word is None else 1 if word == "clockwise" else -1
    found = rotation_of(time, azimuth, period=given, direction=direction)
    if found is None and is_lone and (given, direction) != (None, None):
        # Perhaps it turns otherwise than is told.
        found = rotation_of(
            time, azimuth, direction=direction if _is_trusted(said, "rotation") else None
        )
    if found is None:
        # Too few reports to tell the phase still belong to turns.
        if given is None or direction is None:
            return None, True
        return Rotation(given, 0.0, direction), False
    if given is not None and _is_trusted(said, "scan_period") and not is_period(given, found):
        start = float(time[0])
        phase = found.azimuth(start) - found.direction * 2 * np.pi * start / given
        return Rotation(given, float(phase % (2 * np.pi)), found.direction), False
    return found, not wanders(time, azimuth, found)


def _are_seldom(reports: ReportTable, rows: NDArray[np.bool_], period: float) -> bool:
    """Tell whether who says who it is reports too seldom for a beam that turns in a period [s]."""
    if reports.identity is None:
        return False
    own = np.flatnonzero(rows & (reports.identity >= 0))
    own = own[np.argsort(reports.identity[own], kind="stable")]
    same = np.diff(reports.identity[own]) == 0
    pauses = np.diff(reports.time[own])[same]
    return pauses.size > 0 and bool(np.median(pauses) > SELDOM * period)


def _is_trusted(said: Mapping[str, Any], key: str) -> bool:
    trust = said.get("trust", False)
    return trust if isinstance(trust, bool) else key in trust


def filled(kind: MeasurementKind | ForeignKind, measured: FloatArray) -> float:
    """Return the extent, in their units, that measurements (reports ≥ 1, components) fill."""
    # It is 1 for positions, whose extent is estimated with their noise.
    if kind.is_position:
        return 1.0
    if isinstance(kind, ForeignKind):
        sides = np.ptp(measured[:, : kind.n_components(2)], axis=0)
        return float(np.prod(np.where(sides > 0.0, MARGIN * sides, 1.0)))
    if kind.is_bearing_only:
        return _arc(measured[:, 0])
    extent = MARGIN * float(measured[:, 0].max()) * _arc(measured[:, 1]) or 1.0
    if kind.has_elevation:
        extent *= max(MARGIN * float(np.ptp(measured[:, 2])), SHALLOWEST)
    if kind.has_rate:
        place = 3 if kind.has_elevation else 2
        extent *= max(MARGIN * float(np.ptp(measured[:, place])), SLOWEST)
    return extent


def _arc(angle: FloatArray) -> float:
    """Return the width of the sector from which directions come [rad]."""
    ordered = np.sort(angle)
    gaps = np.diff(ordered, append=ordered[0] + 2 * np.pi)
    widest = float(gaps.max())
    return max(2 * np.pi - widest, NARROWEST) if widest > WIDEST_CHANCE_GAP else 2 * np.pi


def _usual_range(kind: MeasurementKind | ForeignKind, measured: FloatArray) -> float:
    return float(np.median(measured[:, 0])) or 1.0 if kind.has_range else 1000.0
