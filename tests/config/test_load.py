"""A configuration is checked key by key, and refused in one clear line."""

import tomllib
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from trackweave.config import Configuration, load_configuration
from trackweave.errors import InvalidInputError

FULL = """
seed = 1
[motion]
model = "constant-velocity"
filter = "unscented"
process_noise = 0.05
turn_noise = 0.01
max_speed = 30.0
max_acceleration = 5.0
max_turn_rate = 0.3
[motion.imm]
models = ["constant-velocity", "coordinated-turn", "sprint"]
sojourn_time = [60, 10, 10.5]
[motion.imm.constant-velocity]
process_noise = 0.01
[motion.imm.sprint]
model = "constant-acceleration"
max_acceleration = 4.0
[sensors.default]
measurement = "position"
sigma = 10.0
detection_probability = 0.9
clutter_density = 6.9e-5
scan_period = 1
position = [0.0, 0.0]
rotation = "clockwise"
strength = {target_mean = 20.0, target_sigma = 5.0, clutter_mean = 12.0, clutter_sigma = 4.0}
identity_error = 0.02
trust = ["sigma"]
[sensors.radar]
measurement = "range-azimuth-rate"
sigma = {range_m = 70.0, azimuth_deg = 0.08, range_rate_mps = 2.0}
[sensors.camera]
sigma = {bearing_deg = 1.0}
[sensors.3]
sigma = {x = 10.0, y = 12.0}
clutter_per_scan = 100
field_of_view = {min_range_m = 0, max_range_m = 90000, azimuth_deg = [0, 360]}
[sensors.north]
field_of_view = {polygon = [[0, 0], [9, 0], [0, 9]]}
[window]
depth = 5
max_scans = 15
[search]
deadline_ms = 200
[lifecycle]
confirm = "3/4"
delete_after_misses = 5
new_target_density = 1e-6
survival = 0.999
certain_probability = 0.99
[output]
period = 4.0
estimate = "best"
[growth]
margin = 25.0
keep = 500
max_nodes = 2000000
[frame]
origin = [47.1, 8.5]
projection = "stereographic"
"""


def message(text: str, tmp_path: Path) -> str:
    file = tmp_path / "tracker.toml"
    file.write_text(text)
    with pytest.raises(InvalidInputError) as caught:
        load_configuration(file)
    return str(caught.value).removeprefix(f"{tmp_path}/")


@pytest.mark.parametrize(
    ("sigma", "said"),
    [
        ("{x = 3}", "sigma: {x = 3}; expected a number > 0 in metres, or one for each column"),
        ("{}", "sigma: {}; expected a number > 0 in metres, or one for each column"),
        ("{range_m = 3}", "sigma: {range_m = 3}; expected a number > 0 in metres, or one for"),
        ("{x = 3, range_m = 3}", "sigma: {x = 3, range_m = 3}; expected a number > 0 in metres"),
        ("{bearing = 3}", "sigma.bearing: unknown key; did you mean bearing_deg?"),
        ("{bearing_deg = 300}", "sigma.bearing_deg: 300; expected a number > 0 of degrees"),
    ],
)
def test_half_a_sigma_table_is_an_error_of_its_key(sigma: str, said: str, tmp_path: Path) -> None:
    text = message(f"[sensors.default]\nsigma = {sigma}\n", tmp_path)
    assert text.startswith(f"tracker.toml, sensors.default.{said}")


@pytest.mark.parametrize(
    ("key", "meant"),
    [
        ("divide", "lifecycle.divide"),
        ("sigma", "sensors.NAME.sigma"),
        ("process_noise", "motion.process_noise or fusion.process_noise"),
        ("seeed", "seed"),
    ],
)
def test_a_key_that_stands_in_a_table_is_told_where(key: str, meant: str) -> None:
    with pytest.raises(InvalidInputError, match=f"{key}: unknown key; did you mean {meant}\\?$"):
        load_configuration({key: 1})


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[motion]\nprocess_noise = 1e300", "expected a number ≥ 0 in m²/s³, at most 1e+30"),
        ("[window]\ndepth = 201", "expected a whole number from 1 to 200"),
        ("[motion]\nprocess_noise = -1.0", "expected a number ≥ 0 in m²/s³"),
    ],
)
def test_a_value_too_large_is_told_the_limit(text: str, said: str, tmp_path: Path) -> None:
    assert message(text, tmp_path).endswith(said)


def test_takes_every_key_of_the_format(tmp_path: Path) -> None:
    file = tmp_path / "tracker.toml"
    file.write_text(FULL)
    assert load_configuration(file).values == tomllib.loads(FULL)


def test_keys_left_out_are_none() -> None:
    configuration = load_configuration({"motion": {"max_speed": 3.0}})
    assert configuration.said("motion", "process_noise") is None
    assert configuration.values == {"motion": {"max_speed": 3.0}}


def test_none_is_as_good_as_left_out_where_there_is_such_a_key(tmp_path: Path) -> None:
    assert load_configuration({"seed": None, "motion": {"model": None}}).values == {"motion": {}}
    with pytest.raises(InvalidInputError, match=r"motion\.modle: unknown key; did you mean model"):
        load_configuration({"motion": {"modle": None}})


def test_values_of_numpy_are_as_pythons() -> None:
    told = {
        "seed": np.int64(3),
        "motion": {"max_speed": np.float32(20.0), "process_noise": np.float64(0.5)},
        "lifecycle": {"join": np.bool_(False)},
        "sensors": {"a": {"position": np.array([1.0, 2.0])}},
    }
    found = load_configuration(told)
    assert found.said("seed") == 3
    assert type(found.said("motion", "max_speed")) is float
    assert found.said("lifecycle", "join") is False
    assert found.sensor("a")["position"] == [1.0, 2.0]
    with pytest.raises(InvalidInputError, match=r"motion\.max_speed: -1; expected"):
        load_configuration({"motion": {"max_speed": np.int64(-1)}})


def test_nothing_given_is_an_empty_configuration() -> None:
    assert load_configuration(None).values == {}


def test_a_configuration_is_taken_as_it_is() -> None:
    configuration = Configuration()
    assert load_configuration(configuration) is configuration


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("[sensors.default]\nsigma = -3", "sensors.default.sigma: -3; expected a number > 0"),
        ("[sensors.A]\nsigma = {x = -1.0, y = 2.0}", "sensors.A.sigma.x: -1.0; expected a number"),
        ("[sensors.A]\nsigma = nan", "sensors.A.sigma: nan; expected a number > 0"),
        ("[sensors.A]\nsigma = true", "sensors.A.sigma: true; expected a number > 0"),
        ('[sensors.A]\nsigma = "10"', 'sensors.A.sigma: "10"; expected a number > 0'),
        ("[sensors.A]\nsgima = 2.0", "sensors.A.sgima: unknown key; did you mean sigma?"),
        ("zap = 1", "zap: unknown key; expected one of frame, fusion, growth"),
        ("sensors = [1]", "sensors: [1]; expected tables such as [sensors.default]"),
        ("sensors.A = 3", "sensors.A: 3; expected a table of keys"),
        ("motion = 3", "motion: 3; expected a table of keys"),
        ("seed = 1.5", "seed: 1.5; expected a whole number ≥ 0"),
        ("seed = -1", "seed: -1; expected a whole number ≥ 0"),
        ('[motion]\nmodel = "zap"', 'motion.model: "zap"; expected one of "constant-velocity"'),
        ('[motion]\nfilter = "zap"', 'motion.filter: "zap"; expected "extended" or "unscented"'),
        ("[motion]\nmax_turn_rate = 0", "motion.max_turn_rate: 0; expected a number > 0 in rad/s"),
        ("motion.imm = 3", "motion.imm: 3; expected a table of keys"),
        ('[motion.imm]\nmodels = ["random-walk"]', 'models: ["random-walk"]; expected two to'),
        (
            '[motion.imm]\nmodels = ["random-walk", "zap"]',
            'expected "zap" to be a model, or a table whose key model says one',
        ),
        (
            '[motion.imm]\nmodels = ["random-walk", "random-walk"]',
            "expected each name once; a table with a key model gives another name",
        ),
        ("[motion.imm]\nsojourn_time = [60, -1]", "sojourn_time: [60, -1]; expected a number > 0"),
        ("[motion.imm.zap]\nmax_speed = 1", 'expected "zap" to be a model, or a table whose key'),
        (
            "[motion.imm.random-walk]\nmax_speed = -1",
            "motion.imm.random-walk.max_speed: -1; expected a number > 0 in m/s",
        ),
        (
            "[motion.imm.random-walk]\nspeed = 1",
            "motion.imm.random-walk.speed: unknown key; did you mean max_speed?",
        ),
        (
            '[motion.imm.cruise]\nmodel = "imm"',
            'motion.imm.cruise.model: "imm"; expected one of "constant-velocity"',
        ),
        ('[sensors.A]\nmeasurement = "zap"', 'measurement: "zap"; expected one of "position"'),
        ('[sensors.A]\nmeasurement = "range-rate"', 'measurement: "range-rate"; expected one of'),
        ('[sensors.A]\nrotation = "left"', 'rotation: "left"; expected "clockwise", "counter'),
        (
            "[sensors.A]\nstrength = {target_mean = 1, target_sigma = 2}",
            "sensors.A.strength: {target_mean = 1, target_sigma = 2}; expected at least "
            "target_mean, target_sigma, clutter_mean, clutter_sigma",
        ),
        (
            "[sensors.A]\nstrength = {target_mean = 1, target_sigma = -2, clutter_mean = 0, "
            "clutter_sigma = 1}",
            "sensors.A.strength.target_sigma: -2; expected a number > 0",
        ),
        (
            '[sensors.A]\ntrust = "sigma"',
            'sensors.A.trust: "sigma"; expected true, false, or a li',
        ),
        ('[sensors.A]\ntrust = ["colour"]', 'or a list of keys: "sigma"'),
        ("[sensors.A]\nidentity_error = 1.0", "identity_error: 1.0; expected a number between"),
        ('[frame]\nprojection = "zap"', 'projection: "zap"; expected "tangent" or "stereo'),
        ("[sensors.A]\nposition = [1, 2, 'x']", 'sensors.A.position: [1, 2, "x"]; expected two'),
        ('[lifecycle]\nconfirm = "4/3"', 'lifecycle.confirm: "4/3"; expected text of the form'),
        ('[lifecycle]\nconfirm = "all"', 'lifecycle.confirm: "all"; expected text of the form'),
        ("[lifecycle]\nsurvival = 1.0", "lifecycle.survival: 1.0; expected a number between"),
        ("[window]\ndepth = 0", "window.depth: 0; expected a whole number from 1 to 200"),
        ("[frame]\norigin = [91.0, 0.0]", "frame.origin: [91.0, 0.0]; expected [latitude"),
        (
            "[sensors.A]\nclutter_density = 1.0\nclutter_per_scan = 2.0",
            "expected clutter_density or clutter_per_scan, not both",
        ),
        (
            "[sensors.A]\nfield_of_view = {min_range_m = 9, max_range_m = 8}",
            "expected min_range_m below max_range_m",
        ),
    ],
)
def test_refuses_a_wrong_value_by_name(text: str, expected: str, tmp_path: Path) -> None:
    said = message(text, tmp_path)
    assert said.startswith("tracker.toml, ")
    assert expected in said
    assert "\n" not in said


def test_says_how_many_more_keys_are_wrong(tmp_path: Path) -> None:
    said = message("seed = -1\n[window]\ndepth = 0\nmax_scans = 0", tmp_path)
    assert said == "tracker.toml, seed: -1; expected a whole number ≥ 0 (and 2 more)"


def test_names_the_place_of_a_syntax_error(tmp_path: Path) -> None:
    assert message("[motion\n", tmp_path).startswith("tracker.toml, line 1, column 8: ")


def test_refuses_a_file_that_is_not_text(tmp_path: Path) -> None:
    file = tmp_path / "tracker.toml"
    file.write_bytes(b"seed = 1 # \xff")
    with pytest.raises(InvalidInputError, match="byte 11: not UTF-8"):
        load_configuration(file)


@pytest.mark.parametrize(("name", "said"), [("none.toml", "no such file"), (".", "directory")])
def test_refuses_what_cannot_be_read(name: str, said: str, tmp_path: Path) -> None:
    with pytest.raises(InvalidInputError, match=f"(?i){said}"):
        load_configuration(tmp_path / name)


values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: (
        st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3)
    ),
    max_leaves=5,
)
sections = st.sampled_from(["motion", "sensors", "window", "lifecycle", "output", "frame", "seed"])
keys = st.sampled_from(
    ["sigma", "default", "depth", "model", "confirm", "origin", "position", "x"]
)


@pytest.mark.slow
@given(
    st.dictionaries(
        sections | st.text(max_size=5),
        values
        | st.dictionaries(keys, values | st.dictionaries(keys, values, max_size=3), max_size=3),
        max_size=4,
    )
)
def test_any_mapping_is_taken_or_refused_in_one_line(mapping: dict[str, object]) -> None:
    try:
        taken = load_configuration(mapping)
    except InvalidInputError as err:
        assert str(err).startswith("configuration")
        assert "; " in str(err)
    else:
        assert isinstance(taken, Configuration)
