"""Tests of scenarios."""

from typing import Any

import numpy as np
import pytest

from trackweave.errors import InvalidInputError
from trackweave.simulation.scenario import Area, RandomTargets, Scenario, SimulatedSensor
from trackweave.simulation.targets import Crossing, Parallel, Target

SENSOR = SimulatedSensor("radar", 10.0, 1.0)
AREA = Area((0, 0), (100, 100))


def scenario(**changes: Any) -> Scenario:
    return Scenario(**{"area": AREA, "duration": 10.0, "sensors": (SENSOR,)} | changes)


def test_numbers_targets_that_have_no_name() -> None:
    named = Target((0, 0), (1, 0), name="tug")
    found = scenario(
        targets=(named, Target((1, 1), (1, 0))),
        crossings=(Crossing((50, 50), 5.0, 5.0),),
        parallels=(Parallel((5, 5), (1, 0), 10.0),),
    ).explicit_targets()
    assert [target.name for target in found] == ["tug", "2", "3", "4", "5", "6"]


def test_one_sigma_serves_every_axis() -> None:
    assert SENSOR.sigmas(3) == (10.0, 10.0, 10.0)
    assert SimulatedSensor("r", (1, 2), 1.0).sigmas(2) == (1.0, 2.0)


def test_takes_numpy_numbers_and_arrays() -> None:
    area = Area(np.zeros(2), np.array([5, 6]))
    assert area.high == (5.0, 6.0)
    assert RandomTargets(np.int64(3), (np.float64(1), 2)).count == 3


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"duration": 0.0}, "duration: 0.0; expected a number above 0"),
        ({"duration": "long"}, "duration: 'long'"),
        ({"duration": True}, "duration: True"),
        ({"process_noise": -1.0}, "process_noise: -1.0; expected a number of at least 0"),
        ({"seed": -1}, "seed: -1; expected a whole number of at least 0"),
        ({"seed": 1.5}, "seed: 1.5"),
        ({"sensors": ()}, "sensors: none; expected at least one"),
        ({"sensors": (SENSOR, SENSOR)}, r"sensors\[1\].name: 'radar' comes twice"),
        (
            {"sensors": (SimulatedSensor("r", (1, 1, 1), 1.0),)},
            r"sensors\[0\].sigma: .* 2 numbers",
        ),
        ({"sensors": (SimulatedSensor("r", 1.0, 1e-9),)}, "scans in 10 s; expected at most"),
        ({"targets": (Target((0, 0, 0), (1, 0, 0)),)}, r"targets\[0\]: 3 dimensions; expected 2"),
        ({"targets": (Target((0, 0), (1, 0), start=11.0),)}, r"targets\[0\].start: 11"),
        (
            {"targets": (Target((0, 0), (1, 0), name="2"), Target((0, 0), (1, 0)))},
            r"targets\[1\].name: '2' comes twice",
        ),
        ({"random": RandomTargets(1, (1, 2), birth_rate=1e9)}, "random.birth_rate"),
        (
            {"sensors": (SimulatedSensor("r", 1.0, 1e-3, clutter_per_scan=1e5),)},
            r"1e\+09 false alarms; expected at most 1e\+07 reports",
        ),
    ],
)
def test_refuses_a_scenario_that_cannot_be(change: dict[str, Any], words: str) -> None:
    with pytest.raises(InvalidInputError, match=words):
        scenario(**change)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Area((0, 0), (0, 1)), "high: .* expected numbers above low"),
        (lambda: Area((0, 0), (1, 1, 1)), "high"),
        (lambda: Area((0, 0), (1, 1), margin=-1), "margin: -1"),
        (lambda: SimulatedSensor("", 1.0, 1.0), "name: ''"),
        (lambda: SimulatedSensor(3, 1.0, 1.0), "name: 3"),
        (lambda: SimulatedSensor("r", 0.0, 1.0), "sigma: 0.0"),
        (
            lambda: SimulatedSensor("r", (1.0, -1.0), 1.0),
            "sigma: .1.0, -1.0.; expected",
        ),
        (lambda: SimulatedSensor("r", "1", 1.0), "sigma: '1'"),
        (lambda: SimulatedSensor("r", 1.0, 0.0), "scan_period: 0.0"),
        (lambda: SimulatedSensor("r", 1.0, 1.0, 1.5), "detection_probability: 1.5; expected"),
        (lambda: SimulatedSensor("r", 1.0, 1.0, 0.9, -2), "clutter_per_scan: -2"),
        (lambda: SimulatedSensor("r", 1.0, 1.0, start_offset=-1), "start_offset: -1"),
        (lambda: SimulatedSensor("r", 1.0, 1.0, position=(1,)), "position"),
        (lambda: SimulatedSensor("r", 1.0, 1.0, max_range=0), "max_range: 0"),
        (lambda: RandomTargets(-1, (1, 2)), "count: -1"),
        (
            lambda: RandomTargets(10**9, (1, 2)),
            "count: 1000000000; .* to 100000",
        ),
        (lambda: RandomTargets(1, (2, 1)), "speed"),
        (lambda: RandomTargets(1, (1, 2), survival=0.0), "survival: 0.0"),
        (lambda: RandomTargets(1, (1, 2), stay_inside="yes"), "stay_inside: 'yes'"),
    ],
)
def test_refuses_a_part_that_cannot_be(make: object, words: str) -> None:
    assert callable(make)
    with pytest.raises(InvalidInputError, match=words):
        make()
