"""Tracks from directions alone: ghosts, where lines of different objects cross, do not stay."""

import numpy as np
import pytest
from scipy.optimize import linear_sum_assignment

from trackweave.association.growth_limits import GrowthLimits
from trackweave.domain.measurements import MeasurementKind
from trackweave.domain.scans import Scan
from trackweave.errors import InvalidInputError
from trackweave.models.motion import ConstantVelocity
from trackweave.models.sensors import Sensor
from trackweave.trackers.lifecycle import Lifecycle
from trackweave.trackers.multi_hypothesis import MultiHypothesisTracker
from trackweave.trackers.window import Window

SIDE, SIGMA, FALSE = 10e3, 0.002, 2.0
PLACES = SIDE / 2 + 9e3 * np.array([[0.0, 1.0], [1.0, 0.0], [0.0, -1.0], [-1.0, 0.0]])


def eyes(places=PLACES) -> list[Sensor]:
    return [
        Sensor(
            f"eye {number}", measurement=MeasurementKind.BEARING, sigma=SIGMA, scan_period=1.0,
            clutter_density=FALSE / 1.2, position=tuple(place),
        )
        for number, place in enumerate(places.tolist())
    ]  # fmt: skip


def tracker(sensors, limits=None) -> MultiHypothesisTracker:
    return MultiHypothesisTracker(
        motion=ConstantVelocity(0.1, max_speed=40.0), sensors=sensors, limits=limits,
        window=Window(depth=4, max_scans=16),
        lifecycle=Lifecycle(new_target_density=1e-9, initial_target_density=10 / SIDE**2),
    )  # fmt: skip


def seen_by(place: np.ndarray, objects: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Return the bearings that a sensor reports of objects, and false ones."""
    apart = objects[rng.random(len(objects)) < 0.9] - place
    bearing = np.arctan2(apart[:, 0], apart[:, 1]) + rng.normal(0.0, SIGMA, len(apart))
    inward = np.arctan2(*(SIDE / 2 - place))
    false = inward + rng.uniform(-0.6, 0.6, rng.poisson(FALSE))
    return np.concatenate([bearing, false])[:, None] % (2 * np.pi)


@pytest.mark.parametrize("seed", [1, 2])
def test_ten_objects_are_found_and_no_ghost_stays(seed) -> None:
    rng = np.random.default_rng(seed)
    start, velocity = rng.uniform(1e3, 9e3, (10, 2)), rng.uniform(-20.0, 20.0, (10, 2))
    sensors = eyes()
    found = tracker(sensors)
    for time in range(16):
        true = start + time * velocity
        for sensor, place in zip(sensors, PLACES, strict=True):
            scan = Scan(float(time), sensor.name, seen_by(place, true, rng))
            hypothesis = found.step(scan, rng=rng)
    tracks = hypothesis.tracks
    known = tracks.mean[tracks.status != "tentative", :2]
    apart = np.linalg.norm(true[:, None] - known[None], axis=2)
    rows, columns = linear_sum_assignment(np.minimum(apart, 200.0))
    assert len(known) == 10
    assert np.all(apart[rows, columns] < 200.0)
    assert np.median(apart[rows, columns]) < 25.0


def test_two_sensors_at_one_place_begin_nothing() -> None:
    rng = np.random.default_rng(0)
    sensors = eyes(PLACES[[0, 0]])
    found = tracker(sensors)
    for time in range(6):
        true = np.array([[4e3, 5e3], [6e3, 4e3]]) + 10.0 * time
        for sensor in sensors:
            scan = Scan(float(time), sensor.name, seen_by(PLACES[0], true, rng))
            hypothesis = found.step(scan, rng=rng)
    assert len(hypothesis.tracks) == 0


def test_parallel_bearings_begin_nothing() -> None:
    sensors = eyes(np.array([[0.0, 0.0], [1000.0, 0.0], [2000.0, 0.0]]))
    found, rng = tracker(sensors), np.random.default_rng(0)
    for time in range(6):
        for sensor in sensors:
            hypothesis = found.step(Scan(float(time), sensor.name, [[0.3]]), rng=rng)
    assert len(hypothesis.tracks) == 0


def test_without_a_sensor_that_tells_places_the_tree_is_wider() -> None:
    wide, usual = GrowthLimits.of_bearings(), GrowthLimits()
    assert wide.new_keep > usual.new_keep
    assert wide.new_ceiling > usual.new_ceiling
    with pytest.raises(InvalidInputError, match="limits"):
        tracker(eyes(), limits="wide")
