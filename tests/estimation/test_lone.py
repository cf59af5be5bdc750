"""What lone reports tell of how objects move."""

import numpy as np
import pytest

from trackweave.arrays import FloatArray
from trackweave.estimation.lone import lone_reports
from trackweave.estimation.threads import Threads, threads_of


def side_by_side(seed: int = 1) -> tuple[FloatArray, FloatArray]:
    """Return when and where twelve straight ships, and three beside them, report themselves."""
    rng = np.random.default_rng(seed)
    rows, ways = [], []
    for number in range(15):
        if number < 12:
            start, heading = rng.uniform(-3000, 3000, 2), rng.uniform(0, 2 * np.pi)
            velocity = rng.uniform(3, 11) * np.array([np.cos(heading), np.sin(heading)])
            ways.append((start, velocity, rng.choice([6.0, 10.0, 30.0])))
        start, velocity, pause = ways[number % 12]
        beside = np.array([30.0, -25.0]) * (number >= 12)
        time = rng.uniform(0, pause)
        while time < 1200.0:
            seen = start + beside + velocity * time + rng.normal(0, 5.0, 2)
            rows.append((np.floor(time), *seen))
            time += pause * rng.uniform(0.95, 1.05)
    table = np.array(sorted(rows))
    return table[:, 0], table[:, 1:]


def test_a_noise_that_is_told_makes_no_turns_of_ships_side_by_side() -> None:
    time, position = side_by_side()
    found = lone_reports(time, position, threads_of(time, position), 5.0)
    assert found.sigma == 5.0
    assert found.process_noise is not None
    assert found.process_noise < 0.02


def test_ships_without_noise_are_given_some() -> None:
    time = np.array([10.0 * k + i for k in range(30) for i in range(3)])
    way = np.array([5.0, 3.0])
    place = np.array([[2000.0 * i, 900.0 * i] for _ in range(30) for i in range(3)])
    # As on a plane of the Earth, where what goes straight in degrees bends a little.
    place += time[:, None] * way + 1e-8 * np.square(time)[:, None]
    found = lone_reports(time, place, threads_of(time, place), None)
    assert found.sigma == pytest.approx(1e-3 * 10.0 * np.hypot(*way), rel=0.01)


def test_an_axis_without_noise_hides_not_that_of_the_other() -> None:
    rng = np.random.default_rng(4)
    rows = [
        (time + 0.15 * tag, 0.5 * time, 60.0 * tag + rng.normal(0, 0.3))
        for tag in range(6)
        for time in np.arange(0.0, 300.0)
    ]
    table = np.array(sorted(rows))
    found = lone_reports(table[:, 0], table[:, 1:], threads_of(table[:, 0], table[:, 1:]), None)
    assert found.sigma == pytest.approx(0.3 / np.sqrt(2.0), rel=0.1)


def test_a_thread_that_begins_with_anothers_report_tells_its_noise() -> None:
    rng = np.random.default_rng(3)
    waits = 8.0 * rng.choice([0.2, 1.0, 3.0], 40)
    time = np.cumsum(waits)
    position = np.array([3.0, 1.0]) * time[:, None] + rng.normal(0.0, 5.0, (40, 2))
    position[0] += 700.0
    found = lone_reports(time, position, Threads([np.arange(40)], 40), None)
    assert found.sigma == pytest.approx(5.0, rel=0.3)


def drifting(seed: int = 1) -> tuple[FloatArray, FloatArray, FloatArray, Threads]:
    """Return reports of drifters in loops of 17 h: times, places, their own noise, and whose."""
    rng = np.random.default_rng(seed)
    time = np.sort(rng.uniform(0.0, 25 * 86400.0, 1000))
    who = rng.integers(0, 5, time.size)
    turn = rng.uniform(0.0, 2.0 * np.pi, 5)[who] + 2.0 * np.pi * time / 61_200.0
    place = 1950.0 * np.stack([np.sin(turn), np.cos(turn)], axis=1)
    place += rng.uniform(-3e5, 3e5, (5, 2))[who] + 0.1 * time[:, None]
    own = rng.choice([150.0, 350.0, 1000.0, 3000.0], time.size)[:, None] * np.ones(2)
    threads = [np.flatnonzero(who == each) for each in range(5)]
    return time, place + own * rng.normal(size=place.shape), own, Threads(threads, time.size)


def test_motion_beside_noise_that_reports_tell_themselves_is_what_they_do() -> None:
    time, place, own, threads = drifting()
    found = lone_reports(time, place, threads, float(np.median(own)), own)
    # A loop's velocity turns by some 0.2 m/s from report to report.
    assert found.process_noise is not None
    assert 1e-6 < found.process_noise < 2e-5
    # Over five reports a loop evens out; nobody is slower than it goes round.
    assert found.max_speed is not None
    assert 0.1 * np.sqrt(2.0) + 0.2 < found.max_speed < 1.0
