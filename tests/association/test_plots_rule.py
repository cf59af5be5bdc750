"""Tests of the rule that makes tuples from the plots of several sensors."""

import math
from itertools import permutations

import numpy as np
import pytest
from scipy.optimize import least_squares

from oracles import plots as oracle
from trackweave.association.plots_rule import PlotsRule, SensorPlots, scene_plots
from trackweave.errors import InvalidInputError
from trackweave.simulation.scenes import BearingKind, PositionKind, draw_scene

PLACES = np.array([[0.0, 9e3], [-8e3, -4e3], [8e3, -4e3], [9e3, 3e3]])
RULES = [PlotsRule(cost="equation-1"), PlotsRule(1e-6), PlotsRule(1e-6, gate=4.0)]


def radar(value, sigma=10.0, **changes):
    return SensorPlots(
        np.asarray(value, dtype=float),
        **{"sigma": sigma, "volume": 1e6, "false_alarms": 2.0} | changes,
    )


def bearing_of(place, point):
    return math.atan2(point[0] - place[0], point[1] - place[1])


def camera(place, points, sigma=0.01, noise=None):
    value = np.array([bearing_of(place, point) for point in points])
    if noise is not None:
        value += noise.normal(0.0, sigma, size=value.shape)
    return SensorPlots(value, sigma, volume=2.0, false_alarms=1.5, place=place)


def radars(seed, n_objects=4, n_sensors=3, dim=2):
    rng = np.random.default_rng(seed)
    points = rng.uniform(0.0, 60.0, size=(n_objects, dim))
    sensors = []
    for sensor in range(n_sensors):
        sigma = rng.uniform(5.0, 15.0, size=(n_objects, dim))
        value = points + rng.normal(size=points.shape) * sigma
        detection, clutter = 0.6 + 0.1 * sensor, 1.0 + sensor
        sensors.append(radar(value, sigma, detection_probability=detection, false_alarms=clutter))
    return sensors


def cameras(seed, n_objects=4, n_sensors=4, sigma=0.02):
    rng = np.random.default_rng(seed)
    points = rng.uniform(-5e3, 5e3, size=(n_objects, 2))
    return [camera(place, points, sigma, rng) for place in PLACES[:n_sensors]]


def rows_of(scored):
    return {tuple(row): place for place, row in enumerate(scored.tuples.tolist())}


def assert_as_the_oracle_says(sensors, rule, *, least=2):
    expected = oracle.every_tuple(sensors, rule, least=least)
    scored = rule(sensors)
    rows = rows_of(scored)
    assert len(rows) == len(scored)
    assert set(rows) == set(expected)
    for key, row in rows.items():
        want = expected[key]
        spread = np.linalg.inv(want.information)
        np.testing.assert_allclose(scored.costs[row], want.cost, atol=1e-5)
        away = scored.positions[row] - want.position
        assert away @ want.information @ away < 1e-6
        np.testing.assert_allclose(scored.covariances[row], spread, rtol=1e-2, atol=1e-9)
    return rows


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("dim", [2, 3])
def test_finds_and_prices_every_tuple_of_positions(rule, dim):
    n_tuples = [len(assert_as_the_oracle_says(radars(seed, dim=dim), rule)) for seed in range(3)]
    assert min(n_tuples) > 10


@pytest.mark.slow
@pytest.mark.parametrize("rule", RULES)
def test_finds_and_prices_every_tuple_of_bearings(rule):
    n_tuples = [len(assert_as_the_oracle_says(cameras(seed), rule)) for seed in range(5)]
    assert min(n_tuples) > 40


@pytest.mark.parametrize("order", list(permutations(range(3))))
def test_positions_and_bearings_may_be_mixed(order):
    rng = np.random.default_rng(3)
    points = rng.uniform(-3e3, 3e3, size=(4, 2))
    sensors = [
        camera(PLACES[0], points, 0.05, rng),
        radar(points + rng.normal(size=points.shape) * 300.0, 300.0),
        camera(PLACES[1], points, 0.05, rng),
    ]
    rows = assert_as_the_oracle_says([sensors[place] for place in order], PlotsRule(1e-7))
    assert sum(all(row) for row in rows) >= 4


def test_lone_positions_are_priced_on_request():
    sensors = [*radars(1, 3, 2), camera((0.0, -100.0), [(10.0, 20.0), (50.0, 30.0)], 0.1)]
    for cost in ("equation-1", "evidence"):
        rule = PlotsRule(1e-6, cost=cost, lone_plots=True)
        rows = assert_as_the_oracle_says(sensors, rule, least=1)
        lone = {row for row in rows if np.count_nonzero(row) == 1}
        assert lone == {(1, 0, 0), (2, 0, 0), (3, 0, 0), (0, 1, 0), (0, 2, 0), (0, 3, 0)}


def test_the_evidence_of_positions_does_not_depend_on_the_order_of_sensors():
    sensors = radars(5, 3, 4)
    # So wide a gate that the order of joining leaves nothing out.
    rule = PlotsRule(1e-6, gate=1e6)
    first = rule(sensors)
    costs = dict(zip(map(tuple, first.tuples.tolist()), first.costs, strict=True))
    assert len(costs) == 4**4 - 1 - 12
    for order in permutations(range(4)):
        scored = rule([sensors[place] for place in order])
        for row, cost in zip(scored.tuples, scored.costs, strict=True):
            back = np.empty(4, dtype=int)
            back[list(order)] = row
            assert cost == pytest.approx(costs[tuple(back.tolist())], abs=1e-6)


def integrated(sensors, row, density, centre, half):
    """Return the evidence's cost by a sum over a fine grid."""
    axis = np.linspace(-half, half, 801)
    east, north = np.meshgrid(centre[0] + axis, centre[1] + axis)
    log = np.full(east.shape, math.log(density * (axis[1] - axis[0]) ** 2))
    for sensor, number in zip(sensors, row, strict=True):
        if not number:
            log += math.log(1 - sensor.detection_probability)
            continue
        aside = sensor.value[number - 1] - np.arctan2(
            east - sensor.place[0], north - sensor.place[1]
        )
        aside = np.remainder(aside + math.pi, 2 * math.pi) - math.pi
        sigma = sensor.sigma[number - 1]
        log += -0.5 * (aside / sigma) ** 2 - math.log(math.sqrt(2 * math.pi) * sigma)
        clutter = sensor.false_alarms / sensor.volume
        log += math.log(sensor.detection_probability / clutter)
    return -math.log(np.sum(np.exp(log)))


@pytest.mark.parametrize(("sigma", "within"), [(0.002, 0.02), (0.0087, 0.05), (0.02, 0.1)])
def test_the_evidence_of_bearings_is_the_integral_over_all_positions(sigma, within):
    sensors = cameras(2, n_objects=2, n_sensors=3, sigma=sigma)
    scored = PlotsRule(1e-7)(sensors)
    compared = 0
    for row, cost, place, spread in zip(
        scored.tuples, scored.costs, scored.positions, scored.covariances, strict=True
    ):
        if np.abs(place).max() > 6e3:
            continue
        half = 8 * math.sqrt(np.linalg.eigvalsh(spread).max())
        assert cost == pytest.approx(integrated(sensors, row, 1e-7, place, half), abs=within)
        compared += 1
    assert compared >= 6


def test_the_position_is_the_most_likely_one():
    sensors = cameras(7, n_objects=1)
    scored = PlotsRule(1e-6)(sensors)
    row = rows_of(scored)[1, 1, 1, 1]

    def aside(point):
        seen = [bearing_of(sensor.place, point) for sensor in sensors]
        return [
            math.remainder(sensor.value[0] - angle, 2 * math.pi) / sensor.sigma[0]
            for sensor, angle in zip(sensors, seen, strict=True)
        ]

    best = least_squares(aside, [0.0, 0.0], x_scale=1e3, xtol=1e-14, ftol=1e-14)
    np.testing.assert_allclose(scored.positions[row], best.x, atol=0.01)


def test_equal_positions_have_their_mean():
    sensors = [radar([[0.0, 0.0]]), radar([[6.0, 3.0]]), radar([[3.0, 9.0]])]
    scored = PlotsRule(1e-6)(sensors)
    row = rows_of(scored)[1, 1, 1]
    np.testing.assert_allclose(scored.positions[row], [3.0, 4.0])
    np.testing.assert_allclose(scored.covariances[row], np.eye(2) * 100.0 / 3.0)


def test_the_gate_is_a_squared_distance():
    rule = PlotsRule(1e-6, gate=16.0)
    # Of two plots of 10 m each: 4 sigma are 4 √2 · 10 m.
    reach = 4.0 * math.sqrt(2.0) * 10.0
    for side, n_tuples in ((reach - 1e-6, 1), (reach + 1e-6, 0)):
        for step in ([side, 0.0], [0.0, side], [-side, 0.0], [0.0, -side]):
            assert len(rule([radar([[0.0, 0.0]]), radar([step])])) == n_tuples


def test_bearings_that_cross_behind_a_sensor_are_no_tuple():
    east, west = (1000.0, 0.0), (-1000.0, 0.0)
    towards = [camera(west, [(0.0, 500.0)]), camera(east, [(0.0, 500.0)])]
    away = [camera(west, [(-2000.0, 500.0)]), camera(east, [(2000.0, 500.0)])]
    one_behind = [camera(west, [(0.0, 500.0)]), camera(east, [(2000.0, -500.0)])]
    assert len(PlotsRule(1e-6)(towards)) == 1
    assert len(PlotsRule(1e-6)(away)) == 0
    assert len(PlotsRule(1e-6)(one_behind)) == 0


def test_parallel_bearings_are_no_tuple_until_a_third_crosses_them():
    between = (100.0, 3.0)
    sensors = [camera((-1000.0, 0.0), [between]), camera((1000.0, 0.0), [between])]
    assert len(PlotsRule(1e-6)(sensors)) == 0
    aside = camera((0.0, 1000.0), [between, (300.0, 500.0)])
    rows = assert_as_the_oracle_says([*sensors, aside], PlotsRule(1e-6))
    # The second bearing of the third crosses each of the two, but not where both look.
    assert set(rows) == {(1, 1, 1), (1, 0, 1), (0, 1, 1), (1, 0, 2), (0, 1, 2), (1, 1, 2)}


def test_parallel_bearings_side_by_side_are_no_tuple_with_any_third():
    sensors = [
        SensorPlots([0.0], 0.01, 1.0, 1.0, place=(0.0, 0.0)),
        SensorPlots([0.0], 0.01, 1.0, 1.0, place=(1000.0, 0.0)),
        SensorPlots([math.pi / 2], 0.01, 1.0, 1.0, place=(-1000.0, 2000.0)),
    ]
    assert set(rows_of(PlotsRule(1e-6)(sensors))) == {(1, 0, 1), (0, 1, 1)}


def test_bearings_about_north_are_close():
    point = (0.0, 1000.0)
    sensors = [camera((-900.0, 900.0), [point]), camera((800.0, 1500.0), [point])]
    for value in (0.003, -0.003, 2 * math.pi - 0.003, 0.003 - 4 * math.pi):
        north = SensorPlots([value], 0.01, 1.0, 1.0, place=(0.0, 0.0))
        assert (1, 1, 1) in rows_of(PlotsRule(1e-6)([*sensors, north]))


def test_a_tuple_lies_in_the_area_as_far_as_is_known():
    sensors = cameras(4)
    area = ((-5e3, -5e3), (5e3, 5e3))
    everywhere, inside = PlotsRule(1e-6)(sensors), PlotsRule(1e-6, area=area)(sensors)
    deviation = np.sqrt(np.diagonal(everywhere.covariances, axis1=1, axis2=2))
    beyond = np.abs(everywhere.positions) - 5e3 > 4.0 * deviation
    assert 0 < np.sum(np.any(beyond, axis=1)) < len(everywhere)
    np.testing.assert_array_equal(inside.tuples, everywhere.tuples[~np.any(beyond, axis=1)])


@pytest.mark.parametrize(
    ("kind", "cost"),
    [
        (PositionKind(4, 20, 4.0), "equation-1"),
        (PositionKind(4, 20, 4.0), "evidence"),
        (BearingKind(4, 15, 0.01), "equation-1"),
        (BearingKind(4, 15, 0.01), "evidence"),
    ],
)
def test_tuples_that_cost_less_than_nothing_are_all_that_some_best_answer_needs(kind, cost):
    for seed in range(3):
        scene = draw_scene(kind, np.random.default_rng(seed))
        sensors, density = scene_plots(scene), scene.object_density
        every = PlotsRule(density, cost=cost)(sensors)
        negative = PlotsRule(density, cost=cost, negative_only=True)(sensors)
        below = every.costs < 0.0
        assert 0 < np.sum(below) < len(every) or cost == "equation-1"
        np.testing.assert_array_equal(negative.tuples, every.tuples[below])
        np.testing.assert_array_equal(negative.costs, every.costs[below])


def test_true_tuples_are_among_those_within_the_gate():
    scene = draw_scene(BearingKind(5, 40), np.random.default_rng(8))
    rows = rows_of(PlotsRule(scene.object_density)(scene_plots(scene)))
    n_seen = n_found = 0
    for target in range(40):
        numbers = [np.flatnonzero(label == target) for label in scene.label]
        row = tuple(int(number[0]) + 1 if number.size else 0 for number in numbers)
        n_seen += np.count_nonzero(row) > 1
        n_found += row in rows
    assert n_seen == 40
    assert n_found >= 39


def test_bearings_of_sensors_at_one_place_do_not_cross():
    point, place = (0.0, 1000.0), (0.0, 0.0)
    sensors = [camera(place, [point, (500.0, 0.0)]), camera(place, [point])]
    assert len(PlotsRule(1e-6)(sensors)) == 0
    aside = camera((1000.0, 1000.0), [point])
    rows = rows_of(PlotsRule(1e-6)([*sensors, aside]))
    assert set(rows) == {(1, 1, 1), (1, 0, 1), (0, 1, 1)}


def test_extreme_plots_give_finite_numbers_or_nothing():
    rng = np.random.default_rng(6)
    n_tuples = 0
    for scale in (1e-30, 1e-9, 1.0, 1e9, 1e29):
        for place in (0.0, 1.0, scale):
            point = rng.normal(size=2) * scale
            sensors = [
                camera((place, 0.0), [point, (place, 0.0)], 1e-29),
                camera((-place, scale), [point, (0.0, 0.0)], 3.0),
                radar([point, [0.0, 0.0]], scale),
                camera((0.0, -scale), [point, (0.0, scale)], 0.1),
            ]
            for cost in ("equation-1", "evidence"):
                scored = PlotsRule(1.0, cost=cost, gate=25.0, lone_plots=True)(sensors)
                n_tuples += len(scored)
                for values in (scored.costs, scored.positions, scored.covariances):
                    assert np.all(np.isfinite(values))
    assert n_tuples > 100


def test_numbers_follow_the_plots_as_they_came():
    values = np.array([[50.0, 0.0], [0.0, 0.0], [100.0, 0.0]])
    sensors = [radar(values, 1.0), radar(values[[2, 0, 1]], 1.0)]
    assert set(rows_of(PlotsRule(1e-6)(sensors))) == {(1, 2), (2, 3), (3, 1)}


def test_a_problem_can_be_made_of_them():
    scored = PlotsRule(1e-6)(radars(1))
    problem = scored.problem()
    assert problem.n_items == 12
    assert np.isfinite(problem.total).sum() == len(scored)


def test_a_sensor_without_plots_adds_its_miss():
    sensors = [radar([[0.0, 0.0]]), radar([[1.0, 0.0]])]
    blind = radar(np.empty((0, 2)), detection_probability=0.8)
    without, with_blind = PlotsRule(1e-6)(sensors), PlotsRule(1e-6)([*sensors, blind])
    assert with_blind.tuples.tolist() == [[1, 1, 0]]
    assert with_blind.costs[0] - without.costs[0] == pytest.approx(-math.log(0.2))


def test_no_plots_make_no_tuples():
    scored = PlotsRule(1e-6)([radar(np.empty((0, 3))), radar(np.empty((0, 3)))])
    assert scored.tuples.shape == (0, 2)
    assert scored.covariances.shape == (0, 3, 3)


def test_too_many_tuples_are_refused_and_just_enough_are_not():
    sensors = radars(0, n_objects=30)
    n_tuples = len(PlotsRule(1e-6)(sensors))
    assert n_tuples > 5000
    assert len(PlotsRule(1e-6, max_tuples=n_tuples)(sensors)) == n_tuples
    with pytest.raises(InvalidInputError, match=f"more than {n_tuples - 1} tuples lie in"):
        PlotsRule(1e-6, max_tuples=n_tuples - 1)(sensors)


def test_leaves_the_plots_as_they_are_and_gives_the_same_again():
    sensors = cameras(0)
    before = [sensor.value.copy() for sensor in sensors]
    one, two = PlotsRule(1e-6)(sensors), PlotsRule(1e-6)(sensors)
    assert one.costs.tobytes() == two.costs.tobytes()
    for sensor, value in zip(sensors, before, strict=True):
        np.testing.assert_array_equal(sensor.value, value)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"cost": "cheap"}, "cost: 'cheap'; expected one of evidence, equation-1"),
        ({"object_density": None}, "object_density: None; expected"),
        ({"object_density": 0.0}, "object_density: 0.0"),
        ({"object_density": math.nan}, "object_density: nan"),
        ({"gate": 0.0}, "gate: 0.0"),
        ({"gate": math.inf}, "gate: inf"),
        ({"negative_only": 1}, "negative_only: 1"),
        ({"lone_plots": "yes"}, "lone_plots: 'yes'"),
        ({"max_tuples": 0}, "max_tuples: 0"),
        ({"max_tuples": 1.5}, "max_tuples: 1.5"),
        ({"area": ((0.0, 0.0), (0.0, 1.0))}, "area: .* expected low before high"),
        ({"area": ((0.0, 0.0), (math.nan, 1.0))}, "area"),
        ({"area": (0.0, 1.0)}, "area"),
    ],
)
def test_refuses_a_rule_that_cannot_be(changes, words):
    with pytest.raises(InvalidInputError, match=words):
        PlotsRule(**{"object_density": 1e-6} | changes)


def test_refuses_sensors_that_do_not_fit_together():
    flat, deep = radar([[0.0, 0.0]]), radar([[0.0, 0.0, 0.0]])
    for sensors in ([flat, deep], [deep, camera((0.0, 0.0), [(1.0, 1.0)])]):
        with pytest.raises(InvalidInputError, match="two dimensions, or bearings, and of three"):
            PlotsRule(1e-6)(sensors)
    with pytest.raises(InvalidInputError, match="sensors: none"):
        PlotsRule(1e-6)([])
    with pytest.raises(InvalidInputError, match=r"sensors\[0\]: (?s:.*) SensorPlots"):
        PlotsRule(1e-6)([np.zeros((2, 2))])
    with pytest.raises(InvalidInputError, match=r"area: .* expected shape"):
        PlotsRule(1e-6, area=((0.0,) * 3, (1.0,) * 3))([flat])
