"""The usual practice, to be compared with: sensor after sensor, two lists at a time."""

from collections.abc import Callable, Sequence

import numpy as np
from scipy.optimize import linear_sum_assignment

from trackweave.arrays import FloatArray, IntArray
from trackweave.association.chain_rule import (
    TrackEstimates,
    accumulated_distance,
    same_object_threshold,
)

__all__ = ["nearest_neighbour", "pairwise_sequential"]


def pairwise_sequential(
    sensors: Sequence[TrackEstimates], *, false_rejection: float = 0.01
) -> list[IntArray]:
    """Return groups of tracks by one optimal assignment per further sensor."""
    # The first sensor's tracks are the first groups. Each further sensor's are assigned to the
    # groups so far, at least total accumulated distance to their fused estimates; what is beyond
    # the threshold begins a group.
    return _sequential(sensors, false_rejection, _assigned)


def nearest_neighbour(
    sensors: Sequence[TrackEstimates], *, false_rejection: float = 0.01
) -> list[IntArray]:
    """Return groups of tracks where each track in turn takes the nearest group that is free."""
    return _sequential(sensors, false_rejection, _nearest)


_Choice = Callable[[FloatArray, float], IntArray]


def _sequential(
    sensors: Sequence[TrackEstimates], false_rejection: float, choose: _Choice
) -> list[IntArray]:
    """Return groups, taking sensor after sensor; ``choose`` gives tracks groups, -1 for none."""
    first = sensors[0]
    threshold = same_object_threshold(false_rejection, first.n_times, first.dim)
    labels = [np.arange(first.n_tracks)]
    # Of each group the information and the information-weighted state.
    weight = np.linalg.inv(first.covariance)
    pull = np.einsum("ktij,ktj->kti", weight, first.mean)
    for sensor in sensors[1:]:
        covariance = np.linalg.inv(weight)
        covariance = (covariance + covariance.swapaxes(-1, -2)) / 2.0
        fused = TrackEstimates(np.einsum("ktij,ktj->kti", covariance, pull), covariance)
        label = choose(accumulated_distance(fused, sensor), threshold)
        information = np.linalg.inv(sensor.covariance)
        pulled = np.einsum("ktij,ktj->kti", information, sensor.mean)
        taken = label >= 0
        weight[:, label[taken]] += information[:, taken]
        pull[:, label[taken]] += pulled[:, taken]
        label[~taken] = weight.shape[1] + np.arange(np.count_nonzero(~taken))
        weight = np.concatenate([weight, information[:, ~taken]], axis=1)
        pull = np.concatenate([pull, pulled[:, ~taken]], axis=1)
        labels.append(label)
    return labels


def _assigned(distance: FloatArray, threshold: float) -> IntArray:
    """Return the group of each track at least total distance; none costs the threshold."""
    label = np.full(distance.shape[1], -1, dtype=np.int64)
    group, track = linear_sum_assignment(np.minimum(distance, threshold))
    within = distance[group, track] < threshold
    label[track[within]] = group[within]
    return label


def _nearest(distance: FloatArray, threshold: float) -> IntArray:
    """Return the nearest free group of each track in turn."""
    label = np.full(distance.shape[1], -1, dtype=np.int64)
    free = distance.copy()
    for track in range(distance.shape[1]):
        group = int(np.argmin(free[:, track])) if free.shape[0] else -1
        if group >= 0 and free[group, track] < threshold:
            label[track] = group
            free[group] = np.inf
    return label
