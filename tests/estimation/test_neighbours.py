"""What neighbours say of a report, and which chains are far noisier than most."""

import numpy as np
import pytest

from trackweave.estimation.neighbours import expected_of, is_as_most

TIME = np.array([0.0, 3.0, 7.0, 8.0, 13.0, 15.0])


def test_neighbours_foresee_what_goes_straight_and_all_four_a_cubic():
    line = np.stack([3.0 * TIME - 1.0, 5.0 - TIME], axis=1)
    for expected, _ in expected_of(TIME, line):
        np.testing.assert_allclose(expected, line[2:-2], atol=1e-9)
    cubic = np.stack([TIME**3 - 2.0 * TIME**2, 4.0 * TIME - TIME**3], axis=1)
    np.testing.assert_allclose(expected_of(TIME, cubic)[-1][0], cubic[2:-2], rtol=1e-9)


def test_what_neighbours_say_is_as_uncertain_as_told():
    """The variance is that of a weighted sum, by moving one neighbour at a time."""
    known = np.zeros((5, 2))
    for moved in range(6):
        place = np.zeros((6, 2))
        place[moved] = 1.0
        for way, (expected, _) in enumerate(expected_of(TIME, place)):
            # A report itself says nothing of where it should be.
            assert moved - 2 not in (0, 1) or expected[moved - 2, 0] == 0.0
            known[way] += expected[:, 0] ** 2
    for way, (_, told) in enumerate(expected_of(TIME, np.zeros((6, 2)))):
        np.testing.assert_allclose(told, known[way], rtol=1e-12)


@pytest.mark.parametrize("turning", [0.0, 3.0], ids=["straight", "in turns of 3 degrees a second"])
def test_bad_transponders_are_left_out_and_turns_are_not(turning):
    rng = np.random.default_rng(3)
    time = np.tile(np.cumsum(rng.uniform(4.0, 6.0, 30)), (12, 1))
    heading = np.radians(turning) * time + np.arange(12.0)[:, None]
    if turning:
        place = 200.0 / np.radians(turning) * np.stack([-np.cos(heading), np.sin(heading)], axis=2)
    else:
        place = 200.0 * time[:, :, None] * np.stack([np.sin(heading), np.cos(heading)], axis=2)
    # Azimuths make it differ from chain to chain, and two are bad.
    noise = np.r_[np.linspace(50.0, 130.0, 10), 900.0, 1500.0]
    place = place + noise[:, None, None] * rng.normal(size=place.shape)
    time[3, 20:], place[3, 20:] = np.nan, np.nan
    time[11, 12:], place[11, 12:] = np.nan, np.nan
    np.testing.assert_array_equal(is_as_most(time, place), noise < 500.0)


def test_chains_too_short_to_tell_are_kept():
    time = np.tile(np.arange(5.0), (3, 1))
    place = (
        np.random.default_rng(1).normal(size=(3, 5, 2)) * np.array([1.0, 1.0, 1e3])[:, None, None]
    )
    assert is_as_most(time, place).all()
    assert is_as_most(np.empty((0, 5)), np.empty((0, 5, 2))).size == 0
