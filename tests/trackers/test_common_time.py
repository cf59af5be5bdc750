"""Plots of moments that differ, brought to one time along tracks."""

import numpy as np
import pytest

from trackweave.association.sensor_plots import SensorPlots
from trackweave.domain.tracks import TrackTable
from trackweave.trackers.common_time import carried_along

GATE = 16.0


def one_track(mean, time=9.0, position=25.0, velocity=4.0):
    """Return a table of one track whose position and velocity are correlated."""
    covariance = np.diag([position, position, velocity, velocity]).astype(float)
    covariance[0, 2] = covariance[2, 0] = covariance[1, 3] = covariance[3, 1] = 2.0
    one = np.ones(1)
    return TrackTable(
        time=time * one,
        track=one.astype(int),
        status=one.astype(int),
        mean=np.array([mean], dtype=float),
        covariance=covariance[None],
        score=-one,
        hits=one.astype(int),
        last_update=time * one,
    )


def positions(value, drift=0.0, **changed):
    value = np.array(value, dtype=float)
    values = {"sigma": 10.0, "volume": 1e6, "false_alarms": 1.0, "drift": drift}
    return SensorPlots(value=value, **(values | changed))


def test_a_position_near_a_track_moves_with_it():
    # At 9.4 s the track is foretold at (108, 54); it goes on for 0.6 s.
    plots = positions([[110.0, 50.0], [900.0, 900.0]], drift=[3.0, 3.0])
    moved = carried_along(plots, np.full(2, 0.6), 10.0, one_track([100, 50, 20, 10]), GATE)
    assert moved.value[0] == pytest.approx([110 + 12, 50 + 6])
    assert moved.covariance[0] == pytest.approx((100 + 4 * 0.36) * np.eye(2))
    assert moved.drift.tolist() == [0.0, 3.0]
    assert moved.value[1].tolist() == [900.0, 900.0]


@pytest.mark.parametrize(("aside", "moves"), [(3.9, True), (4.1, False)])
def test_near_is_what_lies_in_the_gate_at_the_plots_own_time(aside, moves):
    spread = 25 + 100 + 2 * 2.0 * 0.4 + 4.0 * 0.16
    plots = positions([[108.0 + aside * np.sqrt(spread), 54.0]], drift=[3.0])
    moved = carried_along(plots, np.array([0.6]), 10.0, one_track([100, 50, 20, 10]), GATE)
    assert bool(moved.drift[0] == 0.0) == moves


def test_correlated_errors_stay_so():
    covariance = np.array([[[100.0, 60.0], [60.0, 80.0]]])
    plots = positions([[108.0, 54.0]], sigma=None, covariance=covariance)
    moved = carried_along(plots, np.array([0.6]), 10.0, one_track([100, 50, 20, 10]), GATE)
    assert moved.covariance[0] == pytest.approx(covariance[0] + 4 * 0.36 * np.eye(2))


@pytest.mark.parametrize("place", [[0.0, 0.0], [[0.0, 0.0]]])
def test_a_bearing_turns_as_the_track_does(place):
    track = one_track([0.0, 1000.0, 50.0, 0.0], time=10.0)
    then = np.arctan2(-0.5 * 50.0, 1000.0)
    plots = positions([then + 0.001], sigma=0.01, volume=6.0, place=place, drift=[25.0])
    moved = carried_along(plots, np.array([0.5]), 10.0, track, GATE)
    assert np.sin(moved.value[0] - 0.001) == pytest.approx(0.0, abs=1e-12)
    across = 4.0 * 0.25 / (1000.0**2 + 25.0**2)
    assert moved.sigma[0] ** 2 == pytest.approx(0.01**2 + across, rel=1e-2)
    assert moved.drift[0] == 0.0


def test_a_bearing_is_near_across_north():
    track = one_track([-1.0, 1000.0, 0.0, 0.0], time=10.0)
    plots = positions([0.002], sigma=0.01, volume=6.0, place=[0.0, 0.0], drift=[25.0])
    assert carried_along(plots, np.array([0.5]), 10.0, track, GATE).drift[0] == 0.0


def test_plots_of_the_common_time_stay_bit_by_bit():
    plots = positions([[108.0, 54.0], [1.0 / 3.0, 0.1]])
    track = one_track([100, 50, 20, 10])
    assert carried_along(plots, np.zeros(2), 10.0, track, GATE) is plots
    partly = carried_along(plots, np.array([0.6, 0.0]), 10.0, track, GATE)
    assert partly.value[1].tolist() == plots.value[1].tolist()
    assert carried_along(plots, np.full(2, 0.6), 10.0, TrackTable.empty(2), GATE) is plots
