"""Reports that may be of two objects at once, because their sensor could not tell them apart."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.domain.foreign_kind import ForeignKind
from trackweave.domain.reports import ReportTable
from trackweave.domain.tracks import CONFIRMED, TrackTable
from trackweave.models._kernels import is_covered
from trackweave.models.measurements import to_position
from trackweave.models.sensors import Sensor
from trackweave.run.batches import hearing_in
from trackweave.run.beginnings import Evidence
from trackweave.run.scans import scan_ends

__all__ = ["merged_reports"]

# Two objects nearer than so many standard deviations of a report are taken for one.
RESOLUTION_SIGMAS = 2.0
# More tracks near a report along x than so many are a crowd, and it is not looked at.
MOST_NEAR = 200


class _Pairs(NamedTuple):
    """Reports and other tracks near them: rows of the reports, and of the history."""

    report: IntArray
    other: IntArray
    squared: FloatArray
    """Distance of both tracks, in standard deviations of the report, squared."""

    def kept(self, which: Any) -> "_Pairs":
        return _Pairs(self.report[which], self.other[which], self.squared[which])


def merged_reports(
    reports: ReportTable,
    assignment: Mapping[int, int],
    history: TrackTable,
    sensors: Sequence[Sensor],
    within: float | None = None,
) -> dict[int, int]:
    """Return the rows, ascending, of reports that may be of two tracks, and the second of each."""
    # Such a report is one of a sensor that scans and tells positions; it belongs to a confirmed
    # track, and at its scan another confirmed track is as near to that one as the sensor's noise
    # lets two objects be confused, within the field of view, and has no report of that scan.
    # Assignment and history are those after all amendments; the history is smoothed, and tells
    # where tracks were at the end of each scan. The second is the nearest track that shares no
    # other report of that time; -1 where none is left. Where it is told within how many metres
    # objects are one report, that stands for the sensor's noise.
    evidence = Evidence.of(reports, sensors)
    by_name = {sensor.name: sensor for sensor in sensors}
    own = [by_name[name] for name in reports.sensors]
    turning = {each.name: each.rotation for each in own if each.rotation is not None}
    ends = scan_ends(reports, turning, hearing_in(own))
    known = _confirmed(history)
    rows = _rows_that_may_merge(reports, assignment, evidence, own)
    if rows.size == 0 or len(known) == 0:
        return {}
    track = np.array([assignment[row] for row in rows.tolist()])
    rows, at = _shown(known, rows, track, ends)
    noise = _noise(reports, evidence, rows)
    if within is not None:
        noise[:] = np.eye(evidence.dim) * (within / RESOLUTION_SIGMAS) ** 2
    pairs = _near(known, rows, at, noise)
    pairs = pairs.kept(_in_view(pairs, known, reports, own))
    seen = _has_report(pairs, known, reports, (assignment, ends, own))
    return _seconds(pairs.kept(~seen), known)


def _confirmed(history: TrackTable) -> TrackTable:
    """Return the rows of tracks that were ever confirmed, by time, then track."""
    rows = np.flatnonzero(history.status >= CONFIRMED)
    rows = rows[np.lexsort((history.track[rows], history.time[rows]))]
    return history.at(rows)


def _rows_that_may_merge(
    reports: ReportTable, assignment: Mapping[int, int], evidence: Evidence, own: list[Sensor]
) -> IntArray:
    """Return the assigned reports of sensors that scan and tell where objects are."""
    scanning = np.zeros(len(own), dtype=np.bool_)
    for number, sensor in enumerate(own):
        some = np.flatnonzero(reports.sensor == number)[:1]
        scans = sensor.scan_period is not None or sensor.rotation is not None
        if scans and some.size:
            scanning[number] = evidence.is_located(int(some[0]))
    rows = np.array(sorted(assignment), dtype=np.int64)
    scanning &= [not isinstance(sensor.measurement, ForeignKind) for sensor in own]
    return rows[scanning[reports.sensor[rows]]]


def _shown(
    known: TrackTable, rows: IntArray, track: IntArray, ends: FloatArray
) -> tuple[IntArray, IntArray]:
    """Return the reports whose track is shown at their scan's end, and its row there."""
    times = np.unique(known.time)
    names = np.unique(known.track)
    key = np.searchsorted(times, known.time) * names.size + np.searchsorted(names, known.track)
    moment = np.searchsorted(times, ends[rows]).clip(max=times.size - 1)
    name = np.searchsorted(names, track).clip(max=names.size - 1)
    place = np.searchsorted(key, moment * names.size + name).clip(max=key.size - 1)
    found = (known.time[place] == ends[rows]) & (known.track[place] == track)
    return rows[found], place[found]


def _noise(reports: ReportTable, evidence: Evidence, rows: IntArray) -> FloatArray:
    """Return the covariance of each report's position [m²]."""
    noise = np.empty((rows.size, evidence.dim, evidence.dim))
    for number in range(len(reports.sensors)):
        mine = np.flatnonzero(reports.sensor[rows] == number)
        chosen, width = rows[mine], reports.kind_of(number).n_components(evidence.dim)
        if mine.size:
            _, noise[mine] = to_position(
                reports.kind_of(number),
                evidence.measurement[chosen, :width],
                evidence.sigma[chosen, :width],
                evidence.platform[chosen],
                evidence.dim,
            )
    return noise


def _near(known: TrackTable, rows: IntArray, at: IntArray, noise: FloatArray) -> _Pairs:
    """Return the other tracks within the resolution of each report's track, at its time."""
    reach = RESOLUTION_SIGMAS * np.sqrt(np.linalg.eigvalsh(noise)[:, -1])
    position = known.mean[:, : known.dim]
    # Along one line, times out of each other's reach, so that one order serves all.
    moment = np.unique(known.time, return_inverse=True)[1].reshape(-1)
    span = np.ptp(position[:, 0]) + 4.0 * reach.max(initial=1.0)
    line = position[:, 0] - position[:, 0].min() + span * moment
    order = np.argsort(line, kind="stable")
    reach = reach + 1e-12 * line.max()
    first = np.searchsorted(line[order], line[at] - reach)
    count = np.searchsorted(line[order], line[at] + reach, side="right") - first
    # Of a report among a crowd of tracks nobody can say whose it is too.
    few = count <= MOST_NEAR
    rows, at, noise, first, count = rows[few], at[few], noise[few], first[few], count[few]
    report = np.repeat(np.arange(rows.size), count)
    within = np.arange(report.size) - np.repeat(np.cumsum(count) - count, count)
    other = order[first[report] + within]
    apart = position[other] - position[at[report]]
    squared = np.einsum("ri,rij,rj->r", apart, np.linalg.inv(noise)[report], apart)
    is_near = (other != at[report]) & (squared <= RESOLUTION_SIGMAS**2)
    return _Pairs(rows[report[is_near]], other[is_near], squared[is_near])


def _in_view(pairs: _Pairs, known: TrackTable, reports: ReportTable, own: list[Sensor]) -> Any:
    """Return which other tracks the sensor could see."""
    inside = np.ones(pairs.report.size, dtype=np.bool_)
    for place, (row, other) in enumerate(zip(pairs.report, pairs.other, strict=True)):
        view = own[reports.sensor[row]].field_of_view
        if view is None:
            continue
        coverage = view.coverage()
        if reports.platform is not None and not np.isnan(reports.platform[row, 0]):
            coverage = coverage._replace(position=reports.platform[row, :2].copy())
        inside[place] = is_covered(known.mean[other, 0], known.mean[other, 1], coverage)
    return inside


def _has_report(
    pairs: _Pairs,
    known: TrackTable,
    reports: ReportTable,
    run: tuple[Mapping[int, int], FloatArray, list[Sensor]],
) -> Any:
    """Return which other tracks have a report of the same scan, or turn, of the same sensor."""
    assignment, ends, own = run
    wait = np.array([0.0 if s.rotation is None else s.rotation.period / 2 for s in own])
    # Half a turn before and after: sectors of a turn come one by one.
    when = np.where(wait[reports.sensor] > 0, reports.time, ends)
    rows = np.array(sorted(assignment), dtype=np.int64)
    track = np.array([assignment[row] for row in rows.tolist()], dtype=np.int64)
    of = track * len(own) + reports.sensor[rows]
    order = np.argsort(of, kind="stable")
    of, moment = of[order], when[rows[order]]
    sensor, then = reports.sensor[pairs.report], when[pairs.report]
    wanted = known.track[pairs.other] * len(own) + sensor
    seen = np.zeros(pairs.report.size, dtype=np.bool_)
    first, last = np.searchsorted(of, wanted), np.searchsorted(of, wanted, "right")
    for place in np.flatnonzero(last > first).tolist():
        there = moment[first[place] : last[place]]
        seen[place] = bool(np.any(np.abs(there - then[place]) <= wait[sensor[place]]))
    return seen


def _seconds(pairs: _Pairs, known: TrackTable) -> dict[int, int]:
    """Return each report's second track: the nearest pairs first, nobody twice at a time."""
    found: dict[int, int] = dict.fromkeys(np.unique(pairs.report).tolist(), -1)
    taken = set[int]()
    for place in np.argsort(pairs.squared, kind="stable").tolist():
        report, other = int(pairs.report[place]), int(pairs.other[place])
        if found[report] < 0 and other not in taken:
            found[report] = int(known.track[other])
            taken.add(other)
    return found
