"""How objects move between reports."""

from dataclasses import dataclass
from typing import Annotated, NamedTuple, TypeAlias

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.errors import InvalidInputError
from trackweave.fields import settle
from trackweave.keys import SPEED, Key

__all__ = [
    "CONSTANT_ACCELERATION",
    "CONSTANT_VELOCITY",
    "COORDINATED_TURN",
    "PROCESS_NOISE",
    "RANDOM_WALK",
    "ConstantAcceleration",
    "ConstantVelocity",
    "CoordinatedTurn",
    "Imm",
    "Mode",
    "Motion",
    "MotionRule",
    "RandomWalk",
]

PROCESS_NOISE = Key("a number ≥ 0 in m²/s³", 0, 1e12)
TURN_NOISE = Key("a number ≥ 0 in rad²/s³", 0, 1e6)
ACCELERATION = Key("a number > 0 in m/s²", 1e-12, 1e12)
TURN_RATE = Key("a number > 0 in rad/s", 1e-9, 1e3)

CONSTANT_VELOCITY, CONSTANT_ACCELERATION, COORDINATED_TURN, RANDOM_WALK = 0, 1, 2, 3


class MotionRule(NamedTuple):
    """How objects move, as kernels read it.

    A state of ``n`` components holds positions, velocities, accelerations if any mode has them,
    and a turn rate [rad/s, clockwise seen from above] if any mode turns. ``kind`` says what each
    mode is and ``noise`` its main process noise and that of its turn rate. ``share`` is how much
    of the time objects spend in each mode. After t seconds the mode has changed with the
    probabilities ``basis[0]`` diag(exp(−``decay`` t)) ``basis[1]``, from row to column. ``prior``
    is the variance of each component of which nothing is known, 0 for positions.
    ``acceleration_at`` and ``turn_at`` say where accelerations and the turn rate stand, -1 for
    nowhere. ``unscented`` says how measurements are foreseen: over sigma points instead of by
    derivatives. Turns are always predicted over sigma points.
    """

    dim: int
    kind: IntArray
    noise: FloatArray
    share: FloatArray
    decay: FloatArray
    basis: FloatArray
    prior: FloatArray
    acceleration_at: int
    turn_at: int
    unscented: bool
    max_speed: float


class _OneWay:
    """What every single way to move shares."""

    __slots__ = ()

    process_noise: float
    max_speed: float

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
        return _ball_variance(self.max_speed, dim)

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
        The rule, of one mode.
        """
        return _rule((self,), None, dim, unscented=unscented)


@dataclass(frozen=True, slots=True)
class ConstantVelocity(_OneWay):
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

    process_noise: Annotated[float, PROCESS_NOISE]
    max_speed: Annotated[float, SPEED]

    def __post_init__(self) -> None:
        settle(self)


@dataclass(frozen=True, slots=True)
class ConstantAcceleration(_OneWay):
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

    process_noise: Annotated[float, PROCESS_NOISE.said("a number ≥ 0 in m²/s⁵")]
    max_speed: Annotated[float, SPEED]
    max_acceleration: Annotated[float, ACCELERATION]

    def __post_init__(self) -> None:
        settle(self)


@dataclass(frozen=True, slots=True)
class CoordinatedTurn(_OneWay):
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

    process_noise: Annotated[float, PROCESS_NOISE]
    turn_noise: Annotated[float, TURN_NOISE]
    max_speed: Annotated[float, SPEED]
    max_turn_rate: Annotated[float, TURN_RATE]

    def __post_init__(self) -> None:
        settle(self)


@dataclass(frozen=True, slots=True)
class RandomWalk(_OneWay):
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

    process_noise: Annotated[float, PROCESS_NOISE.said("a number ≥ 0 in m²/s")]
    max_speed: Annotated[float, SPEED]

    def __post_init__(self) -> None:
        settle(self)


Mode: TypeAlias = ConstantVelocity | ConstantAcceleration | CoordinatedTurn | RandomWalk


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
        return _ball_variance(self.max_speed, dim)

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
        return _rule(self.models, self.sojourn_time, dim, unscented=unscented)


Motion: TypeAlias = Mode | Imm


def _ball_variance(radius: float, dim: int) -> float:
    """Return the variance along an axis of what is spread uniformly over a ball."""
    return float(radius**2 / (dim + 2))


def _chain(sojourn_time: tuple[float, ...]) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return each mode's share, and the decays and basis of the transitions."""
    stay = np.asarray(sojourn_time, dtype=float)
    share = stay / stay.sum()
    leaving = np.full((stay.size, stay.size), 1.0 / (stay.size - 1)) / stay[:, None]
    np.fill_diagonal(leaving, -1.0 / stay)
    # As many changes lead from one mode to another as back, so that scaled by the roots of the
    # shares the matrix of rates is symmetric.
    root = np.sqrt(share)
    values, vectors = np.linalg.eigh(root[:, None] * leaving / root)
    basis = np.stack([vectors / root[:, None], vectors.T * root])
    return share, np.maximum(-values, 0.0), basis


def _rule(
    models: tuple[_OneWay, ...],
    sojourn_time: tuple[float, ...] | None,
    dim: int,
    *,
    unscented: bool,
) -> MotionRule:
    """Return the rule of one or more modes, with room for what any of them needs."""
    max_speed = max(model.max_speed for model in models)
    parts = [np.zeros(dim), np.full(dim, _ball_variance(max_speed, dim))]
    pulling = [m.max_acceleration for m in models if isinstance(m, ConstantAcceleration)]
    turning = [m.max_turn_rate for m in models if isinstance(m, CoordinatedTurn)]
    if pulling:
        parts.append(np.full(dim, _ball_variance(max(pulling), dim)))
    if turning:
        parts.append(np.full(1, max(turning) ** 2 / 3.0))
    if sojourn_time is None:
        share, decay, basis = np.ones(1), np.zeros(1), np.ones((2, 1, 1))
    else:
        share, decay, basis = _chain(sojourn_time)
    kinds = [_KINDS[type(model)] for model in models]
    noise = [[model.process_noise, getattr(model, "turn_noise", 0.0)] for model in models]
    return MotionRule(
        dim=int(dim),
        kind=np.array(kinds, dtype=np.int64),
        noise=np.array(noise, dtype=np.float64),
        share=share,
        decay=decay,
        basis=basis,
        prior=np.concatenate(parts),
        acceleration_at=2 * dim if pulling else -1,
        turn_at=(3 if pulling else 2) * dim if turning else -1,
        unscented=bool(unscented),
        max_speed=float(max_speed),
    )


_KINDS: dict[type, int] = {
    ConstantVelocity: CONSTANT_VELOCITY,
    ConstantAcceleration: CONSTANT_ACCELERATION,
    CoordinatedTurn: COORDINATED_TURN,
    RandomWalk: RANDOM_WALK,
}
