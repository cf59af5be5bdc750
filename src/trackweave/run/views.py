"""Where sensors see of which nobody has told it."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

from trackweave.association.window_rule import FARTHEST
from trackweave.config import Configuration
from trackweave.config.fill import ANY_SENSOR
from trackweave.config.sensing import ObservedSensor
from trackweave.domain.foreign_kind import ForeignKind
from trackweave.domain.reports import ReportTable
from trackweave.estimation.coverage import fields_of_view, reach_of_bearings
from trackweave.models.coverage import FieldOfView
from trackweave.run.polar_to_cartesian import platforms_of

__all__ = ["are_bearings", "with_reach", "with_views"]


def are_bearings(observed: Mapping[str, ObservedSensor]) -> bool:
    """Tell whether all sensors measure bearings alone."""
    return all(
        seen.measurement.is_bearing_only and not isinstance(seen.measurement, ForeignKind)
        for seen in observed.values()
    )


def with_views(
    observed: dict[str, ObservedSensor],
    reports: ReportTable,
    configuration: Configuration,
    places: Mapping[str, Sequence[float]],
) -> dict[str, ObservedSensor]:
    """Return what sensors show with where they see, of those of which nobody has told it."""
    if len(reports.sensors) < 2:
        return observed
    standing = {*places, *(name for name, seen in observed.items() if seen.says_where)}
    told = [name for name in reports.sensors if "field_of_view" in configuration.sensor(name)]
    views = fields_of_view(reports, platforms_of(reports, places), standing, told)
    return _viewing(observed, views, configuration)


def with_reach(
    observed: dict[str, ObservedSensor],
    reports: ReportTable,
    configuration: Configuration,
    places: Mapping[str, Sequence[float]],
) -> dict[str, ObservedSensor]:
    """Return sensors of bearings alone that stand far apart with how far they are looked from."""
    if not are_bearings(observed):
        return observed
    far = reach_of_bearings(platforms_of(reports, places))
    if far <= FARTHEST:
        # A sensor of which nothing says how far sees so far anyway.
        return observed
    views = dict.fromkeys(reports.sensors, FieldOfView(max_range=far))
    return _viewing(observed, views, configuration)


def _viewing(
    observed: dict[str, ObservedSensor],
    views: Mapping[str, FieldOfView],
    configuration: Configuration,
) -> dict[str, ObservedSensor]:
    """Return what sensors show with views, where the configuration has none."""
    return observed | {
        name: replace(observed[name], field_of_view=view)
        for name, view in views.items()
        if name != ANY_SENSOR and "field_of_view" not in configuration.sensor(name)
    }
