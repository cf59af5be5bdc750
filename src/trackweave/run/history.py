"""Tracks after the fact: final assignments, smoothed over all their reports.

Models from outside the package are called once for all tracks at the first moment of each, then
at the second, and so on; and back from the last moment of each in the same way.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TypeAlias

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.config.fill import Settings
from trackweave.domain.foreign_kind import FOREIGN, ForeignKind
from trackweave.domain.reports import ReportTable
from trackweave.domain.tracks import COASTING, CONFIRMED, TENTATIVE, TrackTable
from trackweave.filters._rows import let_back_rows, receive_rows
from trackweave.filters.foreign import States, advanced, foreseen, taken_in
from trackweave.filters.smoother import Course, Readings, gone_back, merged, smoothed
from trackweave.models.foreign_motion import ForeignMotion
from trackweave.models.motion import MotionRule
from trackweave.run.batches import hearing_in
from trackweave.run.beginnings import Evidence, begun, first_state, readings_of
from trackweave.run.scans import scan_ends

__all__ = ["Smoothing", "shown_times", "smoothed_at", "smoothed_history", "smoothed_together"]

ASTRAY, MOSTLY = 30.0, 0.25
"""A track is astray of which this part is so many standard deviations from where it was known."""

Way = tuple[MotionRule, ForeignMotion | None]
Smoothing: TypeAlias = Callable[
    [ReportTable, Mapping[int, int], TrackTable, Settings, TrackTable | None], TrackTable
]
"""What `smoothed_history` does, wherever it is done."""


@dataclass(slots=True)
class _Track:
    """One track's readings, the report of each moment, and its states after each."""

    readings: Readings
    report: IntArray
    course: Course
    # Of a motion from outside: what was foreseen for each moment, and by which slope.
    ahead: list[tuple[FloatArray, FloatArray, FloatArray]] = field(default_factory=list)

    @property
    def length(self) -> int:
        return int(self.readings.time.shape[0])

    def state(self, moment: int) -> tuple[FloatArray, ...]:
        """Return the state after a moment's report."""
        return tuple(column[moment] for column in self.course)


def smoothed_together(
    evidence: Evidence,
    read: Sequence[tuple[Readings, IntArray]],
    starts: Sequence[tuple[FloatArray, FloatArray]],
    motion: Way,
) -> list[tuple[FloatArray, FloatArray]]:
    """Return each track's means and covariances, by moment, given all of its reports."""
    # ``read`` are the readings of each track and the row of the report of each moment, ``starts``
    # the states before their first reports.
    tracks = [_begun(*each, start, motion[0]) for each, start in zip(read, starts, strict=True)]
    for step in range(max(track.length for track in tracks)):
        active = [track for track in tracks if track.length > step]
        if step:
            _advance(active, step, motion)
        _receive(active, step, evidence, motion[0])
    if motion[1] is None:
        for track in tracks:
            gone_back(track.readings.time, motion[0], track.course)
    else:
        _back(tracks)
    return [merged(track.course) for track in tracks]


def _begun(
    readings: Readings, report: IntArray, start: tuple[FloatArray, FloatArray], rule: MotionRule
) -> _Track:
    length, modes, size = readings.time.shape[0], rule.kind.shape[0], rule.prior.shape[0]
    course = Course(
        np.empty((length, modes, size)),
        np.empty((length, modes, size, size)),
        np.empty((length, modes)),
    )
    course.mean[0], course.covariance[0], course.weight[0] = *start, rule.share
    return _Track(readings, report, course)


def _gathered(tracks: Sequence[_Track], moments: Sequence[int]) -> States:
    """Return copies of the tracks' states at a moment each."""
    rows = [track.state(moment) for track, moment in zip(tracks, moments, strict=True)]
    return States(*(np.stack(column) for column in zip(*rows, strict=True)))


def _advance(active: Sequence[_Track], step: int, motion: Way) -> None:
    """Write the states before a moment's reports."""
    rule, way = motion
    interval = np.array([t.readings.time[step] - t.readings.time[step - 1] for t in active])
    states = _gathered(active, [step - 1] * len(active))
    if way is None:
        ahead = advanced(states, interval, rule, None)
    else:
        ahead = States(*(column.copy() for column in states))
        slope = np.tile(np.eye(states.mean.shape[2]), (len(active), 1, 1))
        moving = np.flatnonzero(interval != 0.0)
        if moving.size:
            ahead.mean[moving, 0], ahead.covariance[moving, 0], slope[moving] = way.predict(
                states.mean[moving, 0], states.covariance[moving, 0], interval[moving]
            )
        for row, track in enumerate(active):
            track.ahead.append((ahead.mean[row, 0], ahead.covariance[row, 0], slope[row]))
    _write(active, step, ahead)


def _write(tracks: Sequence[_Track], step: int, states: States) -> None:
    for row, track in enumerate(tracks):
        for column, value in zip(track.course, states, strict=True):
            column[step] = value[row]


def _receive(active: Sequence[_Track], step: int, evidence: Evidence, rule: MotionRule) -> None:
    """Take each track's report of a moment into its state."""
    ours = [track for track in active if 0 <= track.readings.kind[step] != FOREIGN]
    if ours:
        readings = Readings(
            *(
                np.stack([getattr(t.readings, name)[step] for t in ours])
                for name in Readings._fields
            )
        )
        states = _gathered(ours, [step] * len(ours))
        receive_rows(readings, rule, *states)
        _write(ours, step, states)
    for kind, some in _by_kind(active, step, evidence):
        rows = np.array([track.report[step] for track in some])
        states = _gathered(some, [step] * len(some))
        seen = foreseen(kind, states, evidence.platform[rows], evidence.reported(rows))
        _write(some, step, taken_in(states, seen))


def _by_kind(
    active: Sequence[_Track], step: int, evidence: Evidence
) -> Iterator[tuple[ForeignKind, list[_Track]]]:
    """Yield the tracks that have a report of a kind from outside, sensor by sensor."""
    own = [track for track in active if track.readings.kind[step] == FOREIGN]
    of = [int(evidence.sensor[track.report[step]]) for track in own]
    for sensor in sorted(set(of)):
        kind = evidence.kinds[sensor]
        if isinstance(kind, ForeignKind):
            yield kind, [t for t, number in zip(own, of, strict=True) if number == sensor]


def _back(tracks: Sequence[_Track]) -> None:
    """Let what later moments know into the earlier ones, of one mode of motion."""
    for step in range(1, max(track.length for track in tracks)):
        active = [track for track in tracks if track.length > step]
        early = [track.length - 1 - step for track in active]
        now = _gathered(active, early)
        later = _gathered(active, [moment + 1 for moment in early])
        known = [track.ahead[moment] for track, moment in zip(active, early, strict=True)]
        ahead_mean, ahead, slope = (np.stack(column) for column in zip(*known, strict=True))
        mean, covariance = now.mean[:, 0].copy(), now.covariance[:, 0].copy()
        cross = np.ascontiguousarray(covariance @ slope.swapaxes(1, 2))
        let_back_rows(
            cross, ahead_mean, ahead, later.mean[:, 0].copy(), later.covariance[:, 0].copy(),
            mean, covariance,
        )  # fmt: skip
        for row, (track, moment) in enumerate(zip(active, early, strict=True)):
            if track.readings.time[moment] == track.readings.time[moment + 1]:
                # At one instant, what is known then is known before.
                mean[row], covariance[row] = later.mean[row, 0], later.covariance[row, 0]
            track.course.mean[moment, 0] = mean[row]
            track.course.covariance[moment, 0] = covariance[row]


@dataclass(frozen=True, slots=True, eq=False)
class _Path:
    """One track's moments: its reports' own times and the ends of scans, at which it is shown."""

    track: int
    time: FloatArray
    report: IntArray
    shown: IntArray
    start: tuple[FloatArray, FloatArray] | None


def smoothed_history(
    reports: ReportTable,
    assignment: Mapping[int, int],
    tracks: TrackTable,
    settings: Settings,
    priors: TrackTable | None = None,
) -> TrackTable:
    """Return every track at every scan between its first and last report, by time, then track."""
    times = shown_times(reports, tracks, settings)
    return smoothed_at((reports, assignment, tracks), times, settings, priors)


def smoothed_at(
    found: tuple[ReportTable, Mapping[int, int], TrackTable],
    times: tuple[FloatArray, FloatArray],
    settings: Settings,
    priors: TrackTable | None = None,
) -> TrackTable:
    """Return the history of tracks, which may be a part of those that have such `shown_times`."""
    (reports, assignment, tracks), (ends, moments) = found, times
    # Where rows are wanted once in a period only, at those between the two, or at the last report.
    # Each state is conditioned on all of the track's reports, later ones included. Status and
    # score are taken from the tracks as they were known scan by scan.
    rule = settings.motion.rule(reports.dim, unscented=settings.unscented)
    motion = rule, settings.motion if isinstance(settings.motion, ForeignMotion) else None
    evidence = Evidence.of(reports, settings.sensors)
    paths, first_rows = (
        list(_paths(evidence, (ends, moments), assignment, priors)),
        _first_rows(tracks),
    )
    begun_from = {path.track: _state(tracks, first_rows.get(path.track)) for path in paths}
    states = _states(evidence, paths, begun_from, motion)
    parts = [
        _table(path, (ends, settings.period), each, rule)
        for path, each in zip(paths, states, strict=True)
    ]
    table = TrackTable.concatenate(parts, reports.dim)
    if any(sensor.measurement.is_bearing_only for sensor in settings.sensors):
        table = _not_astray(table, tracks)
    table = _with_status(table, tracks)
    return table.at(np.lexsort((table.track, table.time)))


def shown_times(
    reports: ReportTable, tracks: TrackTable, settings: Settings
) -> tuple[FloatArray, FloatArray]:
    """Return when each report's scan ended, and the moments at which tracks are shown [s]."""
    ends = scan_ends(
        reports,
        {s.name: s.rotation for s in settings.sensors if s.rotation is not None},
        hearing_in(settings.sensors),
    )
    if settings.period is not None and len(tracks):
        return ends, np.unique(tracks.time)
    return ends, np.unique(np.concatenate([tracks.time, ends]))


def _states(
    evidence: Evidence,
    paths: list[_Path],
    known: Mapping[int, tuple[float, FloatArray, FloatArray] | None],
    motion: tuple[MotionRule, ForeignMotion | None],
) -> Iterator[tuple[FloatArray, FloatArray]]:
    """Yield the states of each path, by moment; ``known`` is where each track was first shown."""
    rule, way = motion
    has_foreign = way is not None or any(isinstance(k, ForeignKind) for k in evidence.kinds)
    read, starts = [], []
    for path in paths:
        readings = readings_of(evidence, path.time, path.report)
        if path.start is None:
            start = first_state(evidence, readings, path.report, motion, known[path.track])
        else:
            start = _widened(path.start, motion)
        if not has_foreign:
            yield merged(smoothed(readings, start, rule))
            continue
        read.append((readings, path.report))
        starts.append(start)
    for states in smoothed_together(evidence, read, starts, motion) if read else ():
        yield states if way is None else way.shown(*states, rule.dim)


def _paths(
    evidence: Evidence,
    times: tuple[FloatArray, FloatArray],
    assignment: Mapping[int, int],
    priors: TrackTable | None,
) -> Iterator[_Path]:
    """Yield the moments of each track, by the tracks' numbers."""
    # ``times`` are the ends of the reports' scans, and the moments at which tracks are shown.
    ends, moments = times
    # Reports of a turning sensor have their own times; all others count at their scan's end.
    own = np.where(evidence.turning, evidence.time, ends)
    rows_of: dict[int, list[int]] = {}
    for row, track in assignment.items():
        rows_of.setdefault(track, []).append(row)
    begun = {} if priors is None else {int(track): k for k, track in enumerate(priors.track)}
    for track in sorted(rows_of):
        rows = np.array(sorted(rows_of[track]), dtype=np.int64)
        first, last = ends[rows].min(), ends[rows].max()
        begin, end = np.searchsorted(moments, first), np.searchsorted(moments, last, "right")
        shown = moments[begin:end] if end > begin else np.array([last])
        time = np.concatenate([own[rows], shown])
        report = np.concatenate([rows, np.full(shown.size, -1, dtype=np.int64)])
        is_shown = np.repeat([0, 1], [rows.size, shown.size])
        prior, start = begun.get(track), None
        if prior is not None and priors is not None and priors.time[prior] <= time.min():
            time, report = np.r_[priors.time[prior], time], np.r_[-1, report]
            is_shown = np.r_[0, is_shown]
            start = priors.mean[prior], priors.covariance[prior]
        order = np.argsort(time, kind="stable")
        yield _Path(track, time[order], report[order], is_shown[order], start)


def _state(tracks: TrackTable, row: int | None) -> tuple[float, FloatArray, FloatArray] | None:
    """Return when and where a row says that a track is; None for no row."""
    if row is None:
        return None
    return float(tracks.time[row]), tracks.mean[row], tracks.covariance[row]


def _first_rows(tracks: TrackTable) -> dict[int, int]:
    """Return the row in which the tracker first showed each track."""
    order = np.lexsort((tracks.time, tracks.track))
    names, first = np.unique(tracks.track[order], return_index=True)
    return dict(zip(names.tolist(), order[first].tolist(), strict=True))


def _widened(
    start: tuple[FloatArray, FloatArray], motion: tuple[MotionRule, ForeignMotion | None]
) -> tuple[FloatArray, FloatArray]:
    """Return a state of positions and velocities with room for what else the motion has."""
    dim, size = motion[0].dim, start[0].size
    if motion[1] is not None and motion[1].has_kinematics:
        size = 0
    mean, covariance = begun(*motion, start[0][:dim], start[1][:dim, :dim])
    covariance[:size], covariance[:, :size] = 0.0, 0.0
    mean[:size], covariance[:size, :size] = start[0][:size], start[1][:size, :size]
    return mean, covariance


def _table(
    path: _Path,
    times: tuple[FloatArray, float | None],
    states: tuple[FloatArray, FloatArray],
    motion: MotionRule,
) -> TrackTable:
    """Return one row per moment at which a track is shown."""
    # ``times`` are the ends of the reports' scans, and the period between rows, if any. A track is
    # confirmed where it has a report since the row before, or at it.
    (ends, period), (mean, covariance) = times, states
    kept = np.flatnonzero(path.shown)
    taken = path.report >= 0
    size, at = 2 * motion.dim, motion.acceleration_at
    time = path.time[kept]
    known = np.sort(ends[path.report[taken]])
    since = time if period is None else np.nextafter(time - period, np.inf)
    seen = np.searchsorted(known, time, "right") > np.searchsorted(known, since)
    update = np.maximum.accumulate(np.where(taken, path.time, -np.inf))
    return TrackTable(
        time=time,
        track=np.full(kept.size, path.track, dtype=np.int64),
        status=np.where(seen, CONFIRMED, COASTING).astype(np.int64),
        mean=np.ascontiguousarray(mean[kept, :size]),
        covariance=np.ascontiguousarray(covariance[kept, :size, :size]),
        score=np.full(kept.size, np.nan),
        hits=np.cumsum(taken)[kept].astype(np.int64),
        last_update=update[kept],
        acceleration=mean[kept, at : at + motion.dim] if at > 0 else np.empty((kept.size, 0)),
    )


def _not_astray(table: TrackTable, tracks: TrackTable) -> TrackTable:
    """Return a history in which tracks that went astray are as they were known then."""
    # A filter that sets out anew along a bearing may settle kilometres from where crossing
    # bearings had put the object, and is as sure of it.
    order = np.lexsort((tracks.time, tracks.track))
    mean, covariance = table.mean.copy(), table.covariance.copy()
    for track in np.unique(table.track).tolist():
        rows, known = np.flatnonzero(table.track == track), order[tracks.track[order] == track]
        if not known.size:
            continue
        before = np.searchsorted(tracks.time[known], table.time[rows], "right") - 1
        then = known[np.maximum(before, 0)]
        is_same = tracks.time[then] == table.time[rows]
        off = np.linalg.norm((mean[rows] - tracks.mean[then])[:, : table.dim], axis=1)
        spread = np.trace(tracks.covariance[then, : table.dim, : table.dim], axis1=1, axis2=2)
        is_astray = off[is_same] > ASTRAY * np.sqrt(spread[is_same])
        if is_astray.size and np.mean(is_astray) > MOSTLY:
            mean[rows], covariance[rows] = tracks.mean[then], tracks.covariance[then]
    return replace(table, mean=mean, covariance=covariance)


def _with_status(table: TrackTable, tracks: TrackTable) -> TrackTable:
    """Enter what is known of each track in the end: whether it was believed, and its score."""
    confirmed = np.unique(tracks.track[tracks.status >= CONFIRMED])
    order = np.lexsort((tracks.time, tracks.track))
    names, first = np.unique(tracks.track[order], return_index=True)
    last = order[np.r_[first[1:], order.size] - 1] if order.size else order
    place = np.clip(np.searchsorted(names, table.track), 0, max(names.size - 1, 0))
    score = table.score.copy()
    if names.size:
        known = names[place] == table.track
        score[known] = tracks.score[last[place[known]]]
    status = np.where(np.isin(table.track, confirmed), table.status, TENTATIVE)
    return replace(table, status=status.astype(np.int64), score=score)
