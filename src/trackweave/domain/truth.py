"""Where objects really were, as columns."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from trackweave.arrays import FloatArray, float_array, n_axes, require_finite
from trackweave.errors import InvalidInputError
from trackweave.summaries import summary

__all__ = ["TruthTable"]


@dataclass(frozen=True, slots=True, eq=False)
class TruthTable:
    """True positions of targets, one row per target and time, sorted by time, then target.

    The constructor takes columns that are already checked and sorted; ``from_columns`` does
    both for columns that are not.

    Parameters
    ----------
    time
        Time of each row [s], shape (rows,), ascending.
    target
        Identifier of each row's target as text, shape (rows,).
    position
        True position [m], shape (rows, dim), dim 2 or 3.
    velocity
        True velocity [m/s], shape (rows, dim), or None where it is not known.

    Examples
    --------
    >>> import trackweave as tw
    >>> truth = tw.TruthTable.from_columns([1.0, 0.0], ["a", "a"], [[10.0, 0.0], [0.0, 0.0]])
    >>> truth.time, truth.position  # s, m
    (array([0., 1.]), array([[ 0.,  0.],
           [10.,  0.]]))
    """

    time: FloatArray
    target: np.ndarray[Any, Any]
    position: FloatArray
    velocity: FloatArray | None = None

    __repr__ = summary

    def __len__(self) -> int:
        return len(self.time)

    @property
    def dim(self) -> int:
        """Number of spatial dimensions, 2 or 3."""
        return int(self.position.shape[1])

    @classmethod
    def from_columns(
        cls,
        time: ArrayLike,
        target: ArrayLike,
        position: ArrayLike,
        velocity: ArrayLike | None = None,
    ) -> "TruthTable":
        """Return the checked columns as a table in canonical order.

        Parameters
        ----------
        time
            Time of each row [s], in any order. Finite.
        target
            Identifier of each row's target; numbers become text.
        position
            True position [m], shape (rows, 2) or (rows, 3). Finite.
        velocity
            True velocity [m/s], same shape as the position, or None. Finite.

        Returns
        -------
        The rows sorted by time, then by target as text.

        Raises
        ------
        InvalidInputError
            If a shape does not fit, a value is not finite, or a target is in two places at once.
        """
        times = float_array(time, "time", (None,))
        rows = times.shape[0]
        positions = float_array(position, "position", (rows, None))
        if positions.shape[1] not in (2, 3):
            raise InvalidInputError(
                f"position: {positions.shape[1]} columns; expected 2 or 3 spatial dimensions"
            )
        n_axes(target, "target")
        names = np.asarray(target).astype(str).astype(object)
        if names.shape != (rows,):
            raise InvalidInputError(
                f"target: an array of shape {names.shape}; expected shape ({rows},)"
            )
        order = np.lexsort((names.astype(str), times))
        velocities = None
        if velocity is not None:
            velocities = float_array(velocity, "velocity", positions.shape)
            require_finite(velocities, "velocity")
            velocities = velocities[order]
        require_finite(times, "time")
        require_finite(positions, "position")
        times, names = times[order], names[order]
        twice = np.flatnonzero((np.diff(times) == 0) & (names[1:] == names[:-1]))
        if twice.size:
            row = int(twice[0])
            raise InvalidInputError(
                f"target {names[row]!r}: two rows at time {times[row]}; "
                "expected one place at a time"
            )
        return cls(times, names, positions[order], velocities)
