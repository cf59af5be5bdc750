"""Scenes whose truth is known: targets that move, sensors that see some of them."""

from trackweave.simulation.demo import demo_configuration, demo_scenario
from trackweave.simulation.scenario import (
    Area,
    RandomTargets,
    Scenario,
    SimulatedSensor,
)
from trackweave.simulation.scenario_file import read_scenario, scenario_of
from trackweave.simulation.simulate import Simulation, simulate
from trackweave.simulation.targets import (
    Crossing,
    Manoeuvre,
    Parallel,
    Target,
)

__all__ = [
    "Area",
    "Crossing",
    "Manoeuvre",
    "Parallel",
    "RandomTargets",
    "Scenario",
    "SimulatedSensor",
    "Simulation",
    "Target",
    "demo_configuration",
    "demo_scenario",
    "read_scenario",
    "scenario_of",
    "simulate",
]
