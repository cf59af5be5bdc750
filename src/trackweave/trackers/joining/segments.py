"""Tracks of a finished record cut at their long silences, and how each piece moves."""

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trackweave.arrays import FloatArray, IntArray
from trackweave.domain.tracks import TrackTable

__all__ = ["FIRM", "Paths", "Segments", "segments_of"]

USUAL, LONG = 0.9, 4.0
"""Of the waits between a track's reports this share is usual; a silence that lasts so many times
as long is a long one. Where several objects report in bursts, a median would tell nothing."""
FIRM = 8
"""So many reports show that a segment is an object's, and how it moves."""
SPEED_STATES, SPEED_TELLS = 30, 5.0
"""Over how many states a speed is averaged, and from how many on that makes it better known."""


@dataclass(frozen=True, slots=True, eq=False)
class Segments:
    """Pieces of tracks between long silences, by track and time; columns of shape (segments,)."""

    track: IntArray
    begin: FloatArray
    """When its first report was [s]."""
    end: FloatArray
    """When its last report was [s]."""
    count: IntArray
    """Number of its reports; those of one moment are one."""
    interval: FloatArray
    """How far reports of its track usually are apart [s]."""
    before: IntArray
    """The segment of the same track before it, -1 for none."""

    def __len__(self) -> int:
        return int(self.track.shape[0])

    @property
    def is_firm(self) -> NDArray[np.bool_]:
        """Whether there are enough reports to be sure of an object."""
        return self.count >= FIRM


def segments_of(
    track: IntArray, time: FloatArray, kept: Collection[int]
) -> tuple[Segments, IntArray]:
    """Return the segments of some tracks, and the segment of each report, -1 for none.

    Parameters
    ----------
    track
        The track of each report, -1 for none.
    time
        When each was [s], ascending.
    kept
        The tracks to cut, each of which has a report.

    Returns
    -------
    The segments, and one number for each report.
    """
    rows = np.flatnonzero(np.isin(track, list(kept)))
    rows = rows[np.argsort(track[rows], kind="stable")]
    owner, when = track[rows], time[rows]
    wait = np.diff(when, prepend=-np.inf)
    begins = np.diff(owner, prepend=-1) != 0
    names = np.unique(owner)
    later = ~begins & (wait > 0.0)
    usual = float(np.median(wait[later])) if later.any() else np.inf
    interval = _usual(np.searchsorted(names, owner[later]), wait[later], names.size, usual)
    pace = interval[np.searchsorted(names, owner)]
    cut = begins | (wait > LONG * pace)
    first = np.flatnonzero(cut)
    number = np.cumsum(cut) - 1
    of = np.full(track.shape[0], -1, dtype=np.int64)
    of[rows] = number
    segments = Segments(
        track=owner[first],
        begin=when[first],
        end=np.maximum.reduceat(when, first),
        count=np.add.reduceat((cut | (wait > 0.0)).astype(np.int64), first),
        interval=pace[first],
        before=np.where(begins[first], -1, np.arange(first.size) - 1),
    )
    return segments, of


def _usual(track: IntArray, wait: FloatArray, count: int, of_all: float) -> FloatArray:
    """Return how far each track's reports usually are apart; of a few, nothing tells that."""
    # All quantiles at once, each between its two neighbours in order.
    wait = wait[np.lexsort((wait, track))]
    n_waits = np.bincount(track, minlength=count)
    begin = np.cumsum(n_waits) - n_waits
    place = USUAL * np.maximum(n_waits - 1, 0)
    below = place.astype(np.int64)
    padded = np.r_[wait, 0.0]
    low = padded[begin + below]
    high = padded[begin + np.minimum(below + 1, np.maximum(n_waits - 1, 0))]
    longest = np.where(n_waits > 0, padded[begin + np.maximum(n_waits - 1, 0)], 0.0)
    usual: FloatArray = np.where(
        n_waits > 2, low + (place - below) * (high - low), np.maximum(of_all, longest)
    )
    return usual


class Paths:
    """Smoothed states of all segments, by segment and time, and how fast they were about then."""

    def __init__(self, states: TrackTable) -> None:
        # ``states.track`` numbers the segments from 0, each of which has a state.
        self.states = states.at(np.lexsort((states.time, states.track)))
        own = self.states.track
        self.first = np.flatnonzero(np.diff(own, prepend=-1))
        self.last = np.r_[self.first[1:], len(own)] - 1
        dim = states.dim
        moving = self.states.mean[:, dim:]
        unsure = np.trace(self.states.covariance[:, dim:, dim:], axis1=1, axis2=2)
        row = np.arange(len(own))
        before = np.maximum(row - SPEED_STATES, self.first[own])
        after = np.minimum(row + SPEED_STATES, self.last[own])
        squares = np.sum(moving**2, axis=1)
        self._until = _speed(squares, unsure, before, row)
        self._from = _speed(squares, unsure, row, after)

    @property
    def dim(self) -> int:
        """Number of spatial dimensions."""
        return self.states.dim

    def speed(self, row: IntArray, *, onwards: bool) -> tuple[FloatArray, FloatArray]:
        """Return the logarithm of the speed up to a state, or from it on, and its variance."""
        mean, variance = self._from if onwards else self._until
        return mean[row], variance[row]


def _speed(
    squares: FloatArray, unsure: FloatArray, first: IntArray, last: IntArray
) -> tuple[FloatArray, FloatArray]:
    """Return logarithms of mean speeds over states from one to another, and their variances."""
    n = last - first + 1.0
    square, noise = (
        (total[last + 1] - total[first]) / n
        for total in (np.r_[0.0, np.cumsum(each)] for each in (squares, unsure))
    )
    # What noise alone makes of speeds is no speed; a standing object has one that is unknown.
    speed = np.maximum(square - noise, 0.25 * noise) + 1e-12
    few = np.maximum(n / SPEED_TELLS, 1.0) ** 2
    return 0.5 * np.log(speed), np.minimum(0.5 * noise / speed / few, 2.0)
