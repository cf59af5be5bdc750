"""What rests tells the noise, and what sets out seldom is followed where its name is known."""

import numpy as np
import polars as pl
import pytest

from trackweave import track
from trackweave.estimation.stop_and_go import fastest_step, noise_at_rest, process_of_starts
from trackweave.metrics import assignment_quality

PAUSE, SIGMA, SPEED = 300.0, 8.0, 10.0


def birds(seed: int, *, wild: float = 0.0) -> pl.DataFrame:
    """Six that sit in one place for an hour or three, then fly for some fixes."""
    rng, rows = np.random.default_rng(seed), []
    for bird in range(6):
        place, velocity, left = rng.uniform(-300.0, 300.0, 2), np.zeros(2), 20
        for number in range(140):
            left -= 1
            if left == 0:
                flies = not velocity.any()
                heading = rng.uniform(0.0, 2 * np.pi)
                velocity = SPEED * np.array([np.sin(heading), np.cos(heading)]) * flies
                left = int(rng.integers(1, 4) if flies else rng.integers(12, 40))
            place = place + PAUSE * velocity
            off = 1000.0 if rng.random() < wild else SIGMA
            time = PAUSE * number + 31.0 * bird + rng.uniform(-10.0, 10.0)
            rows.append((time, *(place + rng.normal(0.0, off, 2)), f"b{bird}"))
    return pl.DataFrame(rows, ["time", "x", "y", "identity"], orient="row").sort("time")


def threads_of(table: pl.DataFrame) -> tuple[np.ndarray, np.ndarray, list[np.ndarray]]:
    who = table["identity"].to_numpy()
    rows = [np.flatnonzero(who == each) for each in np.unique(who)]
    return table["time"].to_numpy(), table.select("x", "y").to_numpy(), rows


@pytest.mark.slow
@pytest.mark.parametrize("wild", [0.0, 0.03])
@pytest.mark.parametrize("seed", [6, 9])
def test_who_rests_and_flies_keeps_its_name(seed, wild) -> None:
    table = birds(seed, wild=wild)
    result = track(table)
    number = result.assignments["track"].fill_null(-1).to_numpy()
    assert assignment_quality(table["identity"].to_list(), number).idf1 > 0.95
    used = result.run["configuration"]
    assert 0.7 * SIGMA < used["sensors"]["default"]["sigma"] < 1.5 * SIGMA
    assert SPEED * 0.9 < used["motion"]["max_speed"] < SPEED * 2.0


def test_noise_is_that_of_what_rests() -> None:
    assert noise_at_rest(*threads_of(birds(1))) == pytest.approx(SIGMA, rel=0.2)


def test_what_never_rests_tells_no_noise() -> None:
    time = np.arange(60.0)
    way = np.column_stack([20.0 * time, -5.0 * time])
    noise = np.random.default_rng(2).normal(0.0, 3.0, way.shape)
    assert noise_at_rest(time, way + noise, [np.arange(60)]) is None
    assert noise_at_rest(time, way, []) is None


def test_the_fastest_step_is_what_noise_does_not_explain() -> None:
    time, place, rows = threads_of(birds(1))
    assert fastest_step(time, place, rows, SIGMA, 0.9 * PAUSE) == pytest.approx(SPEED, rel=0.1)
    still = np.random.default_rng(3).normal(0.0, 1.0, (50, 2))
    assert fastest_step(np.arange(50.0), still, [np.arange(50)], 1.0, 1.0) < 0.5
    assert fastest_step(time, place, [], SIGMA, PAUSE) == 0.0


def test_starts_and_stops_are_process_noise_and_noise_is_none() -> None:
    time, place, rows = threads_of(birds(1))
    # A start from rest to 10 m/s between two fixes is one standard deviation of the velocity that
    # noise adds in a pause, or some of them.
    found = process_of_starts(time, place, rows, SIGMA, 0.5 * PAUSE)
    assert 0.02 < found * PAUSE / SPEED**2 < 1.0
    still = np.random.default_rng(3).normal(0.0, 1.0, (200, 2))
    steady = process_of_starts(np.arange(200.0), still, [np.arange(200)], 1.0, 0.5)
    assert steady < 0.5
