"""Models of ours as somebody else would write them, in plain NumPy."""

from dataclasses import dataclass

import numpy as np

from trackweave import Auto, slope_of


@dataclass(frozen=True)
class Straight:
    """Nearly constant velocity, as `ConstantVelocity`."""

    process_noise: float
    max_speed: float

    def begin(self, position, covariance):
        rows, dim = position.shape
        mean, spread = np.zeros((rows, 2 * dim)), np.zeros((rows, 2 * dim, 2 * dim))
        mean[:, :dim], spread[:, :dim, :dim] = position, covariance
        spread[:, dim:, dim:] = self.max_speed**2 / (dim + 2) * np.eye(dim)
        return mean, spread

    def predict(self, mean, covariance, interval):
        dim = mean.shape[1] // 2
        eye, step = np.eye(dim), interval[:, None, None]
        slope = np.tile(np.eye(2 * dim), (mean.shape[0], 1, 1))
        slope[:, :dim, dim:] = step * eye
        noise = np.zeros_like(slope)
        noise[:, :dim, :dim] = abs(step) ** 3 / 3 * eye
        noise[:, :dim, dim:] = noise[:, dim:, :dim] = step * abs(step) / 2 * eye
        noise[:, dim:, dim:] = abs(step) * eye
        ahead = np.einsum("rij,rj->ri", slope, mean)
        return ahead, slope @ covariance @ slope.swapaxes(1, 2) + self.process_noise * noise, slope


@dataclass(frozen=True)
class Place:
    """A position, as `MeasurementKind.POSITION`."""

    columns: tuple[str, ...] = ("x", "y")

    def expect(self, mean, platform, reported):
        width = len(self.columns)
        slope = np.zeros((mean.shape[0], width, mean.shape[1]))
        slope[:, :, :width] = np.eye(width)
        return mean[:, :width], slope

    def first_state(self, platform, reported):
        return reported.values, reported.covariance


@dataclass(frozen=True)
class RangeAzimuth:
    """Range and azimuth on the plane [m, rad], as `MeasurementKind.RANGE_AZIMUTH`."""

    columns: tuple[str, ...] = ("distance", "direction")

    def expect(self, mean, platform, reported):
        east, north = (mean[:, :2] - platform[:, :2]).T
        distance = np.hypot(east, north)
        value = np.stack([distance, np.arctan2(east, north) % (2 * np.pi)], axis=1)
        slope = np.zeros((mean.shape[0], 2, mean.shape[1]))
        slope[:, 0, 0], slope[:, 0, 1] = east / distance, north / distance
        slope[:, 1, 0], slope[:, 1, 1] = north / distance**2, -east / distance**2
        return value, slope

    def difference(self, values, expected):
        off = values - expected
        off[:, 1] = np.pi - (np.pi - off[:, 1]) % (2 * np.pi)
        return off

    def first_state(self, platform, reported):
        (distance, azimuth), sigma = reported.values.T, reported.sigma
        along = np.stack([np.sin(azimuth), np.cos(azimuth)], axis=1)
        across = np.stack([along[:, 1], -along[:, 0]], axis=1)
        place = platform[:, :2] + (distance * np.exp(sigma[:, 1] ** 2 / 2))[:, None] * along
        spread = sigma[:, 0, None, None] ** 2 * along[:, :, None] * along[:, None, :]
        wide = (distance * sigma[:, 1])[:, None, None] ** 2
        return place, spread + wide * across[:, :, None] * across[:, None, :]


@dataclass(frozen=True)
class Patient:
    """A solver, as `Auto`, with a key of its own."""

    patience: int = 1

    def __call__(self, problem, *, rng, hint=None, stop=None):
        return Auto()(problem, rng=rng, hint=hint, stop=stop)


@dataclass(frozen=True)
class Cruising:
    """A course and a speed, which wander; the state is x, y, speed, course."""

    max_speed: float = 60.0
    course: float = 0.0
    dim: int = 2

    def begin(self, position, covariance):
        rows = len(position)
        mean, spread = np.zeros((rows, 4)), np.zeros((rows, 4, 4))
        mean[:, :2], spread[:, :2, :2] = position, covariance
        mean[:, 2], mean[:, 3] = 15.0, self.course
        spread[:, 2, 2], spread[:, 3, 3] = 5.0**2, 0.6**2
        return mean, spread

    def kinematics(self, mean):
        speed, course = mean[:, 2:3], mean[:, 3:]
        return np.concatenate([mean[:, :2], speed * np.sin(course), speed * np.cos(course)], 1)

    def predict(self, mean, covariance, interval):
        def moved(state):
            ahead = state.copy()
            ahead[:, :2] += interval[:, None] * self.kinematics(state)[:, 2:]
            return ahead

        slope = slope_of(moved, mean)
        noise = abs(interval)[:, None, None] * np.diag([1.0, 1.0, 0.1, 1e-3])
        return moved(mean), slope @ covariance @ slope.swapaxes(1, 2) + noise, slope
