"""Scenes of tracks that sensors keep of objects, for the tests of fusion."""

import numpy as np

from trackweave.fusion.associator import Association
from trackweave.fusion.pictures import LocalPicture

SIGMA = np.array([10.0, 10.0, 2.0, 2.0])


def picture(
    sensor: str, time: float, tracks: dict[int, tuple[float, float]], *, sigma: float = 10.0
) -> LocalPicture:
    """Return tracks that stand still at places, some 1 m/s sure of it."""
    mean = [[x, y, 0.0, 0.0] for x, y in tracks.values()]
    covariance = np.tile(np.diag([sigma**2, sigma**2, 1.0, 1.0]), (len(tracks), 1, 1))
    if not tracks:
        return LocalPicture.empty(sensor, time, 2)
    return LocalPicture(sensor, time, np.array(list(tracks)), mean, covariance)


class Objects:
    """Objects on a grid at first, and what sensors say of them with independent errors."""

    def __init__(self, rng: np.random.Generator, n_objects: int, *, spacing: float = 10.0) -> None:
        self.rng = rng
        side = int(np.ceil(np.sqrt(n_objects)))
        grid = np.stack(np.divmod(np.arange(n_objects), side), axis=1)
        self.place = spacing * SIGMA[0] * grid.astype(float)
        self.velocity = rng.normal(0.0, 10.0, (n_objects, 2))

    def seen(self, sensor: str, time: float, which: np.ndarray | None = None) -> LocalPicture:
        """Return a sensor's tracks, numbered as the objects."""
        track = np.arange(len(self.place)) if which is None else which
        state = np.concatenate([self.place + time * self.velocity, self.velocity], axis=1)[track]
        mean = state + SIGMA * self.rng.normal(size=state.shape)
        return LocalPicture(
            sensor, time, track, mean, np.tile(np.diag(SIGMA**2), (len(track), 1, 1))
        )


def partition(found: Association) -> set[frozenset[tuple[str, int]]]:
    """Return the groups of two tracks and more."""
    groups: dict[int, set[tuple[str, int]]] = {}
    for sensor, track, number in zip(found.sensor, found.track, found.object, strict=True):
        groups.setdefault(int(number), set()).add((found.names[sensor], int(track)))
    return {frozenset(group) for group in groups.values() if len(group) > 1}


def contrasts(mean: np.ndarray, covariance: np.ndarray) -> float:
    """Return the squared distance of one time's estimates to each other, all differences at once.

    The differences to the first have the covariance L Σ Lᵀ; an oracle for the fused mean.
    """
    n_members, n = mean.shape
    whole = np.zeros((mean.size, mean.size))
    for member in range(n_members):
        place = slice(member * n, (member + 1) * n)
        whole[place, place] = covariance[member]
    ones = -np.ones((n_members - 1, 1))
    difference = np.kron(np.hstack([ones, np.eye(n_members - 1)]), np.eye(n))
    t = difference @ mean.reshape(-1)
    return float(t @ np.linalg.solve(difference @ whole @ difference.T, t))
