"""Tracks smoothed all at once, where motion or measurement is from outside the package.

Each model is called once for all tracks at the first moment of each, then at the second, and so
on; and back from the last moment of each in the same way.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.domain.foreign_kind import FOREIGN, ForeignKind
from trackweave.filters._rows import let_back_rows, receive_rows
from trackweave.filters.foreign import States, advanced, foreseen, taken_in
from trackweave.filters.smoother import Course, Readings, gone_back, merged
from trackweave.models.foreign_motion import ForeignMotion
from trackweave.models.motion import MotionRule
from trackweave.run.beginnings import Evidence

__all__ = ["smoothed_together"]

Way = tuple[MotionRule, ForeignMotion | None]


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
