"""What fused reports are to a tracker, against plots drawn at random."""

import numpy as np
import pytest

from trackweave.association.plots_rule import PlotsRule, SensorPlots
from trackweave.domain.measurements import MeasurementKind
from trackweave.errors import InvalidInputError
from trackweave.models.coverage import FieldOfView
from trackweave.models.sensors import Sensor
from trackweave.trackers.fused_sensors import chances_of, likely_places

SIDE = 1000.0
CLUTTER = 4e-5


def sensors(count, **changed):
    values = {"sigma": 15.0, "detection_probability": 0.8, "clutter_density": CLUTTER}
    return [Sensor(name=str(number), **(values | changed)) for number in range(count)]


def evidence(**changed):
    values = {"object_density": 1e-4, "negative_only": True, "lone_plots": True, "gate": 1e4}
    return PlotsRule(**(values | changed))


def plots_of_positions(points, sensor):
    return SensorPlots(
        value=points,
        sigma=sensor.sigma,
        volume=SIDE**2,
        false_alarms=sensor.clutter_density * SIDE**2,
        detection_probability=sensor.detection_probability,
    )


def objects_seen(own, rule, rng, n_trials=1500):
    """Return how often all the plots of a lone object make a tuple that stands."""
    count = 0
    for _ in range(n_trials):
        plots = []
        for sensor in own:
            seen = rng.random() < sensor.detection_probability
            plots.append(plots_of_positions(rng.normal(0, sensor.sigma, (int(seen), 2)), sensor))
        n_seen = sum(len(each.value) for each in plots)
        tuples = rule(plots)
        count += bool(np.any(np.count_nonzero(tuples.tuples, axis=1) == n_seen)) and n_seen > 0
    return count / n_trials


@pytest.mark.parametrize("count", [2, 3])
def test_an_object_is_reported_as_often_as_its_plots_stand(count):
    own, rule = sensors(count), evidence()
    chance, _ = chances_of(own, rule, np.zeros((1, 2)), [None] * count)
    found = objects_seen(own, rule, np.random.default_rng(2))
    assert chance == pytest.approx(found, abs=0.035)
    assert 0.3 < chance < 0.95


@pytest.mark.slow
def test_chance_makes_as_many_tuples_as_false_alarms_do():
    own, rule, rng = sensors(3), evidence(), np.random.default_rng(3)
    _, density = chances_of(own, rule, np.zeros((1, 2)), [None] * 3)
    n_trials, count = 200, 0
    for _ in range(n_trials):
        plots = [
            plots_of_positions(rng.uniform(0, SIDE, (rng.poisson(CLUTTER * SIDE**2), 2)), sensor)
            for sensor in own
        ]
        count += len(rule(plots))
    assert count > 150
    assert density * SIDE**2 == pytest.approx(count / n_trials, rel=0.2)


@pytest.mark.slow
def test_two_bearings_cross_by_chance_as_often_as_drawn():
    stands = [(0.0, 0.0), (SIDE, 0.0)]
    own = [
        Sensor(
            name=str(number),
            sigma=0.01,
            clutter_density=2.0,
            measurement=MeasurementKind.BEARING,
            position=stand,
        )
        for number, stand in enumerate(stands)
    ]
    # So many objects that every crossing stands.
    rule = evidence(object_density=10.0)
    place = np.array([[500.0, 800.0]])
    _, density = chances_of(own, rule, place, [None, None])
    rng, count, n_trials, half = np.random.default_rng(4), 0, 1500, 60.0
    for _ in range(n_trials):
        angles = [rng.uniform(0, 2 * np.pi, rng.poisson(2.0 * 2 * np.pi)) for _ in own]
        for first in angles[0]:
            for second in angles[1]:
                ways = np.array(
                    [[np.sin(first), -np.sin(second)], [np.cos(first), -np.cos(second)]]
                )
                along = np.linalg.solve(ways, np.array([SIDE, 0.0]))
                point = along[0] * ways[:, 0]
                is_there = np.all(np.abs(point - place[0]) < half) and np.all(along > 0)
                count += bool(is_there)
    assert density * (2 * half) ** 2 == pytest.approx(count / n_trials, rel=0.15)


def test_lone_plots_stand_only_where_they_are_worth_more_than_a_false_alarm():
    places = np.zeros((1, 2))
    crowded = sensors(1, clutter_density=1e-4)
    quiet = sensors(1, clutter_density=1e-8)
    assert chances_of(crowded, evidence(), places, [None])[0] < 1e-6
    chance, density = chances_of(quiet, evidence(), places, [None])
    assert chance == pytest.approx(0.8)
    assert density == pytest.approx(1e-8)
    assert chances_of(quiet, evidence(lone_plots=False), places, [None])[0] < 1e-6


def test_equation_one_weighs_tuples_against_their_plots_alone():
    # A pair of two sensors leaves out two misses: it stands if ½ d² is less than they cost.
    own = sensors(2)
    rule = PlotsRule(cost="equation-1", lone_plots=True, gate=1e4)
    chance, _ = chances_of(own, rule, np.zeros((1, 2)), [SIDE**2] * 2)
    saved = -2.0 * np.log(0.2)
    assert chance == pytest.approx(0.64 * (1.0 - np.exp(-saved)))
    with pytest.raises(InvalidInputError, match="field_of_view"):
        chances_of(own, rule, np.zeros((1, 2)), [None, None])


def test_only_sensors_that_cover_a_place_count_there():
    near = FieldOfView(max_range=100.0)
    own = sensors(3, detection_probability=0.9, clutter_density=1e-9)
    rule = evidence(lone_plots=False)
    all_round, _ = chances_of(own, rule, np.array([[0.0, 500.0]]), [None] * 3)
    own[2] = Sensor(
        name="2", sigma=15.0, detection_probability=0.9, clutter_density=1e-9, field_of_view=near
    )
    two, _ = chances_of(own, rule, np.array([[0.0, 500.0]]), [None] * 3)
    three, _ = chances_of(own, rule, np.array([[0.0, 50.0]]), [None] * 3)
    assert two == pytest.approx(0.81, abs=1e-3)
    assert three == pytest.approx(all_round)
    # Averaged over the places where anything can be reported at all.
    own[1] = own[2]
    blind = np.array([[0.0, 500.0], [0.0, 50.0]])
    assert chances_of(own, rule, blind, [None] * 3)[0] == pytest.approx(three, abs=1e-3)


def test_more_than_three_sensors_together_always_stand():
    own = sensors(6, detection_probability=0.6, clutter_density=1e-9)
    chance, _ = chances_of(own, evidence(lone_plots=False), np.zeros((1, 2)), [None] * 6)
    lone_or_none = 0.4**6 + 6 * 0.6 * 0.4**5
    assert chance == pytest.approx(1.0 - lone_or_none, abs=0.01)


def test_range_and_azimuth_count_as_the_position_that_they_make():
    radar = {
        "sigma": (20.0, 0.02),
        "clutter_density": 1e-2,
        "measurement": MeasurementKind.RANGE_AZIMUTH,
    }
    place = np.array([[0.0, 1000.0]])
    polar = sensors(2, **radar)
    flat = sensors(2, sigma=20.0, clutter_density=1e-5)
    rule = evidence(object_density=1e-5)
    for one, other in zip(
        chances_of(polar, rule, place, [None] * 2),
        chances_of(flat, rule, place, [None] * 2),
        strict=True,
    ):
        assert one == pytest.approx(other)


def test_elevation_changes_with_the_place_as_differences_say():
    from trackweave.trackers.fused_sensors import _jacobian

    stand, place = np.array([10.0, -20.0, 5.0]), np.array([400.0, 300.0, 250.0])
    own = Sensor(
        name="0",
        measurement=MeasurementKind.RANGE_AZIMUTH_ELEVATION,
        position=tuple(stand.tolist()),
    )

    def seen(point):
        east, north, up = point - stand
        level = np.hypot(east, north)
        return np.array([np.hypot(level, up), np.arctan2(east, north), np.arctan2(up, level)])

    step = 1e-4
    slopes = np.stack(
        [
            (seen(place + step * axis) - seen(place - step * axis)) / (2 * step)
            for axis in np.eye(3)
        ],
        axis=1,
    )
    assert _jacobian(own, place[None])[0] == pytest.approx(slopes, rel=1e-6, abs=1e-9)


def test_likely_places_lie_in_the_fields_of_view_or_about_the_sensors():
    view = FieldOfView(position=(500.0, 0.0), max_range=200.0)
    places = likely_places(sensors(2, field_of_view=view), 3)
    assert places.shape[1] == 3
    assert np.all(np.abs(places - [500.0, 0.0, 0.0]) <= 200.0)
    apart = [sensors(1)[0], Sensor(name="far", position=(4000.0, 0.0))]
    assert np.ptp(likely_places(apart, 2), axis=0).min() > 4000.0
