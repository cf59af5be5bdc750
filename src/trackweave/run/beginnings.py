"""What reports say of tracks, and from which state each track sets out."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import cast

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.domain.foreign_kind import FOREIGN, ForeignKind, Reported
from trackweave.domain.measurements import MeasurementKind
from trackweave.domain.reports import ReportTable
from trackweave.filters.smoother import Readings
from trackweave.models.foreign_motion import ForeignMotion
from trackweave.models.measurements import to_position
from trackweave.models.motion import MotionRule
from trackweave.models.sensors import Sensor

__all__ = ["Evidence", "begun", "first_state", "readings_of"]

HOW_MUCH_WIDER = 10.0
"""A place that was found from the reports themselves is a start so many times less certain."""
FARTHEST = 1e5
"""How far an object may be of which nothing says how far [m]."""


@dataclass(frozen=True, slots=True, eq=False)
class Evidence:
    """Reports as the smoother takes them, one row each."""

    time: FloatArray  # [s]
    kind: IntArray
    width: IntArray  # How many numbers a report of that kind holds
    measurement: FloatArray  # NaN to the right of what a kind has
    sigma: FloatArray
    # Where the sensor was: x, y, z [m] and their rates [m/s], shape (reports, 6).
    platform: FloatArray
    # How probable wider noise is, how many times as wide, how persistent, shape (reports, 3).
    tail: FloatArray
    turning: IntArray  # Whether the report counts at its own time, not at its scan's end
    dim: int
    sensor: IntArray  # The number of each report's sensor
    # What each sensor measures.
    kinds: tuple[MeasurementKind | ForeignKind, ...] = ()
    context: FloatArray | None = None  # What kinds from outside ask for

    @classmethod
    def of(cls, reports: ReportTable, sensors: Sequence[Sensor]) -> "Evidence":
        """Return a table's reports, with their sensors' noise and place where they say none."""
        dim, columns = reports.dim, reports.measurement.shape[1]
        by_name = {sensor.name: sensor for sensor in sensors}
        kinds, widths, turning = [], [], []
        usual = np.full((len(reports.sensors), columns), np.nan)
        places, tails = np.zeros((len(reports.sensors), 6)), np.zeros((len(reports.sensors), 3))
        own = reports.sigma.copy()
        for number, name in enumerate(reports.sensors):
            sensor, kind = by_name[name], reports.kind_of(number)
            # Positions may have fewer numbers than the space has dimensions.
            width = min(kind.n_components(dim), columns)
            usual[number, :width] = sensor.sigmas(dim)[:width]
            if sensor.sigma_at:
                rows = np.ix_(reports.sensor == number, range(width))
                own[rows] = sensor.noise(own[rows], reports.measurement[rows], dim)
            places[number] = sensor.platform
            tails[number] = sensor.tail_share, sensor.tail_scale, sensor.tail_persistence
            kinds.append(int(kind))
            widths.append(width)
            turning.append(int(sensor.rotation is not None))
        of = reports.sensor
        platform = places[of]
        if reports.platform is not None:
            platform = np.where(np.isnan(reports.platform), platform, reports.platform)
        return cls(
            time=reports.time,
            kind=np.array(kinds, dtype=np.int64)[of],
            width=np.array(widths, dtype=np.int64)[of],
            measurement=reports.measurement,
            sigma=np.where(np.isnan(own), usual[of], own),
            platform=platform,
            tail=tails[of],
            turning=np.array(turning, dtype=np.int64)[of],
            dim=dim,
            sensor=of,
            kinds=tuple(map(reports.kind_of, range(len(reports.sensors)))),
            context=reports.context,
        )

    def kind_of(self, row: int) -> MeasurementKind | ForeignKind:
        """Return what a report holds."""
        return self.kinds[int(self.sensor[row])]

    def context_of(self, rows: slice | IntArray, kind: ForeignKind) -> FloatArray | None:
        """Return what a kind from outside asks for of some reports."""
        return None if self.context is None else self.context[rows, : len(kind.context)]

    def reported(self, rows: IntArray) -> Reported:
        """Return reports of one kind from outside as it gets them."""
        kind = cast("ForeignKind", self.kind_of(int(rows[0])))
        width = int(self.width[rows[0]])
        return kind.reported(
            np.ascontiguousarray(self.measurement[rows, :width]),
            np.ascontiguousarray(self.sigma[rows, :width]),
            self.context_of(rows, kind),
        )

    def is_located(self, row: int) -> bool:
        """Tell whether a report says by itself where its object is in all dimensions."""
        kind = self.kind_of(row)
        is_whole = kind.has_range or isinstance(kind, ForeignKind) or self.width[row] == self.dim
        return kind.gives_position(self.dim) and bool(is_whole)

    def place(self, row: int) -> tuple[FloatArray, FloatArray]:
        """Return the position of a report that is located, and its covariance."""
        one, kind = slice(row, row + 1), self.kind_of(row)
        context = self.context_of(one, kind) if isinstance(kind, ForeignKind) else None
        position, covariance = to_position(
            kind, self.measurement[one], self.sigma[one], self.platform[one], self.dim, context
        )
        return position[0], covariance[0]


def readings_of(evidence: Evidence, time: FloatArray, report: IntArray) -> Readings:
    """Return a track's moments, ascending times [s], with the row of each report, -1 for none."""
    taken = report >= 0
    return Readings(
        time=time,
        kind=np.where(taken, evidence.kind[report], -1),
        width=evidence.width[report],
        measurement=np.ascontiguousarray(evidence.measurement[report]),
        sigma=np.ascontiguousarray(evidence.sigma[report]),
        platform=np.ascontiguousarray(evidence.platform[report]),
        tail=np.ascontiguousarray(evidence.tail[report]),
    )


def first_state(
    evidence: Evidence,
    readings: Readings,
    report: IntArray,
    motion: tuple[MotionRule, ForeignMotion | None],
    known: tuple[float, FloatArray, FloatArray] | None,
) -> tuple[FloatArray, FloatArray]:
    """Return mean and covariance from which a track sets out, its velocity unknown."""
    # A first report that says where the object is makes the state, and is taken out of the
    # readings but for its range rate. Otherwise the track sets out from a wide spread about where
    # its object was found later. The readings are changed in place; ``known`` is when the tracker
    # first placed the track [s], with its mean and covariance then.
    rule, way = motion
    dim = rule.dim
    moment = int(np.flatnonzero(report >= 0)[0])
    row = int(report[moment])
    if evidence.is_located(row):
        _take_out(readings, moment)
        return begun(rule, way, *evidence.place(row))
    located = [k for k in np.flatnonzero(report >= 0) if evidence.is_located(int(report[k]))]
    if known is not None:
        time, place, spread = known[0], known[1][:dim], known[2][:dim, :dim]
    elif located:
        time = float(readings.time[located[0]])
        place, spread = evidence.place(int(report[located[0]]))
    else:
        time, place, spread = float(readings.time[0]), *_along(evidence, row)
    variance = rule.prior[dim] if way is None else way.velocity_variance(dim)
    drift = variance * (time - readings.time[0]) ** 2
    return begun(rule, way, place, HOW_MUCH_WIDER**2 * spread + drift * np.eye(dim))


def begun(
    rule: MotionRule, way: ForeignMotion | None, place: FloatArray, spread: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the state of an object of which nothing but a place is known."""
    dim, size = rule.dim, rule.prior.size
    if way is not None:
        mean, covariance = way.begin(place[None], spread[None], size)
        return mean[0], covariance[0]
    alone, wide = np.zeros(size), np.diag(rule.prior)
    alone[:dim], wide[:dim, :dim] = place, spread
    return alone, wide


def _take_out(readings: Readings, moment: int) -> None:
    """Leave of a report only its range rate, if it has one."""
    kind = int(readings.kind[moment])
    if kind == FOREIGN or not MeasurementKind(kind).has_rate:
        readings.kind[moment] = -1
        return
    last = int(readings.width[moment]) - 1
    readings.kind[moment], readings.width[moment] = int(MeasurementKind.RANGE_RATE), 1
    readings.measurement[moment, 0] = readings.measurement[moment, last]
    readings.sigma[moment, 0] = readings.sigma[moment, last]


def _along(evidence: Evidence, row: int) -> tuple[FloatArray, FloatArray]:
    """Return a place halfway along a report's direction, which is all that is known of it."""
    dim, kind = evidence.dim, evidence.kind_of(row)
    measured, place = evidence.measurement[row], evidence.platform[row, :dim].copy()
    half = FARTHEST / 2
    if isinstance(kind, ForeignKind):
        return place, np.eye(dim) * half**2
    if kind.is_position:
        place[: evidence.width[row]] = measured[: evidence.width[row]]
        return place, np.diag(np.r_[evidence.sigma[row, :2] ** 2, np.full(dim - 2, half**2)])
    azimuth = measured[kind.azimuth]
    distance = measured[0] if kind.has_range else half
    place[:2] += distance * np.array([np.sin(azimuth), np.cos(azimuth)])
    return place, np.eye(dim) * (distance / HOW_MUCH_WIDER) ** 2
