"""What is known of objects, as columns."""

from dataclasses import dataclass, field

import numpy as np

from trackweave.arrays import FloatArray, IntArray

__all__ = ["COASTING", "CONFIRMED", "STATUSES", "TENTATIVE", "TrackTable"]

TENTATIVE, CONFIRMED, COASTING = 0, 1, 2
STATUSES = ("tentative", "confirmed", "coasting")


@dataclass(frozen=True, slots=True, eq=False)
class TrackTable:
    """States of tracks, one row per track and time.

    Parameters
    ----------
    time
        Time of each row [s], shape (rows,).
    track
        Identifier of the track, shape (rows,).
    status
        0 for TENTATIVE, 1 for CONFIRMED, 2 for COASTING, which is confirmed but not seen lately;
        shape (rows,). ``STATUSES[number]`` is the word that files carry.
    mean
        Position [m] then velocity [m/s], shape (rows, 2 dim): x, y[, z], vx, vy[, vz].
    covariance
        Covariance of the mean, shape (rows, 2 dim, 2 dim).
    score
        Cost of the track's reports against "all false alarms" [nats]; smaller is more credible.
    hits
        Number of reports that the track has taken, shape (rows,).
    last_update
        Time of the last report taken [s], shape (rows,).
    acceleration
        Acceleration [m/s²], shape (rows, dim), or (rows, 0) where the motion knows none, as when
        left out.
    """

    time: FloatArray
    track: IntArray
    status: IntArray
    mean: FloatArray
    covariance: FloatArray
    score: FloatArray
    hits: IntArray
    last_update: FloatArray
    acceleration: FloatArray = field(default_factory=lambda: np.empty((0, 0)))

    def __post_init__(self) -> None:
        if self.acceleration.shape[0] != self.time.shape[0]:
            object.__setattr__(self, "acceleration", np.empty((self.time.shape[0], 0)))

    def __len__(self) -> int:
        return int(self.time.shape[0])

    @property
    def dim(self) -> int:
        """Number of spatial dimensions, 2 or 3."""
        return int(self.mean.shape[1]) // 2

    @classmethod
    def concatenate(cls, tables: "list[TrackTable]", dim: int) -> "TrackTable":
        """Return the rows of all tables, one after the other; ``dim`` serves an empty list."""
        if not tables:
            return cls.empty(dim)
        # Tracks from elsewhere tell no acceleration even where the motion knows one.
        width = max(table.acceleration.shape[1] for table in tables)
        pulls = [
            table.acceleration
            if table.acceleration.shape[1] == width
            else np.full((len(table), width), np.nan)
            for table in tables
        ]
        columns = {
            name: np.concatenate([getattr(table, name) for table in tables])
            for name in cls.__dataclass_fields__
            if name != "acceleration"
        }
        return cls(**columns, acceleration=np.concatenate(pulls))

    @classmethod
    def empty(cls, dim: int) -> "TrackTable":
        """Return a table without rows for objects in ``dim`` spatial dimensions."""
        none, nobody = np.empty(0), np.empty(0, dtype=np.int64)
        n = 2 * dim
        return cls(none, nobody, nobody, np.empty((0, n)), np.empty((0, n, n)), none, nobody, none)
