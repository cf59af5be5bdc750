"""What ways to move share: the form that kernels read, and what a configuration tells."""

from typing import ClassVar, NamedTuple, Protocol, Self

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.keys import Key

__all__ = [
    "PROCESS_NOISE", "USUAL_PROCESS", "USUAL_SPEED", "MotionRule", "OneWay", "Told",
    "ball_variance", "rule_of",
]  # fmt: skip

# Units may be anything: nanometres, or days.
PROCESS_NOISE = Key("a number ≥ 0 in m²/s³", 0, 1e30)
# What is taken where neither the file nor the reports tell: a vehicle's.
USUAL_SPEED, USUAL_PROCESS = 50.0, 1.0


class Told(Protocol):
    """What a configuration tells of one way to move."""

    @property
    def period(self) -> float:
        """The shortest time from scan to scan [s]."""

    def above(self, key: str, usual: float) -> float:
        """Return the value of a key, of ``[motion]`` where its own table leaves it out."""

    def own(self, key: str, usual: float) -> float:
        """Return the value of a key whose unit is another than in ``[motion]``."""


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


class OneWay:
    """What every single way to move shares: each has a word in files and a number for kernels."""

    __slots__ = ()

    word: ClassVar[str]
    number: ClassVar[int]
    process_noise: float
    max_speed: float

    @classmethod
    def told(cls, told: Told) -> Self:
        """Return the model that a configuration tells, what is left out being usual."""
        raise NotImplementedError

    def further(self) -> tuple[float, float, float]:
        """Return greatest acceleration and turn rate, and the turn's noise; 0 for having none."""
        return 0.0, 0.0, 0.0

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
        The rule, of one mode.
        """
        return rule_of((self,), None, dim, unscented=unscented)


def ball_variance(radius: float, dim: int) -> float:
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


def rule_of(
    models: tuple[OneWay, ...],
    sojourn_time: tuple[float, ...] | None,
    dim: int,
    *,
    unscented: bool,
) -> MotionRule:
    """Return the rule of one or more modes, with room for what any of them needs."""
    max_speed = max(model.max_speed for model in models)
    parts = [np.zeros(dim), np.full(dim, ball_variance(max_speed, dim))]
    further = [model.further() for model in models]
    pulling, turning, _ = map(max, zip(*further, strict=True))
    if pulling:
        parts.append(np.full(dim, ball_variance(pulling, dim)))
    if turning:
        parts.append(np.full(1, turning**2 / 3.0))
    if sojourn_time is None:
        share, decay, basis = np.ones(1), np.zeros(1), np.ones((2, 1, 1))
    else:
        share, decay, basis = _chain(sojourn_time)
    kinds = [model.number for model in models]
    noise = [[model.process_noise, own[2]] for model, own in zip(models, further, strict=True)]
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
