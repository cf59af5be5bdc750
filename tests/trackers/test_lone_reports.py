"""Sensors that do not scan: a report may come alone at any time."""

import numpy as np
import pytest

from trackweave.domain.scans import Scan
from trackweave.models.motion import ConstantVelocity
from trackweave.models.sensors import Sensor
from trackweave.trackers.lifecycle import Lifecycle
from trackweave.trackers.multi_hypothesis import MultiHypothesisTracker

N_OBJECTS = 6


def lone_reports(rng, period):
    """Yield lone reports of six objects in turn, at uneven times."""
    start = np.stack([200.0 * np.arange(N_OBJECTS), np.zeros(N_OBJECTS)], axis=1)
    time = 0.0
    for turn in range(20 * N_OBJECTS):
        time += period / N_OBJECTS * rng.uniform(0.5, 1.5)
        place = start[turn % N_OBJECTS] + time * np.array([0.0, 5.0])
        yield Scan(time, "transponder", place[None] + rng.normal(0, 3.0, (1, 2)))


def tracker(scan_period):
    sensors = [
        Sensor("transponder", 3.0, 0.9, 1e-8, scan_period=scan_period),
        Sensor("radar", 3.0, 0.9, 1e-8, scan_period=2.0),
    ]
    return MultiHypothesisTracker(
        motion=ConstantVelocity(0.1, 20.0),
        sensors=sensors,
        window=5,
        lifecycle=Lifecycle(new_target_density=1e-7, initial_target_density=1e-5),
    )


def test_lone_reports_of_others_are_no_misses():
    rng = np.random.default_rng(1)
    following = tracker(scan_period=None)
    for scan in lone_reports(rng, period=2.0):
        last = following.step(scan, rng=rng)
    assert len(last.tracks) == N_OBJECTS
    assert set(last.tracks.track.tolist()) == set(range(1, N_OBJECTS + 1))
    assert np.all(last.tracks.status == 1)


def test_an_empty_scan_of_a_sensor_without_period_is_a_miss_for_all():
    rng = np.random.default_rng(1)
    following = tracker(scan_period=None)
    for scan in lone_reports(rng, period=2.0):
        last = following.step(scan, rng=rng)
    for step in range(1, 8):
        nothing = Scan(last.time + step, "transponder", np.empty((0, 2)))
        ended = following.step(nothing, rng=rng)
    assert len(ended.tracks) == 0


@pytest.mark.parametrize("silence", [500.0, 700.0])
def test_without_any_period_a_track_ends_after_ten_minutes_unseen(silence):
    rng = np.random.default_rng(1)
    following = MultiHypothesisTracker(
        motion=ConstantVelocity(1e-6, 5.0),
        sensors=[Sensor("transponder", 3.0, 0.9, 1e-8)],
        lifecycle=Lifecycle(survival=1 - 1e-9, new_target_density=1e-7),
    )
    for time in range(20):
        following.step(Scan(float(time), "transponder", np.zeros((1, 2))), rng=rng)
    far = np.array([[1e6, 1e6]])
    for later in range(8):
        scan = Scan(19.0 + silence + later, "transponder", far + 300.0 * later)
        last = following.step(scan, rng=rng)
    followed = np.abs(last.tracks.mean[:, 0]) < 1e4
    assert bool(followed.any()) == (silence < 600.0)
