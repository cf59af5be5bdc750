"""How objects move between reports."""

from dataclasses import dataclass

import numpy as np

from trackweave.errors import InvalidInputError

__all__ = ["ConstantVelocity"]


@dataclass(frozen=True, slots=True)
class ConstantVelocity:
    """Nearly constant velocity, driven by white acceleration along each axis.

    Parameters
    ----------
    process_noise
        Power spectral density of the acceleration [m²/s³]. Must not be negative.
    max_speed
        Greatest speed of an object [m/s]; a new object's velocity is spread uniformly over the
        ball of this radius. Must be positive.

    Raises
    ------
    InvalidInputError
        If a value is out of range.
    """

    process_noise: float
    max_speed: float

    def __post_init__(self) -> None:
        if not (np.isfinite(self.process_noise) and self.process_noise >= 0):
            raise InvalidInputError(
                f"process_noise: {self.process_noise}; expected a finite number ≥ 0 in m²/s³"
            )
        if not (np.isfinite(self.max_speed) and self.max_speed > 0):
            raise InvalidInputError(
                f"max_speed: {self.max_speed}; expected a finite number > 0 in m/s"
            )

    def velocity_variance(self, dim: int) -> float:
        """Return the variance of a new object's velocity along one axis [m²/s²].

        A uniform ball of radius v in ``dim`` dimensions has variance v²/(dim + 2) along an axis.

        Parameters
        ----------
        dim
            Number of spatial dimensions.

        Returns
        -------
        The variance.
        """
        return self.max_speed**2 / (dim + 2)
