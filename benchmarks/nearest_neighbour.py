"""A plain tracker to compare with: Kalman filter, one-to-one assignment scan by scan, three hits.

It is what most people write first: predict each track at constant velocity, gate, pair tracks and
reports at the least total distance, start a track from every report left over, confirm it with
its third report, end it when it has been missed too often.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import linear_sum_assignment

Array = np.ndarray[Any, Any]


class Habits(NamedTuple):
    """What the plain tracker must be told."""

    process_noise: float  # m²/s³
    sigma: float  # m
    top_speed: float  # m/s
    gate: float = 16.0
    most_misses: int = 5
    hits_to_confirm: int = 3


class Seen(NamedTuple):
    """A confirmed track at the time of a scan; ``report`` is -1 where it was missed."""

    time: float
    track: int
    position: Array
    report: int


@dataclass
class _Track:
    number: int
    mean: Array
    covariance: Array
    time: float
    misses: int = 0
    reports: list[int] = field(default_factory=list)

    def ahead(self, now: float, noise: float) -> None:
        """Predict to a time."""
        dt, eye = now - self.time, np.eye(len(self.mean) // 2)
        step = np.kron(np.array([[1.0, dt], [0.0, 1.0]]), eye)
        drift = np.kron(np.array([[dt**3 / 3, dt**2 / 2], [dt**2 / 2, dt]]), eye)
        self.mean = step @ self.mean
        self.covariance = step @ self.covariance @ step.T + noise * drift
        self.time = now

    def take(self, position: Array, variance: float) -> None:
        """Update by a report."""
        dim = len(position)
        spread = self.covariance[:dim, :dim] + variance * np.eye(dim)
        gain = np.linalg.solve(spread, self.covariance[:dim]).T
        self.mean = self.mean + gain @ (position - self.mean[:dim])
        self.covariance = self.covariance - gain @ self.covariance[:dim]


def nearest_neighbour(time: Array, position: Array, habits: Habits) -> Iterator[Seen]:
    """Yield the confirmed tracks of each scan; a scan is the reports of one time."""
    variance, dim = habits.sigma**2, position.shape[1]
    alive: list[_Track] = []
    n_tracks = 0
    for now in np.unique(time):
        rows = np.flatnonzero(time == now)
        for one in alive:
            one.ahead(now, habits.process_noise)
        pairs = _pairs(alive, position[rows], variance, habits.gate)
        for place, one in enumerate(alive):
            if place in pairs:
                one.misses = 0
                one.take(position[rows[pairs[place]]], variance)
                one.reports.append(int(rows[pairs[place]]))
            else:
                one.misses += 1
        alive = [one for one in alive if one.misses < habits.most_misses]
        for row in np.delete(rows, list(pairs.values())):
            mean = np.concatenate([position[row], np.zeros(dim)])
            spread = np.diag([variance] * dim + [habits.top_speed**2 / 4] * dim)
            alive.append(_Track(n_tracks, mean, spread, now, reports=[int(row)]))
            n_tracks += 1
        for one in alive:
            if len(one.reports) >= habits.hits_to_confirm:
                report = one.reports[-1] if one.misses == 0 else -1
                yield Seen(float(now), one.number, one.mean[:dim], report)


def _pairs(alive: list[_Track], position: Array, variance: float, gate: float) -> dict[int, int]:
    """Return from a track's place to a report's place, paired at the least total distance."""
    if not alive or not len(position):
        return {}
    dim = position.shape[1]
    distance = np.empty((len(alive), len(position)))
    for place, one in enumerate(alive):
        off = position - one.mean[:dim]
        spread = one.covariance[:dim, :dim] + variance * np.eye(dim)
        distance[place] = np.sum(off * np.linalg.solve(spread, off.T).T, axis=1)
    first, second = linear_sum_assignment(np.minimum(distance, 10 * gate))
    near = distance[first, second] <= gate
    return dict(zip(first[near].tolist(), second[near].tolist(), strict=True))
