"""Objects seen by their bearing alone, against integrals over the plane."""

import numpy as np
import pytest
from scipy.stats import multivariate_normal, norm

from oracles import sensing
from oracles.kind_windows import radar
from oracles.windows import SURVIVAL, WIDE
from trackweave.association.tree import AssociationTree
from trackweave.association.window_rule import Context, scan_input, window_rule
from trackweave.domain.measurements import MeasurementKind as Kind
from trackweave.domain.scans import Scan
from trackweave.models.coverage import FieldOfView
from trackweave.models.motion import ConstantVelocity, Imm

MOTION = ConstantVelocity(0.5, 50.0)
LOG_DENSITY = float(np.log(1e-8))
TRUE = np.array([1200.0, 2500.0])
WEST = radar("west", Kind.BEARING, position=(-2000.0, 0.0), clutter_density=0.5)
EAST = radar("east", Kind.BEARING, position=(2500.0, 700.0), sigma=0.015)
POINT = radar("point", Kind.POSITION, sigma=60.0)
POLAR = radar("polar", Kind.RANGE_AZIMUTH, position=(-1500.0, 3000.0), sigma=(40.0, 0.02))
RATE = radar("rate", Kind.RANGE_AZIMUTH_RATE, position=(-1500.0, 3000.0), sigma=(40.0, 0.02, 3.0))


def exact(sensor, place=TRUE):
    """Return what a sensor measures of an object that stands, without noise."""
    return sensing.expected(sensor.measurement, np.r_[place, 0.0, 0.0], sensor.platform, 2)


def grown(steps, motion=MOTION):
    """Return the tree after reports, one (time, sensor, measurement) each."""
    rule = window_rule(motion, (SURVIVAL, np.inf, np.inf, np.inf, np.inf), 2, crossing_time=4.0)
    tree, before = AssociationTree(rule, WIDE), None
    sensors = [WEST, EAST, POINT, POLAR, RATE]
    for slot, (time, sensor, measurement) in enumerate(steps):
        scan = Scan(time, sensor.name, np.atleast_2d(measurement))
        number = next((k for k, known in enumerate(sensors) if known is sensor), 9)
        data, _ = scan_input(scan, sensor, 0.0, Context(motion, 2, number))
        data = data._replace(slot=np.array([slot]), new_instant=time != before)
        tree.grow(data, np.array([LOG_DENSITY]))
        before = time
    return tree


def together(tree):
    """Return the node of the sequence of both reports, None if there is none."""
    nodes = tree.nodes
    both = [n for n in range(tree.n_nodes) if nodes.parent[n] >= 0]
    assert len(both) <= 1
    return both[0] if both else None


def likelihood(sensor, measurement, places):
    """Return the density of a report of an object at each place."""
    noise = np.diag(sensor.sigmas(2) ** 2)[:2, :2]
    if sensor.measurement is Kind.POSITION:
        return multivariate_normal(np.zeros(2), noise).pdf(places - measurement)
    place = places - sensor.platform[:2]
    azimuth = np.arctan2(place[:, 0], place[:, 1])
    if sensor.measurement is Kind.BEARING:
        return norm.pdf(np.angle(np.exp(1j * (azimuth - measurement[0]))), 0, sensor.sigma)
    off = np.angle(np.exp(1j * (azimuth - measurement[1])))
    density = norm.pdf(off, 0, sensor.sigma[1])
    density *= norm.pdf(np.hypot(*place.T) - measurement[0], 0, sensor.sigma[0])
    if sensor.measurement.has_rate:
        spread = np.hypot(np.sqrt(MOTION.velocity_variance(2)), sensor.sigma[2])
        density *= norm.pdf(measurement[2], 0, spread)
    return density


def integral(first, one, second, other, around, reach=900.0, cells=700):
    """Return the integral of both reports' densities over the plane [m²]."""
    axis = (np.arange(cells) + 0.5) / cells * 2 * reach - reach
    grid = np.stack(np.meshgrid(axis, axis), axis=-1).reshape(-1, 2) + around
    return (
        float(np.sum(likelihood(first, one, grid) * likelihood(second, other, grid)))
        * (2 * reach / cells) ** 2
    )


def cost_of_both(first, second, area):
    detected = np.log(first.detection_probability * second.detection_probability)
    clutter = np.log(first.clutter_density * second.clutter_density)
    return clutter - detected - LOG_DENSITY - np.log(area)


@pytest.mark.slow
@pytest.mark.parametrize("order", [1, -1], ids=["west first", "east first"])
@pytest.mark.parametrize("seed", range(3))
def test_two_crossing_bearings_cost_what_the_plane_says(seed, order):
    first, second = (WEST, EAST)[::order]
    rng = np.random.default_rng(seed)
    one = exact(first) + rng.normal(0, first.sigma)
    other = exact(second) + rng.normal(0, second.sigma)
    tree = grown([(0.0, first, one), (0.0, second, other)])
    node = together(tree)
    area = integral(first, one, second, other, TRUE)
    # The lines widen with the distance: the closed form is good to some per cent.
    assert tree.nodes.cost[node] == pytest.approx(cost_of_both(first, second, area), abs=0.02)


def test_bearings_put_their_object_where_they_cross_as_surely_as_fisher_says():
    one, other = exact(WEST), exact(EAST)
    tree = grown([(0.0, WEST, one), (0.0, EAST, other)])
    node = together(tree)
    np.testing.assert_allclose(tree.nodes.mean[node, 0], [*TRUE, 0.0, 0.0], atol=1e-6)
    state, nothing = np.r_[TRUE, 0.0, 0.0], np.eye(4)
    information = np.zeros((2, 2))
    for sensor in (WEST, EAST):
        _, _, cross = sensing.by_slopes(Kind.BEARING, state, nothing, sensor.platform, 2)
        information += cross[:2] @ cross[:2].T / sensor.sigma**2
    covariance = tree.nodes.covariance[node, 0]
    np.testing.assert_allclose(covariance[:2, :2], np.linalg.inv(information), rtol=1e-5)
    speed = MOTION.velocity_variance(2)
    np.testing.assert_allclose(covariance[2:], np.c_[np.zeros((2, 2)), speed * np.eye(2)])


@pytest.mark.parametrize("sensor", [POINT, POLAR, RATE], ids=lambda sensor: sensor.name)
@pytest.mark.parametrize("seed", range(2))
def test_a_place_on_a_line_costs_what_the_plane_says(sensor, seed):
    rng = np.random.default_rng(seed)
    one = exact(WEST) + rng.normal(0, WEST.sigma)
    other = exact(sensor) + rng.normal(0, sensor.sigmas(2))
    tree = grown([(0.0, WEST, one), (0.0, sensor, other)])
    area = integral(WEST, one, sensor, other, TRUE)
    node = together(tree)
    assert tree.nodes.cost[node] == pytest.approx(cost_of_both(WEST, sensor, area), abs=0.06)
    # The state is that of the place with the bearing taken in.
    alone = grown([(0.0, sensor, other)]).nodes
    mean, covariance = alone.mean[0, 0], alone.covariance[0, 0]
    expected, spread, cross = sensing.by_slopes(Kind.BEARING, mean, covariance, WEST.platform, 2)
    spread = spread + WEST.sigma**2
    off = sensing.difference(Kind.BEARING, one, expected)
    gain = cross @ np.linalg.inv(spread)
    np.testing.assert_allclose(
        tree.nodes.mean[node, 0], mean + gain @ off, atol=1e-3 * covariance[0, 0] ** 0.5
    )
    np.testing.assert_allclose(
        tree.nodes.covariance[node, 0], covariance - gain @ spread @ gain.T, atol=3.0
    )


@pytest.mark.parametrize("sensor", [EAST, POINT], ids=["bearing", "place"])
def test_an_older_bearing_is_less_certain_by_what_the_object_may_have_moved(sensor):
    """The object is where it is now: only the bearing of before is blurred by its motion."""
    tree = grown([(0.0, WEST, exact(WEST)), (3.0, sensor, exact(sensor))])
    mean, covariance = tree.nodes.mean[together(tree), 0], tree.nodes.covariance[together(tree), 0]
    np.testing.assert_allclose(mean, [*TRUE, 0.0, 0.0], atol=1e-6)
    state, information = np.r_[TRUE, 0.0, 0.0], np.zeros((2, 2))
    drift = 9.0 * MOTION.velocity_variance(2)
    near = np.linalg.norm(TRUE - WEST.platform[:2])
    for each, more in ((WEST, drift / near**2), (sensor, 0.0)):
        slope = np.eye(2)
        if each.measurement is Kind.BEARING:
            slope = sensing.by_slopes(Kind.BEARING, state, np.eye(4), each.platform, 2)[2][:2]
        information += slope @ slope.T / (each.sigma**2 + more)
    np.testing.assert_allclose(covariance[:2, :2], np.linalg.inv(information), rtol=1e-5)


def test_a_sensor_hardly_faster_than_its_objects_cannot_tell_where_they_are():
    """From a moving place, bearings one after the other cross; so do those of what moves."""
    found = []
    for speed in (100.0, 400.0):
        rule = window_rule(
            MOTION, (SURVIVAL, np.inf, np.inf, np.inf, np.inf), 2, crossing_time=4.0
        )
        tree = AssociationTree(rule, WIDE)
        gaze = radar("gaze", Kind.BEARING, sigma=1e-3, position=None)
        for slot, time in enumerate((0.0, 2.0)):
            platform = np.array([speed * time, 0.0, 0.0, speed, 0.0, 0.0])
            bearing = np.arctan2(*(TRUE - platform[:2]))
            scan = Scan(time, "gaze", np.array([[bearing]]), platform=platform)
            data, _ = scan_input(scan, gaze, 0.0, Context(MOTION, 2))
            tree.grow(data._replace(slot=np.array([slot])), np.array([LOG_DENSITY]))
        found.append(together(tree))
    assert found[0] is None
    assert found[1] is not None


def test_every_mode_begins_where_bearings_cross():
    two = Imm((MOTION, ConstantVelocity(20.0, 50.0)), (30.0, 10.0))
    tree = grown([(0.0, WEST, exact(WEST)), (0.0, EAST, exact(EAST))], two)
    node = together(tree)
    np.testing.assert_allclose(tree.nodes.weight[node], [0.75, 0.25])
    np.testing.assert_array_equal(tree.nodes.mean[node, 0], tree.nodes.mean[node, 1])
    np.testing.assert_array_equal(tree.nodes.covariance[node, 0], tree.nodes.covariance[node, 1])


@pytest.mark.parametrize("apart", [-3.9, -1.0, 0.0, 1.0, 3.9])
def test_nearly_parallel_bearings_do_not_say_where(apart):
    """Within four standard deviations of parallel a crossing may be anywhere."""
    spread = np.hypot(WEST.sigma, EAST.sigma)
    first = np.pi / 4
    steps = [(0.0, WEST, [first]), (0.0, EAST, [first - apart * spread])]
    assert together(grown(steps)) is None


def test_bearings_just_steeper_do():
    spread = np.hypot(WEST.sigma, EAST.sigma)
    # Far to the north both lines meet, the eastern one turned to the west.
    tree = grown([(0.0, WEST, [0.05]), (0.0, EAST, [2 * np.pi + 0.05 - 4.1 * spread])])
    assert together(tree) is not None


@pytest.mark.parametrize(
    ("bearings", "why"),
    [
        ((-0.5, 0.5), "they part"),
        ((np.pi - 0.5, np.pi + 0.5), "they meet beyond the west"),
    ],
)
def test_lines_that_do_not_meet_ahead_have_no_object(bearings, why):
    pair = [(0.0, s, [b % (2 * np.pi)]) for s, b in zip((WEST, EAST), bearings, strict=True)]
    found = together(grown(pair))
    assert (found is None) == (why == "they part")


def test_a_crossing_farther_than_a_sensor_sees_is_none():
    near = radar(
        "near", Kind.BEARING, position=EAST.position, field_of_view=FieldOfView(max_range=1500.0)
    )
    assert np.linalg.norm(TRUE - near.position[:2]) > 1500.0
    assert together(grown([(0.0, WEST, exact(WEST)), (0.0, near, exact(near))])) is None


@pytest.mark.parametrize(("later", "meets"), [(4.0, True), (4.1, False)])
@pytest.mark.parametrize("sensor", [EAST, POINT], ids=["bearing", "place"])
def test_lines_wait_a_scan_period_and_no_longer(later, meets, sensor):
    tree = grown([(0.0, WEST, exact(WEST)), (later, sensor, exact(sensor))])
    assert (together(tree) is not None) == meets


@pytest.mark.parametrize(("off", "meets"), [(280.0, True), (300.0, False)])
def test_a_place_far_from_the_line_is_not_its_objects(off, meets):
    """At 4 km the line is 41 m wide, the place 60 m: the gate of 4.03 deviations is at 292 m."""
    beside = TRUE + off * np.array([2500.0, -3200.0]) / np.hypot(2500.0, 3200.0)
    tree = grown([(0.0, WEST, exact(WEST)), (0.0, POINT, beside)])
    assert (together(tree) is not None) == meets


def test_a_bearing_alone_is_never_worth_more_than_a_false_alarm():
    quiet = radar("quiet", Kind.BEARING, clutter_density=1e-9, position=(-2000.0, 0.0))
    tree = grown([(0.0, quiet, [0.3])])
    assert tree.nodes.is_line[0] == 1
    assert tree.nodes.cost[0] >= 1.0
    assert tree.totals()[0] >= 1.0
