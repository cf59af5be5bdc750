"""Of tracks that cannot be told apart, as many as there are objects."""

import numpy as np
import pytest
import scipy.stats

from oracles.scenes import MOTION, run, scan, sensor
from trackweave.trackers.lifecycle import Lifecycle
from trackweave.trackers.multi_hypothesis import MultiHypothesisTracker
from trackweave.trackers.surplus import surplus


def at(*places, dim=2, sigma=1.0):
    """Return places on the first axis and their covariances."""
    position = np.zeros((len(places), dim))
    position[:, 0] = places
    return position, np.broadcast_to(sigma**2 * np.eye(dim), (len(places), dim, dim))


@pytest.mark.parametrize("dim", [2, 3])
def test_of_four_that_share_the_doubt_about_one_the_weakest_goes(dim):
    chance = np.array([0.8, 0.9, 0.6, 0.9])
    told = surplus(*at(0.0, 1.0, 2.0, 3.0, dim=dim), chance)
    assert told.tolist() == [False, False, True, False]


def test_as_many_stay_as_there_are_objects():
    told = surplus(*at(0.0, 0.5, 1.0, 1.5), np.array([0.55, 0.5, 0.6, 0.65]))
    assert told.tolist() == [True, True, False, False]


def test_a_doubt_of_less_than_half_an_object_takes_nobody():
    assert not surplus(*at(0.0, 1.0, 2.0), np.array([0.8, 0.9, 0.85])).any()


def test_tracks_that_are_told_apart_stand_each_for_itself():
    assert not surplus(*at(0.0, 100.0, 200.0), np.array([0.6, 0.6, 0.6])).any()


def test_how_well_places_are_known_says_who_is_told_apart():
    chance = np.array([0.6, 0.7])
    assert not surplus(*at(0.0, 10.0, sigma=1.0), chance).any()
    assert surplus(*at(0.0, 10.0, sigma=5.0), chance).tolist() == [True, False]


def test_one_below_half_counts_for_the_number_and_is_none_too_many():
    # 1.0 objects are expected of which one is shown anyway.
    assert not surplus(*at(0.0, 1.0), np.array([0.4, 0.6])).any()
    # 0.95 of an object beside two that are shown.
    told = surplus(*at(0.0, 1.0, 2.0), np.array([0.1, 0.6, 0.7]))
    assert told.tolist() == [False, True, False]


def test_the_doubts_of_two_that_are_apart_do_not_end_the_one_between_them():
    # Each of the outer two has less than half an object too many beside it.
    told = surplus(*at(0.0, 4.0, 8.0), np.array([0.56, 0.95, 0.56]))
    assert not told.any()


def test_nobody_and_one_alone_are_never_too_many():
    assert surplus(*at(), np.empty(0)).shape == (0,)
    assert not surplus(*at(0.0), np.array([0.5])).any()


def by_definition(position, covariance, chance):
    """Lower the weakest first, each beside whom its place may be that of."""
    away = position[:, None] - position[None, :]
    spread = covariance[:, None] + covariance[None, :]
    square = np.einsum("ijk,ijk->ij", away, np.linalg.solve(spread, away[..., None])[..., 0])
    is_beside = square <= scipy.stats.chi2(position.shape[1]).ppf(0.99)
    shown = chance >= 0.5
    followed = shown.copy()
    for row in sorted(np.flatnonzero(shown), key=lambda row: chance[row]):
        beside = is_beside[row]
        is_weakest = np.all(chance[beside & shown] >= chance[row])
        if is_weakest and (beside & shown).sum() - chance[beside].sum() > 0.5:
            shown[row] = False
    return followed & ~shown


@pytest.mark.parametrize("dim", [2, 3])
def test_crowds_of_any_shape_are_thinned_as_defined(dim):
    rng, n_surplus = np.random.default_rng(dim), 0
    for _ in range(50):
        position = rng.normal(0.0, 8.0, (20, dim))
        root = rng.normal(0.0, 1.5, (20, dim, dim))
        covariance = root @ root.transpose(0, 2, 1) + 0.1 * np.eye(dim)
        chance = rng.uniform(0.3, 1.0, 20)
        told = surplus(position, covariance, chance)
        assert told.tolist() == by_definition(position, covariance, chance).tolist()
        n_surplus += told.sum()
    assert n_surplus > 20


def test_where_one_of_four_that_meet_ends_three_are_shown():
    # Side by side within their noise; then three, each between two of where the four were.
    lifecycle = Lifecycle(survival=0.99, hidden_share=0.0)
    tracker = MultiHypothesisTracker(
        motion=MOTION, sensors=[sensor()], lifecycle=lifecycle, window=5
    )
    scans, number = [], 0
    for time in range(19):
        across = np.array([0.0, 10.0, 20.0, 30.0] if time < 15 else [5.0, 15.0, 25.0])
        seen = np.stack([np.full(across.shape, 20.0 * time), across], axis=1)
        scans.append(scan(float(time), seen, report=number + np.arange(len(seen))))
        number += len(seen)
    shown = [hypothesis.tracks for hypothesis in run(tracker, scans)]
    assert len(shown[14]) == 4
    # No single one is more probably gone than not.
    assert len(shown[18]) == 3
    assert np.all(shown[18].existence > 0.8)
