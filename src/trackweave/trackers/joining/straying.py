"""How far objects stray from straight flight, learned from as long a time in which they were seen.

What an object does in a silence nobody saw. But what objects of the same record did in as long a
time while they were followed is known, and no model of motion tells it as well: ships that turn
now and then, aircraft that hold, people who stop.
"""

from dataclasses import dataclass
from math import lgamma, pi
from typing import Self

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.trackers.joining.segments import Paths, Segments

__all__ = ["Straying", "reach", "student_log_density"]

TAILS = (1.0, 2.0, 4.0, 8.0)
"""Degrees of freedom of Student's t that are tried: of some objects all turn a little, of others
most go dead straight and a few turn back."""
N_LAGS, N_STARTS, N_SEGMENTS, FEWEST = 14, 12, 300, 10
"""Times that are looked at, beginnings of such a time in one segment, segments, and how many
cases tell of one time."""
LEAST_STRAY, LEAST_CHANGE = 0.02, 0.05
"""Nobody flies straighter, as a share of the way, or keeps its speed better (of its logarithm)."""
NOWHERE, ANEW = 1e-3, 0.5
"""Who stood is so far from where it was, as a share of the way that it could have gone, and its
speed (the logarithm) so far from that before."""
REACH, SIGMAS = 2.0, 4.0
"""Nobody comes farther than so many times its speed before or after lets it, but for noise."""
SELDOM = 1e-3
"""So many do what nobody of the record did while it was followed, such as a balloon that bursts:
they are anywhere that they can reach."""
SCALES = np.exp(np.linspace(-25.0, 5.0, 121))
# SciPy's takes longer to import than all joins of a short run.
_log_gamma = np.vectorize(lgamma, otypes=[np.float64])


@dataclass(frozen=True, slots=True, eq=False)
class Straying:
    """How far objects come from where straight flight would have brought them, by time.

    Along and across their way (and upwards) the distance is Student's t, with scales that are
    shares of the way at the speed before; so is the change of the logarithm of the speed.
    """

    time: FloatArray  # Ascending [s], shape (times,)
    squares: FloatArray  # Squared scales: along, across[, up], speed; shape (times, dim + 1)
    tails: FloatArray  # Degrees of freedom, of the place and of the speed; shape (times, 2)

    @classmethod
    def learned(cls, paths: Paths, segments: Segments, least: float) -> Self | None:
        """Return what segments tell of times from a least one [s] on; None for nothing."""
        length = paths.states.time[paths.last] - paths.states.time[paths.first]
        firm = np.flatnonzero(segments.is_firm & (length > 0.0))
        if firm.size == 0:
            return None
        # Evenly chosen, as a record's beginning is no better than its end.
        firm = firm[np.linspace(0, firm.size - 1, min(firm.size, N_SEGMENTS)).astype(int)]
        times, found, tails = [], [], []
        for lag in np.geomspace(least, max(float(length.max()), 2.0 * least), N_LAGS):
            before, after = _cases(paths, firm[length[firm] >= lag], float(lag))
            told = _scales(paths, before, after)
            if told is not None:
                times.append(lag)
                found.append(told[0])
                tails.append(told[1])
        return cls(np.array(times), np.array(found), np.array(tails)) if times else None

    def log_density(
        self, paths: Paths, before: IntArray, after: IntArray
    ) -> tuple[FloatArray, FloatArray]:
        """Return how likely segments go from state to state, moving and standing, pair by pair."""
        # The logarithm of the density of the place [m⁻ᵈ] and of the logarithm of the speed.
        wait = paths.states.time[after] - paths.states.time[before]
        off, covariance, pace = _off(paths, before, after)
        scales, tails = self._at(wait, self.squares), self._at(wait, self.tails)
        dim = paths.dim
        diagonal = np.arange(dim)
        covariance[:, diagonal, diagonal] += (
            (scales[:, :dim] + LEAST_STRAY**2) * (pace * wait**2)[:, np.newaxis]
        )  # fmt: skip
        place = student_log_density(off, covariance, tails[:, 0])
        change, unsure = _change(paths, before, after)
        spread = unsure + scales[:, dim] + LEAST_CHANGE**2
        kept = student_log_density(
            change[:, np.newaxis], spread[:, np.newaxis, np.newaxis], tails[:, 1]
        )
        stood = _stood(paths, before, after, pace * wait**2)
        anew = _at_rest(change[:, np.newaxis], (unsure + ANEW**2)[:, np.newaxis, np.newaxis])
        anywhere = -_log_ball(reach(paths, before, after, wait), dim) + np.log(SELDOM)
        went = np.logaddexp(place + kept + np.log1p(-SELDOM), anywhere + anew)
        return went, stood + anew

    def _at(self, wait: FloatArray, told: FloatArray) -> FloatArray:
        logs = np.log(np.maximum(wait, self.time[0]))
        return np.stack([np.interp(logs, np.log(self.time), column) for column in told.T], axis=1)


def reach(paths: Paths, before: IntArray, after: IntArray, wait: FloatArray) -> FloatArray:
    """Return how far from the first state's place the second may be after a wait [m]."""
    states, dim = paths.states, paths.dim
    pace = np.exp(paths.speed(before, onwards=False)[0])
    later = np.exp(paths.speed(after, onwards=True)[0])
    spread = states.covariance[before] + states.covariance[after]
    noise = SIGMAS * np.sqrt(np.trace(spread[:, :dim, :dim], axis1=1, axis2=2))
    return np.asarray(REACH * np.maximum(pace, later) * wait + noise)


def _stood(paths: Paths, before: IntArray, after: IntArray, way: FloatArray) -> FloatArray:
    """Return how likely objects stood in the silence and are where they were, pair by pair."""
    # Of a way squared [m²] the part that is nothing keeps exact positions from being singular.
    states, dim = paths.states, paths.dim
    moved = states.mean[after, :dim] - states.mean[before, :dim]
    scale = states.covariance[before, :dim, :dim] + states.covariance[after, :dim, :dim]
    scale[:, np.arange(dim), np.arange(dim)] += (NOWHERE**2 * way)[:, np.newaxis]
    return _at_rest(moved, scale)


def _log_ball(radius: FloatArray, dim: int) -> FloatArray:
    """Return the logarithm of what balls of a radius hold [mᵈ]."""
    return np.asarray(0.5 * dim * np.log(pi) - lgamma(0.5 * dim + 1.0) + dim * np.log(radius))


def _at_rest(off: FloatArray, scale: FloatArray) -> FloatArray:
    return student_log_density(off, scale, np.full(off.shape[0], TAILS[-1]))


def student_log_density(off: FloatArray, scale: FloatArray, tail: FloatArray) -> FloatArray:
    """Return the log density of multivariate t, of shapes (rows, n), (rows, n, n) and (rows,)."""
    # S. Kotz, S. Nadarajah, Multivariate t Distributions and Their Applications, 2004, eq. (1.1).
    n = off.shape[1]
    squared = np.sum(off * np.linalg.solve(scale, off[..., np.newaxis])[..., 0], axis=1)
    size = _log_gamma((tail + n) / 2) - _log_gamma(tail / 2) - 0.5 * n * np.log(tail * pi)
    log_volume = 0.5 * np.linalg.slogdet(scale)[1]
    return np.asarray(size - log_volume - 0.5 * (tail + n) * np.log1p(squared / tail))


def _cases(paths: Paths, segments: IntArray, lag: float) -> tuple[IntArray, IntArray]:
    """Return states of segments, and those of the same a time later."""
    time, before, after = paths.states.time, [], []
    for segment in segments.tolist():
        first, last = paths.first[segment], paths.last[segment]
        own = time[first : last + 1]
        n = int(np.clip(3.0 * (own[-1] - own[0]) / lag, 1, N_STARTS))
        starts = np.linspace(own[0], own[-1] - lag, n)
        before.append(first + np.searchsorted(own, starts))
        after.append(first + np.minimum(np.searchsorted(own, starts + lag), own.size - 1))
    if not before:
        return np.empty(0, np.int64), np.empty(0, np.int64)
    early, late = np.concatenate(before), np.concatenate(after)
    apart = time[late] > time[early]
    return early[apart], late[apart]


def _scales(
    paths: Paths, before: IntArray, after: IntArray
) -> tuple[FloatArray, tuple[float, float]] | None:
    """Return the squared scales and the degrees of freedom that cases tell; None for too few."""
    off, covariance, pace = _off(paths, before, after)
    change, unsure = _change(paths, before, after)
    # Where an object stands it strays from nothing.
    moves = unsure < 1.0
    if np.count_nonzero(moves) < FEWEST:
        return None
    way = (pace * (paths.states.time[after] - paths.states.time[before]) ** 2)[moves]
    # Each segment counts once, however long.
    _, own, n = np.unique(
        paths.states.track[before][moves], return_inverse=True, return_counts=True
    )
    weight = 1.0 / n[own]
    axes = range(paths.dim)
    share = off[moves] / np.sqrt(way)[:, np.newaxis]
    known = covariance[moves][:, axes, axes] / way[:, np.newaxis]
    place, tail = _likeliest(share, known, weight)
    speed, steady = _likeliest(change[moves, np.newaxis], unsure[moves, np.newaxis], weight)
    return np.array([*place, *speed]), (tail, steady)


def _likeliest(
    off: FloatArray, known: FloatArray, weight: FloatArray
) -> tuple[list[float], float]:
    """Return the likeliest squared scale of each column beyond what is known, and their tail."""
    best: tuple[float, list[float], float] = (-np.inf, [], 0.0)
    for tail in TAILS:
        likely, scales = 0.0, []
        for own, unsure in zip(off.T, known.T, strict=True):
            spread = unsure[np.newaxis] + SCALES[:, np.newaxis]
            each = -0.5 * np.log(spread) - 0.5 * (tail + 1.0) * np.log1p(own**2 / (tail * spread))
            total = each @ weight
            scales.append(float(SCALES[np.argmax(total)]))
            size = _log_gamma((tail + 1) / 2) - _log_gamma(tail / 2) - 0.5 * np.log(tail * pi)
            likely += float(total.max()) + float(size) * float(weight.sum())
        if likely > best[0]:
            best = (likely, scales, tail)
    return best[1], best[2]


def _off(
    paths: Paths, before: IntArray, after: IntArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return how far later states are off straight flight, along the way, with squared speeds."""
    states, dim = paths.states, paths.dim
    early, late = states.mean[before], states.mean[after]
    wait = (states.time[after] - states.time[before])[:, np.newaxis]
    off = late[:, :dim] - early[:, :dim] - wait * early[:, dim:]
    own, lag = states.covariance[before], wait[:, np.newaxis]
    crossed = own[:, :dim, dim:] + own[:, dim:, :dim]
    covariance = own[:, :dim, :dim] + lag * crossed + lag**2 * own[:, dim:, dim:]
    covariance = covariance + states.covariance[after][:, :dim, :dim]
    heading = np.arctan2(early[:, dim + 1], early[:, dim])
    turned = np.tile(np.eye(dim), (before.size, 1, 1))
    turned[:, 0, 0] = turned[:, 1, 1] = np.cos(heading)
    turned[:, 0, 1], turned[:, 1, 0] = np.sin(heading), -np.sin(heading)
    along = np.einsum("nij,nj->ni", turned, off)
    pace = np.exp(2.0 * paths.speed(before, onwards=False)[0])
    return along, turned @ covariance @ turned.swapaxes(1, 2), pace


def _change(paths: Paths, before: IntArray, after: IntArray) -> tuple[FloatArray, FloatArray]:
    """Return how the logarithm of the speed changed, and how unsure that is."""
    early, unsure = paths.speed(before, onwards=False)
    late, also = paths.speed(after, onwards=True)
    return late - early, unsure + also
