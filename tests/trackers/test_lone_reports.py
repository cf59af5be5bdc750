"""Sensors that do not scan: a report may come alone at any time."""

import numpy as np
import pytest

from trackweave.domain.scans import Scan
from trackweave.errors import InvalidInputError
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


def shared(scans):
    """Return a tracker after two objects shared stamps for a minute, a third had none."""
    following = MultiHypothesisTracker(
        motion=ConstantVelocity(1e-4, 5.0),
        sensors=[Sensor("transponder", 3.0, 0.2, 1e-8, scans=scans)],
        lifecycle=Lifecycle(new_target_density=1e-7, initial_target_density=1e-5),
    )
    for time in range(5):
        spots = [[0.0, 0.0], [500.0, 0.0], [0.0, 500.0]]
        following.step(Scan(float(time), "transponder", spots))
    for time in range(5, 60):
        last = following.step(Scan(float(time), "transponder", [[0.0, 0.0], [500.0, 0.0]]))
    return last.tracks


def test_stamps_that_others_share_are_no_misses_where_the_sensor_does_not_scan():
    assert len(shared(scans=False)) == 3


@pytest.mark.parametrize("scans", [None, True])
def test_several_reports_of_one_time_are_a_scan_where_nobody_says_otherwise(scans):
    assert len(shared(scans)) == 2


def test_a_lone_report_of_a_sensor_that_scans_is_a_miss_for_others():
    assert Sensor("camera", scans=True).tells_silence(1)
    assert not Sensor("camera").tells_silence(1)
    assert Sensor("camera", scans=False).tells_silence(0)


def test_a_sensor_that_does_not_scan_has_no_scan_period():
    with pytest.raises(InvalidInputError, match="scans: False; expected True"):
        Sensor("transponder", scan_period=2.0, scans=False)


def test_scans_taken_in_together_tell_what_they_tell_one_by_one():
    def following():
        return MultiHypothesisTracker(
            motion=ConstantVelocity(0.1, 20.0),
            sensors=[Sensor("transponder", 3.0, 0.2, 1e-8, scans=False)],
            window=12,
            lifecycle=Lifecycle(new_target_density=1e-7, initial_target_density=1e-5),
        )

    scans = list(lone_reports(np.random.default_rng(1), period=2.0))
    single, several = following(), following()
    for scan in scans:
        one_by_one = single.step(scan)
    for first in range(0, len(scans), 3):
        together = several.step(scans[first : first + 3])
    assert together.time == one_by_one.time
    np.testing.assert_allclose(together.tracks.mean, one_by_one.tracks.mean, rtol=1e-6, atol=1e-6)


def test_refuses_scans_together_that_are_not_in_order():
    scans = list(lone_reports(np.random.default_rng(1), period=2.0))[:3]
    with pytest.raises(InvalidInputError, match="each later than the last"):
        tracker(scan_period=None).step(scans[::-1])
    twice = [scans[0], scans[1], scans[1]]
    which = rf"number 3 of 3 \(sensor .*\) at {scans[1].time:.15g} s, after one"
    with pytest.raises(InvalidInputError, match=which):
        tracker(scan_period=None).step(twice)
