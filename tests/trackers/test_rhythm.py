"""Objects that report themselves, each at intervals of its own."""

import numpy as np
import pytest

from trackweave.association.growth_limits import GrowthLimits
from trackweave.domain.scans import Scan
from trackweave.models.motion import ConstantVelocity
from trackweave.models.sensors import Sensor
from trackweave.trackers.lifecycle import Lifecycle
from trackweave.trackers.multi_hypothesis import MultiHypothesisTracker


def followed(ships, end, rng, negligible=0.0):
    """Return the track of each ship's reports: of a place, an interval and a first time each."""
    heard = sorted(
        (float(time) + rng.uniform(0.0, 0.3), ship)
        for ship, (_, interval, first) in enumerate(ships)
        for time in np.arange(first, end, interval)
    )
    following = MultiHypothesisTracker(
        motion=ConstantVelocity(process_noise=1e-6, max_speed=0.5),
        sensors=[Sensor("ais", 8.0, 0.05, 1e-9, scans=False)],
        window=24,
        limits=GrowthLimits(new_margin=20.0, new_keep=30, new_ceiling=25.0, negligible=negligible),
        lifecycle=Lifecycle(
            survival=1 - 1e-6, new_target_density=1e-9, initial_target_density=1e-7
        ),
    )
    track = {}

    def enter(assignments):
        track.update(zip(assignments.report.tolist(), assignments.track.tolist(), strict=True))

    for number, (time, ship) in enumerate(heard):
        place = np.array([[ships[ship][0], 0.0]]) + rng.normal(0.0, 6.0, (1, 2))
        enter(following.step(Scan(time, "ais", place, report=[number]), rng=rng).final)
    enter(following.pending())
    own = np.array([ship for _, ship in heard])
    tracks = np.array([track[number] for number in range(len(heard))])
    return [tracks[own == ship].tolist() for ship in range(len(ships))]


def share_of_own(found):
    """Return the share of all reports in the most usual track of their ship, no track twice."""
    own = [max(set(tracks), key=tracks.count) for tracks in found]
    assert len(set(own)) == len(own)
    kept = sum(tracks.count(name) for tracks, name in zip(found, own, strict=True))
    return kept / sum(map(len, found))


@pytest.mark.parametrize("negligible", [0.0, 0.005])
def test_neighbours_at_a_quay_are_told_apart_by_when_they_report(negligible):
    ships = [(0.0, 30.0, 1.0), (20.0, 30.0, 6.0)]
    shares = [
        share_of_own(followed(ships, 600.0, np.random.default_rng(seed), negligible))
        for seed in (1, 2)
    ]
    assert min(shares) > 0.9


def test_a_ship_that_reports_often_is_not_two():
    found = followed([(0.0, 10.0, 1.0)], 600.0, np.random.default_rng(1))
    assert len(set(found[0])) == 1
