"""Reports of one look that are pieces of one object, for which one of them stands."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.config import Configuration
from trackweave.config.fill import Settings, needs_estimates
from trackweave.config.sensing import ObservedSensor
from trackweave.domain.foreign_kind import ForeignKind
from trackweave.domain.measurements import MeasurementKind
from trackweave.domain.reports import ReportTable
from trackweave.models.measurements import NO_PLATFORM, to_position
from trackweave.run.doubles import heard_once
from trackweave.run.observing import observe
from trackweave.run.scans import with_turns

__all__ = [
    "Pieces",
    "first_pieces",
    "mean_of",
    "pieces_in",
    "pieces_of",
    "seen_from_sensor",
    "with_extent",
    "with_pieces",
]

# Objects an extent apart whose range rates differ by an extent in so long [s] are two.
LATER = 3.0


@dataclass(frozen=True, eq=False)
class Pieces:
    """Which reports are pieces of one object."""

    reports: ReportTable
    configuration: Configuration  # With the extents of objects
    # Row of the report that stands for the object of each, its own where that is alone.
    first: IntArray
    learned: tuple[str, ...] = ()  # Sensors whose objects' extents the reports tell

    @property
    def count(self) -> int:
        """How many reports there are for whose object another stands."""
        return int(np.count_nonzero(self.first != np.arange(self.first.size)))

    @property
    def place(self) -> IntArray:
        """Row in ``joined`` of the report that stands for the object of each."""
        return np.unique(self.first, return_inverse=True)[1]

    @cached_property
    def joined(self) -> ReportTable:
        """One report for each object, in the middle of its pieces; all where all are alone."""
        if self.count == 0:
            return self.reports
        table, place = self.reports, self.place
        once = table.part(np.unique(self.first))
        measurement = once.measurement.copy()
        for index in range(len(table.sensors)):
            rows, own = np.flatnonzero(table.sensor == index), once.sensor == index
            if own.any():
                groups = np.unique(place[rows], return_inverse=True)[1]
                measurement[own] = mean_of(table.kind_of(index), table.measurement[rows], groups)
        return replace(once, measurement=measurement)

    def restored(self, joined: ReportTable) -> ReportTable:
        """Return all reports, moved as those that stand for objects are by now."""
        if self.count == 0:
            return joined
        moved = (joined.measurement - self.joined.measurement)[self.place]
        return replace(self.reports, measurement=self.reports.measurement + moved)

    def shared(self, second: Mapping[int, int]) -> dict[int, int]:
        """Return the second track of every report, by row, from that of each in ``joined``."""
        place = enumerate(self.place.tolist())
        return {row: second[one] for row, one in place if one in second}

    def entered(self, settings: Settings) -> Settings:
        """Return a configuration as used, in which extents that reports tell are estimated."""
        learned = {f"sensors.{name}.extent": "estimated" for name in self.learned}
        return replace(settings, sources={**settings.sources, **learned})

    def notes(self) -> list[str]:
        """Return a sentence on each sensor's pieces."""
        said = []
        for index, name in enumerate(self.reports.sensors):
            rows = np.flatnonzero(self.reports.sensor == index)
            count = int(np.count_nonzero(self.first[rows] != rows))
            if count and name in self.learned:
                extent = self.configuration.sensor(name)["extent"]
                said.append(
                    f"sensor {name}: objects give several reports a scan, or times are rounded: "
                    f"those within {extent:g} m are one object's, {count:,} of {rows.size:,} "
                    "beside another that stands for it; tracks are clearly likelier so; give "
                    "extent = 0 to track each for itself"
                )
        return said


def pieces_in(reports: ReportTable, configuration: Configuration, *, looks: bool = True) -> Pieces:
    """Return which reports are pieces of one object, as is told or, with ``looks``, as they say.

    Parameters
    ----------
    reports
        All of a run.
    configuration
        What is told: of sensors whose ``extent`` is, nothing is looked for.
    looks
        Whether anything is.

    Returns
    -------
    With a configuration that has every extent that is used.
    """
    chosen: list[str] = []
    is_told = any(configuration.sensor(name).get("extent") for name in reports.sensors)
    is_open = looks and needs_estimates(configuration, reports.sensors)
    if not (is_told or is_open):
        return Pieces(reports, configuration, np.arange(len(reports)))
    seen = observe(reports, configuration)
    look = _looks(reports, seen)
    if is_open:
        # A complete configuration takes nothing of what estimates.
        from trackweave.run.piece_trial import likeliest_extent

        # What comes twice over a network is no second piece, but would make any extent likely.
        heard = heard_once(reports, seen)
        extent, chosen = likeliest_extent(reports.part(heard), look[heard], configuration)
        configuration = with_extent(configuration, chosen, extent)
    return replace(pieces_of(reports, look, configuration), learned=tuple(chosen))


def _looks(reports: ReportTable, seen: Mapping[str, ObservedSensor]) -> IntArray | FloatArray:
    """Return the number of each report's look: its turn where a beam turns, or scan or time."""
    turning = {name: each.rotation for name, each in seen.items() if each.rotation is not None}
    turns = with_turns(reports, turning)
    return reports.look if turns is None else turns


def with_extent(
    configuration: Configuration, names: Sequence[str], extent: float
) -> Configuration:
    """Return a configuration with an extent of what some sensors see [m]."""
    sensors = configuration.table("sensors")
    for name in names:
        sensors[name] = {**sensors.get(name, {}), "extent": extent}
    return configuration.changed(sensors=sensors) if names else configuration


def with_pieces(record: dict[str, Any], pieces: Pieces, assigned: int) -> dict[str, Any]:
    """Return a run's record, a new one, of which the totals count every report that came."""
    # ``assigned`` counts the reports that have a track, copies and pieces too.
    totals = record["totals"]
    counts = {
        "reports": len(pieces.reports) + totals["unavailable_reports"],
        "assigned_reports": assigned,
        "pieces": pieces.count,
    }
    return {**record, "totals": {**totals, **counts}}


def pieces_of(
    reports: ReportTable, look: IntArray | FloatArray, configuration: Configuration
) -> Pieces:
    """Return which reports are pieces of one object, by the extents that a configuration has.

    Parameters
    ----------
    reports
        All of a run.
    look
        Number of each one's look, shape (reports,), by which those of a sensor are told apart.
    configuration
        With the extents.

    Returns
    -------
    None of sensors without.
    """
    first = np.arange(len(reports))
    for index, name in enumerate(reports.sensors):
        extent = configuration.sensor(name).get("extent", 0.0)
        rows = np.flatnonzero(reports.sensor == index)
        kind = reports.kind_of(index)
        if not extent or rows.size == 0 or isinstance(kind, ForeignKind):
            continue
        keys = [each[rows] for each in (look, reports.identity) if each is not None]
        apart = np.unique(np.column_stack(keys), axis=0, return_inverse=True)[1].ravel()
        strength = None if reports.strength is None else reports.strength[rows]
        measurement = reports.measurement[rows, : kind.n_components(reports.dim)]
        if kind.gives_position(reports.dim):
            first[rows] = rows[first_pieces(kind, measurement, apart, extent, strength)]
    return Pieces(reports, configuration, first)


def first_pieces(
    kind: MeasurementKind,
    measurement: FloatArray,
    apart: IntArray,
    extent: float,
    strength: FloatArray | None = None,
) -> IntArray:
    """Return the row of the report that stands for each one's object: its strongest, or first.

    Parameters
    ----------
    kind
        What is measured.
    measurement
        By one sensor, shape (reports, numbers), which tells positions.
    apart
        Number of each report's look, shape (reports,): those of others are other objects'.
    extent
        How far each piece of an object is from the next at most [m].
    strength
        How strong each report is, shape (reports,), NaN where nobody says.

    Returns
    -------
    Rows, shape (reports,).
    """
    rows = np.arange(len(measurement))
    if rows.size < 2:
        return rows
    near = seen_from_sensor(kind, measurement) / extent
    # Looks are put so far apart that whatever links is of the same one.
    width = 10.0 * (1.0 + float(np.linalg.norm(np.ptp(near, axis=0))))
    places = np.column_stack([near, width * apart])
    # Runs whose reports are all alone need not wait for the import.
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import KDTree

    pairs = KDTree(places).query_pairs(1.0, output_type="ndarray")
    links = coo_array((np.ones(len(pairs)), tuple(pairs.T)), shape=(rows.size, rows.size))
    group = connected_components(links, directed=False)[1]
    weak = np.zeros(rows.size) if strength is None else -np.nan_to_num(strength, nan=-np.inf)
    order = np.lexsort((rows, weak, group))
    heads = order[np.r_[True, np.diff(group[order]) != 0]]
    found: IntArray = heads[np.unique(group, return_inverse=True)[1]]
    return found


def seen_from_sensor(kind: MeasurementKind, measurement: FloatArray) -> FloatArray:
    """Return where reports are, seen from their sensor [m]; range rates count as another axis."""
    if kind.is_position:
        return measurement
    dim = 3 if kind.has_elevation else 2
    platform = np.tile(NO_PLATFORM, (len(measurement), 1))
    place = to_position(kind, measurement, np.zeros_like(measurement), platform, dim)[0]
    return np.column_stack([place, LATER * measurement[:, -1:]]) if kind.has_rate else place


def mean_of(
    kind: MeasurementKind | ForeignKind, measurement: FloatArray, groups: IntArray
) -> FloatArray:
    """Return the mean of each group's reports, of angles the shorter way round.

    Parameters
    ----------
    kind
        What is measured.
    measurement
        By one sensor, shape (reports, numbers).
    groups
        Number of each report's group, from 0, shape (reports,).

    Returns
    -------
    Shape (groups, numbers).
    """
    head = np.unique(groups, return_index=True)[1]
    aside = measurement - measurement[head][groups]
    azimuth = kind.azimuth if isinstance(kind, MeasurementKind) else None
    if azimuth is not None:
        aside[:, azimuth] = (aside[:, azimuth] + np.pi) % (2.0 * np.pi) - np.pi
    total = np.zeros((head.size, measurement.shape[1]))
    np.add.at(total, groups, aside)
    mean: FloatArray = measurement[head] + total / np.bincount(groups)[:, None]
    if azimuth is not None:
        mean[:, azimuth] %= 2.0 * np.pi
    return mean
