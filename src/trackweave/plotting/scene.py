"""What pictures of a run show."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from trackweave.arrays import FloatArray, IntArray
from trackweave.domain.foreign_kind import ForeignKind
from trackweave.domain.reports import ReportTable
from trackweave.domain.tracks import TrackTable
from trackweave.domain.truth import TruthTable
from trackweave.models.measurements import to_position

__all__ = ["ScanSeries", "Scene", "paths_of_sensors", "places_of_reports"]


@dataclass(frozen=True, slots=True, eq=False)
class Scene:
    """What is to be seen."""

    reports: ReportTable | None  # All reports; None where they are not at hand
    # Rows of tracks; confirmed and coasting ones are drawn. May be empty.
    tracks: TrackTable
    truth: TruthTable | None = None  # Where targets really were, None where it is not known
    # From a report's row number to its track; a report without one is a false alarm. None where it
    # is not known.
    assignment: Mapping[int, int] | None = None
    # Where sensors stand [m], by name.
    sensor_positions: Mapping[str, tuple[float, ...]] = field(default_factory=dict)
    title: str | None = None  # Heading; None for a count of what there is
    pixels: bool = False  # Whether positions are those of an image, in pixels, y downwards
    # Latitude and longitude of the plane's origin [degrees], None for plane coordinates.
    origin: tuple[float, float] | None = None


@dataclass(frozen=True, slots=True, eq=False)
class ScanSeries:
    """What each scan left behind, for the curves beside the plan."""

    time: FloatArray  # End of each scan [s], shape (scans,)
    reports: FloatArray  # Number of reports
    assigned: FloatArray  # Number of those that belong to a track in the end
    # How far the scan's answer may be from the best, as a share of its cost; NaN where nothing is
    # known.
    gap: FloatArray
    # Whether the answer was proven to be the best. With a gap of 0 it is otherwise the best of
    # what was kept.
    proven: NDArray[np.bool_]
    cpu_ms: FloatArray | None  # CPU time [ms]; None where it is not known
    known: TrackTable  # Rows of tracks as they were known then, to count them by status
    iso_time: bool = False  # Whether times are seconds from 1970 UTC


def places_of_reports(
    reports: ReportTable, sensor_positions: Mapping[str, tuple[float, ...]]
) -> FloatArray:
    """Return where reports put their objects on the plan [m], shape (reports, 2)."""
    # It is NaN for a bearing, and for a range and azimuth from an unknown place. Without an
    # elevation a range counts as one over the ground. ``sensor_positions`` [m] are for reports
    # that do not say it themselves.
    places = np.full((len(reports), 2), np.nan)
    for code, name in enumerate(reports.sensors):
        rows = np.flatnonzero(reports.sensor == code)
        kind = reports.kind_of(code)
        if kind.is_position:
            places[rows] = reports.measurement[rows, :2]
            continue
        if isinstance(kind, ForeignKind):
            # Where such a report puts its object takes the noise that the run was told.
            continue
        dim = 3 if kind.has_elevation else 2
        width = kind.n_components(dim)
        sigma = np.nan_to_num(reports.sigma[rows, :width])
        # Of a sensor that measures ranges from it is not said where, runs take the origin.
        origin = (0.0, 0.0) if kind.has_range else None
        platform = _platform(reports, rows, sensor_positions.get(name, origin))
        found, _ = to_position(kind, reports.measurement[rows, :width], sigma, platform, dim)
        places[rows] = found[:, :2]
    return places


def paths_of_sensors(reports: ReportTable) -> dict[str, FloatArray]:
    """Return where sensors went that say so themselves [m], in order of time, by name."""
    if reports.platform is None:
        return {}
    paths = {}
    for code, name in enumerate(reports.sensors):
        path = reports.platform[reports.sensor == code, :2]
        path = path[~np.isnan(path).any(axis=1)]
        if len(path):
            moved = np.append(True, np.any(np.diff(path, axis=0) != 0, axis=1))
            paths[name] = path[moved]
    return paths


def _platform(
    reports: ReportTable, rows: IntArray, stands: tuple[float, ...] | None
) -> FloatArray:
    """Return where the sensor was at each report, the height 0 where nothing is said of it."""
    platform = np.full((rows.size, 3), np.nan)
    platform[:, 2] = 0.0
    if stands is not None:
        platform[:, : len(stands)] = stands
    if reports.platform is not None:
        own = reports.platform[rows, :3]
        platform = np.where(np.isnan(own), platform, own)
    return platform
