"""What a user is told of sensors before anything is tracked."""

from collections.abc import Mapping

import numpy as np

from trackweave.config import Configuration
from trackweave.config.fill import Settings
from trackweave.config.sensing import ObservedSensor, is_period, sense_of
from trackweave.domain.reports import ReportTable
from trackweave.estimation.estimates import Estimates
from trackweave.models.coverage import FieldOfView
from trackweave.run.polar_to_cartesian import platforms_of

__all__ = ["note_on_speed", "notes_on_sensors"]

# A speed that is told is too small for some where these are so many times as fast.
FASTER = 1.3
# Sensors no farther apart than this stand at one place [m].
SAME_PLACE = 1.0


def notes_on_sensors(
    reports: ReportTable,
    configuration: Configuration,
    observed: Mapping[str, ObservedSensor],
    filled: Settings,
    places: Mapping[str, tuple[float, ...]],
) -> list[str]:
    """Return sentences on what sensors' reports show, and do not."""
    # ``places`` are where sensors are said to stand [m].
    return [
        *_notes_on_turns(configuration, observed),
        *_notes_on_bearings(reports, observed, filled),
        *_notes_on_places(reports, observed, places),
        *_notes_on_sigma(reports, configuration),
        *_notes_on_views(filled),
    ]


def note_on_speed(configuration: Configuration, estimates: Estimates | None) -> list[str]:
    """Return a sentence where some objects seem faster than any is told to be."""
    told = configuration.said("motion", "max_speed")
    if told is None or estimates is None or estimates.speed_of_few < FASTER * told:
        return []
    return [
        f"motion.max_speed is told as {told:g} m/s, but a few objects seem to move at "
        f"{estimates.speed_of_few:.3g} m/s, and are lost if they do; false alarms that line up "
        "look so too: raise it only where something can be so fast"
    ]


def _notes_on_views(filled: Settings) -> list[str]:
    """Return a sentence on each sensor that is taken not to see where others do."""
    views = {
        sensor.name: sensor.field_of_view
        for sensor in filled.sensors
        if sensor.field_of_view is not None
        and filled.sources.get(f"sensors.{sensor.name}.field_of_view") == "estimated"
    }
    if views and all(sensor.measurement.is_bearing_only for sensor in filled.sensors):
        farthest = _words(next(iter(views.values())))
        return [
            f"bearings alone of stations so far apart: objects are looked for up to {farthest} "
            "from each; give field_of_view where some are farther"
        ]
    return [
        f"sensor {name}: no field_of_view is given, and nothing that others see beyond "
        f"{_words(view)} is among its reports: it is taken to see no farther; "
        "give field_of_view where that is wrong"
        for name, view in views.items()
    ]


def _words(view: FieldOfView) -> str:
    """Return an estimated edge in words."""
    if view.polygon is not None:
        return "the hull of its own"
    sector = view.azimuth_deg
    words = [] if np.isinf(view.max_range) else [f"{view.max_range:g} m"]
    words += [] if sector == (0.0, 360.0) else [f"azimuths {sector[0]:g}° to {sector[1]:g}°"]
    return " or ".join(words)


def _notes_on_bearings(
    reports: ReportTable, observed: Mapping[str, ObservedSensor], filled: Settings
) -> list[str]:
    """Return sentences on sensors of bearings of which nothing could be estimated."""
    bearing = [name for name, seen in observed.items() if seen.measurement.is_bearing_only]
    keys = ("sigma", "detection_probability", "clutter_density")
    notes = []
    for name in bearing:
        usual = [key for key in keys if filled.sources.get(f"sensors.{name}.{key}") == "default"]
        own = reports.sigma[reports.sensor == reports.sensors.index(name), 0]
        if "sigma" in usual and not np.isnan(own).any():
            usual.remove("sigma")
        if usual:
            notes.append(
                f"sensor {name}: its bearings alone do not tell {', '.join(usual)}; usual values "
                "stand in, which may be far off: better give them"
            )
    if len(bearing) == len(observed) == 2:
        notes.append(
            f"sensors {' and '.join(bearing)}: the bearings of two sensors cross for every pair "
            "of objects, and two may be taken for such ghosts of theirs until the whole recording "
            "tells, if it does; a third sensor tells them apart"
        )
    if bearing and len(observed) == 1:
        notes.append(
            f"sensor {bearing[0]}: one sensor's bearings do not tell where objects are; no track "
            "begins without another sensor or --priors"
        )
    return notes


def _notes_on_sigma(reports: ReportTable, configuration: Configuration) -> list[str]:
    """Return a sentence on each sensor whose noise is told although every row has its own."""
    has_own = np.asarray(np.isfinite(reports.sigma).any(axis=1))
    return [
        f"sensors.{name}.sigma: not used, as every report has a sigma of its own"
        for index, name in enumerate(reports.sensors)
        if configuration.sensor(name).get("sigma") is not None
        and np.all(has_own[reports.sensor == index])
    ]


def _notes_on_places(
    reports: ReportTable,
    observed: Mapping[str, ObservedSensor],
    places: Mapping[str, tuple[float, ...]],
) -> list[str]:
    """Return a sentence where all sensors see directions alone, and from one place."""
    names = list(observed)
    if len(names) < 2 or any(not seen.measurement.is_bearing_only for seen in observed.values()):
        return []
    stands = platforms_of(reports, places)[:, :2]
    if not np.all(np.ptp(stands, axis=0) < SAME_PLACE):
        return []
    return [
        f"sensors {', '.join(names)}: all see directions from one place, so that their bearings "
        "cross nowhere; no track begins without a sensor elsewhere or --priors"
    ]


def _notes_on_turns(
    configuration: Configuration, observed: Mapping[str, ObservedSensor]
) -> list[str]:
    """Return sentences on beams that do not turn as told, or not steadily."""
    notes = []
    for name, seen in observed.items():
        said, turn = configuration.sensor(name), seen.rotation
        if turn is None:
            continue
        told = said.get("scan_period")
        if said.get("rotation") not in (None, sense_of(turn)):
            notes.append(
                f"sensor {name}: rotation told {said['rotation']}, its reports show a beam that "
                f"turns {sense_of(turn)}; that is used; correct it, or "
                f"{_to_keep('rotation', name)}"
            )
        shown = f"{turn.period:.5g} s"
        varying = (
            f", varying by {float(f'{100 * turn.wander:.1g}'):g} %" if turn.wander > 0 else ""
        )
        if told is not None and not is_period(told, turn):
            notes.append(
                f"sensor {name}: scan_period told {told:g} s, its reports show {shown}{varying}; "
                f"that is used; correct it, or {_to_keep('scan_period', name)}"
            )
        elif varying:
            notes.append(
                f"sensor {name}: its reports show turns of {shown}{varying}; its beam is followed "
                "from turn to turn"
            )
        if not seen.is_turn_sure:
            notes.append(
                f"sensor {name}: its reports do not show where its beam is at each time; taken to "
                f"turn steadily in {shown}; better give a `scan` column"
            )
    return notes


def _to_keep(key: str, name: str) -> str:
    return f'give trust = ["{key}"] in [sensors.{name}] to keep what is told'
