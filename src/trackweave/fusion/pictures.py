"""What one sensor's tracker says of its tracks at one time."""

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from trackweave.arrays import FloatArray, IntArray, float_array, int_array
from trackweave.errors import InvalidInputError
from trackweave.fields import checked_dimension, checked_number, plain
from trackweave.filters.kalman import predicted
from trackweave.summaries import summary

__all__ = ["LocalPicture"]

_SYMMETRY = 1e-9
"""How far a covariance may be from symmetric, beside its greatest entry: rounding alone."""


@dataclass(frozen=True, slots=True, eq=False)
class LocalPicture:
    """The tracks of one sensor at one time.

    Parameters
    ----------
    sensor
        Name of the sensor, or of the local node.
    time
        Time to which the states belong [s].
    track
        Numbers that the sensor gives its tracks, each once, shape (n,).
    mean
        Position [m] then velocity [m/s], shape (n, 2 dim): x, y[, z], vx, vy[, vz].
    covariance
        Covariance of the mean, shape (n, 2 dim, 2 dim). Must be symmetric and positive definite.

    Raises
    ------
    InvalidInputError
        If shapes do not fit, a number is not finite, a track is there twice, or a covariance is
        missing, not symmetric or not positive definite. The message names sensor and track.

    Examples
    --------
    >>> import numpy as np
    >>> import trackweave as tw
    >>> state = [[100.0, 50.0, 10.0, 0.0]]  # x, y [m], vx, vy [m/s]
    >>> spread = np.diag([25.0, 25.0, 1.0, 1.0])[None]
    >>> picture = tw.LocalPicture("A", 0.0, [1], state, spread)  # at 0 s
    >>> picture.predicted(2.0, process_noise=0.1).mean  # at 2 s
    array([[120.,  50.,  10.,   0.]])
    """

    sensor: str
    time: float
    track: IntArray
    mean: FloatArray
    covariance: FloatArray

    __repr__ = summary

    def __post_init__(self) -> None:
        name = plain(self.sensor)
        if not isinstance(name, str) or not name:
            raise InvalidInputError(f"sensor: {self.sensor!r:.80}; expected a name")
        who = f"sensor {name}"
        time = checked_number(self.time, f"{who}, time")
        track = int_array(self.track, f"{who}, track", (None,))
        mean = float_array(self.mean, f"{who}, mean", (track.shape[0], None))
        if mean.shape[1] not in {4, 6}:
            raise InvalidInputError(
                f"{who}, mean: {mean.shape[1]} numbers a track; expected position and velocity "
                "in 2 or 3 dimensions, which are 4 or 6"
            )
        if self.covariance is None:
            raise InvalidInputError(
                f"{who}: tracks without covariance; expected one of each, as association weighs "
                "distances by them"
            )
        covariance = float_array(
            self.covariance, f"{who}, covariance", (*mean.shape, mean.shape[1])
        )
        _require_tracks(who, track, mean, covariance)
        cast = {
            "sensor": str(name),
            "time": time,
            "track": track,
            "mean": mean,
            "covariance": covariance,
        }
        for key, value in cast.items():
            object.__setattr__(self, key, value)

    def __len__(self) -> int:
        return int(self.track.shape[0])

    @property
    def dim(self) -> int:
        """Number of spatial dimensions, 2 or 3."""
        return int(self.mean.shape[1]) // 2

    @classmethod
    def empty(cls, sensor: str, time: float, dim: int) -> Self:
        """Return the picture of a sensor that sees nothing."""
        n = 2 * checked_dimension(dim)
        return cls(
            sensor, time, np.empty(0, dtype=np.int64), np.empty((0, n)), np.empty((0, n, n))
        )

    def predicted(self, time: float, process_noise: float) -> "LocalPicture":
        """Return the picture as it should look at a later time, at constant velocities.

        Parameters
        ----------
        time
            That time [s], not before the picture's own.
        process_noise
            Power spectral density of the acceleration along each axis [m²/s³], at least 0.

        Returns
        -------
        The same tracks then, with their greater covariances; the picture itself at its own time.

        Raises
        ------
        InvalidInputError
            If the time lies before the picture's, or a number is out of range.
        """
        time = checked_number(time, "time")
        process_noise = checked_number(process_noise, "process_noise", "a number ≥ 0 [m²/s³]")
        if time < self.time:
            raise InvalidInputError(
                f"sensor {self.sensor}: tracks of {self.time:g} s are wanted at {time!r:.80} s; "
                "expected a time not before theirs"
            )
        if process_noise < 0.0:
            raise InvalidInputError(
                f"process_noise: {process_noise!r:.80}; expected a number ≥ 0 [m²/s³]"
            )
        if time == self.time:
            return self
        interval = np.full(len(self), time - self.time)
        mean, covariance = predicted(self.mean, self.covariance, interval, process_noise)
        covariance = (covariance + covariance.swapaxes(1, 2)) / 2.0
        return LocalPicture(self.sensor, float(time), self.track, mean, covariance)


def _require_tracks(who: str, track: IntArray, mean: FloatArray, covariance: FloatArray) -> None:
    """Refuse tracks that are there twice, or whose numbers make no estimate, naming the first."""
    number, count = np.unique(track, return_counts=True)
    if np.any(count > 1):
        raise InvalidInputError(
            f"{who}: track {number[count > 1][0]} is there {count.max()} times; "
            "expected each track once"
        )
    is_odd = np.asarray(~np.isfinite(mean).all(axis=1))
    _refuse(who, track, is_odd, "a mean that is not finite; expected finite numbers")
    is_odd = np.asarray(~np.isfinite(covariance).all(axis=(1, 2)))
    _refuse(who, track, is_odd, "a covariance that is not finite; expected finite numbers")
    size = np.abs(covariance).max(axis=(1, 2), initial=0.0)
    lopsided = np.abs(covariance - covariance.swapaxes(1, 2)).max(axis=(1, 2), initial=0.0)
    _refuse(
        who, track, np.asarray(lopsided > _SYMMETRY * size),
        "a covariance that is not symmetric; expected a symmetric one",
    )  # fmt: skip
    _refuse(
        who, track, ~_is_definite(covariance),
        "a covariance that is not positive definite; expected a positive definite one",
    )  # fmt: skip


def _is_definite(covariance: FloatArray) -> NDArray[np.bool_]:
    """Tell which matrices are positive definite; all at once as long as all are."""
    try:
        np.linalg.cholesky(covariance)
    except np.linalg.LinAlgError:
        # Scaled to correlations, as metres and metres per second may be worlds apart.
        diagonal = np.diagonal(covariance, axis1=1, axis2=2)
        root = np.sqrt(np.where(diagonal > 0.0, diagonal, 1.0))
        least = np.linalg.eigvalsh(covariance / (root[:, :, None] * root[:, None, :]))[:, 0]
        return np.asarray((diagonal > 0.0).all(axis=1) & (least > 1e-14))
    return np.ones(covariance.shape[0], dtype=np.bool_)


def _refuse(who: str, track: IntArray, is_wrong: NDArray[np.bool_], what: str) -> None:
    if np.any(is_wrong):
        raise InvalidInputError(f"{who}, track {track[np.argmax(is_wrong)]}: {what}")
