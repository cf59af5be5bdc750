"""What objects do while they are seen tells what they do in as long a time unseen."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import multivariate_t

from trackweave.domain.tracks import CONFIRMED, TrackTable
from trackweave.trackers.joining.segments import Paths, Segments
from trackweave.trackers.joining.straying import TAILS, Straying, student_log_density


@pytest.mark.parametrize("size", [1, 2, 3])
def test_the_density_is_that_of_scipy(size):
    rng = np.random.default_rng(size)
    root = rng.normal(size=(5, size, size))
    scale = root @ root.swapaxes(1, 2) + np.eye(size)
    off = rng.normal(0.0, 4.0, (5, size))
    tail = np.array([1.0, 2.0, 2.5, 4.0, 8.0])
    expected = [
        multivariate_t(shape=each, df=degrees).logpdf(row)
        for row, each, degrees in zip(off, scale, tail, strict=True)
    ]
    np.testing.assert_allclose(student_log_density(off, scale, tail), expected)


def flown(turn: float | np.ndarray, n_objects: int = 12, n: int = 120) -> tuple[Paths, Segments]:
    """Return objects of 10 m/s whose headings wander, by radians per root second (of each)."""
    rng = np.random.default_rng(7)
    heading = rng.uniform(0, 2 * np.pi, (n_objects, 1)) + np.cumsum(
        rng.normal(0.0, turn, (n_objects, n)), axis=1
    )
    velocity = 10.0 * np.stack([np.cos(heading), np.sin(heading)], axis=2)
    place = np.cumsum(velocity, axis=1)
    mean = np.concatenate([place, velocity], axis=2).reshape(-1, 4)
    time = np.tile(np.arange(float(n)), n_objects)
    number = np.repeat(np.arange(n_objects), n)
    rows = number.size
    states = TrackTable(
        time, number, np.full(rows, CONFIRMED), mean, np.tile(0.01 * np.eye(4), (rows, 1, 1)),
        np.zeros(rows), np.ones(rows, np.int64), time,
    )  # fmt: skip
    each = np.arange(n_objects)
    whole = np.full(n_objects, n)
    zero = np.zeros(n_objects)
    return Paths(states), Segments(each, zero, zero + n - 1.0, whole, zero + 1.0, each * 0 - 1)


def straying(turn: float | np.ndarray) -> Straying:
    found = Straying.learned(*flown(turn), 1.0)
    assert found is not None
    return found


def test_who_wanders_strays_farther_the_longer_it_takes():
    across = np.sqrt(straying(0.1).squares[:, 1])
    assert across[-1] > 0.15
    assert across[-1] > 5 * across[0]


def test_who_flies_straight_does_not_stray():
    assert np.all(straying(1e-4).squares < 0.02**2)


def test_where_most_fly_straight_and_few_turn_tails_are_wide():
    all_turn = straying(0.1).tails[:, 0]
    few_turn = straying(np.where(np.arange(12) < 3, 0.1, 1e-4)[:, np.newaxis]).tails[:, 0]
    assert np.all(few_turn[4:] == TAILS[0])
    assert np.all(all_turn[4:] > TAILS[0])


def test_where_nobody_is_surely_known_nothing_is_learned():
    paths, segments = flown(0.1)
    few = Segments(*(getattr(segments, name) for name in ("track", "begin", "end")),
                   segments.count * 0 + 3, segments.interval, segments.before)  # fmt: skip
    assert Straying.learned(paths, few, 1.0) is None


def test_going_on_straight_is_likelier_than_coming_back():
    paths, _ = flown(0.02, n_objects=12)
    found = straying(0.02)
    own, other = np.array([60]), np.array([80])
    back = np.array([paths.first[5] + 80])
    on, _ = found.log_density(paths, own, other)
    assert on > found.log_density(paths, own, back)[0] + 5.0


def test_who_stood_is_where_it_was():
    paths, _ = flown(0.02, n_objects=12)
    found = straying(0.02)
    time = paths.states.time
    # One is where it was half a minute ago, another where it would have gone.
    place = paths.states.mean.copy()
    place[90, :2] = place[60, :2] + 0.1
    stands = Paths(replace(paths.states, mean=place))
    own, later = np.array([60, 60]), np.array([90, 88])
    assert np.all(time[later] > time[own])
    went, stood = found.log_density(stands, own, later)
    assert stood[0] > went[0] + 5.0
    assert went[1] > stood[1] + 5.0
