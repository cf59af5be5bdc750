"""Tests of scenario files."""

import re
from pathlib import Path

import pytest

from trackweave.errors import InvalidInputError
from trackweave.simulation.scenario import Area, RandomTargets, Scenario, SimulatedSensor
from trackweave.simulation.scenario_file import read_scenario
from trackweave.simulation.targets import Crossing, Manoeuvre, Parallel, Target

LEAST = """
duration = 10
[area]
low = [0, 0]
high = [100, 100]
[[sensors]]
name = "radar"
sigma = 5
scan_period = 1
"""
FULL = """
seed = 7
duration = 60.0
process_noise = 0.05
[area]
low = [0, 0]
high = [1000, 800]
margin = 50
[[sensors]]
name = "north"
sigma = [8, 9]
scan_period = 2.0
detection_probability = 0.8
clutter_per_scan = 4
start_offset = 0.5
position = [500, 900]
max_range = inf
[[sensors]]
name = "south"
sigma = 5.0
scan_period = 1.0
[[targets]]
name = "tug"
position = [10, 20]
velocity = [3, 4]
start = 1
end = 50
at = 2
[[targets.manoeuvres]]
start = 10
duration = 5
turn_rate_deg_s = -3
[[targets.manoeuvres]]
start = 20
duration = 5
acceleration = [0.1, 0]
[[crossings]]
point = [500, 400]
time = 30
speed = 10
count = 3
[[parallels]]
position = [100, 100]
velocity = [5, 0]
spacing = 40
[random]
count = 4
speed = [2, 9]
birth_rate = 0.1
survival = 0.99
stay_inside = false
"""


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "scene.toml"


def test_reads_every_key(file: Path) -> None:
    file.write_text(FULL)
    assert read_scenario(file) == Scenario(
        Area((0, 0), (1000, 800), 50),
        60.0,
        (
            SimulatedSensor("north", (8, 9), 2.0, 0.8, 4, 0.5, (500, 900)),
            SimulatedSensor("south", 5.0, 1.0),
        ),
        (
            Target(
                (10, 20),
                (3, 4),
                1,
                50,
                2,
                (Manoeuvre(10, 5, -3.0), Manoeuvre(20, 5, None, (0.1, 0.0))),
                "tug",
            ),
        ),
        (Crossing((500, 400), 30, 10, 3),),
        (Parallel((100, 100), (5, 0), 40),),
        RandomTargets(4, (2, 9), 0.1, 0.99, False),
        0.05,
        7,
    )


def test_reads_the_least_that_there_can_be(file: Path) -> None:
    file.write_text(LEAST)
    assert read_scenario(str(file)).sensors == (SimulatedSensor("radar", 5.0, 1.0),)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (LEAST.replace("duration = 10", ""), "duration: missing; expected a value"),
        (LEAST.replace("sigma = 5", ""), "sensors[0].sigma: missing; expected a value"),
        (
            LEAST.replace("sigma = 5", "sigma = -5"),
            "sensors[0].sigma: -5; expected a number above",
        ),
        (LEAST.replace("sigma = 5", "sigma = true"), "sensors[0].sigma: True; expected a number"),
        (LEAST.replace("sigma = 5", 'sigma = "5"'), "sensors[0].sigma: '5'; expected a number"),
        (LEAST.replace("sigma = 5", "sigma = 5\nnoise = 1"), "sensors[0].noise: 1; expected one"),
        (
            LEAST.replace("high = [100, 100]", "high = 100"),
            "area.high: 100; expected two or three",
        ),
        (LEAST.replace("[[sensors]]", "[sensors]"), "expected tables [[sensors]]"),
        (
            LEAST + "[colour]\nred = 1",
            "colour: {'red': 1}; expected one of the keys area, duration",
        ),
        (LEAST + "[[random]]\ncount = 1", "random: [{'count': 1}]; expected a table"),
        (LEAST + "[random]\ncount = 1.5\nspeed = [1, 2]", "random.count: 1.5; expected a whole"),
        (LEAST + "[[sensors]]\nname = 'radar'\nsigma = 1\nscan_period = 1", "comes twice"),
        (
            FULL.replace("turn_rate_deg_s = -3", "turn_rate_deg_s = nan"),
            "targets[0].manoeuvres[0].turn_rate_deg_s: nan; expected a number",
        ),
        (FULL.replace("duration = 5\nacc", "acc"), "targets[0].manoeuvres[1].duration: missing"),
        ("duration = = 1", "expected TOML"),
        ("duration = 1\nduration = 2", "expected TOML"),
        ("", "area: missing; expected a value"),
    ],
)
def test_names_file_key_value_and_what_was_expected(file: Path, text: str, words: str) -> None:
    file.write_text(text)
    with pytest.raises(InvalidInputError, match=re.escape(words)) as caught:
        read_scenario(file)
    assert str(caught.value).startswith(str(file))
    assert "\n" not in str(caught.value)


def test_names_a_file_that_is_not_there_or_no_text(file: Path, tmp_path: Path) -> None:
    with pytest.raises(InvalidInputError, match=r"scene.toml: no such file"):
        read_scenario(file)
    with pytest.raises(InvalidInputError, match="a directory"):
        read_scenario(tmp_path)
    file.write_bytes(b"seed = 1 # \xff\xfe")
    with pytest.raises(InvalidInputError, match="byte 11: not UTF-8"):
        read_scenario(file)


def test_the_reference_pages_example_is_a_scenario(file: Path) -> None:
    page = Path(__file__).resolve().parents[2] / "docs" / "reference" / "scenario.md"
    blocks = re.findall(r"```toml\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL)
    assert blocks
    for block in blocks:
        file.write_text(block, encoding="utf-8")
        assert read_scenario(file).duration > 0
