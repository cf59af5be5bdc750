"""Changes between several ways to move."""

from dataclasses import dataclass
from typing import TypeAlias

from trackweave.errors import InvalidInputError
from trackweave.fields import settle
from trackweave.models.motion.constant_acceleration import ConstantAcceleration
from trackweave.models.motion.constant_velocity import ConstantVelocity
from trackweave.models.motion.coordinated_turn import CoordinatedTurn
from trackweave.models.motion.random_walk import RandomWalk
from trackweave.models.motion.rule import MotionRule, ball_variance, rule_of

__all__ = ["MODELS", "Imm", "Mode", "Motion"]

Mode: TypeAlias = ConstantVelocity | ConstantAcceleration | CoordinatedTurn | RandomWalk
# The ways to move by the words that files have for them.
MODELS: dict[str, type[Mode]] = {
    model.word: model
    for model in (ConstantVelocity, ConstantAcceleration, CoordinatedTurn, RandomWalk)
}


@dataclass(frozen=True, slots=True)
class Imm:
    """Objects that change between several ways to move: an interacting multiple model [1]_.

    Modes change as a chain in continuous time, so that any interval has its exact transition
    probabilities: from the mode that is left, every other follows with the same probability. In
    the long run an object spends in each mode a share of the time like that mode's sojourn time.

    Parameters
    ----------
    models
        At least two ways to move.
    sojourn_time
        How long an object stays in each on average [s]. Each must be positive.

    Raises
    ------
    InvalidInputError
        If there are fewer than two models, not as many sojourn times, or one is out of range.

    References
    ----------
    .. [1] H. A. P. Blom, Y. Bar-Shalom, *The interacting multiple model algorithm for systems
       with Markovian switching coefficients*, 1988. doi:10.1109/9.1299

    Examples
    --------
    >>> import trackweave as tw
    >>> modes = [tw.ConstantVelocity(noise, max_speed=20.0) for noise in (0.01, 5.0)]
    >>> motion = tw.Imm(modes, sojourn_time=(60.0, 20.0))  # s
    >>> motion.rule(2).share  # of the time in each
    array([0.75, 0.25])
    """

    models: tuple[Mode, ...]
    sojourn_time: tuple[float, ...]

    def __post_init__(self) -> None:
        settle(self)
        models, times = self.models, self.sojourn_time
        if len(models) < 2:
            names = ", ".join(type(model).__name__ for model in models)
            raise InvalidInputError(f"models: [{names}]; expected two or more ways to move")
        if len(times) != len(models):
            raise InvalidInputError(
                f"sojourn_time: {len(times)} times for {len(models)} models; expected one each"
            )
        for time in times:
            if not time > 0:
                raise InvalidInputError(
                    f"sojourn_time: {time!r:.80}; expected finite numbers > 0 in s"
                )

    @property
    def max_speed(self) -> float:
        """Greatest speed of an object in any mode [m/s]."""
        return max(model.max_speed for model in self.models)

    def velocity_variance(self, dim: int) -> float:
        """Return the variance of a new object's velocity along one axis [m²/s²]."""
        return ball_variance(self.max_speed, dim)

    def rule(self, dim: int, *, unscented: bool = False) -> MotionRule:
        """Return the form that kernels read.

        Parameters
        ----------
        dim
            Number of spatial dimensions.
        unscented
            Whether measurements are foreseen over sigma points instead of by derivatives.

        Returns
        -------
        The rule, one mode per model.
        """
        return rule_of(self.models, self.sojourn_time, dim, unscented=unscented)


Motion: TypeAlias = Mode | Imm
