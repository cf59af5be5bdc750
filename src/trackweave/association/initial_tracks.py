"""Tracks as they enter an association tree."""

from dataclasses import dataclass, fields
from typing import Any

from numpy.typing import NDArray

from trackweave.arrays import FloatArray, IntArray

__all__ = ["InitialTracks"]


@dataclass(frozen=True, slots=True, eq=False)
class InitialTracks:
    """States with which tracks enter a tree, one row per track."""

    track: IntArray
    time: FloatArray  # Of each state [s]
    mean: FloatArray  # By modes of motion, shape (tracks, modes, size)
    covariance: FloatArray  # Shape (tracks, modes, size, size)
    weight: FloatArray  # Shape (tracks, modes)
    hits: IntArray  # Reports taken so far
    chances: FloatArray  # To be seen, from the first report on
    tail: FloatArray  # Cost of the chances missed since ``time`` [nats]
    # How probable it is then that an object that lives is where no sensor can see it.
    hidden: FloatArray
    # … and where one cannot, shape (tracks, sensors of which such is known).
    unseen: FloatArray
    misses: FloatArray  # Their number
    wild: FloatArray  # How probably its last report's noise was wide, -1 for nothing known
    # At which intervals it reports itself, as in ``association._rhythm``, shape (tracks, 6).
    rhythm: FloatArray
    level: FloatArray  # How high it is, as in ``association._levels``, shape (tracks, 6)
    identity: IntArray  # Whom the track is of; -1 for nobody
    other: IntArray  # Of whom its last report was, if not of that one; -1 for nobody
    sensor: IntArray  # Which saw it last; -1 for none
    is_line: IntArray  # 1 for an object that has been seen by its bearing alone
    slot: IntArray  # The slot of its last report, -1 where there was none

    @classmethod
    def names(cls) -> tuple[str, ...]:
        """Return the names of what a tree's nodes hold of it."""
        return tuple(each.name for each in fields(cls) if each.name not in ("track", "slot"))

    def columns(self) -> dict[str, NDArray[Any]]:
        """Return what a tree's nodes hold of it, by name."""
        return {name: getattr(self, name) for name in self.names()}
