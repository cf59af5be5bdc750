"""A written configuration says what every value is, and reads back as the same."""

import tomllib
from dataclasses import replace

import pytest

from config.test_fill import ESTIMATES, filled
from trackweave.config import load_configuration
from trackweave.config.fill import Settings, fill
from trackweave.config.write import WIDTH, commented_toml
from trackweave.models.strength import StrengthModel
from trackweave.solvers import Auto


def read_back(text: str, names: tuple[str, ...]) -> Settings:
    return fill(load_configuration(tomllib.loads(text)), ESTIMATES, names)


def test_reads_back_as_the_same_settings() -> None:
    settings = filled({})
    again = read_back(commented_toml(settings), ("A", "B"))
    assert again.sensors == settings.sensors
    assert again.motion == settings.motion
    assert again.window == settings.window
    assert again.lifecycle == settings.lifecycle
    assert again.growth == settings.growth
    assert again.estimate == settings.estimate


def test_an_estimated_strength_is_written_and_reads_back() -> None:
    model = StrengthModel(9.0, 3.5, 1.0, 2.5)
    sensors = {name: replace(found, strength=model) for name, found in ESTIMATES.sensors.items()}
    settings = fill(load_configuration(None), replace(ESTIMATES, sensors=sensors), ("A", "B"))
    assert settings.sources["sensors.A.strength"] == "estimated"
    text = commented_toml(settings)
    assert "# estimated\n[sensors.default.strength]" in text
    assert "target_mean = 9.0" in text
    assert read_back(text, ("A", "B")).sensors == settings.sensors


@pytest.mark.parametrize(
    "values",
    [
        {"sensors": {"A": {"sigma": 3.0}}},
        {"sensors": {"A": {"sigma": {"x": 3.0, "y": 4.0}}, "B": {"position": [1.0, 2.0]}}},
        {"sensors": {"default": {"field_of_view": {"polygon": [[0.0, 0.0], [9, 0], [0, 9]]}}}},
        {"sensors": {"B": {"field_of_view": {"max_range_m": 10.0, "azimuth_deg": [10, 90]}}}},
        {"search": {"method": "genetic", "population": 12}, "output": {"period": 2.5}},
        {"lifecycle": {"confirm": "2/3", "survival": 0.99999999999}},
    ],
)
def test_reads_back_what_a_file_said(values: dict[str, object]) -> None:
    settings = filled(values)
    again = read_back(commented_toml(settings), ("A", "B"))
    assert again.sensors == settings.sensors
    assert again.lifecycle == settings.lifecycle
    assert (again.search or Auto()) == (settings.search or Auto())
    assert again.period == settings.period


def test_a_clutter_per_scan_stays_one() -> None:
    view = {"max_range_m": 100.0}
    text = commented_toml(
        filled({"sensors": {"A": {"clutter_per_scan": 3.0, "field_of_view": view}}})
    )
    values = tomllib.loads(text)["sensors"]
    assert values["A"]["clutter_per_scan"] == 3.0
    assert "clutter_density" not in values["A"]


def test_says_once_what_all_sensors_share() -> None:
    values = tomllib.loads(commented_toml(filled({"sensors": {"B": {"sigma": 3.5}}})))["sensors"]
    assert values["default"]["detection_probability"] == 0.8
    assert values["A"] == {"sigma": 7.0}
    assert values["B"] == {"sigma": 3.5}


def test_says_of_each_value_where_it_came_from_and_how_sure_it_is() -> None:
    text = commented_toml(
        filled({"motion": {"max_speed": 5.0}}),
        remarks={"sensors.A.sigma": "± 10 %", "motion.process_noise": "from 12 tracks"},
        doubts={"B": "a crowd"},
    )
    lines = {line.split(" = ")[0]: line for line in text.splitlines() if " = " in line}
    assert lines["process_noise"].endswith("# estimated: from 12 tracks")
    assert lines["max_speed"].endswith("# file")
    assert lines["depth"].endswith("# default")
    assert "m²/s³" in text
    assert "# In doubt: a crowd.\n[sensors.B]" in text


@pytest.mark.parametrize("name", ["radar north", 'a "b"', "a.b", "ø", "\x7f\t\\", "default", "]"])
def test_takes_any_name_of_a_sensor(name: str) -> None:
    known = replace(ESTIMATES, sensors={**ESTIMATES.sensors, name: ESTIMATES.sensors["A"]})
    given = load_configuration({"sensors": {name: {"sigma": 3.0}}})
    settings = fill(given, known, ("A", name))
    values = tomllib.loads(commented_toml(settings, doubts={name: f"odd {name}"}))["sensors"]
    assert values[name]["sigma"] == 3.0


def test_no_comment_ends_a_line_early() -> None:
    text = commented_toml(filled({}), head=["a\nb = 3", "word " * 60])
    assert "# a b = 3\n" in text
    assert max(len(line) for line in text.splitlines() if line.startswith("#")) <= WIDTH
    assert "b" not in tomllib.loads(text)
