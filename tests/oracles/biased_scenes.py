"""Two sensors that track the same objects, the second shifted, turned and late."""

from dataclasses import dataclass

import numpy as np

from trackweave.filters.kalman import predicted, updated
from trackweave.fusion.pictures import LocalPicture


@dataclass(frozen=True)
class Truth:
    """What is wrong with sensor B, and how its objects move."""

    n_objects: int = 10
    dim: int = 2
    n_times: int = 28
    period: float = 4.0
    process_noise: float = 0.5
    sigma: float = 50.0
    translation: tuple[float, ...] = (1000.0, -300.0, 200.0)
    angle: float = np.deg2rad(2.0)
    range_bias: float = 0.0
    late: float = 0.5
    centre: tuple[float, ...] = (0.0, 0.0, 0.0)
    headings: float = 2.0 * np.pi

    def numbers(self, turned_by: str = "rotation") -> np.ndarray:
        """The bias in the order of `BiasModel.names`."""
        turns = [self.angle, 0.0] if turned_by == "rotation" else [0.0, self.angle]
        return np.array(
            [*self.translation[: self.dim], turns[0], self.range_bias, turns[1], self.late]
        )


@dataclass(frozen=True)
class Scene:
    """Pictures of both sensors, the right pairs, and where the objects end."""

    reference: list[LocalPicture]
    other: list[LocalPicture]
    pairs: np.ndarray
    last: np.ndarray


def scene(truth: Truth, rng: np.random.Generator, *, first: int = 2) -> Scene:
    """Simulate reports of both sensors and track them; pictures begin with the given update."""
    n, dim = truth.n_objects, truth.dim
    heading, speed = rng.uniform(0, truth.headings, n), rng.uniform(100, 300, n)
    extent = np.array([20e3, 20e3, 3e3])[:dim]
    state = np.zeros((n, 2 * dim))
    state[:, :dim] = rng.uniform(-extent, extent, (n, dim))
    state[:, dim], state[:, dim + 1] = speed * np.sin(heading), speed * np.cos(heading)
    numbers = rng.permutation(n) + 1, rng.permutation(n) + 101
    pictures: tuple[list[LocalPicture], ...] = ([], [])
    tracks: list[tuple[np.ndarray, np.ndarray]] = []
    for k in range(truth.n_times + first):
        late = _moved(state, truth.period - truth.late, truth, rng)
        state = _moved(late, truth.late, truth, rng)
        places = state[:, :dim], _biased(late[:, :dim], truth)
        reports = [place + truth.sigma * rng.normal(size=(n, dim)) for place in places]
        tracks = (
            [
                _followed(*track, report, truth)
                for track, report in zip(tracks, reports, strict=True)
            ]
            if tracks
            else [_begun(report, truth) for report in reports]
        )
        for side in range(2) if k >= first else ():
            pictures[side].append(
                LocalPicture("AB"[side], k * truth.period, numbers[side], *tracks[side])
            )
    return Scene(*pictures, np.stack(numbers, axis=1), state)


def _moved(
    state: np.ndarray, interval: float, truth: Truth, rng: np.random.Generator
) -> np.ndarray:
    n = state.shape[0]
    mean, noise = predicted(
        state, np.zeros((n, *state.shape[1:] * 2)), np.full(n, interval), truth.process_noise
    )
    if not noise.any():
        return mean
    return mean + np.einsum("rij,rj->ri", np.linalg.cholesky(noise), rng.normal(size=mean.shape))


def _biased(position: np.ndarray, truth: Truth) -> np.ndarray:
    dim = truth.dim
    away = position - np.array(truth.centre[:dim])
    reach = np.linalg.norm(away, axis=1, keepdims=True)
    away = away * (reach + truth.range_bias) / reach
    cos, sin = np.cos(truth.angle), np.sin(truth.angle)
    # Clockwise, from north to east.
    east, north = cos * away[:, 0] + sin * away[:, 1], cos * away[:, 1] - sin * away[:, 0]
    away[:, 0], away[:, 1] = east, north
    return np.array(truth.centre[:dim]) + away + np.array(truth.translation[:dim])


def _begun(report: np.ndarray, truth: Truth) -> tuple[np.ndarray, np.ndarray]:
    n, dim = report.shape
    spread = np.diag([truth.sigma**2] * dim + [200.0**2] * dim)
    return np.concatenate([report, np.zeros((n, dim))], axis=1), np.tile(spread, (n, 1, 1))


def _followed(
    mean: np.ndarray, covariance: np.ndarray, report: np.ndarray, truth: Truth
) -> tuple[np.ndarray, np.ndarray]:
    interval = np.full(mean.shape[0], truth.period)
    ahead = predicted(mean, covariance, interval, truth.process_noise)
    return updated(*ahead, report, np.full(report.shape, truth.sigma))
