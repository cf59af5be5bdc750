"""What reports say of tracks, and from which state each track sets out."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.domain.measurements import MeasurementKind
from trackweave.domain.reports import ReportTable
from trackweave.filters.smoother import Readings
from trackweave.models.measurements import to_position
from trackweave.models.motion import MotionRule
from trackweave.models.sensors import Sensor

__all__ = ["Evidence", "first_state", "readings_of"]

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
    tail: FloatArray  # How probable wider noise is, and how many times as wide, shape (reports, 2)
    turning: IntArray  # Whether the report counts at its own time, not at its scan's end
    dim: int

    @classmethod
    def of(cls, reports: ReportTable, sensors: Sequence[Sensor]) -> "Evidence":
        """Return a table's reports, with their sensors' noise and place where they say none."""
        dim, columns = reports.dim, reports.measurement.shape[1]
        by_name = {sensor.name: sensor for sensor in sensors}
        kinds, widths, turning = [], [], []
        usual = np.full((len(reports.sensors), columns), np.nan)
        places, tails = np.zeros((len(reports.sensors), 6)), np.zeros((len(reports.sensors), 2))
        for number, name in enumerate(reports.sensors):
            sensor, kind = by_name[name], reports.kind_of(number)
            # Positions may have fewer numbers than the space has dimensions.
            width = min(kind.n_components(dim), columns)
            usual[number, :width] = sensor.sigmas(dim)[:width]
            places[number] = sensor.platform
            tails[number] = sensor.tail_share, sensor.tail_scale
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
            sigma=np.where(np.isnan(reports.sigma), usual[of], reports.sigma),
            platform=platform,
            tail=tails[of],
            turning=np.array(turning, dtype=np.int64)[of],
            dim=dim,
        )

    def is_located(self, row: int) -> bool:
        """Tell whether a report says by itself where its object is in all dimensions."""
        kind = MeasurementKind(int(self.kind[row]))
        return kind.gives_position(self.dim) and (kind.has_range or self.width[row] == self.dim)

    def place(self, row: int) -> tuple[FloatArray, FloatArray]:
        """Return the position of a report that is located, and its covariance."""
        one = slice(row, row + 1)
        position, covariance = to_position(
            MeasurementKind(int(self.kind[row])),
            self.measurement[one],
            self.sigma[one],
            self.platform[one],
            self.dim,
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
    motion: MotionRule,
    known: tuple[float, FloatArray, FloatArray] | None,
) -> tuple[FloatArray, FloatArray]:
    """Return mean and covariance from which a track sets out, its velocity unknown."""
    # A first report that says where the object is makes the state, and is taken out of the
    # readings but for its range rate. Otherwise the track sets out from a wide spread about where
    # its object was found later. The readings are changed in place; ``known`` is when the tracker
    # first placed the track [s], with its mean and covariance then.
    dim = motion.dim
    mean, covariance = np.zeros(motion.prior.size), np.diag(motion.prior)
    moment = int(np.flatnonzero(report >= 0)[0])
    row = int(report[moment])
    if evidence.is_located(row):
        mean[:dim], covariance[:dim, :dim] = evidence.place(row)
        _take_out(readings, moment)
        return mean, covariance
    located = [k for k in np.flatnonzero(report >= 0) if evidence.is_located(int(report[k]))]
    if known is not None:
        time, place, spread = known[0], known[1][:dim], known[2][:dim, :dim]
    elif located:
        time = float(readings.time[located[0]])
        place, spread = evidence.place(int(report[located[0]]))
    else:
        time, place, spread = float(readings.time[0]), *_along(evidence, row)
    drift = motion.prior[dim] * (time - readings.time[0]) ** 2
    mean[:dim] = place
    covariance[:dim, :dim] = HOW_MUCH_WIDER**2 * spread + drift * np.eye(dim)
    return mean, covariance


def _take_out(readings: Readings, moment: int) -> None:
    """Leave of a report only its range rate, if it has one."""
    kind = MeasurementKind(int(readings.kind[moment]))
    if not kind.has_rate:
        readings.kind[moment] = -1
        return
    last = int(readings.width[moment]) - 1
    readings.kind[moment], readings.width[moment] = int(MeasurementKind.RANGE_RATE), 1
    readings.measurement[moment, 0] = readings.measurement[moment, last]
    readings.sigma[moment, 0] = readings.sigma[moment, last]


def _along(evidence: Evidence, row: int) -> tuple[FloatArray, FloatArray]:
    """Return a place halfway along a report's direction, which is all that is known of it."""
    dim, kind = evidence.dim, MeasurementKind(int(evidence.kind[row]))
    measured, place = evidence.measurement[row], evidence.platform[row, :dim].copy()
    half = FARTHEST / 2
    if kind is MeasurementKind.POSITION:
        place[: evidence.width[row]] = measured[: evidence.width[row]]
        return place, np.diag(np.r_[evidence.sigma[row, :2] ** 2, np.full(dim - 2, half**2)])
    azimuth = measured[0 if kind is MeasurementKind.BEARING else 1]
    distance = measured[0] if kind.has_range else half
    place[:2] += distance * np.array([np.sin(azimuth), np.cos(azimuth)])
    return place, np.eye(dim) * (distance / HOW_MUCH_WIDER) ** 2
