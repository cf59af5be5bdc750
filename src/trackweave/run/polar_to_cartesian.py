"""Reports of every kind as positions, as far as they tell any."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.domain.foreign_kind import ForeignKind
from trackweave.domain.measurements import MeasurementKind
from trackweave.domain.reports import ReportTable
from trackweave.models.measurements import to_position
from trackweave.models.rotation import Rotation
from trackweave.run.turns import turn_ends, with_turns

__all__ = ["in_turns", "placed", "platforms_of"]


def platforms_of(
    reports: ReportTable, positions: Mapping[str, Sequence[float]] | None = None
) -> FloatArray:
    """Return where each report's sensor was: x, y, z [m], rates [m/s], shape (reports, 6)."""
    # ``positions`` are of sensors whose rows do not say: x, y[, z] [m], the origin for others.
    stands = np.zeros((len(reports.sensors), 6))
    for index, name in enumerate(reports.sensors):
        place = (positions or {}).get(name)
        if place is not None:
            stands[index, : len(place)] = place
    platform = stands[reports.sensor]
    if reports.platform is not None:
        platform = np.where(np.isnan(reports.platform), platform, reports.platform)
    return platform


def placed(
    reports: ReportTable, positions: Mapping[str, Sequence[float]] | None = None
) -> ReportTable:
    """Return the reports that tell a position, as positions; the same table where all do."""
    # The sensors are those that tell some, in the same order; noise is kept where it is that of a
    # position. ``positions`` are of sensors whose rows do not say: x, y[, z] [m].
    if not reports.kinds:
        return reports
    dim = reports.dim
    # What a plug-in's reports tell takes a noise that only a person knows.
    telling = [
        index
        for index, kind in enumerate(reports.kinds)
        if kind.gives_position(dim) and not isinstance(kind, ForeignKind)
    ]
    platform = platforms_of(reports, positions)
    position, sigma = np.full((2, len(reports), dim), np.nan)
    for index in telling:
        rows, kind = reports.sensor == index, reports.kinds[index]
        measured = reports.measurement[rows, : kind.n_components(dim)]
        # Without its noise a direction is taken as it is.
        position[rows], _ = to_position(
            kind, measured, np.zeros_like(measured), platform[rows], dim
        )
        if kind is MeasurementKind.POSITION:
            sigma[rows] = reports.sigma[rows, :dim]
    return _of_sensors(replace(reports, measurement=position, sigma=sigma), telling)


def in_turns(reports: ReportTable, rotations: Mapping[str, Rotation]) -> ReportTable:
    """Return reports as if each had been made at the end of its turn, which is a scan."""
    # They are in order of the new times; the same table where nothing turns.
    if not rotations:
        return reports
    ends = reports.time.copy()
    for index, name in enumerate(reports.sensors):
        if name in rotations:
            rows = reports.sensor == index
            _, ends[rows] = turn_ends(reports.time[rows], rotations[name])
    numbered = replace(reports, scan=with_turns(reports, rotations), time=ends)
    order: IntArray = np.lexsort((reports.sensor, ends))
    return numbered.part(order)


def _of_sensors(reports: ReportTable, sensors: Sequence[int]) -> ReportTable:
    """Return the reports of some sensors of a table that holds positions now."""
    number = np.full(len(reports.sensors), -1, dtype=np.int64)
    number[list(sensors)] = np.arange(len(sensors))
    chosen = reports.part(np.flatnonzero(np.isin(reports.sensor, sensors)))
    return replace(
        chosen,
        sensor=number[chosen.sensor],
        sensors=tuple(reports.sensors[index] for index in sensors),
        kinds=(),
        space=0,
    )
