"""Tracks of two sensors set side by side over time."""

import numpy as np
import pytest

from trackweave.fusion.bias import BiasModel
from trackweave.fusion.matching import match_tracks, unbiased
from trackweave.fusion.pictures import LocalPicture

SPREAD = np.diag([100.0, 100.0, 4.0, 4.0])


def picture(sensor: str, time: float, tracks: dict[int, float]) -> LocalPicture:
    mean = [[east, 0.0, 0.0, 0.0] for east in tracks.values()]
    spread = np.tile(SPREAD, (len(tracks), 1, 1))
    return LocalPicture(sensor, time, list(tracks), np.reshape(mean, (-1, 4)), spread)


def test_pairs_those_that_are_near_over_all_times() -> None:
    first = [picture("A", t, {1: 0.0, 2: 100.0}) for t in (0.0, 1.0)]
    # Track 8 is nearest to 1 at one time, 9 at both times together.
    second = [
        picture("B", 0.0, {9: 5.0, 8: 40.0, 7: 100.0}),
        picture("B", 1.0, {9: 5.0, 8: 4.0, 7: 110.0}),
    ]
    assert match_tracks(first, second).tolist() == [[1, 9], [2, 7]]


def test_leaves_alone_what_is_far_away_or_there_at_other_times() -> None:
    first = [picture("A", 0.0, {1: 0.0}), picture("A", 1.0, {2: 0.0})]
    second = [picture("B", 0.0, {7: 900.0}), picture("B", 1.0, {8: 500.0})]
    assert match_tracks(first, second).shape == (0, 2)
    apart = [picture("A", 0.0, {1: 0.0}), LocalPicture.empty("A", 1.0, 2)]
    other = [LocalPicture.empty("B", 0.0, 2), picture("B", 1.0, {7: 0.0})]
    assert match_tracks(apart, other).shape == (0, 2)


def test_an_uncertain_bias_widens_all_tracks() -> None:
    covariance = np.zeros((6, 6))
    covariance[0, 0] = 400.0
    bias = np.zeros(6)
    bias[0] = 50.0
    moved = unbiased(picture("B", 0.0, {7: 60.0}), BiasModel(), bias, covariance)
    assert moved.mean[0] == pytest.approx([10.0, 0.0, 0.0, 0.0])
    assert moved.covariance[0, 0, 0] == pytest.approx(500.0)
    assert moved.covariance[0, 1, 1] == pytest.approx(100.0)
