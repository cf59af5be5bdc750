"""Heights that reports tell beside their places say whose they are."""

import numpy as np
import pytest

import trackweave as tw
from trackweave.metrics import assignment_quality


def idf1_of_stack(climb: float | None, offset: float = 0.0) -> float:
    """Return how well eight aircraft that circle one above the other keep their names."""
    rng, scans, target = np.random.default_rng(3), [], []
    for turn in range(150):
        number = rng.permutation(8)[: rng.integers(6, 9)]
        angle = np.radians(1.5) * 4.0 * turn + 0.2 * number
        place = 4000.0 * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        height = 1500.0 + 300.0 * number + (climb or 0.0) * 4.0 * turn + offset * (turn % 2)
        height[rng.random(number.size) < 0.1] = np.nan
        scans.append(
            tw.Scan(
                time=4.0 * turn,
                sensor=f"radar {turn % 2 if offset else 0}",
                measurement=place + rng.normal(0, 300.0, place.shape),
                height=None if climb is None else height,
            )
        )
        target += number.tolist()
    sensors = [
        tw.Sensor(name, sigma=300.0, detection_probability=0.9, clutter_density=1e-10)
        for name in ("radar 0", "radar 1")
    ]
    motion = tw.ConstantVelocity(process_noise=30.0, max_speed=200.0)
    tracker = tw.MultiHypothesisTracker(motion=motion, sensors=sensors)
    track = np.full(len(target), -1)
    for scan in scans:
        final = tracker.step(scan, rng=np.random.default_rng(1)).final
        track[final.report] = final.track
    final = tracker.pending()
    track[final.report] = final.track
    return assignment_quality([str(each) for each in target], track).idf1


@pytest.mark.slow
@pytest.mark.parametrize("climb", [0.0, 60.0])
def test_heights_tell_apart_what_circles_in_a_stack(climb: float) -> None:
    assert idf1_of_stack(climb) > 0.8
    assert idf1_of_stack(None) < 0.4


def test_two_sensors_whose_heights_differ_see_the_same_objects() -> None:
    assert idf1_of_stack(0.0, offset=120.0) > 0.8
