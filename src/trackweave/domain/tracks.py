"""What is known of objects, as columns."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from trackweave.arrays import FloatArray, IntArray, float_array, int_array, n_axes
from trackweave.errors import InvalidInputError
from trackweave.fields import checked_dimension
from trackweave.summaries import summary

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
    existence
        Probability that the object is there and the track follows it, shape (rows,); NaN where a
        method tells none, as when left out.
    visible
        Probability that an object that is there is in sight of a sensor, shape (rows,); NaN where
        a method tells none, as when left out.

    Raises
    ------
    InvalidInputError
        If a column holds no numbers, or shapes do not fit.

    Examples
    --------
    >>> import numpy as np
    >>> import trackweave as tw
    >>> table = tw.TrackTable(
    ...     time=[0.0], track=[4], status=[1], mean=[[5.0, 0.0, 1.0, 0.0]],
    ...     covariance=[np.eye(4)], score=[-9.0], hits=[3], last_update=[0.0],
    ... )
    >>> len(table), table.dim
    (1, 2)
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
    existence: FloatArray = field(default_factory=lambda: np.empty(0))
    visible: FloatArray = field(default_factory=lambda: np.empty(0))

    __repr__ = summary

    def __post_init__(self) -> None:
        time = float_array(self.time, "time", (None,))
        rows = time.shape[0]
        mean = float_array(self.mean, "mean", (rows, None))
        if mean.shape[1] not in (4, 6):
            raise InvalidInputError(f"mean: {mean.shape[1]} columns; expected 4 or 6")
        shapes: dict[str, tuple[int | None, ...]] = {
            "covariance": (rows, mean.shape[1], mean.shape[1]),
            "score": (rows,),
            "last_update": (rows,),
        }
        if n_axes(self.acceleration, "acceleration") != 2 or np.size(self.acceleration):
            shapes["acceleration"] = (rows, None)
        for name in ("existence", "visible"):
            if n_axes(getattr(self, name), name) != 1 or np.size(getattr(self, name)):
                shapes[name] = (rows,)
        columns: dict[str, FloatArray | IntArray] = {"time": time, "mean": mean}
        columns |= {n: float_array(getattr(self, n), n, shape) for n, shape in shapes.items()}
        columns |= {
            n: int_array(getattr(self, n), n, (rows,)) for n in ("track", "status", "hits")
        }
        # Left out, it has as many rows as the others.
        columns.setdefault("acceleration", np.empty((rows, 0)))
        for name in ("existence", "visible"):
            columns.setdefault(name, np.full(rows, np.nan))
        if np.any((columns["status"] < TENTATIVE) | (columns["status"] > COASTING)):
            raise InvalidInputError("status: expected 0, 1 or 2, as STATUSES counts them")
        for name, values in columns.items():
            object.__setattr__(self, name, values)

    def __len__(self) -> int:
        return int(self.time.shape[0])

    @property
    def dim(self) -> int:
        """Number of spatial dimensions, 2 or 3."""
        return int(self.mean.shape[1]) // 2

    def at(self, rows: Any) -> "TrackTable":
        """Return some rows, by their numbers or by a mask."""
        return TrackTable(*(getattr(self, name)[rows] for name in self.__dataclass_fields__))

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
        dim = checked_dimension(dim)
        none, nobody = np.empty(0), np.empty(0, dtype=np.int64)
        n = 2 * dim
        return cls(none, nobody, nobody, np.empty((0, n)), np.empty((0, n, n)), none, nobody, none)
