"""Gaps are filled in order of precedence, and each value tells where it came from."""

import math
from dataclasses import replace

import numpy as np
import pytest

from trackweave.config import load_configuration
from trackweave.config.fill import Settings, fill, known_sigma, needs_estimates
from trackweave.errors import InvalidInputError
from trackweave.estimation import Estimates, SensorEstimate
from trackweave.solvers import Dual, Genetic

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
    (note,) = filled({}, preset="hillis-1997").notes
    assert "each lone report counts as a track of one report" in note


def test_a_preset_fills_what_the_file_leaves_out() -> None:
    settings = filled({"window": {"depth": 3}}, preset="hillis-1997")
    assert settings.window.depth == 3
    assert settings.sources["window.depth"] == "file"
    assert settings.sources["search.population"] == "preset"
    assert isinstance(settings.search, Genetic)


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
    assert all(value is None or isinstance(value, str) or np.isfinite(value) for value in found)
