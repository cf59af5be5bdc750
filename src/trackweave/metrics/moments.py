"""Truth and tracks side by side at the truth's times."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.domain.tracks import CONFIRMED, TrackTable
from trackweave.domain.truth import TruthTable
from trackweave.errors import InvalidInputError
from trackweave.metrics._distances import distances

__all__ = ["Moment", "Moments", "Presence", "align", "usual_gap"]

# Times that were written to a file and read back may differ in the last digits.
SAME_TIME_S = 1e-6
PERIODS_OF_GAP = 1.5
# Pauses of a whole file are usual up to that which so much of the time, and so many of the
# intervals, lie in or below: a single long silence is neither.
SHARE_OF_TIME, SHARE_OF_INTERVALS = 0.95, 0.995


class Presence(NamedTuple):
    """Who was where: rows grouped by time, those of time k in ``first[k]:first[k + 1]``."""

    first: IntArray
    identity: IntArray
    position: FloatArray


class Moment(NamedTuple):
    """One time: who was there, and how far [m] each target was from each track.

    Examples
    --------
    >>> import trackweave as tw
    >>> from trackweave.metrics import align
    >>> truth = tw.TruthTable.from_columns([0, 0], ["A", "B"], [[0, 0], [50, 0]])
    >>> tracks = tw.TruthTable.from_columns([0], ["1"], [[3, 4]])
    >>> moment = next(iter(align(truth, tracks, None)))
    >>> moment.time, moment.distance.shape
    (0.0, (2, 1))
    """

    time: float
    targets: IntArray
    tracks: IntArray
    distance: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Moments:
    """Truth and tracks at the truth's times [s]; identifiers are replaced by numbers from 0.

    ``target_names`` and ``track_names`` are the identifiers as text, those of tracks also that
    live at none of the times.
    """

    time: FloatArray
    truth: Presence
    tracks: Presence
    target_names: tuple[str, ...]
    track_names: tuple[str, ...]

    @property
    def n_targets(self) -> int:
        """Number of different targets."""
        return len(self.target_names)

    @property
    def n_tracks(self) -> int:
        """Number of different tracks, also those that live at none of the times."""
        return len(self.track_names)

    def __len__(self) -> int:
        return len(self.time)

    def __iter__(self) -> Iterator[Moment]:
        for place, time in enumerate(self.time):
            true = slice(self.truth.first[place], self.truth.first[place + 1])
            tracked = slice(self.tracks.first[place], self.tracks.first[place + 1])
            yield Moment(
                float(time),
                self.truth.identity[true],
                self.tracks.identity[tracked],
                distances(self.truth.position[true], self.tracks.position[tracked]),
            )


class _Points(NamedTuple):
    """Rows of one side, sorted by identity, then time."""

    time: FloatArray
    identity: IntArray
    position: FloatArray
    names: tuple[str, ...]


def align(truth: TruthTable, tracks: TrackTable | TruthTable, max_gap: float | None) -> Moments:
    """Return truth and tracks at the truth's times.

    A track's position between two of its rows is interpolated linearly. Before its first and
    after its last row it is not there, nor in a gap that is too long. A gap in which no track has
    a row, although several live, is a pause of the whole file and may be longer than one in which
    others have rows.

    Parameters
    ----------
    truth
        Where targets were. Only its times count.
    tracks
        Rows of tracks in any order. Of a ``TrackTable`` only confirmed and coasting rows count;
        other tables with identifiers of any kind come as a ``TruthTable``, all of whose rows do.
    max_gap
        Longest time between two rows of a track that is bridged [s]; None for 1.5 times the
        tracks' own period, which is the interval between rows that half of all tracked time
        lies in or below, or 1.5 times the file's usual pause where the file pauses.

    Returns
    -------
    Both sides at each time.

    Raises
    ------
    InvalidInputError
        If the dimensions differ, or the gap is negative or not a number.

    Examples
    --------
    >>> import trackweave as tw
    >>> from trackweave.metrics import align
    >>> truth = tw.TruthTable.from_columns([0, 1, 2], ["A"] * 3, [[0, 0], [10, 0], [20, 0]])
    >>> tracks = tw.TruthTable.from_columns([0, 2], ["1", "1"], [[3, 4], [23, 4]])
    >>> [moment.distance.tolist() for moment in align(truth, tracks, max_gap=2.0)]
    [[[5.0]], [[5.0]], [[5.0]]]
    """
    points = _points(tracks)
    if len(truth) and points.time.size and truth.dim != points.position.shape[1]:
        raise InvalidInputError(
            f"tracks: {points.position.shape[1]} dimensions; expected {truth.dim}, as truth has"
        )
    if max_gap is not None and not max_gap >= 0:
        raise InvalidInputError(f"max_gap: {max_gap}; expected at least 0 seconds")
    times = np.unique(truth.time)
    targets, codes = np.unique(truth.target.astype(str), return_inverse=True)
    true = _grouped(
        np.searchsorted(times, truth.time), codes.reshape(-1), truth.position, times.size
    )
    tracked = _interpolated(points, times, _longest_gaps(points, max_gap))
    return Moments(times, true, tracked, tuple(targets.tolist()), points.names)


def _points(tracks: TrackTable | TruthTable) -> _Points:
    """Return the rows that count, one per identity and time (the last where there are several)."""
    time: FloatArray
    names: np.ndarray[Any, Any]
    if isinstance(tracks, TrackTable):
        counts = np.flatnonzero(tracks.status >= CONFIRMED)
        time, names = tracks.time[counts], tracks.track[counts]
        position = tracks.mean[counts, : tracks.dim]
    else:
        time, names, position = tracks.time, tracks.target.astype(str), tracks.position
    unique, codes = np.unique(names, return_inverse=True)
    codes = codes.reshape(-1)
    order = np.lexsort((time, codes))
    time, codes, position = time[order], codes[order], position[order]
    last = np.append(
        (np.diff(time) != 0) | (np.diff(codes) != 0), np.ones(min(1, time.size), bool)
    )
    return _Points(
        time[last], codes[last], position[last], tuple(str(name) for name in unique.tolist())
    )


def usual_gap(time: FloatArray, identity: IntArray) -> float:
    """Return the longest gap that is bridged [s]: 1.5 times the usual interval, 0 without any."""
    # Usual is what half of all time lies in or below. Times are sorted by identity, then time.
    # The median is weighted by time: three radars that take turns within a tenth of a second and
    # then rest for four seconds have a period of four seconds, not of a tenth.
    gaps = np.diff(time)[np.diff(identity) == 0]
    if gaps.size == 0:
        return 0.0
    gaps = np.sort(gaps)
    covered = np.cumsum(gaps)
    usual = gaps[np.searchsorted(covered, covered[-1] / 2)]
    return PERIODS_OF_GAP * float(usual)


def _longest_gaps(points: _Points, max_gap: float | None) -> FloatArray:
    """Return for each row how long a gap before it is bridged [s]."""
    if max_gap is not None:
        return np.full(points.time.size, max_gap)
    longest = np.full(points.time.size, usual_gap(points.time, points.identity))
    moments = np.unique(points.time)
    if len(points.names) < 2 or moments.size < 2:
        return longest
    # Where only one track lives, its dropouts look like pauses of the file.
    bounds = np.searchsorted(points.identity, np.arange(len(points.names) + 1))
    born, gone = np.sort(points.time[bounds[:-1]]), np.sort(points.time[bounds[1:] - 1])
    begin = moments[:-1]
    lives = np.searchsorted(born, begin, "right") - np.searchsorted(gone, begin, "right")
    intervals = np.diff(moments)
    pause = PERIODS_OF_GAP * _usual_pause(np.sort(intervals[lives >= 2]))
    place = np.searchsorted(moments, points.time)
    follows = np.zeros(points.time.size, dtype=np.bool_)
    follows[1:] = (np.diff(points.identity) == 0) & (np.diff(place) == 1)
    silent = follows & (lives[np.maximum(place - 1, 0)] >= 2)
    longest[silent] = np.maximum(longest[silent], pause)
    return longest


def _usual_pause(intervals: FloatArray) -> float:
    """Return the longest usual one of a file's intervals [s], which come in ascending order."""
    if intervals.size == 0:
        return 0.0
    covered = np.cumsum(intervals)
    of_time = int(np.searchsorted(covered, covered[-1] * SHARE_OF_TIME))
    of_intervals = int((intervals.size - 1) * SHARE_OF_INTERVALS)
    return float(intervals[min(of_time, of_intervals)])


def _interpolated(points: _Points, times: FloatArray, longest: FloatArray) -> Presence:
    dim = points.position.shape[1]
    when, who = [np.empty(0, dtype=np.int64)], [np.empty(0, dtype=np.int64)]
    where = [np.empty((0, dim))]
    bounds = np.searchsorted(points.identity, np.arange(len(points.names) + 1))
    for number in range(len(points.names)):
        rows = slice(bounds[number], bounds[number + 1])
        own, position, bridged = points.time[rows], points.position[rows], longest[rows]
        begin = np.searchsorted(times, own[0] - SAME_TIME_S, side="left")
        end = np.searchsorted(times, own[-1] + SAME_TIME_S, side="right")
        inside = np.arange(begin, end)
        after = np.minimum(np.searchsorted(own, times[inside]), own.size - 1)
        before = np.maximum(after - 1, 0)
        gap = own[after] - own[before]
        lapse = np.clip(times[inside] - own[before], 0.0, gap)
        share = np.divide(lapse, gap, out=np.zeros_like(gap), where=gap > 0)
        at_row = np.minimum(
            np.abs(times[inside] - own[before]), np.abs(times[inside] - own[after])
        )
        known = (gap <= bridged[after] + SAME_TIME_S) | (at_row <= SAME_TIME_S)
        step = share[known, None] * (position[after[known]] - position[before[known]])
        when.append(inside[known])
        who.append(np.full(int(known.sum()), number))
        where.append(position[before[known]] + step)
    return _grouped(np.concatenate(when), np.concatenate(who), np.concatenate(where), times.size)


def _grouped(moment: IntArray, identity: IntArray, position: FloatArray, n_times: int) -> Presence:
    order = np.lexsort((identity, moment))
    first = np.searchsorted(moment[order], np.arange(n_times + 1))
    return Presence(first, identity[order], position[order])
