"""Motion models from outside the package: what they offer, and what stands for them."""

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.domain.foreign_kind import shaped, slope_of
from trackweave.errors import InvalidInputError
from trackweave.fields import checked_number
from trackweave.models.motion import Imm, Mode, MotionRule
from trackweave.plugin_faults import told_as_theirs

__all__ = ["AnyMotion", "ForeignMotion", "MotionModel", "checked_motion"]

FOREIGN_MOTION = -1
"""What kernels read as the kind of a mode that they do not know."""


class MotionModel(Protocol):
    """A way to move: one class, best a frozen dataclass, whose fields are its keys.

    A state begins with a position [m]; a velocity [m/s] comes next, and then whatever else.
    ``max_speed`` is how fast an object can be [m/s]. Everything is for many rows at once. It may
    also have ``dim``, the number of dimensions of the tracking space that it is for, and, where
    no velocity comes next, ``kinematics(mean)``, the positions and velocities that states tell
    of, shape (rows, 2 dim).

    Examples
    --------
    >>> import numpy as np
    >>> import trackweave as tw
    >>> class Moored:
    ...     max_speed = 1.0  # m/s
    ...
    ...     def begin(self, position, covariance):
    ...         mean, spread = np.zeros((len(position), 4)), np.zeros((len(position), 4, 4))
    ...         mean[:, :2], spread[:, :2, :2] = position, covariance
    ...         return mean, spread + 1e-4 * np.eye(4)
    ...
    ...     def predict(self, mean, covariance, interval):
    ...         wider = np.abs(interval)[:, None, None] * np.diag([0.1, 0.1, 0.0, 0.0])
    ...         return mean, covariance + wider, np.tile(np.eye(4), (len(mean), 1, 1))
    ...
    >>> radar = tw.Sensor("radar", sigma=5.0)
    >>> tracker = tw.MultiHypothesisTracker(motion=Moored(), sensors=[radar])
    >>> tracker.step(tw.Scan(time=0.0, sensor="radar", measurement=[[20.0, 0.0]])).time
    0.0
    """

    max_speed: float

    def begin(self, position: FloatArray, covariance: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the states of new objects, of which a report told the position.

        Parameters
        ----------
        position, covariance
            Shapes (rows, dim) and (rows, dim, dim).

        Returns
        -------
        Means, shape (rows, size), which begin with the positions, and covariances, shape (rows,
        size, size), in which those of the positions stand first.
        """
        ...

    def predict(
        self, mean: FloatArray, covariance: FloatArray, interval: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return states after an interval each.

        Parameters
        ----------
        mean, covariance
            Shapes (rows, size) and (rows, size, size).
        interval
            Seconds, shape (rows,), never 0. A negative one asks for the state of before, with
            as much noise as on the way there.

        Returns
        -------
        Means, covariances with the process noise, and the derivatives of the new means by the
        old, shape (rows, size, size).
        """
        ...


@dataclass(frozen=True, slots=True)
class ForeignMotion:
    """What stands for a motion model from outside, beside our own.

    Parameters
    ----------
    model
        The model itself.

    Raises
    ------
    InvalidInputError
        If something is missing of what a model has to offer.
    """

    model: Any

    def __post_init__(self) -> None:
        for name, call in (
            ("begin", "begin(position, covariance), which returns means and covariances"),
            (
                "predict",
                "predict(mean, covariance, interval), which returns means, covariances and slopes",
            ),
        ):
            if not callable(getattr(self.model, name, None)):
                raise InvalidInputError(f"{self.name}: no method {name}; expected {call}")
        expected = "a finite number > 0 in m/s"
        speed = getattr(self.model, "max_speed", None)
        if not checked_number(speed, f"{self.name}: max_speed", expected) > 0:
            raise InvalidInputError(f"{self.name}: max_speed {speed}; expected {expected}")

    @property
    def name(self) -> str:
        """What messages call it."""
        return f"motion {type(self.model).__name__}"

    @property
    def max_speed(self) -> float:
        """Greatest speed of an object [m/s]."""
        return float(self.model.max_speed)

    @property
    def has_kinematics(self) -> bool:
        """Whether it tells velocities in another way than by what comes after the position."""
        return callable(getattr(self.model, "kinematics", None))

    def shown(
        self, mean: FloatArray, covariance: FloatArray, dim: int
    ) -> tuple[FloatArray, FloatArray]:
        """Return positions and velocities of states, and their covariances, 2 dim numbers each."""
        size = 2 * dim
        if not self.has_kinematics or not mean.shape[0]:
            return mean[:, :size], covariance[:, :size, :size]
        slope = slope_of(lambda state: self._kinematics(state, dim), mean)
        spread = slope @ covariance @ slope.swapaxes(1, 2)
        return self._kinematics(mean, dim), (spread + spread.swapaxes(1, 2)) / 2

    def _kinematics(self, mean: FloatArray, dim: int) -> FloatArray:
        shapes: list[tuple[int, ...]] = [(mean.shape[0], 2 * dim)]
        return self._called("kinematics", shapes, mean)[0]

    @property
    def process_noise(self) -> float:
        """As our own models have one; nothing is known of it here."""
        return 0.0

    def velocity_variance(self, dim: int) -> float:
        """Return the variance of a new object's velocity along one axis [m²/s²]."""
        place, spread = np.zeros((1, dim)), np.zeros((1, dim, dim))
        size = self.rule(dim).prior.size
        wide = self.shown(*self.begin(place, spread, size), dim)[1]
        return float(np.diagonal(wide[0])[dim:].mean())

    def rule(self, dim: int, *, unscented: bool = False) -> MotionRule:
        """Return what kernels have to know: how large a state is, what is not known at first."""
        # A rule of one mode that no kernel can move. Our own measurements may be foreseen over
        # sigma points. Refused for another number of dimensions, or if states do not begin with a
        # position and a velocity.
        if (getattr(self.model, "dim", None) or dim) != dim:
            raise InvalidInputError(
                f"{self.name}: for {self.model.dim} dimensions; expected {dim}, as reports have"
            )
        place, spread = np.zeros((1, dim)), np.zeros((1, dim, dim))
        with told_as_theirs(self.model, "motions", "begin"):
            mean, covariance = self.model.begin(place, spread)
        size = int(np.shape(mean)[-1]) if np.ndim(mean) == 2 else 0
        least = dim if self.has_kinematics else 2 * dim
        if size < least:
            words = "" if self.has_kinematics else ", or a method kinematics that tells velocities"
            raise InvalidInputError(
                f"{self.name}: begin returned means of shape {np.shape(mean)}; expected (1, size) "
                f"with a size of at least {least}: position, velocity, whatever else{words}"
            )
        _, covariance = self.begin(place, spread, size)
        return MotionRule(
            dim=int(dim),
            kind=np.array([FOREIGN_MOTION], dtype=np.int64),
            noise=np.zeros((1, 2)),
            share=np.ones(1),
            decay=np.zeros(1),
            basis=np.ones((2, 1, 1)),
            prior=np.ascontiguousarray(np.diagonal(covariance[0])),
            acceleration_at=-1,
            turn_at=-1,
            unscented=bool(unscented),
            max_speed=self.max_speed,
        )

    def begin(
        self, position: FloatArray, covariance: FloatArray, size: int
    ) -> tuple[FloatArray, FloatArray]:
        """Return states of so many numbers of new objects; see `MotionModel`."""
        rows = position.shape[0]
        shapes: list[tuple[int, ...]] = [(rows, size), (rows, size, size)]
        mean, spread = self._called("begin", shapes, position, covariance)
        return mean, spread

    def predict(
        self, mean: FloatArray, covariance: FloatArray, interval: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return states after an interval each, and the slopes; see `MotionModel`."""
        matrices = covariance.shape
        shapes = [mean.shape, matrices, matrices]
        ahead, spread, slope = self._called("predict", shapes, mean, covariance, interval)
        return ahead, spread, slope

    def _called(self, name: str, shapes: list[tuple[int, ...]], *given: Any) -> list[FloatArray]:
        """Return what a method makes of what it is given, of the shapes that it has to have."""
        with told_as_theirs(self.model, "motions", name):
            found = getattr(self.model, name)(*given)
        return shaped(found, shapes, self.name, name)


AnyMotion = Mode | Imm | ForeignMotion


def checked_motion(motion: Any) -> AnyMotion:
    """Return a motion model, one from outside as what stands for it."""
    if isinstance(motion, AnyMotion):
        return motion
    if isinstance(motion, type) or not hasattr(motion, "predict"):
        raise InvalidInputError(f"motion: {motion!r:.80}; expected a motion model")
    return ForeignMotion(motion)
