"""One wild report neither ends a track nor drags it, where reports have heavy tails."""

import numpy as np
import pytest

from trackweave.domain.scans import Scan
from trackweave.models.motion import ConstantVelocity
from trackweave.models.sensors import Sensor
from trackweave.trackers.multi_hypothesis import MultiHypothesisTracker
from trackweave.trackers.nearest_neighbour import NearestNeighbourTracker

SIGMA, WILD_AT, N_SCANS = 5.0, 12, 24
MOTION = ConstantVelocity(process_noise=0.5, max_speed=60.0)


def followed(tracker, *, times=0.0, **tails):
    """Return tracks after each scan of one object, of whose reports one is so many sigmas off."""
    rng = np.random.default_rng(2)
    sensor = Sensor(
        "radar", sigma=SIGMA, clutter_density=1e-9, detection_probability=0.95, scan_period=1.0,
        **tails,
    )  # fmt: skip
    live, rows = tracker(motion=MOTION, sensors=[sensor]), []
    for number in range(N_SCANS):
        place = np.array([30.0 * number, -10.0 * number]) + SIGMA * rng.normal(size=2)
        if number == WILD_AT:
            place += times * SIGMA * np.array([0.6, 0.8])
        rows.append(live.step(Scan(float(number), "radar", [place])).tracks)
    return rows


@pytest.mark.parametrize("tracker", [MultiHypothesisTracker, NearestNeighbourTracker])
@pytest.mark.parametrize("times", [10.0, 20.0])
def test_a_wild_report_leaves_name_and_place(tracker, times):
    tails = {"tail_share": 0.01, "tail_scale": 10.0}
    calm, wild = followed(tracker, **tails), followed(tracker, times=times, **tails)
    for before, after in zip(calm, wild, strict=True):
        (name,) = before.track
        (row,) = np.flatnonzero(after.track == name)
        apart = np.abs(after.mean[row] - before.mean[0])
        assert np.all(apart < np.sqrt(np.diagonal(after.covariance[row])))
    assert len(wild[-1]) == 1


@pytest.mark.parametrize("tracker", [MultiHypothesisTracker, NearestNeighbourTracker])
def test_no_share_is_no_tail_however_wide(tracker):
    plain, wide = followed(tracker, times=10.0), followed(tracker, times=10.0, tail_scale=50.0)
    for before, after in zip(plain, wide, strict=True):
        np.testing.assert_array_equal(before.track, after.track)
        np.testing.assert_array_equal(before.mean, after.mean)
        np.testing.assert_array_equal(before.covariance, after.covariance)


def names_of_a_bad_one(persistence):
    """Return how many names an object has whose every report is some ten sigmas off."""
    rng = np.random.default_rng(7)
    sensor = Sensor(
        "radar", sigma=SIGMA, clutter_density=1e-9, detection_probability=0.8, scan_period=1.0,
        tail_share=0.05, tail_scale=12.0, tail_persistence=persistence,
    )  # fmt: skip
    live, names = MultiHypothesisTracker(motion=MOTION, sensors=[sensor]), set()
    for number in range(80):
        place = np.array([30.0 * number, -10.0 * number]) + 12.0 * SIGMA * rng.normal(size=2)
        hypothesis = live.step(Scan(float(number), "radar", [place]))
        names |= set(hypothesis.final.track.tolist())
    return len(names - {-1})


def test_an_object_of_wide_noise_keeps_one_name_where_tails_persist():
    assert names_of_a_bad_one(0.95) == 1
    assert names_of_a_bad_one(0.0) > 1
