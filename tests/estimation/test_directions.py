"""Noise of ranges and directions is told apart, beside tracks."""

import numpy as np
import pytest

from estimation.test_estimate import table
from trackweave.estimation.directions import across_of, bearing_sensor, with_components
from trackweave.estimation.estimate import estimate
from trackweave.estimation.refine import Followed


def passing(n_scans: int = 40) -> tuple[np.ndarray, np.ndarray]:
    """Objects far from a radar, as range and azimuth with noise."""
    rng = np.random.default_rng(3)
    start = rng.uniform(-3e4, 3e4, (8, 2))
    velocity = rng.normal(0, 100, (8, 2))
    time = np.repeat(4.0 * np.arange(n_scans), 8)
    place = (start + velocity * 4.0 * np.arange(n_scans)[:, None, None]).reshape(-1, 2)
    distance = np.hypot(*place.T) + rng.normal(0, 20, len(place))
    azimuth = np.arctan2(*place.T) + rng.normal(0, 0.004, len(place))
    seen = np.stack([distance * np.sin(azimuth), distance * np.cos(azimuth)], axis=1)
    return time, seen


def test_range_and_azimuth_have_noise_of_their_own() -> None:
    time, place = passing()
    reports = table(time, place)
    track = np.tile(np.arange(8), 40)
    followed = Followed(track, {"A": np.unique(time)})
    found = with_components(estimate(reports), reports, followed, {"A": (0.0, 0.0)})
    sigma = found.sensors["A"].sigma
    assert isinstance(sigma, tuple)
    assert sigma[0] == pytest.approx(20.0, rel=0.2)
    assert sigma[1] == pytest.approx(0.004, rel=0.2)


def test_without_tracks_the_noise_stays_as_it_was() -> None:
    time, place = passing(10)
    reports = table(time, place)
    before = estimate(reports)
    followed = Followed(np.full(len(reports), -1), {"A": np.unique(time)})
    assert with_components(before, reports, followed, {"A": ()}) == before


def test_bearings_are_told_beside_tracks() -> None:
    rng = np.random.default_rng(2)
    moments = np.arange(0.0, 60.0, 0.5)
    track = np.stack([200.0 + moments, 100.0 + 0 * moments], axis=1)
    time, bearing = [], []
    for moment, place in zip(moments, track, strict=True):
        if rng.random() < 0.6:
            time.append(moment)
            bearing.append(np.arctan2(*place) + rng.normal(0, 0.01))
        for _ in range(rng.poisson(2.0)):
            time.append(moment)
            bearing.append(rng.uniform(0, 2 * np.pi))
    found = bearing_sensor(
        np.array(time),
        np.array(bearing) % (2 * np.pi),
        np.zeros((len(time), 2)),
        [(moments, track)],
        2 * np.pi,
    )
    assert found is not None
    assert isinstance(found.sigma, tuple)
    assert found.sigma[0] == pytest.approx(0.01, rel=0.3)
    assert found.detection_probability == pytest.approx(0.6, abs=0.12)
    assert found.clutter_density * 2 * np.pi == pytest.approx(2.0, rel=0.3)


def test_bearings_beside_no_track_tell_nothing() -> None:
    time = np.arange(50.0)
    assert bearing_sensor(time, np.ones(50), np.zeros((50, 2)), [], 6.28) is None


def azimuth_noise(width, angle, seed=3):
    """Return distances of tracks and the noise of their azimuths, where objects have a width."""
    rng = np.random.default_rng(seed)
    distance = rng.uniform(300.0, 5000.0, 40)
    scatter = np.hypot(angle, width / distance) * rng.lognormal(0.0, 0.1, distance.size)
    return distance, scatter, rng.integers(20, 200, distance.size)


@pytest.mark.parametrize("angle", [0.0, 0.002])
def test_noise_that_is_there_however_near_objects_are_is_told(angle):
    assert across_of(*azimuth_noise(10.0, angle)) == pytest.approx(10.0, rel=0.2)


def test_noise_that_goes_with_the_distance_has_no_part_that_does_not():
    assert across_of(*azimuth_noise(0.0, 0.005)) == 0.0


def test_few_tracks_do_not_tell_how_noise_goes_with_the_distance():
    assert across_of(*(column[:5] for column in azimuth_noise(10.0, 0.0))) == 0.0
