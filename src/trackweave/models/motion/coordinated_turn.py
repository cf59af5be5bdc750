"""Turns of nearly constant speed and turn rate."""

from dataclasses import dataclass
from typing import Annotated, ClassVar, Self

from trackweave.fields import settle
from trackweave.keys import SPEED, Key
from trackweave.models.motion.rule import PROCESS_NOISE, USUAL_PROCESS, USUAL_SPEED, OneWay, Told

__all__ = ["COORDINATED_TURN", "CoordinatedTurn"]

COORDINATED_TURN = 2
TURN_NOISE = Key("a number ≥ 0 in rad²/s³", 0, 1e6)
TURN_RATE = Key("a number > 0 in rad/s", 1e-9, 1e3)
USUAL_TURN_RATE = 0.2
# A manoeuvre fades in about so many seconds.
FADE = 10.0


@dataclass(frozen=True, slots=True)
class CoordinatedTurn(OneWay):
    """A horizontal turn of nearly constant speed and turn rate; height at constant velocity.

    Parameters
    ----------
    process_noise
        Power spectral density of the acceleration along each axis [m²/s³].
    turn_noise
        Power spectral density of the turn rate's change [rad²/s³]; for coordinated-turn.
    max_speed
        Greatest speed of an object [m/s], as in `ConstantVelocity`.
    max_turn_rate
        Greatest turn rate to either side [rad/s]; for coordinated-turn.

        One of which nothing is known is spread uniformly between the two. A turn of a g at v m/s
        has 9.81·a/v rad/s.

    Raises
    ------
    InvalidInputError
        If a value is out of range.

    Examples
    --------
    >>> import trackweave as tw
    >>> motion = tw.CoordinatedTurn(1.0, 1e-5, max_speed=300.0, max_turn_rate=0.05)
    >>> motion.velocity_variance(2)  # m²/s²
    22500.0
    """

    word: ClassVar[str] = "coordinated-turn"
    number: ClassVar[int] = COORDINATED_TURN
    process_noise: Annotated[float, PROCESS_NOISE]
    turn_noise: Annotated[float, TURN_NOISE]
    max_speed: Annotated[float, SPEED]
    max_turn_rate: Annotated[float, TURN_RATE]

    def __post_init__(self) -> None:
        settle(self)

    @classmethod
    def told(cls, told: Told) -> Self:
        """Return the model that a configuration tells, what is left out being usual."""
        speed = told.above("max_speed", USUAL_SPEED)
        rate = told.above("max_turn_rate", USUAL_TURN_RATE)
        # A turn rate that is spread evenly up to its greatest and fades has this noise.
        turn_noise = told.above("turn_noise", 2 * rate**2 / 3 / FADE)
        return cls(told.above("process_noise", USUAL_PROCESS), turn_noise, speed, rate)

    def further(self) -> tuple[float, float, float]:
        """Return greatest acceleration and turn rate, and the turn's noise; 0 for having none."""
        return 0.0, self.max_turn_rate, self.turn_noise
