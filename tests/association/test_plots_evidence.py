"""Tests of the evidence against sums over a fine grid of places, for every kind of plot."""

import math
from dataclasses import replace

import numpy as np
import pytest

from oracles import plots as oracle
from trackweave.association.plots_rule import PlotsRule, SensorPlots
from trackweave.models.coverage import FieldOfView

DENSITY = 2e-7
POINT = np.array([400.0, -300.0])


def camera(place, drift=0.0, sigma=0.004, off=0.0):
    away = POINT - place
    value = [math.atan2(*away) + off * sigma]
    return SensorPlots(value, sigma, place=place, clutter_density=0.4, drift=drift)


def radar(off, covariance, **changes):
    return SensorPlots(
        (POINT + off)[None],
        covariance=np.asarray(covariance)[None],
        clutter_density=2e-6,
        **changes,
    )


ROUND, SLANTED = np.diag([400.0, 900.0]), np.array([[900.0, 500.0], [500.0, 400.0]])
NEAR, FAR = np.array([-3000.0, 500.0]), np.array([900.0, 4000.0])
CASES = {
    "positions": [radar([5.0, 9.0], ROUND), radar([-8.0, 4.0], 2 * ROUND)],
    "correlated": [radar([5.0, 9.0], SLANTED), radar([-8.0, 4.0], ROUND)],
    "positions that drift": [radar([5.0, 9.0], SLANTED, drift=25.0), radar([-8.0, 4.0], ROUND)],
    "bearings": [camera(NEAR, off=0.5), camera(FAR), camera(np.array([3e3, -900.0]), off=-0.7)],
    "bearings that drift": [camera(NEAR, 20.0, off=0.5), camera(FAR, 30.0)],
    "mixed": [radar([5.0, 9.0], SLANTED), camera(NEAR, 15.0, off=1.0), camera(FAR)],
    "a lone plot": [radar([5.0, 9.0], SLANTED)],
    "a lone plot that drifts": [radar([5.0, 9.0], SLANTED, drift=10.0)],
}


def blind(coverage):
    """Return a sensor that saw nothing."""
    return SensorPlots(np.empty((0, 2)), 1.0, clutter_density=1e-6, coverage=coverage)


def integrated(sensors, half=260.0, n_steps=131):
    """Return the evidence's cost, of the first plot of each sensor that has any, by a sum."""
    axis, step = np.linspace(-half, half, n_steps, retstep=True)
    total = 0.0
    for east in POINT[0] + axis:
        for north in POINT[1] + axis:
            total += likelihood(sensors, np.array([east, north]))
    return -math.log(total * DENSITY * step**2)


def likelihood(sensors, at):
    ratio = 1.0
    for sensor in sensors:
        detection = sensor.detection_probability
        if not len(sensor.value):
            sees = sensor.coverage is None or oracle.covers(sensor.coverage, at)
            ratio *= 1.0 - detection * sees
            continue
        noise = oracle.noise(sensor, 0, at)
        off = oracle.aside(sensor, 0, at)
        root = math.sqrt(np.linalg.det(2.0 * math.pi * noise))
        ratio *= detection / sensor.clutter_density / root
        ratio *= math.exp(-0.5 * off @ np.linalg.inv(noise) @ off)
    return ratio


def priced(sensors):
    scored = PlotsRule(DENSITY, lone_plots=True)(sensors)
    seen = [int(len(sensor.value) > 0) for sensor in sensors]
    return scored.costs[scored.tuples.tolist().index(seen)]


@pytest.mark.parametrize("case", CASES)
def test_the_evidence_is_the_integral_over_all_places(case):
    sensors = CASES[case]
    within = 0.03 if any(sensor.is_bearing for sensor in sensors) else 1e-3
    assert priced(sensors) == pytest.approx(integrated(sensors), abs=within)


@pytest.mark.parametrize(("reach", "is_seen"), [(200.0, True), (200.0, False)])
def test_a_place_that_one_sensor_covers_may_hold_an_object_that_one_saw(reach, is_seen):
    centre = POINT if is_seen else POINT + 3000.0
    elsewhere = blind(FieldOfView(tuple(centre), max_range=reach))
    lone = radar([5.0, 9.0], SLANTED)
    sensors = [lone, elsewhere]
    assert priced(sensors) == pytest.approx(integrated(sensors), abs=1e-3)
    # An object is worth ln(P_D · density of objects / density of false alarms), and a miss.
    want = -math.log(0.9 * DENSITY / 2e-6) - (math.log(0.1) if is_seen else 0.0)
    assert priced(sensors) == pytest.approx(want, abs=1e-6)
    richer = PlotsRule(1e-5, lone_plots=True, negative_only=True)
    assert len(richer(sensors)) == (0 if is_seen else 1)


@pytest.mark.parametrize("aside", [-40.0, -15.0, 0.0, 15.0, 40.0])
def test_at_the_edge_of_a_coverage_the_evidence_is_right_within_the_five_points(aside):
    # A wide disk: its edge passes the plot like a straight line.
    edge = FieldOfView((float(POINT[0] + aside - 9000.0), float(POINT[1])), max_range=9000.0)
    sensors = [radar([0.0, 0.0], ROUND), replace(blind(edge), detection_probability=0.6)]
    assert priced(sensors) == pytest.approx(integrated(sensors), abs=0.2)
