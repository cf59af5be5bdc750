"""The live tracker that a configuration asks for, with or without reports to estimate from."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from trackweave.config import Configuration, load_configuration
from trackweave.config.fill import ANY_SENSOR, Settings, fill
from trackweave.config.sensing import ObservedSensor, told_rotation
from trackweave.domain.foreign_kind import ForeignKind
from trackweave.domain.frames import LocalFrame
from trackweave.domain.measurements import MeasurementKind
from trackweave.errors import InvalidInputError
from trackweave.io.reports import ONLY_SENSOR
from trackweave.models.rotation import Rotation
from trackweave.run.course import tracker_of
from trackweave.run.doubles import doubles_of
from trackweave.run.observing import settle
from trackweave.run.pieces import pieces_in
from trackweave.run.told_places import on_plane, with_facts
from trackweave.run.tracking import report_table

if TYPE_CHECKING:
    from trackweave.trackers.multi_hypothesis import MultiHypothesisTracker
    from trackweave.trackers.nearest_neighbour import NearestNeighbourTracker

__all__ = ["configured", "settings_alone"]


def configured(
    config: str | Path | Mapping[str, Any] | Configuration, reports: Any = None
) -> "MultiHypothesisTracker | NearestNeighbourTracker":
    """Return the tracker that ``track`` would take, ready for the first scan.

    Parameters
    ----------
    config
        A path of a TOML file, or its content as a mapping.
    reports
        Reports as for ``track``, from which keys that are left out are estimated; None to take
        the usual values for all of them but noise and clutter, which must be given then.

    Returns
    -------
    The tracker.

    Raises
    ------
    InvalidInputError
        If a value cannot be used, a key is missing without which nothing can be tracked, or the
        configuration asks for plots to be fused, which takes instants in place of scans.
    """
    configuration = load_configuration(config)
    if reports is None:
        configuration = on_plane(configuration, _frame(configuration), 2)
        settings, dim = settings_alone(configuration), None
    else:
        table, _ = report_table(reports, configuration)
        configuration = with_facts(configuration, table)
        pieces = pieces_in(table, configuration)
        configuration = pieces.configuration
        _, (settings, _) = doubles_of(pieces.joined, lambda once: settle(once, configuration))
        dim = table.dim
    if settings.plots is not None:
        raise InvalidInputError(
            "plots.fuse: true; expected false, as a tracker of scans fuses no plots (see "
            "FusedPlotsTracker, which takes instants)"
        )
    return tracker_of(settings, settings.sensors, dim, max_ahead=settings.max_ahead)


def _frame(configuration: Configuration) -> LocalFrame | None:
    """Return the plane that a configuration tells, None for none."""
    origin = configuration.said("frame", "origin")
    if origin is None:
        return None
    return LocalFrame(origin[0], origin[1], configuration.said("frame", "projection") or "tangent")


def settings_alone(configuration: Configuration) -> Settings:
    """Return a configuration whose gaps are filled by what is usual.

    Parameters
    ----------
    configuration
        As read, with a table for each sensor.

    Returns
    -------
    Everything that a tracker needs.

    Raises
    ------
    InvalidInputError
        If it lacks what nothing usual can stand in for.
    """
    told = configuration.table("sensors")
    names = [name for name in told if name != ANY_SENSOR]
    if not names and told:
        names = [ONLY_SENSOR]
    missing = [key for name in names for key in _missing(configuration, name)]
    if missing or not names:
        what = ", ".join(missing) or "sensors.NAME, a table for each sensor"
        raise InvalidInputError(
            f"configuration: {what} left out; expected in the configuration, or reports to "
            "estimate from"
        )
    observed = {name: _as_told(configuration, name, alone=len(names) == 1) for name in names}
    return fill(configuration, None, names, observed=observed)


def _missing(configuration: Configuration, name: str) -> list[str]:
    """Return the keys of a sensor that nothing usual can stand in for."""
    own, kind = configuration.sensor(name), _kind(configuration, name)
    view = own.get("field_of_view")
    is_bounded = view is not None and (
        kind.is_position or kind.is_bearing_only or "max_range_m" in view
    )
    keys = []
    is_unknown = kind.is_position or (
        isinstance(kind, ForeignKind) and not kind.has_own_covariance
    )
    if "sigma" not in own and is_unknown:
        keys.append("sigma")
    if "clutter_density" not in own and ("clutter_per_scan" not in own or not is_bounded):
        why = "" if "clutter_per_scan" not in own else " (clutter_per_scan needs a field_of_view)"
        keys.append(f"clutter_density{why}")
    return [f"sensors.{name}.{key}" for key in keys]


def _kind(configuration: Configuration, name: str) -> MeasurementKind | ForeignKind:
    outside = configuration.plugins.kind_of(name)
    if outside is not None:
        return outside
    word = configuration.sensor(name).get("measurement")
    kinds = {kind.word: kind for kind in MeasurementKind}
    return MeasurementKind.POSITION if word is None else kinds[word]


def _as_told(configuration: Configuration, name: str, *, alone: bool) -> ObservedSensor:
    """Return a sensor as the configuration describes it."""
    own, kind = configuration.sensor(name), _kind(configuration, name)
    rotation = told_rotation(own)
    if rotation is None and own.get("rotation", "none") != "none" and "scan_period" in own:
        rotation = Rotation(own["scan_period"], 0.0, 1 if own["rotation"] == "clockwise" else -1)
    return ObservedSensor(
        measurement=kind,
        dim=3 if kind.has_elevation else 2,
        needs_place=kind.needs_place and not alone,
        rotation=rotation,
    )
