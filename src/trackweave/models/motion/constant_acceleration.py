"""Nearly constant acceleration."""

from dataclasses import dataclass
from typing import Annotated, ClassVar, Self

from trackweave.fields import settle
from trackweave.keys import SPEED, Key
from trackweave.models.motion.rule import PROCESS_NOISE, USUAL_SPEED, OneWay, Told

__all__ = ["CONSTANT_ACCELERATION", "ConstantAcceleration"]

CONSTANT_ACCELERATION = 1
ACCELERATION = Key("a number > 0 in m/s²", 1e-12, 1e12)
# An object reaches its greatest speed in about so many seconds, and a manoeuvre fades in so many.
SPEED_UP, FADE = 10.0, 10.0


@dataclass(frozen=True, slots=True)
class ConstantAcceleration(OneWay):
    """Nearly constant acceleration, driven by white jerk along each axis.

    Parameters
    ----------
    process_noise
        Power spectral density of the jerk [m²/s⁵].
    max_speed
        Greatest speed of an object [m/s], as in `ConstantVelocity`.
    max_acceleration
        Greatest acceleration [m/s²]; for constant-acceleration.

        One of which nothing is known is spread uniformly over the ball of this radius.

    Raises
    ------
    InvalidInputError
        If a value is out of range.

    Examples
    --------
    >>> import trackweave as tw
    >>> motion = tw.ConstantAcceleration(process_noise=0.5, max_speed=40.0, max_acceleration=6.0)
    >>> motion.velocity_variance(2)  # of a new object, along an axis [m²/s²]
    400.0
    """

    word: ClassVar[str] = "constant-acceleration"
    number: ClassVar[int] = CONSTANT_ACCELERATION
    process_noise: Annotated[float, PROCESS_NOISE.said("a number ≥ 0 in m²/s⁵")]
    max_speed: Annotated[float, SPEED]
    max_acceleration: Annotated[float, ACCELERATION]

    def __post_init__(self) -> None:
        settle(self)

    @classmethod
    def told(cls, told: Told) -> Self:
        """Return the model that a configuration tells, what is left out being usual."""
        speed = told.above("max_speed", USUAL_SPEED)
        acceleration = told.above("max_acceleration", speed / SPEED_UP)
        jerk = 2 * acceleration**2 / 5 / FADE
        return cls(told.own("process_noise", jerk), speed, acceleration)

    def further(self) -> tuple[float, float, float]:
        """Return greatest acceleration and turn rate, and the turn's noise; 0 for having none."""
        return self.max_acceleration, 0.0, 0.0
