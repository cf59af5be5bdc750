"""Silences that a merge explains: who is one report with another is not seen beside it."""

import numpy as np
from numpy.typing import NDArray

from trackweave.arrays import FloatArray, IntArray
from trackweave.trackers.joining.segments import Paths, Segments

__all__ = ["merge_pairs"]

SLACK = 1.5
"""Ends and beginnings are so many times as far from the other object as two may be that are one
report: the last report before a merge is one of two objects that are still told apart."""
WAITS = 2.5
"""So many intervals after the end of the track that had the merged reports, who parts is seen."""


def merge_pairs(paths: Paths, segments: Segments, within: float) -> NDArray[np.bool_]:
    """Return which segments may go on as which, because they were hidden in a merge.

    An object ends beside a track that goes on, and begins again beside it. The track that had the
    reports of both may end as they part: it goes on as one of those that begin there, too.

    Parameters
    ----------
    paths
        The segments' states.
    segments
        Pieces of tracks.
    within
        Objects nearer than this may be one report [m].

    Returns
    -------
    Whether the first may go on as the second, shape (segments, segments).
    """
    begin, end, wait = segments.begin, segments.end, segments.interval
    beside_end = _beside(paths, (paths.last, end, wait), SLACK * within)
    beside_begin = _beside(paths, (paths.first, begin, -wait), SLACK * within)
    goes_on = (begin[None] < end[:, None]) & (end[None] > end[:, None])
    was_there = (begin[None] < begin[:, None]) & (end[None] >= begin[:, None] - WAITS * wait[None])
    hides, shows = beside_end & goes_on, beside_begin & was_there
    later = end[:, None] < begin[None]
    # Who merges is asked for seldom, and need not be waited for otherwise; few are near anybody.
    from scipy.sparse import csr_array

    common = csr_array(hides.astype(np.int32)) @ csr_array(shows.astype(np.int32)).T
    hidden = later & (common.toarray() > 0)
    # Who had the reports of another that comes back.
    before, after = np.nonzero(hidden)
    has_hidden = np.zeros(len(segments), dtype=np.bool_)
    for early, late in zip(before.tolist(), after.tolist(), strict=True):
        has_hidden |= hides[early] & shows[late]
    return np.asarray(hidden | (later & shows.T & has_hidden[:, None]))


def _beside(
    paths: Paths, at: tuple[IntArray, FloatArray, FloatArray], within: float
) -> NDArray[np.bool_]:
    """Return which segments are near each at a state of its own, or where it is soon after."""
    states, dim = paths.states, paths.dim
    row, time, wait = at
    place, speed = states.mean[row, :dim], states.mean[row, dim : 2 * dim]
    near = np.zeros((len(row), len(row)), dtype=np.bool_)
    for number in range(len(row)):
        for later in (0.0, wait[number]):
            others = states.mean[_rows_at(paths, time[number] + later), :dim]
            apart = others - place[number] - later * speed[number]
            near[number] |= np.sum(apart**2, axis=1) <= within**2
        near[number, number] = False
    return near


def _rows_at(paths: Paths, time: float) -> IntArray:
    """Return the last state of each segment up to a time, or its first."""
    states = paths.states
    start = float(states.time.min())
    span = float(np.ptp(states.time)) + 1.0
    own = states.track[paths.first] * span
    key = states.track * span + (states.time - start)
    row = np.searchsorted(key, own + np.clip(time - start, 0.0, span - 1.0), "right") - 1
    rows: IntArray = np.clip(row, paths.first, paths.last)
    return rows
