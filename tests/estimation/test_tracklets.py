"""Tracks of one sensor come from its reports alone."""

import numpy as np

from trackweave.estimation.tracklets import SensorReports, tracklets_of


def seen(n_objects=5, n_scans=20, seed=1, n_false=0):
    """Objects that go straight, each seen in every scan, and whose each report is."""
    rng = np.random.default_rng(seed)
    start, velocity = rng.uniform(0, 4e4, (n_objects, 2)), rng.normal(0, 100, (n_objects, 2))
    scan = np.repeat(np.arange(n_scans), n_objects)
    whose = np.tile(np.arange(n_objects), n_scans)
    time = 4.0 * scan + 0.1 * whose
    place = start[whose] + velocity[whose] * time[:, None] + rng.normal(0, 20, (scan.size, 2))
    when = rng.integers(0, n_scans, n_false)
    time, scan = np.r_[time, 4.0 * when], np.r_[scan, when]
    place = np.r_[place, rng.uniform(0, 4e4, (n_false, 2))]
    whose = np.r_[whose, np.full(n_false, -1)]
    nothing, noise = np.full(time.size, np.nan), np.full(time.size, 20.0)
    return SensorReports(time, place, noise, nothing, scan, 4.0), whose


def test_each_object_is_one_track():
    reports, whose = seen()
    track = tracklets_of(reports, 400.0)
    assert np.unique(np.stack([track, whose]), axis=1).shape[1] == 5
    assert track.min() == 0


def test_false_alarms_are_on_no_track_as_a_rule():
    reports, whose = seen(n_false=60)
    track = tracklets_of(reports, 400.0)
    assert np.mean(track[whose < 0] < 0) > 0.9
    assert np.mean(track[whose >= 0] >= 0) > 0.95


def test_what_is_seen_too_seldom_is_no_track():
    reports, _ = seen(n_scans=5)
    assert np.all(tracklets_of(reports, 400.0) == -1)


def test_reports_at_other_heights_are_of_others():
    reports, _ = seen(n_objects=1)
    odd = np.where(reports.scan % 2, 1e3, 9e3)
    track = tracklets_of(reports._replace(height=odd), 400.0)
    assert np.unique(odd[track == track[0]]).size == 1
