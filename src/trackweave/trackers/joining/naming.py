"""What segments of tracks are called by their reports, and which are one object's by that."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from trackweave.arrays import FloatArray, IntArray
from trackweave.trackers.joining.segments import FIRM, Segments

__all__ = ["RARELY", "Named", "elsewhere", "named_by", "whose"]

RARELY = 0.01
"""Names that are wrong more often than this prove nothing."""
CHANGING = 8.0
"""For so many usual waits reports of one object may go to the track before and to the next."""
CLEARLY = 0.9
"""Of the reports of a segment that have a name, so many have its own."""


class Named(NamedTuple):
    """Whom each segment's reports say that it is; columns of shape (segments,)."""

    identity: IntArray
    """-1 for none."""
    before: IntArray
    """The segment before that alone has the same name, -1 for none."""
    error: float
    """How often reports are under another identity than their object's."""

    def favour(self, early: IntArray, late: IntArray) -> FloatArray:
        """Return what speaks for pairs of segments as one object by whom they say they are."""
        number = np.unique(self.identity[self.identity >= 0]).size
        same = np.log((1.0 - self.error) * max(number, 1) + self.error)
        first, second = self.identity[early], self.identity[late]
        both = (first >= 0) & (second >= 0)
        return np.where(both, np.where(first == second, same, np.log(self.error)), 0.0)


def named_by(segments: Segments, of: IntArray, identity: IntArray, error: float) -> Named:
    """Return whom each segment's reports say that it is, and who is the same by that alone.

    Parameters
    ----------
    segments
        Pieces of tracks.
    of
        The segment of each report, -1 for none.
    identity
        The identity that each report tells, -1 for none.
    error
        How often reports are under another identity than their object's.

    Returns
    -------
    Segments of a name that no other has at the same time follow one another.
    """
    most, is_clear = whose(of, identity, len(segments))
    before = np.full(len(segments), -1, dtype=np.int64)
    if error <= RARELY:
        for name in np.unique(most[(most >= 0) & is_clear]).tolist():
            own = np.flatnonzero((most == name) & is_clear)
            chain = _in_turn(segments, own[np.argsort(segments.begin[own], kind="stable")])
            before[chain[1:]] = chain[:-1]
    return Named(most, before, error)


def _in_turn(segments: Segments, own: IntArray) -> IntArray:
    """Return the segments of a name, by time; none where it is of two objects at once."""
    chain: list[int] = []
    for each in own.tolist():
        if not chain or _goes_on(segments, chain[-1], each):
            chain.append(each)
            continue
        # Of two at once the scrap is a wrong report; where neither is, the name is of several.
        fewer, more = sorted((each, chain[-1]), key=lambda one: int(segments.count[one]))
        if segments.count[fewer] >= FIRM:
            return np.empty(0, dtype=np.int64)
        chain[-1] = more
    return np.array(chain, dtype=np.int64)


def _goes_on(segments: Segments, early: int, late: int) -> bool:
    """Tell whether one segment comes after the other, but for a change of tracks between them."""
    lap = segments.end[early] - segments.begin[late]
    usual = max(segments.interval[early], segments.interval[late])
    # A new track may have begun while reports still went to the one before.
    is_brief = lap < CHANGING * usual and segments.end[late] > segments.end[early]
    return bool(lap < 0.0 or (is_brief and segments.begin[late] > segments.begin[early]))


def elsewhere(
    track: IntArray, time: FloatArray, identity: IntArray, nameless: NDArray[np.bool_]
) -> NDArray[np.bool_]:
    """Return which nameless reports a track has while another of the same name is reported.

    Parameters
    ----------
    track
        The track of each report, -1 for none.
    time
        When each was [s].
    identity
        The identity that each report tells, -1 for none.
    nameless
        Which reports have none although their sensor tells some.

    Returns
    -------
    They lie before all reports that have the name, or after all, as rivals' reports do.
    """
    found = np.zeros(track.size, dtype=np.bool_)
    named = np.flatnonzero((track >= 0) & (identity >= 0))
    rows = np.flatnonzero((track >= 0) & nameless)
    if named.size == 0 or rows.size == 0:
        return found
    rows = rows[np.argsort(track[rows], kind="stable")]
    of = track[rows]
    named = named[np.lexsort((time[named], track[named], identity[named]))]
    cuts = np.flatnonzero((np.diff(identity[named]) != 0) | (np.diff(track[named]) != 0)) + 1
    first, last = named[np.r_[0, cuts]], named[np.r_[cuts - 1, named.size - 1]]
    order = np.lexsort((time[first], identity[first]))
    first, last = first[order], last[order]
    early = last[0]
    for begun, ended in zip(first[1:].tolist(), last[1:].tolist(), strict=True):
        if identity[early] != identity[begun]:
            early = ended
            continue
        if time[early] < time[begun]:
            before, after = (
                rows[slice(*np.searchsorted(of, [track[row], track[row] + 1]))]
                for row in (early, begun)
            )
            found[before] |= time[before] >= time[begun]
            found[after] |= time[after] <= time[early]
        early = max(early, ended, key=lambda row: time[row])
    return found


def whose(of: IntArray, identity: IntArray, count: int) -> tuple[IntArray, NDArray[np.bool_]]:
    """Return the identity that most reports of each of so many segments tell, -1 for none.

    Parameters
    ----------
    of
        The segment of each report, -1 for none.
    identity
        The identity that each report tells, -1 for none.
    count
        Number of segments.

    Returns
    -------
    One for each segment, and whether nearly all of its reports that tell one tell that.
    """
    rows = np.flatnonzero((of >= 0) & (identity >= 0))
    pairs, number = np.unique(
        np.stack([of[rows], identity[rows]], axis=1), axis=0, return_counts=True
    )
    most = np.full(count, -1, dtype=np.int64)
    order = np.argsort(number, kind="stable")
    most[pairs[order, 0]] = pairs[order, 1]
    own = np.zeros(count)
    own[pairs[order, 0]] = number[order]
    is_clear = own >= CLEARLY * np.bincount(of[rows], minlength=count)
    return most, is_clear
