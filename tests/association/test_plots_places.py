"""Tests of plots whose errors, times and sensors' coverage depend on the place."""

import math
from dataclasses import replace

import numpy as np
import pytest

from oracles import plots as oracle
from trackweave.association.plots_rule import PlotsRule, SensorPlots
from trackweave.errors import InvalidInputError
from trackweave.models.coverage import FieldOfView

PLACES = np.array([[0.0, 9e3], [-8e3, -4e3], [8e3, -4e3], [9e3, 3e3]])
RULES = [PlotsRule(1e-7), PlotsRule(1e-7, cost="equation-1", lone_plots=True)]


def correlated(rng, n_plots, scale, dim=2):
    root = rng.normal(size=(n_plots, dim, dim)) * scale
    return root @ root.swapaxes(1, 2) + (0.3 * scale) ** 2 * np.eye(dim)


def radars(seed, scale=10.0, dim=2, n_objects=4, n_sensors=3, **changes):
    rng = np.random.default_rng(seed)
    points = rng.uniform(0.0, 6.0 * scale, size=(n_objects, dim))
    sensors = []
    for sensor in range(n_sensors):
        covariance = correlated(rng, n_objects, scale, dim)
        noise = np.einsum(
            "kij,kj->ki", np.linalg.cholesky(covariance), rng.normal(size=points.shape)
        )
        sensors.append(
            SensorPlots(
                points + noise,
                volume=1e6,
                covariance=covariance,
                clutter_density=rng.uniform(1e-7, 3e-6, size=n_objects),
                false_alarms=1.0,
                detection_probability=0.6 + 0.1 * sensor,
                **changes,
            )
        )
    return sensors


def cameras(seed, n_objects=3, sigma=0.01, drift=0.0, n_sensors=3):
    rng = np.random.default_rng(seed)
    points = rng.uniform(-5e3, 5e3, size=(n_objects, 2))
    sensors = []
    for place in PLACES[:n_sensors]:
        away = points - place
        spread = np.sqrt(sigma**2 + np.square(drift) / np.sum(away**2, axis=1))
        value = np.arctan2(away[:, 0], away[:, 1]) + rng.normal(size=n_objects) * spread
        sensors.append(SensorPlots(value, sigma, 2.0, 1.5, place=place, drift=drift))
    return sensors


def assert_as_the_oracle_says(sensors, rule, within=1e-5):
    least = 1 if rule.lone_plots else 2
    expected = oracle.every_tuple(sensors, rule, least=least)
    scored = rule(sensors)
    rows = {tuple(row): place for place, row in enumerate(scored.tuples.tolist())}
    assert len(rows) == len(scored)
    assert set(rows) == set(expected)
    for key, row in rows.items():
        want = expected[key]
        assert scored.costs[row] == pytest.approx(want.cost, abs=within)
        away = scored.positions[row] - want.position
        assert away @ want.information @ away < 1e-6
    return rows


def negative_only_leaves_out_no_more_than_it_may(sensors, rule):
    every = rule(sensors)
    negative = replace(rule, negative_only=True)(sensors)
    below = every.costs < 0.0
    np.testing.assert_array_equal(negative.tuples, every.tuples[below])
    np.testing.assert_array_equal(negative.costs, every.costs[below])
    return int(np.sum(below)), len(every)


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("dim", [2, 3])
def test_correlated_errors_and_densities_of_each_place(rule, dim):
    for seed in range(2):
        assert len(assert_as_the_oracle_says(radars(seed, dim=dim), rule)) > 8


def test_a_covariance_without_correlation_is_a_sigma():
    rng = np.random.default_rng(4)
    value, sigma = rng.uniform(0.0, 50.0, size=(2, 5, 2)), rng.uniform(5.0, 15.0, size=(2, 5, 2))
    by_sigma = [SensorPlots(*each, 1e6, 1.0) for each in zip(value, sigma, strict=True)]
    covariance = sigma[..., None] ** 2 * np.eye(2)
    by_matrix = [
        SensorPlots(each, None, 1e6, 1.0, covariance=spread)
        for each, spread in zip(value, covariance, strict=True)
    ]
    one, two = PlotsRule(1e-6)(by_sigma), PlotsRule(1e-6)(by_matrix)
    np.testing.assert_array_equal(one.tuples, two.tuples)
    np.testing.assert_allclose(one.costs, two.costs, atol=1e-9)


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("dim", [2, 3])
def test_drift_widens_a_position_along_every_axis(rule, dim):
    sensors = radars(1, dim=dim, drift=np.array([0.0, 5.0, 20.0, 1.0]))
    assert len(assert_as_the_oracle_says(sensors, rule)) > 8
    sharp = SensorPlots(np.zeros((1, dim)), 3.0, 1e6, 1.0)
    blunt = PlotsRule(1.0, lone_plots=True)([replace(sharp, drift=4.0)])
    np.testing.assert_allclose(blunt.covariances[0], 25.0 * np.eye(dim))


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("drift", [20.0, 300.0, (0.0, 200.0, 400.0)])
def test_drift_widens_a_bearing_by_its_distance(rule, drift):
    for seed in range(2):
        sensors = cameras(seed, drift=np.asarray(drift) if np.ndim(drift) else drift)
        assert len(assert_as_the_oracle_says(sensors, rule, within=1e-4)) > 6


def test_drift_matters_among_positions_and_bearings_together():
    rng = np.random.default_rng(3)
    points = rng.uniform(-3e3, 3e3, size=(3, 2))
    bearings = [
        replace(sensor, value=np.arctan2(*(points - sensor.place).T))
        for sensor in cameras(3, drift=150.0, n_sensors=2)
    ]
    covariance = correlated(rng, 3, 300.0)
    plots = SensorPlots(points + 100.0, None, 1e8, 1.0, covariance=covariance, drift=100.0)
    for rule in RULES:
        for order in ([plots, *bearings], [bearings[0], plots, bearings[1]]):
            assert len(assert_as_the_oracle_says(order, rule, within=1e-4)) > 6


def test_a_drift_beyond_its_distance_says_nothing_of_direction():
    sensors = cameras(0, drift=3e3)
    assert len(PlotsRule(1e-7)(sensors)) == 0


def test_a_sensor_may_move_between_its_bearings():
    rng = np.random.default_rng(5)
    points = rng.uniform(-4e3, 4e3, size=(3, 2))
    sensors = []
    for place in PLACES[:3]:
        places = place + rng.normal(size=(3, 2)) * 500.0
        away = points - places
        value = np.arctan2(away[:, 0], away[:, 1])
        sensors.append(SensorPlots(value, 0.01, 2.0, 1.5, place=places))
    rows = assert_as_the_oracle_says(sensors, PlotsRule(1e-7))
    assert {(1, 1, 1), (2, 2, 2), (3, 3, 3)} <= set(rows)
    still = [replace(sensor, place=sensor.place[:1].repeat(3, 0)) for sensor in sensors]
    one_place = [replace(sensor, place=sensor.place[0]) for sensor in sensors]
    one, two = PlotsRule(1e-7)(still), PlotsRule(1e-7)(one_place)
    assert one.costs.tobytes() == two.costs.tobytes()


VIEWS = [
    FieldOfView(position=(0.0, 0.0), max_range=45.0),
    FieldOfView(position=(60.0, 0.0), min_range=20.0, max_range=70.0, azimuth_deg=(200.0, 30.0)),
    None,
]


@pytest.mark.parametrize("rule", RULES)
def test_only_those_miss_an_object_that_cover_its_place(rule):
    for seed in range(2):
        sensors = [
            replace(sensor, coverage=view)
            for sensor, view in zip(radars(seed), VIEWS, strict=True)
        ]
        # What is covered changes with the place and its covariance, which are found by steps.
        assert len(assert_as_the_oracle_says(sensors, rule, within=0.05)) > 8


@pytest.mark.parametrize("order", [(0, 1, 2), (2, 1, 0)])
def test_only_those_miss_crossing_bearings_that_cover_their_place(order):
    views = [FieldOfView(tuple(place), max_range=9e3) for place in PLACES[:3]]
    sensors = [
        replace(sensor, coverage=view)
        for sensor, view in zip(cameras(2, drift=50.0), views, strict=True)
    ]
    for rule in RULES:
        rows = assert_as_the_oracle_says([sensors[place] for place in order], rule, within=1e-4)
        assert len(rows) > 6


def test_a_polygon_is_a_coverage_too_and_its_edge_is_gradual():
    plots = SensorPlots([[0.0, 0.0]], 10.0, 1e6, 1.0)
    view = FieldOfView(polygon=[(-500.0, -500.0), (0.0, -500.0), (0.0, 500.0), (-500.0, 500.0)])
    blind = SensorPlots(np.empty((0, 2)), 1.0, 1e6, 1.0, 0.9, coverage=view)
    rule = PlotsRule(1e-6, lone_plots=True)
    alone = rule([plots]).costs[0]
    prices = []
    for east in (-200.0, -8.0, 8.0, 200.0):
        moved = replace(plots, value=plots.value + np.array([east, 0.0]))
        prices.append(rule([moved, blind]).costs[0] - alone)
    shares = -np.expm1(-np.array(prices)) / 0.9
    np.testing.assert_allclose(shares, [1.0, 0.8, 0.2, 0.0], atol=1e-12)


@pytest.mark.parametrize("cost", ["equation-1", "evidence"])
def test_leaving_out_what_costs_more_than_nothing_knows_of_coverage_and_drift(cost):
    seen = [0, 0]
    for seed in range(6):
        views = [None, VIEWS[0], VIEWS[1], VIEWS[0]]
        flat = radars(seed, n_objects=6, n_sensors=4)
        flat = [replace(each, coverage=view) for each, view in zip(flat, views, strict=True)]
        far = cameras(seed, n_objects=5, drift=300.0, n_sensors=4)
        views = [FieldOfView(tuple(place), max_range=8e3) for place in PLACES]
        far = [replace(each, coverage=view) for each, view in zip(far, views, strict=True)]
        for sensors in (flat, far):
            for density in (1e-9, 1e-7):
                rule = PlotsRule(density, cost=cost, lone_plots=True)
                found = negative_only_leaves_out_no_more_than_it_may(sensors, rule)
                seen = [seen[0] + found[0], seen[1] + found[1]]
    assert seen[0] > 100
    assert seen[0] < seen[1] or cost == "equation-1"


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"covariance": np.ones((1, 2, 2))}, "covariance: expected symmetric positive definite"),
        ({"covariance": np.eye(2)}, "covariance: .* expected shape"),
        ({"covariance": [[[1.0, 0.5], [0.1, 1.0]]]}, "covariance: expected symmetric"),
        ({"covariance": [[[math.nan, 0.0], [0.0, 1.0]]]}, "covariance"),
        ({"covariance": 1e-70 * np.eye(2)[None]}, "sigma: .* expected finite numbers > 0"),
        ({"sigma": None}, "sigma: None; expected it, or a covariance"),
        ({"clutter_density": 0.0}, "clutter_density: 0.0"),
        ({"clutter_density": [1.0, 2.0]}, "clutter_density: .* expected shape"),
        ({"clutter_density": [math.inf]}, "clutter_density"),
        ({"volume": [0.0]}, "volume"),
        ({"drift": -1.0}, "drift: -1.0; expected finite numbers ≥ 0"),
        ({"drift": [1.0, 2.0]}, "drift: .* expected shape"),
        ({"drift": None}, "drift: .* expected shape"),
        ({"coverage": "all"}, "coverage: 'all'"),
    ],
)
def test_refuses_plots_that_cannot_be(changes, words):
    with pytest.raises(InvalidInputError, match=words):
        SensorPlots([[0.0, 0.0]], **{"sigma": 1.0, "volume": 1.0, "false_alarms": 1.0} | changes)


def test_refuses_a_covariance_of_bearings():
    with pytest.raises(InvalidInputError, match="covariance: of bearings; expected"):
        SensorPlots([0.0], covariance=np.ones((1, 1, 1)), place=(0.0, 0.0))


def test_evidence_says_what_it_misses():
    plots = SensorPlots([[0.0, 0.0]], 1.0, volume=5.0)
    with pytest.raises(InvalidInputError, match=r"sensors\[0\]: no clutter_density, nor false_al"):
        PlotsRule(1e-6)([plots])
    assert len(PlotsRule(cost="equation-1", lone_plots=True)([plots])) == 1
