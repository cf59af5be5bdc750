"""Tracks as they enter an association tree."""

from dataclasses import dataclass, fields
from typing import Any

from numpy.typing import NDArray

from trackweave.arrays import FloatArray, IntArray

__all__ = ["Beginning"]


@dataclass(frozen=True, slots=True, eq=False)
class Beginning:
    """States with which tracks enter a tree, one row per track.

    Parameters
    ----------
    track
        Identifiers.
    time
        Time of each state [s].
    mean, covariance, weight
        The state by modes of motion, shapes (tracks, modes, size), (tracks, modes, size, size)
        and (tracks, modes).
    hits, chances
        Reports taken so far, and chances to be seen from the first report on.
    tail, misses
        Cost [nats] and number of the chances missed since ``time``.
    hidden
        How probable it is then that an object that lives is where no sensor can see it.
    rhythm
        At which intervals it reports itself, as in ``association._rhythm``, shape (tracks, 5).
    identity, former, sensor
        Whom the track has been of, and which sensor saw it last; -1 for nobody and none.
    is_line
        1 for an object that has been seen by its bearing alone.
    slot
        The slot of its last report, -1 where there was none.
    """

    track: IntArray
    time: FloatArray
    mean: FloatArray
    covariance: FloatArray
    weight: FloatArray
    hits: IntArray
    chances: FloatArray
    tail: FloatArray
    hidden: FloatArray
    misses: FloatArray
    rhythm: FloatArray
    identity: IntArray
    former: IntArray
    sensor: IntArray
    is_line: IntArray
    slot: IntArray

    @classmethod
    def names(cls) -> tuple[str, ...]:
        """Return the names of what a tree's nodes hold of it."""
        return tuple(each.name for each in fields(cls) if each.name not in ("track", "slot"))

    def columns(self) -> dict[str, NDArray[Any]]:
        """Return what a tree's nodes hold of it, by name."""
        return {name: getattr(self, name) for name in self.names()}
