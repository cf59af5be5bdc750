"""What a file leaves out and what an argument leaves out are the same."""

from dataclasses import MISSING, fields
from inspect import signature

import pytest

from trackweave import solvers
from trackweave.association.growth_limits import GrowthLimits
from trackweave.association.plots_rule import PlotsRule
from trackweave.config import load_configuration
from trackweave.config.fill import fill
from trackweave.config.search import options_of
from trackweave.models.sensors import Sensor
from trackweave.solvers import METHODS
from trackweave.trackers.fused_plots import FusedPlotsTracker
from trackweave.trackers.lifecycle import Lifecycle
from trackweave.trackers.multi_hypothesis import MultiHypothesisTracker
from trackweave.trackers.nearest_neighbour import NearestNeighbourTracker
from trackweave.trackers.plot_fusion import PlotFuser
from trackweave.trackers.window import Window

SENSOR = {"sigma": 10.0, "clutter_density": 1e-6}
NO_LIBRARY_DEFAULT = {
    "seed", "motion.model", "motion.process_noise", "motion.max_speed", "motion.trust",
    "tracker.kind", "lifecycle.at_rest", "lifecycle.divide", "lifecycle.join",
    "lifecycle.merge",
    "plots.fuse", "plots.within", "plots.object_density",
}  # fmt: skip
TRACKERS = (MultiHypothesisTracker, NearestNeighbourTracker, FusedPlotsTracker)


def argument(function, name):
    return signature(function).parameters[name].default


def library_defaults():
    life, plots = Lifecycle(), PlotsRule(1e-6)
    sensor = {field.name: field.default for field in fields(Sensor)}
    found = {f"growth.{f.name}": getattr(GrowthLimits(), f.name) for f in fields(GrowthLimits)}
    found |= {f"window.{field.name}": getattr(Window(), field.name) for field in fields(Window)}
    found |= {f"lifecycle.{field.name}": getattr(life, field.name) for field in fields(life)}
    found["lifecycle.confirm"] = f"{life.confirm_hits}/{life.confirm_opportunities}"
    found |= {f"sensors.a.{name}": value for name, value in sensor.items()}
    found["sensors.a.measurement"] = sensor["measurement"].word
    found["sensors.a.rotation"] = sensor["rotation"] or "none"
    found["sensors.a.echoes"] = list(sensor["echoes"])
    found["sensors.a.sigma_at"] = list(sensor["sigma_at"])
    found |= {f"plots.{name}": getattr(plots, name) for name in ("cost", "gate", "max_tuples")}
    found["plots.keep_lone"] = argument(PlotFuser, "keep_lone")
    found["tracker.pairing"] = argument(NearestNeighbourTracker, "pairing")
    found["motion.filter"] = (
        "unscented" if argument(MultiHypothesisTracker, "unscented") else "extended"
    )
    found["output.estimate"] = argument(MultiHypothesisTracker, "estimate")
    found["output.period"] = None
    found["live.max_ahead"] = argument(MultiHypothesisTracker, "max_ahead")
    found["search.deadline_ms"] = argument(MultiHypothesisTracker.step, "deadline")
    found["search.method"] = "auto"
    return found


@pytest.mark.parametrize("kind", ["multi-hypothesis", "nearest-neighbour"])
def test_files_and_library_have_the_same_defaults(kind):
    values = {"sensors": {"a": SENSOR}, "tracker": {"kind": kind}, "plots": {"fuse": True}}
    settings = fill(load_configuration(values), None, ("a",))
    own = {key for key, source in settings.sources.items() if source == "default"}
    expected = library_defaults()
    assert own - NO_LIBRARY_DEFAULT <= set(expected)
    assert len(own) > 30
    for key in own - NO_LIBRARY_DEFAULT:
        value = settings.values
        for part in key.split("."):
            value = value[part]
        assert value == expected[key], key


def test_so_have_the_values_that_a_tracker_gets():
    settings = fill(load_configuration({"sensors": {"a": SENSOR}}), None, ("a",))
    assert settings.lifecycle == Lifecycle()
    assert settings.window == Window()
    assert settings.growth == GrowthLimits()
    assert settings.sensors == (Sensor("a", **SENSOR),)
    assert settings.search is None
    plain = MultiHypothesisTracker(motion=settings.motion, sensors=settings.sensors)
    assert type(plain._search).__name__ == METHODS["auto"]


def test_every_tracker_believes_stamps_alike():
    assert len({argument(tracker, "max_ahead") for tracker in TRACKERS}) == 1


@pytest.mark.parametrize("method", METHODS)
def test_a_solvers_options_are_its_own(method):
    solver = getattr(solvers, METHODS[method])
    usual = {field.name: field.default for field in fields(solver) if field.default is not MISSING}
    # Of any search, how many there are side by side.
    usual = {"islands": 1} | usual
    for name, option in options_of(method).entries.items():
        if isinstance(usual[name], tuple):
            # Searches, which a file names.
            assert len(option.default) == len(usual[name])
        else:
            assert option.default == usual[name]
