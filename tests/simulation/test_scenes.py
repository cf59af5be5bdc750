"""Tests of static scenes."""

import math
from typing import Any

import numpy as np
import pytest

from trackweave.errors import InvalidInputError
from trackweave.simulation.scenes import BearingKind, PositionKind, Scene, SceneKind, draw_scene

KINDS = [PositionKind(3, 40, 6.0), BearingKind(4, 40, 0.01)]


def draw(kind: SceneKind, seed: int = 1) -> Scene:
    return draw_scene(kind, np.random.default_rng(seed))


def azimuths(scene: Scene, sensor: int) -> np.ndarray:
    assert scene.places is not None
    east, north = (scene.objects - scene.places[sensor]).T
    return np.arctan2(east, north)


@pytest.mark.parametrize("kind", KINDS)
def test_the_same_seed_gives_the_same_scene(kind: SceneKind) -> None:
    one, two, other = draw(kind), draw(kind), draw(kind, 2)
    for mine, yours in zip(one.plots + one.label, two.plots + two.label, strict=True):
        assert mine.tobytes() == yours.tobytes()
    assert one.plots[0].tobytes() != other.plots[0].tobytes()


@pytest.mark.parametrize("kind", KINDS)
def test_each_object_is_in_a_sensors_plots_at_most_once(kind: SceneKind) -> None:
    scene = draw(kind)
    assert len(scene.plots) == len(scene.label) == kind.n_sensors
    for plots, label in zip(scene.plots, scene.label, strict=True):
        assert plots.shape[0] == label.shape[0]
        true = label[label >= 0]
        assert len(set(true.tolist())) == true.size
        assert set(true.tolist()) <= set(range(kind.n_objects))


def test_the_squares_side_follows_from_the_spacing() -> None:
    kind = PositionKind(2, 400, 5.0, 2.0)
    scene = draw(kind)
    assert kind.side == 5.0 * 2.0 * 20.0
    assert scene.area == ((0.0, 0.0), (200.0, 200.0))
    assert scene.volume.tolist() == [40_000.0] * 2
    assert scene.object_density == 400 / 40_000
    assert scene.places is None
    assert 0 <= scene.objects.min() < 10
    assert 190 < scene.objects.max() <= 200


def test_plots_lie_about_their_objects_by_the_noise() -> None:
    scene = draw(PositionKind(2, 3000, 10.0, 7.0))
    for plots, label in zip(scene.plots, scene.label, strict=True):
        error = plots[label >= 0] - scene.objects[label[label >= 0]]
        assert np.std(error) == pytest.approx(7.0, rel=0.05)
        assert np.mean(error) == pytest.approx(0.0, abs=0.5)


def test_bearings_point_at_their_objects_clockwise_from_north() -> None:
    scene = draw(BearingKind(3, 2000, 0.001))
    for sensor, (plots, label) in enumerate(zip(scene.plots, scene.label, strict=True)):
        assert plots.min() >= 0
        assert plots.max() < 2 * math.pi
        aside = plots[label >= 0] - azimuths(scene, sensor)[label[label >= 0]]
        aside = np.remainder(aside + math.pi, 2 * math.pi) - math.pi
        assert np.std(aside) == pytest.approx(0.001, rel=0.1)


def test_the_sensors_stand_on_a_circle_the_first_in_the_north() -> None:
    scene = draw(BearingKind(4, 1))
    expected = [[5e3, 14e3], [14e3, 5e3], [5e3, -4e3], [-4e3, 5e3]]
    np.testing.assert_allclose(scene.places, expected, atol=1e-9)


def test_false_bearings_fill_the_angle_in_which_the_square_is_seen() -> None:
    scene = draw(BearingKind(3, 3000, clutter_per_object=1.0))
    # From the north, the nearest corners stand 5 km aside at 4 km.
    assert scene.volume[0] == pytest.approx(2 * math.atan2(5, 4))
    for sensor, (plots, label) in enumerate(zip(scene.plots, scene.label, strict=True)):
        centre = math.atan2(*(5e3 - scene.places[sensor]))
        false = np.remainder(plots[label < 0] - centre + math.pi, 2 * math.pi) - math.pi
        assert np.ptp(false) == pytest.approx(scene.volume[sensor], rel=0.01)
        seen = np.remainder(azimuths(scene, sensor) - centre + math.pi, 2 * math.pi) - math.pi
        assert false.min() - 0.01 < seen.min()
        assert seen.max() < false.max() + 0.01


@pytest.mark.parametrize(
    ("kind", "share"),
    [
        (PositionKind(3, 2000), 0.5),
        (PositionKind(5, 2000), 0.2),
        (BearingKind(3, 2000), 0.2),
        (BearingKind(3, 2000, clutter_per_object=0.7), 0.7),
    ],
)
def test_detections_and_false_alarms_come_as_often_as_they_should(
    kind: SceneKind, share: float
) -> None:
    scene = draw(kind)
    assert scene.false_alarms.tolist() == [share * 2000] * kind.n_sensors
    for label in scene.label:
        assert np.sum(label < 0) == pytest.approx(share * 2000, rel=0.15)
        assert np.sum(label >= 0) == pytest.approx(0.9 * 2000, rel=0.05)


def test_the_order_of_plots_tells_nothing() -> None:
    label = draw(PositionKind(2, 1000, clutter_per_object=1.0)).label[0]
    true = label[label >= 0]
    assert abs(np.corrcoef(np.arange(true.size), true)[0, 1]) < 0.1
    assert np.mean(np.flatnonzero(label < 0)) == pytest.approx(label.size / 2, rel=0.1)


def test_a_scene_may_be_empty() -> None:
    scene = draw(PositionKind(2, 0))
    assert [plots.shape for plots in scene.plots] == [(0, 2), (0, 2)]
    assert scene.object_density == 0.0


@pytest.mark.parametrize(
    ("make", "values", "words"),
    [
        (PositionKind, {"n_sensors": 1}, "n_sensors: 1; expected a whole number of at least 2"),
        (PositionKind, {"n_sensors": 2.5}, "n_sensors: 2.5"),
        (PositionKind, {"n_objects": -1}, "n_objects: -1"),
        (PositionKind, {"n_objects": 10**9}, "n_objects: 1000000000, .* expected at most"),
        (PositionKind, {"spacing": 0.0}, "spacing: 0.0; expected a number above 0"),
        (PositionKind, {"spacing": math.nan}, "spacing: nan"),
        (PositionKind, {"sigma": -1.0}, "sigma: -1.0"),
        (PositionKind, {"detection_probability": 1.0}, "detection_probability: 1"),
        (PositionKind, {"clutter_per_object": -0.1}, "clutter_per_object: -0.1"),
        (PositionKind, {"clutter_per_object": math.inf}, "clutter_per_object: inf"),
        (BearingKind, {"n_sensors": 0}, "n_sensors: 0"),
        (BearingKind, {"sigma": 4.0}, "sigma: 4.0"),
        (BearingKind, {"side": "wide"}, "side: 'wide'"),
        (BearingKind, {"radius": 7_000.0}, "radius: 7000.0; expected a number above 7071"),
    ],
)
def test_refuses_a_scene_that_cannot_be(
    make: type[Any], values: dict[str, Any], words: str
) -> None:
    with pytest.raises(InvalidInputError, match=words):
        make(**{"n_sensors": 3, "n_objects": 10} | values)
