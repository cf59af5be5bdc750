"""Gaps are filled in order of precedence, and each value tells where it came from."""

import math
from dataclasses import replace

import numpy as np
import pytest

from trackweave.config import load_configuration
from trackweave.config.fill import Settings, fill, known_sigma, needs_estimates
from trackweave.config.presets import FUSION_PRESETS, PRESETS, preset_notes
from trackweave.config.sensing import ObservedSensor
from trackweave.domain.measurements import MeasurementKind as Kind
from trackweave.errors import InvalidInputError
from trackweave.estimation.estimates import Estimates, SensorEstimate
from trackweave.models.motion import (
    ConstantAcceleration,
    ConstantVelocity,
    CoordinatedTurn,
    Imm,
    Motion,
    RandomWalk,
)
from trackweave.models.rotation import Rotation
from trackweave.models.strength import StrengthModel
from trackweave.solvers import Dual, Genetic, Islands

ESTIMATES = Estimates(
    sensors={
        name: SensorEstimate(
            scan_period=2.0,
            sigma=7.0,
            detection_probability=0.8,
            clutter_density=1e-5,
            covered=1e6,
            n_objects=3.0,
        )
        for name in ("A", "B")
    },
    process_noise=0.5,
    max_speed=25.0,
    new_target_density=1e-7,
    initial_target_density=3e-6,
)


def filled(values: dict[str, object], preset: str | None = None) -> Settings:
    return fill(load_configuration(values), ESTIMATES, ("A", "B"), preset=preset)


def test_a_sensor_of_which_no_report_is_may_be_another_by_name() -> None:
    settings = filled({"sensors": {"a": {"sigma": 1.0}}})
    assert settings.notes[0].endswith("no report is of a sensor a; did you mean A?")


def test_an_empty_configuration_is_estimated_and_usual() -> None:
    settings = filled({})
    assert settings.motion.max_speed == 25.0
    assert [sensor.sigma for sensor in settings.sensors] == [7.0, 7.0]
    assert settings.lifecycle.new_target_density == 1e-7
    assert settings.search is None
    assert settings.notes == ()
    assert settings.sources["sensors.A.sigma"] == "estimated"
    assert settings.sources["window.depth"] == "default"


def test_a_sensors_own_table_comes_before_that_for_every_sensor() -> None:
    settings = filled(
        {"sensors": {"default": {"sigma": 1.0}, "B": {"sigma": {"x": 2.0, "y": 3.0}}}}
    )
    assert [sensor.sigma for sensor in settings.sensors] == [1.0, (2.0, 3.0)]
    assert settings.sources["sensors.A.sigma"] == "file"


def test_says_that_an_estimate_in_use_is_doubtful() -> None:
    doubtful = replace(ESTIMATES, doubts={"A": "a crowd"})
    some = {
        "sensors": {"default": {"sigma": 5.0}},
        "motion": {"max_speed": 20.0, "process_noise": 0.1},
    }
    notes = fill(load_configuration(some), doubtful, ("A", "B")).notes
    assert notes == ("sensor A: a crowd; better give sensors.A.detection_probability",)
    some["sensors"]["default"]["detection_probability"] = 0.9
    assert fill(load_configuration(some), doubtful, ("A", "B")).notes == ()


def test_says_that_the_patents_preset_takes_lone_reports_for_tracks() -> None:
    said = " ".join(filled({}, preset="hillis-1997").notes)
    assert "each lone report counts as a track of one report" in said


def test_a_preset_to_the_letter_says_which_one_is_made_for_use() -> None:
    words = "preset hillis-1997 keeps to its document's letter; --preset hillis is made for use"
    assert words in filled({}, preset="hillis-1997").notes
    assert filled({}, preset="hillis").notes == ()
    named = [preset_notes(name) for name in (*PRESETS, *FUSION_PRESETS)]
    for note in filter(None, named):
        assert note[0].split("--preset ")[1].split()[0] in {*PRESETS, *FUSION_PRESETS}


def test_islands_are_one_key_beside_a_preset() -> None:
    for preset in ("hillis-1997", "hillis"):
        search = filled({"search": {"islands": 4}}, preset=preset).search
        assert search == Islands((filled({}, preset=preset).search,), 4, own_limits=True)


def test_a_preset_fills_what_the_file_leaves_out() -> None:
    settings = filled({"window": {"depth": 3}}, preset="hillis-1997")
    assert settings.window.depth == 3
    assert settings.sources["window.depth"] == "file"
    assert settings.sources["search.population"] == "preset"
    assert isinstance(settings.search, Genetic)


def test_says_where_the_file_and_the_preset_differ() -> None:
    said = {"plots": {"fuse": False}, "tracker": {"pairing": "nearest"}}
    notes = filled(said, preset="wiranto-2018").notes
    differ = [note for note in notes if note.startswith("preset wiranto-2018:")]
    assert differ == ["preset wiranto-2018: the configuration says otherwise of plots.fuse"]


def test_says_that_plots_are_not_fused_unless_asked_for() -> None:
    words = "plots: without fuse = true nothing follows from within"
    assert words in filled({"plots": {"within": 2.0}}).notes
    assert words not in filled({"plots": {"within": 2.0, "fuse": True}}).notes
    assert words not in filled({"plots": {"within": 2.0}}, preset="wiranto-2018").notes


def test_another_method_than_the_presets_takes_none_of_its_options() -> None:
    settings = filled({"search": {"method": "dual"}}, preset="hillis-1997")
    assert isinstance(settings.search, Dual)
    assert "search.population" not in settings.sources


def test_an_unknown_preset_is_refused_with_a_hint() -> None:
    with pytest.raises(InvalidInputError, match="did you mean hillis-1997"):
        filled({}, preset="hilis-1997")


def test_clutter_per_scan_is_spread_over_the_hull_of_the_reports() -> None:
    settings = filled({"sensors": {"A": {"clutter_per_scan": 20.0}}})
    assert [sensor.clutter_density for sensor in settings.sensors] == pytest.approx([2e-5, 1e-5])


@pytest.mark.parametrize(
    ("view", "area"),
    [
        ({"max_range_m": 100.0}, math.pi * 1e4),
        (
            {"min_range_m": 50.0, "max_range_m": 100.0, "azimuth_deg": [350, 80]},
            math.pi * 7500 / 4,
        ),
        ({"polygon": [[0, 0], [10, 0], [10, 20], [0, 20]]}, 200.0),
        ({"min_range_m": 5.0}, 1e6),
    ],
)
def test_clutter_per_scan_is_spread_over_a_bounded_field_of_view(
    view: dict[str, object], area: float
) -> None:
    settings = filled({"sensors": {"A": {"clutter_per_scan": 20.0, "field_of_view": view}}})
    assert settings.sensors[0].clutter_density == pytest.approx(20.0 / area)


def test_a_sensors_own_kind_of_clutter_wins() -> None:
    settings = filled(
        {"sensors": {"default": {"clutter_per_scan": 20.0}, "A": {"clutter_density": 3e-4}}}
    )
    assert settings.sensors[0].clutter_density == 3e-4
    assert settings.sensors[1].clutter_density == pytest.approx(2e-5)


def test_the_field_of_view_stands_at_the_sensors_position() -> None:
    section = {"position": [5.0, 6.0, 7.0], "field_of_view": {"max_range_m": 100.0}}
    view = filled({"sensors": {"A": section}}).sensors[0].field_of_view
    assert view is not None
    assert (view.position, view.max_range) == ((5.0, 6.0), 100.0)


def test_confirmation_is_taken_apart() -> None:
    lifecycle = filled({"lifecycle": {"confirm": "2/5"}}).lifecycle
    assert (lifecycle.confirm_hits, lifecycle.confirm_opportunities) == (2, 5)


def test_the_deadline_becomes_seconds() -> None:
    assert filled({"search": {"deadline_ms": 250}}).deadline == 0.25
    assert filled({}).deadline is None


def test_a_table_for_a_sensor_that_never_reports_is_noted() -> None:
    (note,) = filled({"sensors": {"C": {"sigma": 1.0}}}).notes
    assert "sensors.C" in note


def test_nothing_needs_estimating_where_all_is_given() -> None:
    sensor = {
        "sigma": 1.0,
        "detection_probability": 0.9,
        "clutter_density": 1e-6,
        "scan_period": 1.0,
    }
    whole = {
        "motion": {"process_noise": 0.1, "max_speed": 9.0},
        "sensors": {"default": sensor},
        "lifecycle": {"new_target_density": 1e-6},
    }
    assert not needs_estimates(load_configuration(whole), ("A", "B"))
    for name in sensor:
        less = {**whole, "sensors": {"default": {k: v for k, v in sensor.items() if k != name}}}
        assert needs_estimates(load_configuration(less), ("A", "B"))


def test_known_noise_is_told_to_the_estimate() -> None:
    configuration = load_configuration({"sensors": {"A": {"sigma": {"x": 2.0, "y": 3.0}}}})
    assert known_sigma(configuration, ("A", "B")) == {"A": 3.0}


def test_every_value_is_finite_or_none() -> None:
    found = filled({}).values["sensors"]["A"].values()
    assert all(one is None or isinstance(one, str) or np.all(np.isfinite(one)) for one in found)


def moving(motion: dict[str, object]) -> Motion:
    return filled({"motion": motion}).motion


def test_every_model_of_motion_is_filled() -> None:
    assert moving({"model": "constant-acceleration"}) == ConstantAcceleration(0.25, 25.0, 2.5)
    turn = moving({"model": "coordinated-turn", "max_turn_rate": 0.3})
    assert turn == CoordinatedTurn(0.5, 2 * 0.3**2 / 3 / 10, 25.0, 0.3)
    assert moving({"model": "random-walk", "process_noise": 7.0}) == RandomWalk(7.0, 25.0)


def test_process_noise_in_other_units_is_not_taken_from_the_estimate() -> None:
    settings = filled({"motion": {"model": "random-walk"}})
    assert settings.motion == RandomWalk(25.0**2 * 2.0 / 9, 25.0)
    assert settings.sources["motion.process_noise"] == "default"


def test_an_imm_takes_each_ways_own_table_before_what_all_share() -> None:
    imm = {
        "models": ["cruise", "sprint", "coordinated-turn"],
        "cruise": {"model": "constant-velocity", "process_noise": 0.01},
        "sprint": {"model": "constant-acceleration", "max_speed": 40.0},
        "coordinated-turn": {"max_turn_rate": 0.3, "turn_noise": 0.1},
    }
    settings = filled({"motion": {"model": "imm", "max_acceleration": 2.0, "imm": imm}})
    assert settings.motion == Imm(
        (
            ConstantVelocity(0.01, 25.0),
            ConstantAcceleration(2 * 2.0**2 / 5 / 10, 40.0, 2.0),
            CoordinatedTurn(0.5, 0.1, 25.0, 0.3),
        ),
        (60.0, 15.0, 15.0),
    )
    assert settings.values["motion"]["imm"]["cruise"]["model"] == "constant-velocity"
    assert settings.sources["motion.imm.sprint.max_speed"] == "file"
    assert list(settings.values)[:3] == ["seed", "motion", "sensors"]


def test_an_imm_without_a_table_cruises_and_turns() -> None:
    motion = moving({"model": "imm"})
    assert isinstance(motion, Imm)
    assert [type(model) for model in motion.models] == [ConstantVelocity, CoordinatedTurn]


def test_an_imm_needs_a_sojourn_time_for_each_way() -> None:
    with pytest.raises(InvalidInputError) as caught:
        moving({"model": "imm", "imm": {"sojourn_time": [1.0, 2.0, 3.0]}})
    assert str(caught.value).startswith("motion.imm.sojourn_time: 3 times; expected 2, one")


RADAR = ObservedSensor(
    Kind.RANGE_AZIMUTH, extent=2 * math.pi * 1e4, usual_range=5000.0, reports_per_scan=4.0
)
CAMERA = ObservedSensor(Kind.BEARING, needs_place=True, extent=2 * math.pi)


def seen(
    sensors: dict[str, object], observed: dict[str, ObservedSensor], *, estimated: bool = True
) -> Settings:
    return fill(
        load_configuration({"sensors": sensors}),
        ESTIMATES if estimated else None,
        tuple(observed),
        observed=observed,
    )


def test_noise_by_column_comes_in_degrees_and_goes_in_radians() -> None:
    settings = seen({"A": {"sigma": {"range_m": 70.0, "azimuth_deg": 0.08}}}, {"A": RADAR})
    assert settings.sensors[0].sigma == (70.0, pytest.approx(math.radians(0.08)))
    assert settings.sensors[0].measurement is Kind.RANGE_AZIMUTH
    assert settings.values["sensors"]["A"]["measurement"] == "range-azimuth"


def test_noise_estimated_on_the_plane_becomes_that_of_range_and_azimuth() -> None:
    (sensor,) = seen({}, {"A": RADAR}).sensors
    assert sensor.sigma == pytest.approx((7.0, 7.0 / 5000.0))
    assert sensor.clutter_density == pytest.approx(1e-5 * 1e6 / RADAR.extent)


def test_without_an_estimate_there_are_usual_values() -> None:
    settings = seen({"B": {"position": [1, 2]}}, {"A": RADAR, "B": CAMERA}, estimated=False)
    radar, camera = settings.sensors
    assert radar.sigma == pytest.approx((50.0, math.radians(0.5)))
    assert camera.sigma == pytest.approx((math.radians(1.0),))
    assert (radar.detection_probability, radar.scan_period) == (0.9, None)
    assert camera.clutter_density == pytest.approx(0.1 / (2 * math.pi))
    assert camera.position == (1, 2)
    assert settings.motion == ConstantVelocity(1.0, 50.0)
    assert settings.lifecycle.new_target_density == 1e-8
    assert {settings.sources[f"sensors.B.{key}"] for key in ("sigma", "rotation")} == {"default"}


@pytest.mark.parametrize(
    ("view", "volume"),
    [
        ({"min_range_m": 1e3, "max_range_m": 9e3, "azimuth_deg": [350, 80]}, 8e3 * math.pi / 2),
        ({"polygon": [[0, 0], [9, 0], [0, 9]]}, RADAR.extent),
        ({}, RADAR.extent),
    ],
)
def test_clutter_per_scan_of_a_radar_is_spread_over_range_and_azimuth(
    view: dict[str, object], volume: float
) -> None:
    settings = seen({"A": {"clutter_per_scan": 6.0, "field_of_view": view}}, {"A": RADAR})
    assert settings.sensors[0].clutter_density == pytest.approx(6.0 / volume)


@pytest.mark.parametrize(
    ("section", "said"),
    [
        ({"measurement": "position"}, 'measurement: "position"; expected "range-azimuth", as its'),
        ({"sigma": 10.0}, "sigma: 10.0; expected {range_m = …, azimuth_deg = …}, because its"),
        ({"sigma": {"bearing_deg": 1.0}}, "sigma: {bearing_deg = 1.0}; expected {range_m = …, az"),
        ({"rotation": "clockwise"}, 'rotation: "clockwise"; expected a scan_period with it'),
    ],
)
def test_refuses_what_does_not_fit_the_reports(section: dict[str, object], said: str) -> None:
    with pytest.raises(InvalidInputError) as caught:
        seen({"A": section}, {"A": RADAR})
    assert str(caught.value).startswith(f"sensors.A.{said}")


def test_refuses_noise_of_a_radar_for_a_sensor_of_positions() -> None:
    with pytest.raises(InvalidInputError, match=r"sensors\.A\.sigma: .*; expected {x = …, y = …}"):
        filled({"sensors": {"A": {"sigma": {"range_m": 70.0, "azimuth_deg": 0.08}}}})


def test_a_sensor_without_a_position_is_refused_where_one_is_needed() -> None:
    with pytest.raises(InvalidInputError) as caught:
        seen({}, {"B": CAMERA})
    assert str(caught.value).startswith(
        "sensors.B.position: left out; expected where the sensor stands, [x, y] in metres, "
        'because its bearing_deg count from there: under [sensors."B"] a line'
    )
    moving = replace(CAMERA, says_where=True)
    assert seen({}, {"B": moving}).sensors[0].position is None


def test_a_rotation_that_the_reports_show_brings_its_period() -> None:
    turning = replace(RADAR, rotation=Rotation(4.0, 1.0, -1))
    settings = seen({}, {"A": turning})
    assert settings.sensors[0].rotation == turning.rotation
    assert settings.sensors[0].scan_period == 4.0
    assert settings.values["sensors"]["A"]["rotation"] == "counter-clockwise"
    assert settings.sources["sensors.A.rotation"] == "estimated"
    assert seen({"A": {"rotation": "none"}}, {"A": turning}).sensors[0].rotation is None


def test_strength_and_identities_are_handed_on() -> None:
    strength = {
        "target_mean": 20.0,
        "target_sigma": 5.0,
        "clutter_mean": 12.0,
        "clutter_sigma": 4.0,
    }
    values = {"sensors": {"A": {"strength": strength, "identity_error": 0.2}}}
    sensor, other = filled(values).sensors
    assert sensor.strength == StrengthModel(20.0, 5.0, 12.0, 4.0)
    assert (sensor.identity_error, other.identity_error, other.strength) == (0.2, 0.001, None)


def test_the_kind_of_filter_is_handed_on() -> None:
    assert not filled({}).unscented
    assert filled({"motion": {"filter": "unscented"}}).unscented


@pytest.mark.parametrize("repeated", [{}, {"method": "genetic"}])
def test_a_key_of_the_search_is_merged_over_the_presets(repeated: dict[str, str]) -> None:
    settings = filled({"search": {**repeated, "population": 40}}, preset="hillis-1997")
    search, sources = settings.search, settings.sources
    assert (search.population, search.crossover, search.settle) == (40, 0.9, False)
    assert (sources["search.population"], sources["search.settle"]) == ("file", "preset")


def test_says_whose_an_option_of_another_solver_is() -> None:
    for preset, method in (("hillis-1997", "genetic"), (None, "auto")):
        with pytest.raises(InvalidInputError, match=rf"ants: a key of ant-system.*is {method}"):
            filled({"search": {"ants": 50}}, preset=preset)
