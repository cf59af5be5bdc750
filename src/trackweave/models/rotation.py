"""Sensors that turn: where the beam points at a time."""

from dataclasses import dataclass, field

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.errors import InvalidInputError
from trackweave.fields import settle

__all__ = ["FollowedRotation", "Rotation"]


@dataclass(frozen=True, slots=True)
class Rotation:
    """The steady turn of a sensor's beam.

    Parameters
    ----------
    period
        Time of a turn [s]. Must be positive.
    phase
        Azimuth of the beam at time 0 [rad, clockwise from north].
    direction
        1 clockwise, -1 counter-clockwise.

    Raises
    ------
    InvalidInputError
        If a value is out of range.

    Examples
    --------
    >>> import numpy as np
    >>> import trackweave as tw
    >>> rotation = tw.Rotation(period=4.0)  # s
    >>> np.degrees(rotation.azimuth(1.0))  # clockwise from north
    np.float64(90.0)
    """

    period: float
    phase: float = 0.0
    direction: int = 1

    def __post_init__(self) -> None:
        settle(self)
        if not self.period > 0:
            raise InvalidInputError(f"rotation: period {self.period}; expected a number > 0 in s")
        if self.direction not in (1, -1):
            raise InvalidInputError(f"rotation: direction {self.direction}; expected 1 or -1")

    @property
    def wander(self) -> float:
        """How much turns differ in length: the deviation of their periods, as a share of one."""
        return 0.0

    def turned(self, time: FloatArray | float) -> FloatArray:
        """Return how many turns the beam has made by some times [s]."""
        return np.asarray(np.asarray(time, dtype=np.float64) / self.period)

    def when(self, turned: FloatArray | float) -> FloatArray:
        """Return at which times [s] the beam has made so many turns."""
        return np.asarray(np.asarray(turned, dtype=np.float64) * self.period)

    def azimuth(self, time: float) -> float:
        """Return where the beam points at a time [s], from 0 to 2π [rad]."""
        turns = float(self.turned(time)) % 1.0
        return float((self.phase + self.direction * 2.0 * np.pi * turns) % (2.0 * np.pi))

    def sector(self, start: float, end: float) -> tuple[float, float]:
        """Return the sector that the beam sweeps.

        Parameters
        ----------
        start, end
            From when to when [s].

        Returns
        -------
        The clockwise first edge, and the width, at most 2π [rad].
        """
        turns = float(self.turned(end) - self.turned(start))
        width = float(np.clip(turns, 0.0, 1.0)) * 2.0 * np.pi
        return self.azimuth(start if self.direction > 0 else end), width


@dataclass(frozen=True, slots=True, eq=False)
class FollowedRotation(Rotation):
    """The turn of a beam whose speed wanders, known turn by turn.

    Before the first and after the last knot it turns steadily with the mean period.

    Parameters
    ----------
    knots
        Times [s], ascending.
    turns
        How many turns the beam has made by then, ascending.
    """

    knots: FloatArray = field(default_factory=lambda: np.zeros(1))
    turns: FloatArray = field(default_factory=lambda: np.zeros(1))

    @property
    def wander(self) -> float:
        """How much turns differ in length: the deviation of their periods, as a share of one."""
        ends = np.arange(np.ceil(self.turns[0]), np.floor(self.turns[-1]) + 1)
        lengths = np.diff(np.interp(ends, self.turns, self.knots))
        return float(np.std(lengths) / self.period) if lengths.size > 1 else 0.0

    def turned(self, time: FloatArray | float) -> FloatArray:
        """Return how many turns the beam has made by some times [s]."""
        moment = np.asarray(time, dtype=np.float64)
        held = np.clip(moment, self.knots[0], self.knots[-1])
        return np.asarray(np.interp(held, self.knots, self.turns) + (moment - held) / self.period)

    def when(self, turned: FloatArray | float) -> FloatArray:
        """Return at which times [s] the beam has made so many turns."""
        made = np.asarray(turned, dtype=np.float64)
        held = np.clip(made, self.turns[0], self.turns[-1])
        return np.asarray(np.interp(held, self.turns, self.knots) + (made - held) * self.period)
