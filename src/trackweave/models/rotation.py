"""Sensors that turn: where the beam points at a time."""

from dataclasses import dataclass

import numpy as np

from trackweave.errors import InvalidInputError
from trackweave.fields import settle

__all__ = ["Rotation"]


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

    def azimuth(self, time: float) -> float:
        """Return where the beam points at a time [s], from 0 to 2π [rad]."""
        turns = (time / self.period) % 1.0
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
        width = float(np.clip((end - start) / self.period, 0.0, 1.0)) * 2.0 * np.pi
        return self.azimuth(start if self.direction > 0 else end), width
