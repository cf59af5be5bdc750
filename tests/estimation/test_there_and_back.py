"""Reports far beside the way are told from turns, starts and stops, whose neighbours are too."""

import numpy as np
import pytest

from trackweave.arrays import FloatArray, IntArray
from trackweave.estimation.lone import lone_reports
from trackweave.estimation.there_and_back import there_and_back
from trackweave.estimation.threads import Threads

SIGMA, PAUSE = 3.0, 20.0


def threads(seed: int = 1, n: int = 5, count: int = 200) -> tuple[FloatArray, list[IntArray]]:
    """Return times, each object's more or less evenly spaced, and whose the reports are."""
    rng = np.random.default_rng(seed)
    time = np.cumsum(rng.uniform(0.7 * PAUSE, 1.3 * PAUSE, (n, count)), axis=1).reshape(-1)
    return time, list(np.arange(n * count).reshape(n, count))


def going(time: FloatArray, rows: list[IntArray], seed: int = 2) -> FloatArray:
    """Return places of ships that stand, set out at 8 m/s, turn at right angles and stop."""
    rng, place = np.random.default_rng(seed), np.zeros((time.size, 2))
    for own in rows:
        leg = ((time[own] - time[own[0]]) // 600.0).astype(int)
        way = 8.0 * np.array([(0, 0), (1, 0), (0, 1), (0, 0), (-1, 0), (0, 0)])[leg % 6]
        step = np.diff(time[own], prepend=time[own[0]])[:, None]
        place[own] = np.cumsum(way * step, axis=0) + rng.uniform(-9e3, 9e3, 2)
    return place


@pytest.mark.parametrize("share", [0.01, 0.03, 0.1])
def test_what_is_far_off_and_back_is_wild(share):
    time, rows = threads()
    rng, place = np.random.default_rng(3), going(*threads())
    is_wild = rng.random(time.size) < share
    away = rng.uniform(0.0, 2.0 * np.pi, time.size)
    far = rng.uniform(60.0, 300.0, time.size) * is_wild
    seen = place + rng.normal(0.0, SIGMA, place.shape)
    seen += far[:, None] * np.stack([np.sin(away), np.cos(away)], axis=1)
    found = there_and_back(time, seen, rows)
    # Near a turn nothing tells.
    assert np.mean(found.is_wild[is_wild]) > 0.6
    assert np.mean(found.is_wild[~is_wild]) < 0.1 * share
    assert found.tail is not None
    assert found.tail[0] == pytest.approx(share, rel=0.4)
    # One axis of a way of uniform length, of any direction.
    wide = np.sqrt(np.mean(np.square(far[is_wild])) / 2.0)
    assert found.tail[1] * SIGMA == pytest.approx(wide, rel=0.3)


def test_turns_starts_and_stops_are_none():
    time, rows = threads()
    place = going(time, rows)
    seen = place + np.random.default_rng(4).normal(0.0, SIGMA, place.shape)
    found = there_and_back(time, seen, rows)
    assert not found.is_wild.any()
    assert found.tail is None


def test_places_without_noise_have_no_wild_ones():
    time, rows = threads()
    found = there_and_back(time, np.zeros((time.size, 2)), rows)
    assert not found.is_wild.any()


def test_what_mostly_stays_in_place_to_the_digit_has_no_wild_ones():
    # Badges in rooms: without those that are elsewhere most are off by nothing at all.
    number = np.arange(200)
    east = np.where(number % 20 == 0, 6.0, np.where(number % 5 == 0, 0.01, 0.0))
    place = np.stack([east, np.zeros(number.size)], axis=1)
    found = there_and_back(PAUSE * number, place, [number])
    assert not found.is_wild.any()
    assert found.tail is None


def test_motion_beside_wild_reports_is_that_without_them():
    time, rows = threads()
    rng, place = np.random.default_rng(5), 2.0 * time[:, None] * np.array([1.0, 0.5])
    seen = place + rng.normal(0.0, SIGMA, place.shape)
    wild = rng.random(time.size) < 0.04
    seen[wild] += rng.normal(0.0, 30.0 * SIGMA, (wild.sum(), 2))
    found = lone_reports(time, seen, Threads(rows, time.size, is_whole=True), None)
    assert found.sigma == pytest.approx(SIGMA, rel=0.2)
    assert found.process_noise is not None
    assert found.process_noise * PAUSE**3 / 3.0 < SIGMA**2
    assert found.max_speed is not None
    assert found.max_speed < 6.0
