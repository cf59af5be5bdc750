"""Which tracker, and whether plots are fused first."""

import numpy as np
import pytest

from trackweave.config import load_configuration
from trackweave.config.fill import fill
from trackweave.errors import InvalidInputError
from trackweave.estimation.estimates import Estimates, SensorEstimate
from trackweave.presets import wiranto_2018
from trackweave.solvers import AntSystem

PERIODS = {"A": 2.0, "B": 5.0}
ESTIMATES = Estimates(
    sensors={
        name: SensorEstimate(
            scan_period=period,
            sigma=7.0,
            detection_probability=0.8,
            clutter_density=1e-5,
            covered=1e6,
            n_objects=3.0,
        )
        for name, period in PERIODS.items()
    },
    process_noise=0.5,
    max_speed=25.0,
    new_target_density=1e-7,
    initial_target_density=3e-6,
)


def filled(values, preset=None, estimates=ESTIMATES):
    names = tuple(PERIODS)
    return fill(load_configuration(values), estimates, names, preset=preset)


def test_left_out_it_is_the_tracker_of_a_window_and_nothing_is_entered():
    settings = filled({"tracker": {}, "plots": {}})
    assert settings.tracker.kind == "multi-hypothesis"
    assert settings.plots is None
    assert not {"tracker", "plots"} & set(settings.values)


def test_what_is_left_out_of_plots_follows_from_the_sensors_and_the_lifecycle():
    settings = filled({"plots": {"fuse": True}})
    assert settings.plots is not None
    assert settings.plots.within == pytest.approx(0.2)
    assert settings.plots.rule.object_density == 3e-6
    assert settings.plots.rule.negative_only
    given = filled({"plots": {"fuse": True}, "lifecycle": {"initial_target_density": 1e-4}})
    assert given.plots is not None
    assert given.plots.rule.object_density == 1e-4
    assert filled({"plots": {"fuse": False, "gate": 9.0}}).plots is None


def test_all_scans_of_a_period_may_be_of_one_instant():
    settings = filled({"plots": {"fuse": True, "within": "period"}})
    assert settings.plots is not None
    assert settings.plots.within == pytest.approx(2.0)


def test_the_usable_preset_fuses_what_its_strict_one_cannot():
    settings = filled({}, preset=wiranto_2018.USABLE)
    assert settings.plots is not None
    assert (settings.plots.rule.cost, settings.plots.keep_lone) == ("evidence", True)
    assert settings.plots.within == pytest.approx(2.0)
    assert settings.tracker.pairing == "one-to-one"
    assert settings.search == AntSystem(
        pheromone_weight=0.5, visibility_weight=3.0, seeded=True, decompose=True
    )


def test_sensors_that_do_not_scan_are_of_one_instant_within_the_noise_of_clocks():
    estimates = Estimates(
        **{
            name: getattr(ESTIMATES, name)
            for name in ("process_noise", "max_speed", "new_target_density")
        },
        initial_target_density=None,
        sensors={name: SensorEstimate(None, 7.0, 0.8, 1e-5, 1e6, 3.0) for name in PERIODS},
    )
    settings = filled({"plots": {"fuse": True}}, estimates=estimates)
    assert settings.plots is not None
    assert settings.plots.within == 1e-6
    assert settings.plots.rule.object_density == 1e-7


def test_equation_one_prices_plots_alone_and_keeps_all_tuples():
    settings = filled({}, preset="wiranto-2018")
    assert settings.plots is not None
    rule = settings.plots.rule
    assert (rule.cost, rule.negative_only, rule.lone_plots) == ("equation-1", False, True)
    assert settings.tracker.pairing == "nearest"
    assert settings.sources["tracker.kind"] == "preset"


@pytest.mark.parametrize(
    ("values", "note"),
    [
        ({"tracker": {"kind": "nearest-neighbour"}, "window": {"depth": 3}}, "window"),
        ({"tracker": {"kind": "multi-hypothesis", "pairing": "nearest"}}, "tracker.pairing"),
    ],
)
def test_keys_that_another_tracker_would_use_are_noted(values, note):
    (found,) = filled(values).notes
    assert found.startswith(note)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        (
            {"tracker": {"kind": "window"}},
            'tracker.kind.*"multi-hypothesis" or "nearest-neighbour"',
        ),
        ({"tracker": {"pairing": 1}}, 'tracker.pairing.*"nearest" or "one-to-one"'),
        ({"plots": {"fuse": 1}}, "plots.fuse.*true or false"),
        ({"plots": {"within": -1.0}}, "plots.within.*≥ 0"),
        ({"plots": {"within": np.inf}}, "plots.within"),
        ({"plots": {"within": "scan"}}, 'plots.within: "scan"; expected .*"period"'),
        ({"plots": {"keep_lone": 1}}, "plots.keep_lone.*true or false"),
        ({"plots": {"cost": "eq1"}}, 'plots.cost.*"evidence" or "equation-1"'),
        ({"plots": {"gate": 0.0}}, "plots.gate.*> 0"),
        ({"plots": {"object_density": 0.0}}, "plots.object_density"),
        ({"plots": {"max_tuples": 0}}, "plots.max_tuples"),
        ({"plots": {"maximum": 3}}, "unknown key"),
    ],
)
def test_values_out_of_range_name_the_key(values, message):
    with pytest.raises(InvalidInputError, match=message):
        load_configuration(values)
