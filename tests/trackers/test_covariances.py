"""Reports whose errors are correlated: a scene and the same scene turned give the same tracks."""

import numpy as np
import pytest

from trackweave.domain.scans import Scan
from trackweave.errors import InvalidInputError
from trackweave.models.motion import ConstantVelocity, Imm
from trackweave.models.sensors import Sensor
from trackweave.trackers.multi_hypothesis import MultiHypothesisTracker

SIGMA = np.array([40.0, 5.0])
ANGLE = np.radians(30.0)
TURN = np.array([[np.cos(ANGLE), -np.sin(ANGLE)], [np.sin(ANGLE), np.cos(ANGLE)]])


def scans(seed: int) -> list[np.ndarray]:
    """Return positions of two objects that pass each other, and of false alarms."""
    rng = np.random.default_rng(seed)
    start, velocity = np.array([[0.0, 0.0], [0.0, 60.0]]), np.array([[15.0, 3.0], [15.0, -3.0]])
    found = []
    for time in range(12):
        false = rng.uniform(-200.0, 400.0, (3, 2))
        exact = start + time * velocity
        found.append(np.concatenate([exact + rng.normal(0.0, SIGMA, exact.shape), false]))
    return found


@pytest.mark.parametrize(
    "motion",
    [
        ConstantVelocity(0.1, max_speed=30.0),
        Imm(
            (ConstantVelocity(0.1, max_speed=30.0), ConstantVelocity(5.0, max_speed=30.0)),
            (10.0, 5.0),
        ),
    ],
    ids=["constant velocity", "imm"],
)
def test_turning_the_world_turns_the_tracks(motion) -> None:
    trackers = [
        MultiHypothesisTracker(
            motion=motion, window=4, sensors=[Sensor("A", clutter_density=1e-5, scan_period=1.0)]
        )
        for _ in range(2)
    ]
    for time, position in enumerate(scans(1)):
        plain = Scan(time, "A", position, sigma=np.broadcast_to(SIGMA, position.shape))
        covariance = TURN @ np.diag(SIGMA**2) @ TURN.T
        turned = Scan(
            time, "A", position @ TURN.T,
            covariance=np.broadcast_to(covariance, (len(position), 2, 2)),
        )  # fmt: skip
        here, there = (
            tracker.step(scan, rng=np.random.default_rng(0))
            for tracker, scan in zip(trackers, (plain, turned), strict=True)
        )
        assert there.certificate.cost == pytest.approx(here.certificate.cost, abs=1e-6)
        mean = here.tracks.mean
        expected = np.concatenate([mean[:, :2] @ TURN.T, mean[:, 2:] @ TURN.T], axis=1)
        # Tracks are named in the order in which the plane was swept, which turns with it.
        found = there.tracks.mean
        order, wanted = np.lexsort(found.round(3).T), np.lexsort(expected.round(3).T)
        np.testing.assert_allclose(found[order], expected[wanted], atol=1e-6)
    assert len(here.tracks) >= 2


def test_scans_of_one_time_keep_their_covariances_when_merged() -> None:
    covariance = np.array([[[9.0, 2.0], [2.0, 4.0]]])
    tracker = MultiHypothesisTracker(
        motion=ConstantVelocity(0.1, max_speed=30.0),
        sensors=[Sensor("A", sigma=2.0, scan_period=1.0)],
        window=3,
    )
    split = MultiHypothesisTracker(
        motion=ConstantVelocity(0.1, max_speed=30.0),
        sensors=[Sensor("A", sigma=2.0, scan_period=1.0)],
        window=3,
    )
    rng = np.random.default_rng(0)
    first, second = np.array([[0.0, 0.0]]), np.array([[50.0, 0.0]])
    both = np.concatenate([covariance, [np.eye(2) * 4.0]])
    whole = tracker.step(Scan(0.0, "A", np.concatenate([first, second]), covariance=both), rng=rng)
    split.step(Scan(0.0, "A", first, covariance=covariance), rng=rng)
    parts = split.step(Scan(0.0, "A", second), rng=rng)
    assert parts.certificate.cost == pytest.approx(whole.certificate.cost)


@pytest.mark.parametrize(
    "covariance",
    [np.eye(2), np.ones((1, 2, 2)), [[[1.0, 0.5], [0.2, 1.0]]], [[[1.0, np.nan], [np.nan, 1.0]]]],
)
def test_refuses_what_is_no_covariance(covariance) -> None:
    with pytest.raises(InvalidInputError, match=r"covariance.*expected"):
        Scan(0.0, "A", [[1.0, 2.0]], covariance=covariance)
