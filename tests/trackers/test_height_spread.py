"""Over how much heights are spread, and that they tell whose a report is."""

import numpy as np
import pytest

import trackweave as tw
from trackweave.metrics import assignment_quality
from trackweave.trackers.height_spread import HeightSpread


def test_heights_in_parts_are_spread_as_all_of_them() -> None:
    height = np.random.default_rng(1).normal(4000.0, 900.0, 300)
    height[::7] = np.nan
    found = HeightSpread()
    for part in np.split(height, [0, 10, 120]):
        found = found.after(part)
    told = height[np.isfinite(height)]
    assert found.count == told.size
    assert found.width() == pytest.approx(np.sqrt(2 * np.pi * np.e) * told.std(), rel=1e-9)


@pytest.mark.parametrize(("count", "deviation"), [(40, 900.0), (300, 60.0)])
def test_few_heights_and_those_of_one_level_tell_nobody_apart(
    count: int, deviation: float
) -> None:
    height = np.random.default_rng(1).normal(0.0, deviation, count)
    assert HeightSpread().after(height).width() == 0.0


def idf1_of_stack(*, has_heights: bool) -> float:
    """Return how well eight aircraft that circle one above the other keep their names."""
    rng, scans, target = np.random.default_rng(3), [], []
    for turn in range(150):
        number = rng.permutation(8)[: rng.integers(6, 9)]
        angle = np.radians(1.5) * 4.0 * turn + 0.2 * number
        place = 4000.0 * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        height = 1500.0 + 300.0 * number
        height[rng.random(number.size) < 0.1] = np.nan
        scans.append(
            tw.Scan(
                time=4.0 * turn,
                sensor="radar",
                measurement=place + rng.normal(0, 300.0, place.shape),
                height=height if has_heights else None,
            )
        )
        target += number.tolist()
    sensor = tw.Sensor("radar", sigma=300.0, detection_probability=0.9, clutter_density=1e-10)
    motion = tw.ConstantVelocity(process_noise=30.0, max_speed=200.0)
    tracker = tw.MultiHypothesisTracker(motion=motion, sensors=[sensor])
    track = np.full(len(target), -1)
    for scan in scans:
        final = tracker.step(scan, rng=np.random.default_rng(1)).final
        track[final.report] = final.track
    final = tracker.pending()
    track[final.report] = final.track
    return assignment_quality([str(each) for each in target], track).idf1


def test_heights_tell_apart_what_circles_in_a_stack() -> None:
    assert idf1_of_stack(has_heights=True) > 0.9
    assert idf1_of_stack(has_heights=False) < 0.4
