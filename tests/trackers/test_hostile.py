"""Scans that no sensor could make: bounded work, sound books, and a word about it."""

import numpy as np
import pytest

from oracles.scenes import MOTION, all_assignments, run, scan, sensor, tracker
from trackweave.association.growth_limits import GrowthLimits
from trackweave.solvers import Auto
from trackweave.trackers.nearest_neighbour import NearestNeighbourTracker

N_REPORTS = 300
LIMITS = GrowthLimits(max_nodes=3_000)
SEARCH = Auto(evaluations=500, branches=0)


def places(kind, rng):
    if kind == "equal":
        return np.full((N_REPORTS, 2), 100.0)
    if kind == "one sigma":
        return 100.0 + rng.normal(0.0, 10.0, (N_REPORTS, 2))
    return rng.uniform(0.0, 200.0, (N_REPORTS, 2))


@pytest.mark.parametrize("kind", ["equal", "one sigma", "uniform"])
def test_a_crowd_in_every_scan_is_bounded_and_told(kind):
    rng = np.random.default_rng(1)
    numbers = np.arange(4 * N_REPORTS).reshape(4, N_REPORTS)
    scans = [scan(float(k), places(kind, rng), report=numbers[k]) for k in range(4)]
    target = tracker(limits=LIMITS, search=SEARCH)
    hypotheses = run(target, scans)
    assert sorted(all_assignments(target, hypotheses)) == numbers.ravel().tolist()
    for number, each in enumerate(hypotheses, start=1):
        # Beginnings never give way.
        assert each.n_sequences <= LIMITS.max_nodes + number * N_REPORTS
        assert np.all(np.isfinite(each.tracks.mean))
        assert each.certificate.lower_bound <= each.certificate.cost + 1e-6
    assert any(each.is_crowded for each in hypotheses)
    assert sum(each.n_pruned for each in hypotheses) > N_REPORTS


def test_a_single_crowd_does_not_end_a_track_elsewhere():
    rng = np.random.default_rng(2)
    scans = []
    for k in range(9):
        own = np.array([[20.0 * k, 0.0]]) + rng.normal(0.0, 5.0, (1, 2))
        crowd = np.full((N_REPORTS if k == 5 else 0, 2), 3_000.0)
        scans.append(scan(float(k), np.concatenate([own, crowd])))
    tracks = run(tracker(limits=LIMITS, search=SEARCH), scans)[-1].tracks
    near = np.hypot(*(tracks.mean[:, :2] - [160.0, 0.0]).T) < 30.0
    assert np.count_nonzero(near) == 1
    assert tracks.hits[near][0] >= 8


def test_the_nearest_neighbour_tracker_takes_a_crowd_too():
    target = NearestNeighbourTracker(motion=MOTION, sensors=[sensor()])
    rng = np.random.default_rng(3)
    scans = [scan(float(k), places("one sigma", rng)) for k in range(3)]
    hypotheses = run(target, scans)
    assert len(all_assignments(target, hypotheses)) == 3 * N_REPORTS
