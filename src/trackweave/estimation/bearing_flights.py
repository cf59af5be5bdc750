"""How probable bearings are if one object, which flies nearly straight, made them all.

No bearing tells a place. All of them together do, if they are of one object: its path is a
Gaussian process, of which every bearing sees a side, and the probability of the bearings is what
is left when all paths are averaged over, as for the batch filters of target motion analysis
(Nardone, Lindgren and Gong 1984).
"""

import math
from typing import NamedTuple

import numpy as np

from trackweave.arrays import FloatArray, IntArray

__all__ = ["Bearings", "Flight", "flight_of"]

MOST_TURNS, SETTLED = 12, 1e-3
"""The path is found anew so often at most, until it moves by less than this share of its reach."""


class Bearings(NamedTuple):
    """Some bearings of any sensors, one number or row for each."""

    time: FloatArray  # [s]
    place: FloatArray  # Where the sensor was: x, y [m], shape (bearings, 2)
    angle: FloatArray  # Clockwise from north [rad]
    sigma: FloatArray  # [rad]

    def at(self, rows: IntArray) -> "Bearings":
        """Return some of them."""
        return Bearings(*(column[rows] for column in self))


class Flight(NamedTuple):
    """Bearings as those of one object."""

    cost: float  # Their negative log-likelihood [nats], infinite where no path settles
    path: FloatArray  # Where it was at each: x, y [m], shape (bearings, 2)


def flight_of(bearings: Bearings, process_noise: float, max_speed: float, reach: float) -> Flight:
    """Return how probable bearings are as those of one object, and where it flew.

    Parameters
    ----------
    bearings
        At least one.
    process_noise
        Of white acceleration [m²/s³], >= 0.
    max_speed
        Three standard deviations of each component of the velocity [m/s].
    reach
        Standard deviation of the object's place along each axis about the sensors' middle [m].

    Returns
    -------
    The flight.

    Examples
    --------
    >>> import numpy as np
    >>> time, place = np.repeat(np.arange(9.0), 2), np.tile([[0.0, 0.0], [900.0, 0.0]], (9, 1))
    >>> seen = np.stack([300.0 + 9.0 * time, np.full(18, 700.0)], axis=1) - place
    >>> angle = np.arctan2(seen[:, 0], seen[:, 1])
    >>> one = Bearings(time, place, angle, np.full(18, 0.01))
    >>> two = one._replace(angle=np.where(place[:, 0] > 0.0, angle[::-1], angle))
    >>> flight_of(one, 0.01, 50.0, 1000.0).cost < flight_of(two, 0.01, 50.0, 1000.0).cost
    True
    >>> flight_of(one, 0.01, 50.0, 1000.0).path[-1].round()
    array([372., 700.])
    """
    # Not above: it takes longer to import than a short run, which has no bearings, takes.
    from scipy.linalg import LinAlgError, cho_factor, cho_solve

    middle = bearings.place.mean(axis=0)
    spread = _covariance(bearings.time, process_noise, max_speed / 3.0, reach)
    path = _first_path(bearings)
    for _ in range(MOST_TURNS):
        east, north = (path - bearings.place).T
        square = np.maximum(east**2 + north**2, 1e-6 * reach**2)
        slope = np.stack([north, -east], axis=1) / square[:, None]
        off = bearings.angle - np.arctan2(east, north)
        off = (off + math.pi) % (2.0 * math.pi) - math.pi
        seen = off + (slope * (path - middle)).sum(axis=1)
        scatter = spread * (slope @ slope.T)
        scatter[np.diag_indices_from(scatter)] += bearings.sigma**2
        try:
            root = cho_factor(scatter, lower=True, overwrite_a=True, check_finite=False)
        except LinAlgError:
            break
        weight = cho_solve(root, seen, check_finite=False)
        volume = 2.0 * np.log(np.diag(root[0])).sum() + seen.size * math.log(2.0 * math.pi)
        cost = 0.5 * (float(seen @ weight) + float(volume))
        now = middle + spread @ (slope * weight[:, None])
        moved = float(np.abs(now - path).max())
        path = now
        if moved < SETTLED * reach:
            return Flight(cost, path)
    return Flight(math.inf, path)


def _covariance(time: FloatArray, process_noise: float, speed: float, reach: float) -> FloatArray:
    """Return the covariance of places along one axis at two times each [m²]."""
    since = time - time.min()
    early, late = np.minimum.outer(since, since), np.maximum.outer(since, since)
    mid = time - time.mean()
    # What white acceleration moves, integrated twice.
    wander = process_noise * early**2 * (3.0 * late - early) / 6.0
    return np.asarray(reach**2 + speed**2 * np.outer(mid, mid) + wander)


def _first_path(bearings: Bearings) -> FloatArray:
    """Return the straight path nearest to all lines of sight, shape (bearings, 2)."""
    sine, cosine = np.sin(bearings.angle), np.cos(bearings.angle)
    mid = bearings.time - bearings.time.mean()
    across = np.stack([cosine, -sine, mid * cosine, -mid * sine], axis=1)
    offset = cosine * bearings.place[:, 0] - sine * bearings.place[:, 1]
    line, *_ = np.linalg.lstsq(across, offset, rcond=None)
    return np.asarray(line[:2] + mid[:, None] * line[2:])
