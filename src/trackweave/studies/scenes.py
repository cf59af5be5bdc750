"""Scenes of tracks: what several sensors' trackers know of objects, and whose each track is."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from trackweave.arrays import IntArray
from trackweave.association.chain_rule import TrackEstimates
from trackweave.fusion.pictures import LocalPicture

__all__ = ["SceneShape", "TrackScene", "draw_scene"]

SIGMA = np.array([10.0, 10.0, 2.0, 2.0])
"""Typical standard deviations of a track's position [m] and velocity [m/s]."""
COURSE = np.array([100.0, 0.0])
SPREAD = 1.0
"""Common velocity of all objects, and how much theirs differ [m/s]: not enough to tell by."""


@dataclass(frozen=True, slots=True)
class SceneShape:
    """How large and how crowded a scene is.

    ``spacing`` is the mean distance of objects to their neighbours, in standard deviations of a
    position; ``seen`` the probability that a sensor sees an object; ``shared`` the part of each
    error's variance that all sensors have in common.
    """

    sensors: int = 3
    objects: int = 10
    times: int = 5
    spacing: float = 6.0
    seen: float = 1.0
    shared: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class TrackScene:
    """What each sensor knows of its tracks at each time, and of which object each of these is."""

    estimates: tuple[TrackEstimates, ...]
    truth: tuple[IntArray, ...]
    shared: float = 0.0

    @property
    def names(self) -> list[str]:
        """Names of the sensors."""
        return [f"S{number + 1}" for number in range(len(self.truth))]

    def pictures(self, time: int) -> dict[str, LocalPicture]:
        """Return what the sensors say at a time."""
        return {
            name: LocalPicture(
                name, float(time), np.arange(each.n_tracks), each.mean[time],
                each.covariance[time],
            )
            for name, each in zip(self.names, self.estimates, strict=True)
        }  # fmt: skip

    def right(self, labels: Sequence[IntArray]) -> float:
        """Return the share of tracks whose group is exactly the tracks of their object."""
        truth, label = np.concatenate(self.truth), np.concatenate(labels)
        pairs, count = np.unique(np.stack([truth, label]), axis=1, return_counts=True)
        exact = count == np.bincount(truth)[pairs[0]]
        exact &= count == np.bincount(label)[pairs[1]]
        return float(count[exact].sum() / truth.shape[0])

    def tuples(self) -> frozenset[tuple[int, ...]]:
        """Return the right groups, each as its tracks' numbers sensor by sensor, -1 for none."""
        n_objects = 1 + max(int(mine.max(initial=-1)) for mine in self.truth)
        table = np.full((n_objects, len(self.truth)), -1, dtype=np.int64)
        for column, mine in enumerate(self.truth):
            table[mine, column] = np.arange(mine.shape[0])
        return frozenset(tuple(line) for line in table[(table >= 0).any(axis=1)].tolist())


def draw_scene(shape: SceneShape, rng: np.random.Generator) -> TrackScene:
    """Return a scene of objects that go the same way, spread evenly over a square."""
    # Errors are independent from time to time and, unless told otherwise, from sensor to sensor,
    # as the document assumes; each track has a covariance, each sensor an order of its own.
    side = shape.spacing * SIGMA[0] * np.sqrt(shape.objects)
    place = rng.uniform(0.0, side, (shape.objects, 2))
    velocity = COURSE + rng.normal(0.0, SPREAD, (shape.objects, 2))
    course = place + np.arange(shape.times)[:, None, None] * velocity
    state = np.concatenate([course, np.broadcast_to(velocity, course.shape)], axis=2)
    common = rng.normal(size=state.shape) * np.sqrt(shape.shared)
    truth, estimates = [], []
    for _ in range(shape.sensors):
        mine = rng.permutation(np.flatnonzero(rng.random(shape.objects) < shape.seen))
        truth.append(mine.astype(np.int64))
        scale = SIGMA * rng.uniform(0.7, 1.4, (len(mine), 1))
        error = common + rng.normal(size=state.shape) * np.sqrt(1.0 - shape.shared)
        spread = np.broadcast_to(np.eye(4) * (scale**2)[:, :, None], (*state[:, mine].shape, 4))
        estimates.append(TrackEstimates(state[:, mine] + error[:, mine] * scale, spread))
    return TrackScene(tuple(estimates), tuple(truth), shape.shared)
