"""How a sensor's picture of the world may be shifted, turned and late, and how to undo it."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from trackweave.arrays import FloatArray, float_array, is_number, require_finite
from trackweave.errors import InvalidInputError
from trackweave.fields import settle

__all__ = ["BIASES", "UNITS", "BiasGradient", "BiasModel"]

BIASES = ("translation", "rotation", "range", "azimuth", "clock")
"""What may be wrong with a sensor, by name."""
UNITS = {"translation": "m", "rotation": "rad", "range": "m", "azimuth": "rad", "clock": "s"}
"""Unit of each bias."""
_AXES = "xyz"
_NEAREST = 1.0
"""Range below which a range bias shortens no more [m]: nothing has a direction at range 0."""
_STEPS = {"translation": 1.0, "rotation": 1e-4, "range": 0.1, "azimuth": 1e-4, "clock": 1e-2}
"""Half widths of central differences; all functions are linear or nearly so over them."""


class BiasGradient(NamedTuple):
    """Corrected states and how they depend on what they were made from.

    ``by_state`` has shape (rows, n, n), ``by_bias`` (rows, n, biases).
    """

    mean: FloatArray
    by_state: FloatArray
    by_bias: FloatArray


@dataclass(frozen=True, slots=True)
class BiasModel:
    """What is taken to be wrong with a sensor, and where the sensor is.

    A sensor at ``position`` that sees an object at a range and an azimuth reports the range too
    long by the *range* bias and the azimuth too great by the *azimuth* bias; then its picture is
    turned about its position by the *rotation*, moved by the *translation*, and stamped with a
    clock that is ahead by the *clock* offset. About one point a rotation is an azimuth bias: only
    one of them can be estimated.

    Parameters
    ----------
    estimate
        The biases to be estimated, of ``BIASES``; the others are taken to be none.
    position
        Where the sensor is, as the reference sees it [m]: x east, y north[, z up].
    prior
        Standard deviation of a bias beforehand, by name [m, rad or s], about 0. A bias without
        one may be anything.

    Raises
    ------
    InvalidInputError
        If a name is unknown, there twice or goes with another, or a number is out of range.

    Examples
    --------
    >>> import trackweave as tw
    >>> model = tw.BiasModel(estimate=("translation", "clock"), prior={"clock": 0.5})  # s
    >>> model.names(2)
    ('translation_x', 'translation_y', 'rotation', 'range', 'azimuth', 'clock')
    >>> model.is_estimated(2)
    array([ True,  True, False, False, False,  True])
    """

    estimate: tuple[str, ...] = ("translation", "rotation", "clock")
    position: tuple[float, ...] = (0.0, 0.0)
    prior: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        settle(self)
        names = tuple(self.estimate)
        if not names or not set(names) <= set(BIASES) or len(set(names)) < len(names):
            raise InvalidInputError(
                f"estimate: {names!r:.80}; expected some of {', '.join(BIASES)}, each once"
            )
        if {"rotation", "azimuth"} <= set(names):
            raise InvalidInputError(
                "estimate: rotation and azimuth, which cannot be told apart: both turn the "
                "picture about the sensor; expected one of them"
            )
        position = float_array(self.position, "position", (None,))
        require_finite(position, "position")
        if position.shape[0] not in {2, 3}:
            raise InvalidInputError(f"position: {self.position!r:.80}; expected x, y[, z]")
        for name, sigma in self.prior.items():
            if name not in names:
                raise InvalidInputError(
                    f"prior: {name!r:.80}; expected names of what is estimated: {', '.join(names)}"
                )
            if not is_number(sigma) or sigma <= 0.0:
                raise InvalidInputError(
                    f"prior, {name}: {sigma!r:.80}; expected a number > 0 [{UNITS[name]}]"
                )
        object.__setattr__(self, "estimate", tuple(name for name in BIASES if name in names))
        object.__setattr__(self, "position", tuple(map(float, position)))

    def names(self, dim: int) -> tuple[str, ...]:
        """Return the names of all numbers of a bias, whether estimated or not.

        Parameters
        ----------
        dim
            Number of spatial dimensions.

        Returns
        -------
        translation_x, translation_y[, translation_z], rotation, range, azimuth, clock.
        """
        return (*(f"translation_{axis}" for axis in _AXES[:dim]), *BIASES[1:])

    def is_estimated(self, dim: int) -> NDArray[np.bool_]:
        """Tell which numbers of a bias are estimated, in the order of `names`."""
        kinds = [name.partition("_")[0] for name in self.names(dim)]
        return np.array([kind in self.estimate for kind in kinds])

    def each(self, values: Mapping[str, float], dim: int, other: float) -> FloatArray:
        """Return one number for each number of a bias.

        Parameters
        ----------
        values
            The numbers by the names of ``BIASES``.
        dim
            Number of spatial dimensions.
        other
            The number where there is none by that name.

        Returns
        -------
        The numbers in the order of `names`.
        """
        kinds = [name.partition("_")[0] for name in self.names(dim)]
        return np.array([values.get(kind, other) for kind in kinds], dtype=np.float64)

    def corrected(self, mean: FloatArray, bias: FloatArray) -> FloatArray:
        """Return states as they would be without the bias.

        Parameters
        ----------
        mean
            The sensor's states, shape (rows, 2 dim).
        bias
            The bias of all rows, shape (dim + 4,), or of each, shape (rows, dim + 4), in the
            order of `names`.

        Returns
        -------
        States at the same time by the reference's clock, of the same shape.
        """
        return self._corrected(mean, np.atleast_2d(bias))[0]

    def gradient(self, mean: FloatArray, bias: FloatArray) -> BiasGradient:
        """Return states as they would be without the bias, and the derivatives of that.

        Parameters
        ----------
        mean
            The sensor's states, shape (rows, 2 dim).
        bias
            The bias, shape (dim + 4,) or (rows, dim + 4), in the order of `names`.

        Returns
        -------
        States and derivatives. How the velocity of a range bias's correction depends on the
        position is left out: it is of the order of velocity × bias / range².
        """
        rows, n = mean.shape
        dim = n // 2
        bias = np.atleast_2d(bias)
        state, block = self._corrected(mean, bias)
        by_state = np.zeros((rows, n, n))
        by_state[:, :dim, :dim] = by_state[:, dim:, dim:] = block
        by_state[:, :dim, dim:] = bias[:, -1, None, None] * block
        steps = self.each(_STEPS, dim, 1.0)
        by_bias = np.zeros((rows, n, steps.shape[0]))
        for place in np.flatnonzero(self.is_estimated(dim)):
            step = np.zeros(steps.shape[0])
            step[place] = steps[place]
            ahead = self._corrected(mean, bias + step)[0]
            behind = self._corrected(mean, bias - step)[0]
            by_bias[:, :, place] = (ahead - behind) / (2.0 * steps[place])
        return BiasGradient(state, by_state, by_bias)

    def _corrected(self, mean: FloatArray, bias: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return corrected states and the derivative of position by position."""
        rows, dim = mean.shape[0], mean.shape[1] // 2
        centre = np.resize([*self.position, 0.0], 3)[:dim]
        # Undo the translation, then both turns, then the range bias, then the clock.
        turn = _turned_back(bias[:, dim] + bias[:, dim + 2], dim)
        away = np.einsum("rij,rj->ri", turn, mean[:, :dim] - bias[:, :dim] - centre)
        reach = np.maximum(np.linalg.norm(away, axis=1), _NEAREST)
        too_long = bias[:, dim + 1]
        outward = np.einsum("ri,rj->rij", away, away) * (too_long / reach**3)[:, None, None]
        kept = (1.0 - too_long / reach)[:, None]
        block = np.einsum("rij,rjk->rik", kept[:, :, None] * np.eye(dim) + outward, turn)
        velocity = np.einsum("rij,rj->ri", block, mean[:, dim:])
        position = centre + kept * away + bias[:, -1, None] * velocity
        return np.concatenate([position, velocity], axis=1), np.broadcast_to(
            block, (rows, dim, dim)
        )


def _turned_back(angle: FloatArray, dim: int) -> FloatArray:
    """Return the matrices that turn counter-clockwise: azimuths grow clockwise."""
    turn = np.zeros((angle.shape[0], dim, dim))
    turn[:, 0, 0] = turn[:, 1, 1] = np.cos(angle)
    turn[:, 0, 1] = -np.sin(angle)
    turn[:, 1, 0] = np.sin(angle)
    if dim == 3:
        turn[:, 2, 2] = 1.0
    return turn
