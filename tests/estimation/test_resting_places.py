"""Places from which reports come for long."""

import numpy as np
import pytest

from trackweave.estimation.resting_places import densest, grain_of, places_of

SIGMA = 5.0


@pytest.mark.parametrize(
    ("step", "grain"), [(60.0, 30.0), (1.0, 0.5), (0.1, 0.05), (0.001, 0.0005), (1e-5, 0.001)]
)
def test_stamps_are_as_exact_as_they_are_rounded(step, grain):
    time = np.random.default_rng(2).uniform(0.0, 3600.0, 500)
    assert grain_of(np.round(time / step) * step) == pytest.approx(grain)


def test_a_place_is_where_reports_come_for_long():
    rng = np.random.default_rng(6)
    still = np.column_stack([np.arange(0.0, 3000.0, 30.0), rng.normal(0.0, SIGMA, (100, 2))])
    passing = np.column_stack([np.arange(0.0, 1000.0, 10.0), np.linspace(-2e3, 2e3, 100)[:, None]
                               * np.ones(2)])  # fmt: skip
    rows = np.vstack([still, passing])
    rows = rows[order := np.argsort(rows[:, 0], kind="stable")]
    track = np.repeat([0, 1], 100)[order]
    (place,) = places_of(rows[:, 0], rows[:, 1:], track, SIGMA)
    assert set(track[place]) == {0}
    assert place.size >= 97


def test_nothing_is_at_rest_without_tracks():
    nothing = np.full(20, -1)
    assert places_of(np.arange(20.0), np.zeros((20, 2)), nothing, SIGMA) == []


def test_the_densest_places_are_where_most_lie():
    rng = np.random.default_rng(7)
    crowd, few = rng.normal(0.0, SIGMA, (60, 2)), rng.normal(200.0, SIGMA, (20, 2))
    first, second, *_ = densest(np.vstack([few, crowd]), SIGMA**2)
    assert np.linalg.norm(first) < 2 * SIGMA
    assert np.linalg.norm(second) < 100.0 or np.linalg.norm(second - 200.0) < 3 * SIGMA
    apart = [np.linalg.norm(a - b) for a in (first,) for b in (second,)]
    assert min(apart) > SIGMA


def test_nothing_is_dense_where_each_lies_alone():
    assert densest(np.arange(20.0).reshape(10, 2) * 100.0, SIGMA**2) == []


def test_who_moves_slowly_is_on_its_way_throughout():
    rng, time = np.random.default_rng(1), np.arange(0.0, 5400.0, 90.0)
    moving = np.column_stack([time, rng.normal(0.0, SIGMA, (60, 2))])
    moving[:, 2] += 0.02 * time
    still = np.column_stack([time + 40.0, rng.normal((3.0, 50.0), SIGMA, (60, 2))])
    rows = np.vstack([moving, still])
    rows = rows[order := np.argsort(rows[:, 0], kind="stable")]
    track = np.repeat([0, 1], 60)[order]
    (place,) = places_of(rows[:, 0], rows[:, 1:], track, SIGMA)
    assert np.mean(track[place] == 1) > 0.9


def test_nobody_is_at_rest_where_all_are_on_their_way():
    time = np.arange(0.0, 500.0, 10.0)
    assert places_of(time, np.outer(time, [5.0, 3.0]), np.zeros(50, dtype=np.int64), SIGMA) == []
