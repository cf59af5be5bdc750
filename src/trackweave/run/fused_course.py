"""What fuses the plots of instants, and the sensors that fused reports seem to have."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.config.fill import Settings
from trackweave.config.plots import PlotSettings
from trackweave.domain.foreign_kind import ours
from trackweave.domain.measurements import MeasurementKind
from trackweave.domain.reports import ReportTable
from trackweave.domain.scans import Scan
from trackweave.estimation.covering import covered_by
from trackweave.models.extent import extent
from trackweave.models.sensors import Sensor
from trackweave.run.observing import filled
from trackweave.run.polar_to_cartesian import placed
from trackweave.solvers.auto import Auto
from trackweave.trackers.plot_fusion import PlotFuser

__all__ = ["fused_sensors", "fuser_of"]

N_PLACES = 50
"""Reports' places over which the chances of fused reports are averaged."""


def fuser_of(
    reports: ReportTable, settings: Settings, plots: PlotSettings
) -> tuple[PlotFuser, list[str]]:
    """Return what fuses the plots, and sentences on fields of view that had to be assumed."""
    sensors = [_standing(sensor, reports) for sensor in settings.sensors]
    volumes, widths, notes = {}, {}, []
    for index, sensor in enumerate(sensors):
        measured = reports.measurement[reports.sensor == index]
        kind = ours(sensor.measurement, sensor.name)
        plain = kind.without_rate
        if plain is not kind:
            widths[sensor.name] = filled(kind, measured) / filled(plain, measured)
        if plots.rule.cost == "evidence":
            continue
        view = None if sensor.field_of_view is None else sensor.field_of_view.coverage()
        if view is not None and reports.dim == 2 and extent(view, kind) is not None:
            continue
        if kind.is_position:
            volume = covered_by(measured, float(np.max(sensor.sigma)))
        else:
            volume = filled(plain, measured)
        volumes[sensor.name] = volume
        notes.append(
            f"sensor {sensor.name}: no bounded field_of_view; equation 1 takes what its reports "
            f"fill, {volume:.4g} {_unit(plain, reports.dim)}"
        )
    fuser = PlotFuser(
        sensors,
        plots.rule,
        settings.search or Auto(),
        motion=settings.motion,
        volumes=volumes,
        ignored_widths=widths,
        dim=reports.dim,
        keep_lone=plots.keep_lone,
    )
    return fuser, notes


def fused_sensors(
    reports: ReportTable, fuser: PlotFuser, instants: Sequence[tuple[Scan, ...]]
) -> tuple[Sensor, ...]:
    """Return the sensors of the fused reports, one for each set of sensors that looks at once."""
    order = {sensor.name: place for place, sensor in enumerate(fuser.sensors)}
    looking = {
        tuple(sorted((s.sensor for s in instant), key=order.__getitem__)) for instant in instants
    }
    combinations = sorted(looking, key=lambda names: (-len(names), [order[n] for n in names]))
    times = np.array([max(s.time for s in instant) for instant in instants if len(instant) > 1])
    gaps = np.diff(times)
    periods = [sensor.scan_period for sensor in fuser.sensors if sensor.scan_period is not None]
    period = float(np.median(gaps)) if gaps.size else max(periods, default=1.0)
    return fuser.fused_sensors(
        # A single report of a sensor that does not scan says nothing of other objects.
        period if periods else None,
        combinations=combinations,
        places=_places(reports, fuser.sensors),
    )


def _places(reports: ReportTable, sensors: Sequence[Sensor]) -> FloatArray | None:
    """Return places of some reports, None where none tells any."""
    stands = {s.name: s.position for s in sensors if s.position is not None}
    position = placed(reports, stands).measurement
    if position.shape[0] == 0:
        return None
    chosen = np.linspace(0, position.shape[0] - 1, min(N_PLACES, position.shape[0]))
    return position[chosen.astype(np.int64), : reports.dim]


def _standing(sensor: Sensor, reports: ReportTable) -> Sensor:
    """Return a sensor that stands where its first report says, if nothing else does."""
    index = reports.sensors.index(sensor.name)
    rows = np.flatnonzero(reports.sensor == index)
    if sensor.position is not None or reports.platform is None or rows.size == 0:
        return sensor
    place = np.nan_to_num(reports.platform[rows[0], :3])
    return replace(sensor, position=tuple(place.tolist()))


def _unit(kind: MeasurementKind, dim: int) -> str:
    if kind.is_position:
        return "m²" if dim == 2 else "m³"
    if kind.is_bearing_only:
        return "rad"
    return "m·rad²" if kind.has_elevation else "m·rad"
