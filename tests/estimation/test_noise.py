"""Errors that are alike from scan to scan are noise, and turns are not."""

import numpy as np
import pytest

from trackweave.arrays import FloatArray
from trackweave.estimation.noise import (
    LONGEST_CHAIN,
    MOST_CHAINS,
    arrays_of,
    calm_noise,
    least_noise,
    noise_in_turns,
    noise_of_chains,
    noise_of_longer_steps,
)

N_CHAINS, N_SCANS = 12, 60
PERIOD = 0.04


def chains(swing: float, turning: float) -> tuple[FloatArray, FloatArray]:
    """Return times and places of objects whose reports' errors wander, and that turn."""
    rng = np.random.default_rng(1)
    time = np.broadcast_to(PERIOD * np.arange(N_SCANS), (N_CHAINS, N_SCANS))
    acceleration = rng.normal(0.0, turning / np.sqrt(PERIOD), (N_CHAINS, N_SCANS, 2))
    velocity = 80.0 + np.cumsum(acceleration * PERIOD, axis=1)
    place = np.cumsum(velocity * PERIOD, axis=1) + rng.normal(0.0, 2.0, (N_CHAINS, N_SCANS, 2))
    wander = np.zeros((N_CHAINS, 2))
    for scan in range(N_SCANS):
        # An error is half forgotten after two scans.
        wander = 0.7 * wander + rng.normal(0.0, 0.7 * swing, wander.shape)
        place[:, scan] += wander
    return time, place


def test_errors_that_wander_are_noise_of_calm_objects() -> None:
    found = calm_noise(*chains(swing=8.0, turning=0.0), 3.0, 1e-5)
    assert found is not None
    sigma, process = found
    assert sigma > 3.0
    assert process < 2000.0


@pytest.mark.parametrize("turning", [0.0, 30.0, 150.0])
def test_independent_errors_are_left_alone(turning: float) -> None:
    found = calm_noise(*chains(swing=0.0, turning=turning), 2.0, 1e-5)
    assert found is None or found[1] > 0.1 * turning**2


def test_short_chains_tell_nothing() -> None:
    time, place = chains(swing=8.0, turning=0.0)
    assert calm_noise(time[:, :20], place[:, :20], 3.0, 1e-5) is None
    assert calm_noise(time[:, :2], place[:, :2], 3.0, 1e-5) is None


@pytest.mark.parametrize("n_chains", [1, 8])
def test_reports_far_off_are_no_turns(n_chains: int) -> None:
    """An object that hardly turns, and in each chain one report four standard deviations off."""
    rng = np.random.default_rng(2)
    time = np.broadcast_to(np.arange(60.0), (n_chains, 60))
    place = 5.0 * time[..., None] + rng.normal(0.0, 10.0, (n_chains, 60, 2)).clip(-18.0, 18.0)
    place[:, 30, 0] += 45.0
    assert noise_of_chains(time, place, 10.0, 1e-9)[1] < 0.5


def test_noise_grows_until_turns_are_followed() -> None:
    """Thirty aircraft that turn by 3° a second for half a minute of four."""
    rng = np.random.default_rng(6)
    time = np.broadcast_to(np.arange(0.0, 240.0, 4.0), (30, 60))
    course = rng.uniform(0.0, 2 * np.pi, (30, 1)) + np.zeros_like(time)
    course += np.radians(3.0) * np.clip(time[0] - 100.0, 0.0, 30.0)
    velocity = 150.0 * np.stack([np.cos(course), np.sin(course)], axis=2)
    place = np.cumsum(4.0 * velocity, axis=1) + rng.normal(0.0, 60.0, (30, 60, 2))
    steady = noise_of_chains(time, place, 60.0, 1e-9, follows_turns=False)[1]
    assert noise_of_chains(time, place, 60.0, 1e-9)[1] >= 2.0 * steady


def turning_chains(n_turning: int, period: float = 5.0) -> tuple[FloatArray, FloatArray]:
    """Return times and places of nine boats, some of which turn by 90° in 24 s of two minutes."""
    rng = np.random.default_rng(4)
    time = np.broadcast_to(np.arange(0.0, 120.0, period), (9, round(120 / period)))
    course = rng.uniform(0.0, 2 * np.pi, (9, 1)) + np.zeros_like(time)
    course[:n_turning] += np.radians(3.75) * np.clip(time[0] - 40.0, 0.0, 24.0)
    velocity = 11.0 * np.stack([np.cos(course), np.sin(course)], axis=2)
    place = np.cumsum(velocity * period, axis=1) + rng.normal(0.0, 8.0, (*time.shape, 2))
    return time, place


@pytest.mark.parametrize("n_turning", [1, 2])
def test_no_boat_that_turns_is_left_behind(n_turning: int) -> None:
    time, place = turning_chains(n_turning)
    noise = noise_of_chains(*turning_chains(0), 8.0, 3e-6)
    assert noise_in_turns(*turning_chains(0), noise, 3e-6) == noise[1] < 0.02
    process = noise_in_turns(time, place, noise_of_chains(time, place, 8.0, 3e-6), 3e-6)
    # An acceleration of 0.7 m/s² over half of a period.
    assert 0.1 < process < 3.0


def test_boats_that_turn_are_no_errors_that_wander() -> None:
    for period in (2.0, 2.5, 4.0, 5.0):
        found = calm_noise(*turning_chains(2, period), 8.0, 3e-6)
        assert found is None or found[1] > 0.1


def test_reports_without_noise_are_given_some_and_their_turns_are_followed() -> None:
    time = np.broadcast_to(np.arange(60.0), (3, 60))
    angle = 0.05 * time + np.arange(3.0)[:, None]
    place = 100.0 * np.stack([np.cos(angle), np.sin(angle)], axis=2)
    least = least_noise(place)
    assert least == pytest.approx(1e-3 * 5.0, rel=1e-3)
    # From a start that is far too small, too, of which nothing fits that hardly turns.
    for start in (0.3, 5e-3, 7e-4):
        sigma, process = noise_of_chains(time, place, start, 1e-8)
        assert sigma >= least
        assert 1e-3 < process < 1.0
    assert noise_of_chains(time, place, 7e-4, 1e-8, fixed=True)[0] == 7e-4


def test_too_few_reports_tell_of_no_turns() -> None:
    nothing = np.full((2, 5), np.nan), np.full((2, 5, 2), np.nan)
    assert noise_in_turns(*nothing, (5.0, 0.1), 1e-6) == 0.1


def test_what_is_noisier_far_away_is_no_turn() -> None:
    """Ships under a radar: across its line of sight noise grows with the distance."""
    rng = np.random.default_rng(5)
    time = np.tile(3.0 * np.arange(50.0), (24, 1))
    across = np.repeat([12.0, 45.0], [16, 8])[:, None, None]
    noise = np.concatenate([np.full_like(across, 8.0), across], axis=2)
    start, velocity = rng.uniform(-5e3, 5e3, (24, 1, 2)), rng.uniform(-8.0, 8.0, (24, 1, 2))
    place = start + time[..., None] * velocity + noise * rng.normal(size=(24, 50, 2))
    sigma, process = noise_of_chains(time, place, 15.0, 1e-5)
    assert process < 0.1
    assert noise_in_turns(time, place, (sigma, process), 1e-5) == process
    crowded = noise_of_chains(time, place, 15.0, 1e-4)
    assert noise_in_turns(time, place, crowded, 1e-4) < 1.0


@pytest.mark.parametrize("degrees", [3, 4, 5])
@pytest.mark.parametrize("process", [0.1, 1.0, 5.0])
def test_noise_with_wide_tails_is_no_turn(process: float, degrees: int) -> None:
    """Ships whose reports have errors of a Student's t of few degrees of freedom."""
    rng = np.random.default_rng(9)
    interval, shape = 6.0, (30, 60, 2)
    time = np.broadcast_to(interval * np.arange(shape[1]), shape[:2])
    turns = rng.normal(0.0, np.sqrt(process * interval), shape)
    velocity = rng.normal(0.0, 6.0, (30, 1, 2)) + np.cumsum(turns, axis=1)
    place = np.cumsum(interval * velocity, axis=1) + 40.0 * rng.standard_t(degrees, shape)
    found = noise_of_chains(time, place, 60.0, 1e-9)[1]
    assert 0.7 * process < found < 2.5 * process


def test_chains_as_arrays_are_the_longest_without_reports_of_one_moment() -> None:
    short = np.array([0.0, 1.0, 1.0, 2.0])
    long = np.arange(5.0)
    time, place = arrays_of([(short, short[:, None]), (long, long[:, None])])
    np.testing.assert_array_equal(time[0], long)
    np.testing.assert_array_equal(time[1], [0.0, 1.0, 2.0, np.nan, np.nan])
    np.testing.assert_array_equal(place[..., 0], time)
    many = [(np.arange(n), np.zeros((n, 2))) for n in range(2, 200)]
    assert arrays_of(many)[1].shape == (MOST_CHAINS, LONGEST_CHAIN, 2)


def test_errors_of_wide_tails_are_no_motion_over_longer_steps() -> None:
    rng = np.random.default_rng(3)
    time = np.broadcast_to(1.0 * np.arange(N_SCANS), (N_CHAINS, N_SCANS))
    place = 80.0 * time[..., None] + 40.0 * rng.standard_t(2.0, (N_CHAINS, N_SCANS, 2))
    found = noise_of_chains(time, place, 20.0, 1e-9, fixed=True, follows_turns=False)
    sigma, process = noise_of_longer_steps((time, place, once(time)), found, 1e-9, fixed=True)
    assert sigma == 20.0
    assert process < found[1] / 16


def test_motion_is_motion_over_longer_steps() -> None:
    time, place = chains(swing=0.0, turning=100.0)
    found = noise_of_chains(time, place, 2.0, 1e-5, follows_turns=False)
    assert noise_of_longer_steps((time, place, once(time)), found, 1e-5) == found


def once(time: FloatArray) -> FloatArray:
    """Return that each report has the usual noise."""
    return np.ones(time.shape)


def test_who_circles_is_no_calmer_over_longer_steps() -> None:
    # A loop takes six reports; every fourth of them is anywhere on it.
    rng = np.random.default_rng(4)
    time = np.broadcast_to(3.0 * np.arange(N_SCANS), (N_CHAINS, N_SCANS))
    phase = rng.uniform(0.0, 2.0 * np.pi, (N_CHAINS, 1)) + time * 2.0 * np.pi / 18.0
    place = 100.0 * np.stack([np.sin(phase), np.cos(phase)], axis=2)
    place += 4.0 * time[..., None] + rng.normal(0.0, 20.0, place.shape)
    found = noise_of_chains(time, place, 20.0, 1e-9, fixed=True, follows_turns=False)
    assert noise_of_longer_steps((time, place, once(time)), found, 1e-9, fixed=True) == found
