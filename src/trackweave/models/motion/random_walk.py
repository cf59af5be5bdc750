"""Diffusion: a position that wanders and has no velocity."""

from dataclasses import dataclass
from typing import Annotated, ClassVar, Self

from trackweave.fields import settle
from trackweave.keys import SPEED
from trackweave.models.motion.rule import PROCESS_NOISE, USUAL_SPEED, OneWay, Told

__all__ = ["RANDOM_WALK", "RandomWalk"]

RANDOM_WALK = 3


@dataclass(frozen=True, slots=True)
class RandomWalk(OneWay):
    """Brownian motion: an object that diffuses and has no velocity.

    Parameters
    ----------
    process_noise
        How fast the variance of the position grows along each axis [m²/s], twice the diffusion
        coefficient.
    max_speed
        Greatest speed at which a report may lie from the last [m/s].

    Raises
    ------
    InvalidInputError
        If a value is out of range.

    Examples
    --------
    >>> import trackweave as tw
    >>> tw.RandomWalk(process_noise=1.0, max_speed=5.0).process_noise  # m²/s
    1.0
    """

    word: ClassVar[str] = "random-walk"
    number: ClassVar[int] = RANDOM_WALK
    process_noise: Annotated[float, PROCESS_NOISE.said("a number ≥ 0 in m²/s")]
    max_speed: Annotated[float, SPEED]

    def __post_init__(self) -> None:
        settle(self)

    @classmethod
    def told(cls, told: Told) -> Self:
        """Return the model that a configuration tells, what is left out being usual."""
        speed = told.above("max_speed", USUAL_SPEED)
        return cls(told.own("process_noise", speed**2 * told.period / 9), speed)
