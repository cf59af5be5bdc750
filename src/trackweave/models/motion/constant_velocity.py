"""Nearly constant velocity."""

from dataclasses import dataclass
from typing import Annotated, ClassVar, Self

from trackweave.fields import settle
from trackweave.keys import SPEED
from trackweave.models.motion.rule import PROCESS_NOISE, USUAL_PROCESS, USUAL_SPEED, OneWay, Told

__all__ = ["CONSTANT_VELOCITY", "ConstantVelocity"]

CONSTANT_VELOCITY = 0


@dataclass(frozen=True, slots=True)
class ConstantVelocity(OneWay):
    """Nearly constant velocity, driven by white acceleration along each axis.

    Parameters
    ----------
    process_noise
        Power spectral density of the acceleration [m²/s³].
    max_speed
        How fast an object can be [m/s]; also the spread of a new track's velocity.

        It is spread uniformly over the ball of this radius.

    Raises
    ------
    InvalidInputError
        If a value is out of range.

    Examples
    --------
    >>> import trackweave as tw
    >>> motion = tw.ConstantVelocity(process_noise=0.1, max_speed=20.0)  # boats: m²/s³, m/s
    >>> motion.velocity_variance(2)  # of a new object, along an axis [m²/s²]
    100.0
    """

    word: ClassVar[str] = "constant-velocity"
    number: ClassVar[int] = CONSTANT_VELOCITY
    process_noise: Annotated[float, PROCESS_NOISE]
    max_speed: Annotated[float, SPEED]

    def __post_init__(self) -> None:
        settle(self)

    @classmethod
    def told(cls, told: Told) -> Self:
        """Return the model that a configuration tells, what is left out being usual."""
        speed = told.above("max_speed", USUAL_SPEED)
        return cls(told.above("process_noise", USUAL_PROCESS), speed)
