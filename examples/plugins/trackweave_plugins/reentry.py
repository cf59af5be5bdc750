"""A body that falls back through the atmosphere, slowed down by drag it is not known how much."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from trackweave import InvalidInputError, slope_of

GRAVITY = 9.81
"""At the ground [m/s²]; the Earth is flat here, as far as a radar sees."""
EARTH = 6_371_000.0
SEA_LEVEL, SCALE_HEIGHT = 1.225, 7_200.0
"""Density of the air at sea level [kg/m³], and how high it falls to 1/e [m]."""
STEPS, MOST_DRAG = 10, 2.0
"""Steps of integration of an interval; the drag a body can have at its speed [1/s]."""


@dataclass(frozen=True, slots=True)
class Reentry:
    """Gravity and drag; the state ends with how much less drag there is than usual [powers of e].

    Parameters
    ----------
    ballistic_coefficient
        A usual body's mass over its drag area, m / (c_d A) [kg/m²].
    ballistic_spread
        Standard deviation of its logarithm over all bodies.
    process_noise
        Power spectral density of other accelerations along each axis [m²/s³].
    ballistic_noise
        How fast the logarithm's variance grows [1/s].
    max_speed
        Greatest speed [m/s].

    Raises
    ------
    InvalidInputError
        If a value is not positive.
    """

    ballistic_coefficient: float = 500.0
    ballistic_spread: float = 1.0
    process_noise: float = 10.0
    ballistic_noise: float = 1e-4
    max_speed: float = 8_000.0
    dim: ClassVar[int] = 3

    def __post_init__(self) -> None:
        for name in ("ballistic_coefficient", "ballistic_spread", "process_noise", "max_speed"):
            if not getattr(self, name) > 0:
                raise InvalidInputError(f"{name}: {getattr(self, name)}; expected a number > 0")

    def begin(self, position: np.ndarray, covariance: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return states of bodies of which a report told the position."""
        rows = position.shape[0]
        mean, spread = np.zeros((rows, 7)), np.zeros((rows, 7, 7))
        mean[:, :3], spread[:, :3, :3] = position, covariance
        spread[:, 3:6, 3:6] = self.max_speed**2 / 5.0 * np.eye(3)
        spread[:, 6, 6] = self.ballistic_spread**2
        return mean, spread

    def predict(
        self, mean: np.ndarray, covariance: np.ndarray, interval: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return states after an interval each, and their slopes."""
        slope = slope_of(lambda state: self._fall(state, interval), mean)
        ahead = slope @ covariance @ slope.swapaxes(1, 2) + self._noise(interval)
        ahead = (ahead + ahead.swapaxes(1, 2)) / 2
        # Where a long interval makes all known as good as one thing, digits are lost.
        ahead += 1e-12 * np.eye(7) * np.diagonal(ahead, axis1=1, axis2=2)[:, None]
        return self._fall(mean, interval), ahead, slope

    def _fall(self, state: np.ndarray, interval: np.ndarray) -> np.ndarray:
        """Return states after an interval each, by Runge and Kutta's fourth order."""
        step, half = interval[:, None] / STEPS, interval[:, None] / STEPS / 2
        for _ in range(STEPS):
            first = self._rate(state)
            second = self._rate(state + half * first)
            third = self._rate(state + half * second)
            fourth = self._rate(state + step * third)
            state = state + step * (first + 2 * second + 2 * third + fourth) / 6
        return state

    def _rate(self, state: np.ndarray) -> np.ndarray:
        """Return how fast states change."""
        velocity, height = state[:, 3:6], state[:, 2]
        speed = np.minimum(np.linalg.norm(velocity, axis=1), 2 * self.max_speed)
        density = SEA_LEVEL * np.exp(-np.clip(height, 0.0, 50 * SCALE_HEIGHT) / SCALE_HEIGHT)
        coefficient = self.ballistic_coefficient * np.exp(np.clip(state[:, 6], -5.0, 5.0))
        drag = np.minimum(density * speed / (2 * coefficient), MOST_DRAG)
        rate = np.zeros_like(state)
        rate[:, :3] = velocity
        rate[:, 3:6] = -drag[:, None] * velocity
        rate[:, 5] -= GRAVITY / (1.0 + np.maximum(height, 0.0) / EARTH) ** 2
        return rate

    def _noise(self, interval: np.ndarray) -> np.ndarray:
        """Return what is not foreseen over an interval each; as much on the way back."""
        noise, long, eye = np.zeros((interval.size, 7, 7)), np.abs(interval), np.eye(3)
        noise[:, :3, :3] = (long**3 / 3)[:, None, None] * eye
        cross = (interval * long / 2)[:, None, None] * eye
        noise[:, :3, 3:6] = noise[:, 3:6, :3] = cross
        noise[:, 3:6, 3:6] = long[:, None, None] * eye
        noise *= self.process_noise
        noise[:, 6, 6] = self.ballistic_noise * long
        return noise
