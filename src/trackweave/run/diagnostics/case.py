"""What the checks look at, and what they say."""

from collections.abc import Callable, Container, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.config.fill import Settings
from trackweave.domain.reports import ReportTable
from trackweave.domain.tracks import CONFIRMED, TrackTable
from trackweave.models.sensors import Sensor
from trackweave.run.polar_to_cartesian import placed, platforms_of

__all__ = ["SURE_HITS", "Case", "Check", "Finding", "Path"]

# A track of so many reports is beyond doubt, and so many tracks tell enough.
SURE_HITS, MOST_PATHS, MOST_SENSORS = 6, 300, 16


@dataclass(frozen=True, slots=True)
class Finding:
    """A sentence on something that contradicts something else."""

    cause: str  # Such as "clock" or "sigma"
    sensor: str | None  # None where it concerns none or all
    sentence: str  # What is wrong, with the numbers told and seen, and what to change
    weight: float  # The greater, the earlier it is said
    told: float | None = None
    seen: float | None = None
    is_clear: bool = False  # Whether what is told cannot be, so that it may be given back
    likewise: tuple[str, ...] = ()  # Other sensors of which the same is true

    def as_record(self) -> dict[str, Any]:
        """Return it as an object for a run's record."""
        names = ("cause", "sensor", "told", "seen", "sentence")
        return {name: getattr(self, name) for name in names}


@dataclass(frozen=True, slots=True, eq=False)
class Path:
    """A confirmed track after the fact."""

    time: FloatArray  # [s], ascending
    place: FloatArray  # On the plane [m], shape (times, 2)
    speed: FloatArray  # [m/s], shape (times,)
    rows: IntArray  # Rows of its reports, by time

    def at(self, time: FloatArray) -> FloatArray:
        """Return where it was at some times [m], NaN before its first and after its last."""
        place = [np.interp(time, self.time, axis, np.nan, np.nan) for axis in self.place.T]
        return np.stack(place, axis=-1)


@dataclass(frozen=True, eq=False)
class Case:
    """A run's reports, its configuration as used, and what came of it."""

    reports: ReportTable  # The reports as tracked, of any kind
    settings: Settings
    track: IntArray  # -1 for none, shape (reports,)
    history: TrackTable | None  # Amended and smoothed, rows by time; None while not known
    # When each sensor scanned [s], ascending, by its name; sectors of turning ones too.
    looks: Mapping[str, FloatArray] = field(default_factory=dict)
    # Why nobody looked for biases of a sensor, by its name; others are left out.
    unregistered: Mapping[str, str] = field(default_factory=dict)

    @cached_property
    def sensors(self) -> tuple[Sensor, ...]:
        """The sensors in the order of the reports' table."""
        by_name = {sensor.name: sensor for sensor in self.settings.sensors}
        return tuple(by_name[name] for name in self.reports.sensors)

    @cached_property
    def usual_speed(self) -> float:
        """How fast objects usually are [m/s], 0 where no track is known."""
        if not self.paths:
            return 0.0
        return float(np.median([np.median(path.speed) for path in self.paths]))

    @cached_property
    def rows(self) -> tuple[IntArray, ...]:
        """The rows of each sensor's reports."""
        of = self.reports.sensor
        ends = np.searchsorted(np.sort(of), np.arange(1, len(self.reports.sensors)))
        return tuple(np.split(np.argsort(of, kind="stable"), ends))

    @cached_property
    def examined(self) -> tuple[int, ...]:
        """The sensors with the most reports, by index: of thousands, each costs time."""
        sizes = np.array([rows.size for rows in self.rows])
        return tuple(np.sort(np.argsort(-sizes, kind="stable")[:MOST_SENSORS]).tolist())

    @cached_property
    def guessed(self) -> Container[str]:
        """Names of the sensors whose scan period nobody gave."""
        return {s.name for s in self.sensors if not self.is_told(f"sensors.{s.name}.scan_period")}

    @cached_property
    def platform(self) -> FloatArray:
        """Where each report's sensor was, x and y [m], shape (reports, 2)."""
        return self.stand[:, :2]

    @cached_property
    def stand(self) -> FloatArray:
        """Where each report's sensor was [m], shape (reports, dim)."""
        places = {s.name: s.position for s in self.sensors if s.position is not None}
        return platforms_of(self.reports, places)[:, : self.reports.dim]

    @cached_property
    def position(self) -> FloatArray:
        """Where each report puts its object [m], shape (reports, 2), NaN where it does not."""
        return self.place[:, :2]

    @cached_property
    def place(self) -> FloatArray:
        """Where each report puts its object [m], shape (reports, dim), NaN where it does not."""
        if not self.reports.kinds:
            return self.reports.measurement
        places = {s.name: s.position for s in self.sensors if s.position is not None}
        telling = [kind.gives_position(self.reports.dim) for kind in self.reports.kinds]
        found = np.full((len(self.reports), self.reports.dim), np.nan)
        rows = np.flatnonzero(np.array(telling)[self.reports.sensor])
        found[rows] = placed(self.reports, places).measurement
        return found

    @cached_property
    def paths(self) -> tuple[Path, ...]:
        """The confirmed tracks with the most reports."""
        return tuple(self._paths())

    @cached_property
    def groups(self) -> tuple[IntArray, ...]:
        """The rows of each track beyond doubt, by time; the tracks with the most first."""
        return self.tracks_of(SURE_HITS)

    def tracks_of(self, fewest: int) -> tuple[IntArray, ...]:
        """Return the rows of each track of so many reports, as ``groups`` does."""
        rows = np.flatnonzero(self.track >= 0)
        rows = rows[np.argsort(self.track[rows], kind="stable")]
        ends = np.flatnonzero(np.diff(self.track[rows])) + 1
        groups = sorted(np.split(rows, ends), key=lambda group: -group.size)
        return tuple(group for group in groups[:MOST_PATHS] if group.size >= fewest)

    def _paths(self) -> Iterator[Path]:
        history = self.history
        if history is None or len(history) == 0:
            return
        order = np.argsort(history.track, kind="stable")
        number, starts = np.unique(history.track[order], return_index=True)
        shown = dict(zip(number.tolist(), np.split(order, starts[1:]), strict=True))
        dim = history.dim
        for own in self.groups:
            states = shown.get(int(self.track[own[0]]))
            if states is None or states.size < 2:
                continue
            if history.status[states].max() >= CONFIRMED:
                mean = history.mean[states]
                speed = np.linalg.norm(mean[:, dim : 2 * dim], axis=1)
                yield Path(history.time[states], mean[:, :2], speed, own)

    def is_told(self, key: str) -> bool:
        """Tell whether somebody gave a value, by its dotted key."""
        return self.settings.sources.get(key) in {"file", "preset"}

    def plane_sigma(self, index: int) -> float:
        """Return the usual standard deviation of a sensor's positions on the plane [m]."""
        sensor, rows = self.sensors[index], self.rows[index]
        sigma = sensor.sigmas(self.reports.dim)
        if not sensor.measurement.has_range:
            return float(np.max(sigma[:2]))
        middle = float(np.median(self.reports.measurement[rows, 0]))
        return float(max(sigma[0], middle * sigma[1]))

    def tells_place(self, index: int) -> bool:
        """Tell whether a sensor's reports say where their objects are."""
        kind = self.reports.kind_of(index)
        return kind.gives_position(self.reports.dim) and self.rows[index].size > 0


Check = Callable[[Case], Iterator[Finding]]
"""Looks at a case and yields what contradicts something; changes nothing."""
