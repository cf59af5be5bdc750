"""Tracks of several sensors become an assignment problem: which tracks are of one object.

After Huo, Zhang, Bai, Song, Xiong (2008): a tuple of one track per sensor costs the accumulated
distances between the tracks of consecutive sensors.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtri

from trackweave.arrays import (
    FloatArray,
    IntArray,
    float_array,
    n_axes,
    require_finite,
)
from trackweave.association.problem import AssignmentProblem
from trackweave.errors import InvalidInputError
from trackweave.fields import checked_count, checked_members, checked_number
from trackweave.summaries import summary

__all__ = [
    "Chains",
    "TrackEstimates",
    "accumulated_distance",
    "complete_chains",
    "same_object_threshold",
    "track_chains",
]

_BLOCK = 1_000_000
"""Numbers of pairwise covariances that are in memory at a time."""


@dataclass(frozen=True, slots=True, eq=False)
class TrackEstimates:
    """What one sensor knows of its tracks, at one time or at several.

    Parameters
    ----------
    mean
        State of each track, shape (tracks, dim), or (times, tracks, dim).
    covariance
        Its covariance, with two axes of length dim instead of one. Must be positive definite.

    Raises
    ------
    InvalidInputError
        If shapes do not fit, a number is not finite, or a covariance is not symmetric and
        positive definite.

    Examples
    --------
    >>> import numpy as np
    >>> import trackweave as tw
    >>> estimates = tw.TrackEstimates(mean=[[0.0, 0.0], [50.0, 0.0]], covariance=[np.eye(2)] * 2)
    >>> estimates.n_tracks, estimates.n_times, estimates.dim
    (2, 1, 2)
    """

    mean: FloatArray
    covariance: FloatArray

    __repr__ = summary

    def __post_init__(self) -> None:
        axes = n_axes(self.mean, "mean")
        if axes not in {2, 3}:
            raise InvalidInputError(
                f"mean: an array of {axes} axes; expected (tracks, dim) or (times, tracks, dim)"
            )
        mean = float_array(self.mean, "mean", (None,) * axes)
        covariance = float_array(self.covariance, "covariance", (*mean.shape, mean.shape[-1]))
        require_finite(mean, "mean")
        require_finite(covariance, "covariance")
        if axes == 2:
            mean, covariance = mean[None], covariance[None]
        if not mean.shape[0] or not mean.shape[2]:
            raise InvalidInputError(
                f"mean: an array of shape {mean.shape}; expected at least one time and dimension"
            )
        _require_covariances(covariance)
        object.__setattr__(self, "mean", mean)
        object.__setattr__(self, "covariance", covariance)

    @property
    def n_times(self) -> int:
        """Number of times."""
        return int(self.mean.shape[0])

    @property
    def n_tracks(self) -> int:
        """Number of tracks."""
        return int(self.mean.shape[1])

    @property
    def dim(self) -> int:
        """Length of a state."""
        return int(self.mean.shape[2])


@dataclass(frozen=True, slots=True, eq=False)
class Chains:
    """Candidate tuples of tracks and what they cost."""

    # One row per candidate, one column per sensor: the 1-based number of the sensor's track, 0 for
    # none.
    tuples: IntArray
    costs: FloatArray  # Shape (rows,)
    # Accumulated distance up to which two tracks may be of one object; infinite where every track
    # has to be in exactly one tuple with a track of each sensor.
    threshold: float

    def problem(self) -> AssignmentProblem:
        """Return the problem of choosing tuples that share no track, for a solver."""
        return AssignmentProblem.from_tuples(self.tuples, self.costs, alone=self.threshold)


def same_object_threshold(false_rejection: float, n_times: int, dim: int) -> float:
    """Return the accumulated distance that two tracks of one object exceed so rarely."""
    # It is δ with P{λ ≥ δ} = α, the probability of rejecting two tracks of one object, for λ of χ²
    # with k·n degrees of freedom, k times and n the length of a state. That holds where errors are
    # independent from time to time.
    if not 0.0 < false_rejection < 1.0:
        raise InvalidInputError(
            f"false_rejection: {false_rejection}; expected a probability between 0 and 1"
        )
    if min(n_times, dim) < 1:
        raise InvalidInputError(f"n_times, dim: {n_times}, {dim}; expected both at least 1")
    return float(chdtri(n_times * dim, false_rejection))


def accumulated_distance(first: TrackEstimates, second: TrackEstimates) -> FloatArray:
    """Return the accumulated distances of the tracks of two sensors, shape (first, second)."""
    # λ = Σ tᵀ C⁻¹ t with the difference t of the states and C the sum of their covariances: Huo,
    # Zhang, Bai, Song, Xiong, 2008, eqs. (3), (6) and (7). Errors of different sensors are taken
    # to be independent; times and dimensions must be the same.
    _require_alike([first, second])
    distance = np.zeros((first.n_tracks, second.n_tracks))
    step = max(1, _BLOCK // max(1, second.n_tracks * second.dim**2))
    for time in range(first.n_times):
        for begin in range(0, first.n_tracks, step):
            rows = slice(begin, begin + step)
            difference = first.mean[time, rows, None] - second.mean[time, None]
            spread = first.covariance[time, rows, None] + second.covariance[time, None]
            weighted = np.linalg.solve(spread, difference[..., None])[..., 0]
            distance[rows] += np.einsum("abi,abi->ab", difference, weighted)
    return distance


def track_chains(
    sensors: Sequence[TrackEstimates],
    *,
    false_rejection: float | None = None,
    max_tuples: int = 2_000_000,
) -> Chains:
    """Return the tuples of tracks that may be of one object, and what they cost.

    Without ``false_rejection`` this is the document's problem: all sensors have equally many
    tracks, every tuple takes one of each, every track is used exactly once, and a tuple costs
    b, the sum of the accumulated distances between consecutive sensors.

    With it, objects may be seen by some sensors only, and lists may differ in length or be empty.
    Consecutive are then the sensors that a tuple has; no two consecutive tracks are farther
    apart than the threshold δ; and every object costs δ: a tuple b + δ, a track left alone δ.
    So joining two tracks pays exactly where their distance is below δ. An inner track of a longer
    chain is left alone where the distances to it exceed the distance past it by more than δ,
    which is more often than α, because its own error counts twice.

    Parameters
    ----------
    sensors
        The tracks of each sensor, at least two of them, in the order of the chain.
    false_rejection
        Probability of rejecting two tracks of one object, between 0 and 1; None to reject none.
    max_tuples
        Greatest number of tuples, at least 1; more are refused.

    Returns
    -------
    The candidates, sensor by sensor.

    Raises
    ------
    InvalidInputError
        If sensors do not fit each other, an argument is out of range, the lists differ in length
        without ``false_rejection``, or there are too many tuples.

    References
    ----------
    .. [1] Huo, Zhang, Bai, Song, Xiong, 2008, eqs. (7), (9), (11) and (12).

    Examples
    --------
    >>> import numpy as np
    >>> import trackweave as tw
    >>> first = tw.TrackEstimates(mean=[[0.0, 0.0], [50.0, 0.0]], covariance=[np.eye(2)] * 2)
    >>> second = tw.TrackEstimates(mean=[[51.0, 0.0], [1.0, 0.0]], covariance=[np.eye(2)] * 2)
    >>> chains = tw.track_chains([first, second])
    >>> tw.solve(chains.problem(), rng=np.random.default_rng(1)).tuples
    array([[1, 2],
           [2, 1]])
    """
    sensors = checked_members(sensors, TrackEstimates, "sensors")
    _require_alike(sensors)
    max_tuples = checked_count(max_tuples, "max_tuples", 1)
    if false_rejection is None:
        return _full_chains(sensors, max_tuples)
    rate = checked_number(false_rejection, "false_rejection", "a probability between 0 and 1")
    threshold = same_object_threshold(rate, sensors[0].n_times, sensors[0].dim)
    return _gated_chains(sensors, threshold, max_tuples)


def _full_chains(sensors: Sequence[TrackEstimates], max_tuples: int) -> Chains:
    """Return every tuple of one track per sensor."""
    _require_equal([sensor.n_tracks for sensor in sensors])
    _require_few(sensors[0].n_tracks ** len(sensors), max_tuples)
    distances = [accumulated_distance(first, second) for first, second in pairwise(sensors)]
    return complete_chains(distances, max_tuples=max_tuples)


def complete_chains(distances: Sequence[FloatArray], *, max_tuples: int = 2_000_000) -> Chains:
    """Return every tuple of one track per sensor, from distances that are known already."""
    # For each sensor but the last, these are the accumulated distances λ between its tracks and
    # those of the next, shape (n, n), n the same for all. Each tuple comes with b, the sum of its
    # distances: Huo, Zhang, Bai, Song, Xiong, 2008, eqs. (9), (11) and (12). More tuples than
    # ``max_tuples`` are refused.
    if not distances:
        raise InvalidInputError("distances: none; expected those of at least two sensors")
    _require_equal([len(distances[0]), *(distance.shape[1] for distance in distances)])
    n, n_sensors = len(distances[0]), len(distances) + 1
    _require_few(n**n_sensors, max_tuples)
    every = np.arange(n**n_sensors)
    columns = [every // n ** (n_sensors - 1 - place) % n for place in range(n_sensors)]
    cost = np.zeros(every.shape[0])
    for place, distance in enumerate(distances):
        cost += distance[columns[place], columns[place + 1]]
    return Chains(np.stack(columns, axis=1) + 1, cost, np.inf)


def _gated_chains(sensors: Sequence[TrackEstimates], threshold: float, max_tuples: int) -> Chains:
    """Return every chain whose consecutive tracks are no farther apart than the threshold."""
    n_sensors = len(sensors)
    # The chains that end at each sensor, one array of tuples and one of costs.
    tuples: list[IntArray] = []
    costs: list[FloatArray] = []
    n_rows = 0
    for place, sensor in enumerate(sensors):
        begun = np.zeros((sensor.n_tracks, n_sensors), dtype=np.int64)
        begun[:, place] = np.arange(sensor.n_tracks) + 1
        ending, cost = [begun], [np.full(sensor.n_tracks, threshold)]
        for before in range(place):
            distance = accumulated_distance(sensors[before], sensor)
            last = tuples[before][:, before] - 1
            row, track = _joined(distance <= threshold, last, max_tuples - n_rows)
            n_rows += row.shape[0]
            grown = tuples[before][row]
            grown[:, place] = track + 1
            ending.append(grown)
            cost.append(costs[before][row] + distance[last[row], track])
        tuples.append(np.concatenate(ending))
        costs.append(np.concatenate(cost))
    return Chains(np.concatenate(tuples), np.concatenate(costs), threshold)


def _joined(
    is_near: NDArray[np.bool_], last: IntArray, most: int
) -> tuple[IntArray, NDArray[np.intp]]:
    """Return each pair of a chain, by its last track, and a track near that, chain by chain."""
    near, track = np.nonzero(is_near)
    start = np.searchsorted(near, np.arange(is_near.shape[0] + 1))
    count = np.diff(start)[last]
    _require_few(int(count.sum()), most)
    row = np.repeat(np.arange(last.shape[0]), count)
    turn = np.arange(row.shape[0]) - np.repeat(np.cumsum(count) - count, count)
    return row, track[start[last[row]] + turn]


def _require_covariances(covariance: FloatArray) -> None:
    """Refuse what is not symmetric, up to rounding, and positive definite."""
    scale = np.abs(covariance).max(axis=(-2, -1), keepdims=True, initial=0.0)
    lopsided = np.abs(covariance - np.swapaxes(covariance, -2, -1)) > 1e-9 * scale
    if np.any(lopsided):
        raise InvalidInputError("covariance: not symmetric; expected symmetric matrices")
    try:
        np.linalg.cholesky(covariance)
    except np.linalg.LinAlgError as err:
        raise InvalidInputError(
            "covariance: not positive definite; expected positive definite matrices"
        ) from err


def _require_alike(sensors: Sequence[TrackEstimates]) -> None:
    """Refuse sensors that are too few, or whose times or dimensions differ."""
    if len(sensors) < 2:
        raise InvalidInputError(f"sensors: {len(sensors)}; expected at least two")
    for name in ("n_times", "dim"):
        values = [getattr(sensor, name) for sensor in sensors]
        if len(set(values)) > 1:
            raise InvalidInputError(f"sensors: {name} {values}; expected one for all")


def _require_equal(counts: list[int]) -> None:
    if len(set(counts)) > 1:
        raise InvalidInputError(
            f"sensors: {counts} tracks; expected equally many of each, or false_rejection"
        )


def _require_few(n_tuples: int, most: int) -> None:
    if n_tuples > most:
        raise InvalidInputError(
            f"sensors: {n_tuples} tuples, and {most} left of max_tuples; expected fewer: "
            "false_rejection, and a greater one, leaves out tracks that are far apart"
        )
