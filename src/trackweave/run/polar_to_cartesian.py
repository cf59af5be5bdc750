"""Reports on the plane: as positions as far as they tell any, and slant ranges corrected."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.domain.foreign_kind import ForeignKind
from trackweave.domain.frames import LocalFrame
from trackweave.domain.measurements import MeasurementKind
from trackweave.domain.reports import ReportTable
from trackweave.models.measurements import to_position
from trackweave.models.rotation import Rotation
from trackweave.run.scans import turn_ends, with_turns

__all__ = ["EARTH_RADIUS_M", "in_turns", "laid", "placed", "platforms_of"]


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
        if kind.is_position:
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


EARTH_RADIUS_M = 6_371_000.0
# A direction is carried over by a point so far away [m].
_NEARBY_M = 1_000.0
# Nearer to overhead than this share of the range, nothing is told of the place on the ground.
_STEEPEST = 1e-3
# No aircraft flies higher [m], but many fly as many feet high.
_HIGHEST_M = 20_000.0
# An object whose reports jump by so much is torn [m].
_JUMP_M = 100.0
# Sensors that see so far [m] stand no nearer to each other, unless they are one mast's, beside
# which coordinates count from: those of others are degrees.
_FAR_M, _APART_M, _BESIDE_M = 1_000.0, 2.0, 3.0


def laid(
    reports: ReportTable, places: Mapping[str, Sequence[float]]
) -> tuple[ReportTable, list[str]]:
    """Return reports whose ranges and directions are those on the plane, and what was assumed."""
    # ``places`` are where sensors stand whose rows do not say: x, y[, z] [m].
    # In two dimensions a slant range becomes the distance on the ground where the row tells the
    # object's height, and is taken for that distance where it does not. Where the plane is one of
    # the Earth's, ranges and directions follow the Earth's curve, and count from the plane's north
    # instead of the sensor's.
    notes = _notes_on_heights(reports)
    if not reports.kinds:
        return reports, notes
    platform = platforms_of(reports, places)
    notes += _notes_on_places(reports, places)
    measurement = reports.measurement.copy()
    for index, kind in enumerate(reports.kinds):
        rows = np.flatnonzero(reports.sensor == index)
        if isinstance(kind, ForeignKind) or not kind.needs_place or rows.size == 0:
            continue
        height = None if reports.height is None else reports.height[rows]
        is_flat = kind.has_range and not kind.has_elevation and reports.dim == 2
        if is_flat:
            notes += _notes_on_ranges(reports.sensors[index], measurement[rows, 0], height)
        measured = measurement[rows]
        if reports.frame is not None:
            measurement[rows] = _on_earth(measured, kind, platform[rows], height, reports.frame)
        elif is_flat and height is not None:
            climb = height - platform[rows, 2]
            ground = np.sqrt(np.maximum(measured[:, 0] ** 2 - climb**2, 0.0))
            measurement[rows] = _with_range(measured, kind, ground, ~np.isnan(climb))
    return replace(reports, measurement=measurement), notes


def _with_range(
    measured: FloatArray, kind: MeasurementKind, ground: FloatArray, where: np.ndarray
) -> FloatArray:
    """Return measurements with other ranges, and with the rates of these in level motion."""
    result, slant = measured.copy(), measured[:, 0]
    ground = np.maximum(ground, _STEEPEST * slant)
    result[where, 0] = ground[where]
    if kind.has_rate:
        result[where, 2] *= slant[where] / np.maximum(ground[where], 1e-9)
    return result


def _on_earth(
    measured: FloatArray,
    kind: MeasurementKind,
    platform: FloatArray,
    height: FloatArray | None,
    frame: LocalFrame,
) -> FloatArray:
    """Return measurements from the plane's place of a sensor on the Earth."""
    import pymap3d

    latitude, longitude, altitude = frame.to_geodetic(np.ascontiguousarray(platform[:, :3]))
    at = kind.azimuth
    azimuth = np.degrees(measured[:, at])
    if kind.is_bearing_only:
        slant, elevation = np.full(len(measured), _NEARBY_M), np.zeros(len(measured))
    elif kind.has_elevation:
        slant, elevation = measured[:, 0], measured[:, 2]
    else:
        slant = measured[:, 0]
        level = altitude if height is None else np.where(np.isnan(height), altitude, height)
        low, high = EARTH_RADIUS_M + altitude, EARTH_RADIUS_M + level
        sine = (high**2 - low**2 - slant**2) / np.maximum(2 * slant * low, 1e-9)
        elevation = np.arcsin(np.clip(sine, -1.0, 1.0))
    there = pymap3d.aer2geodetic(
        azimuth, np.degrees(elevation), slant, latitude, longitude, altitude
    )
    offset = frame.to_plane(*(np.asarray(part) for part in there)) - platform[:, :3]
    result = measured.copy()
    result[:, at] = np.arctan2(offset[:, 0], offset[:, 1]) % (2 * np.pi)
    distance = np.hypot(offset[:, 0], offset[:, 1])
    if kind.has_elevation:
        result[:, 0] = np.linalg.norm(offset, axis=1)
        result[:, 2] = np.arctan2(offset[:, 2], distance)
    elif kind.has_range:
        told = np.zeros(len(measured), bool) if height is None else ~np.isnan(height)
        # The plane's scale alone does not change how fast an object comes nearer.
        result = _with_range(result, kind, distance, told)
        result[~told, 0] = distance[~told]
    return result


def _notes_on_places(reports: ReportTable, places: Mapping[str, Sequence[float]]) -> list[str]:
    """Return a doubt about positions that seem to be degrees."""
    told = [places[name][:2] for name in reports.sensors if name in places]
    ranging = [
        reports.sensor == index
        for index, kind in enumerate(reports.kinds)
        if not isinstance(kind, ForeignKind) and kind.has_range
    ]
    if reports.frame is not None or not ranging or len(told) < 2:
        return []
    farthest = max(float(reports.measurement[rows, 0].max(initial=0.0)) for rows in ranging)
    apart = float(np.linalg.norm(np.ptp(np.array(told), axis=0)))
    is_beside = np.abs(told).max() < _BESIDE_M
    if is_beside or farthest < _FAR_M or not 0.0 < apart < _APART_M:
        return []
    return [
        f"sensors stand {apart:.2g} m from each other by their positions, and see {farthest:.4g} "
        "m far: positions are in metres; degrees are told as place = [latitude, longitude]"
    ]


def _notes_on_ranges(name: str, slant: FloatArray, height: FloatArray | None) -> list[str]:
    """Return what is assumed where heights are missing, and doubts about those there are."""
    if height is None or np.isnan(height).all():
        return [
            f"sensor {name}: no height_m, so that its ranges are taken for distances on the ground"
        ]
    missing = int(np.isnan(height).sum())
    notes = []
    if missing:
        told = ~np.isnan(height) & (np.abs(height) < slant)
        level = np.sqrt(slant[told] ** 2 - height[told] ** 2)
        jump = float(np.median(slant[told] - level)) if told.any() else 0.0
        torn = (
            f"; an object that tells its height at times jumps by {jump:.0f} m (median) between "
            "both: leave height_m out where many do"
        )
        notes.append(
            f"sensor {name}: {missing} of {height.size} rows have no height (height_m); their "
            f"ranges are taken for distances on the ground{torn if jump > _JUMP_M else ''}"
        )
    above = int(np.sum(np.abs(height) > slant))
    if above:
        notes.append(
            f"sensor {name}: {above} of {height.size} rows have a height_m beyond their range, as "
            "heights in feet have; they count as overhead"
        )
    return notes


def _notes_on_heights(reports: ReportTable) -> list[str]:
    """Return a doubt about the unit of heights."""
    heights = [] if reports.height is None else [reports.height]
    if reports.dim == 3 and not reports.kinds and reports.frame is not None:
        heights.append(reports.measurement[:, 2])
    for height in heights:
        told = height[~np.isnan(height)]
        if told.size and np.quantile(told, 0.95) > _HIGHEST_M:
            return [
                f"heights of {np.quantile(told, 0.95):.0f} m and more: taken as metres, although "
                "they look like feet"
            ]
    return []
