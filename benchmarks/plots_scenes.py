"""The scenes of plots whose truth is known, and how answers to them are judged."""

import math
import time
from dataclasses import dataclass
from typing import Any

import numpy as np
from plots_practice import Told
from solvers_families import Clock, Family

from trackweave import solve
from trackweave.association.plots_rule import PlotsRule, ScoredTuples, scene_plots
from trackweave.errors import InvalidInputError
from trackweave.metrics import gospa
from trackweave.simulation.scenes import BearingKind, PositionKind, Scene
from trackweave.solvers import Auto

MEASURES = ("right", "false", "GOSPA")
SENSORS, OBJECTS = (3, 4, 5, 7), (5, 10, 20, 50, 100)
POSITION_REACH, BEARING_REACH, COARSE_REACH = 50.0, 90.0, 393.0
"""Five standard deviations, of bearings across the line of sight at the centre [m]."""
MOST_TUPLES, MOST_NEGATIVE = 1_000_000, 3_000_000


def families(objects: tuple[int, ...], sensors: tuple[int, ...] = SENSORS) -> list[Family]:
    """Return the kinds of scenes: positions far and close, bearings fine and coarse."""
    found = []
    for spacing in (10, 4):
        for n_sensors in sensors:
            for n in objects:
                kind = PositionKind(n_sensors, n, float(spacing))
                name = f"position {n_sensors}×{n}, spacing {spacing}"
                found.append(Family(name, kind, (), POSITION_REACH))
    for n_sensors in sensors:
        for n in objects:
            name = f"bearings {n_sensors}×{n}, 2 mrad"
            found.append(Family(name, BearingKind(n_sensors, n), (), BEARING_REACH))
    for n in objects if 3 in sensors else ():
        kind = BearingKind(3, n, math.radians(0.5))
        found.append(Family(f"bearings 3×{n}, 0.5°", kind, (), COARSE_REACH))
    return found


@dataclass(frozen=True)
class Limited:
    """A solver that has a CPU time for each of its answers [s]."""

    solver: Any
    seconds: float

    def __call__(self, problem: Any, *, rng: Any, hint: Any = None, stop: Any = None) -> Any:
        """Return the solver's answer; ``stop`` is the clock's."""
        return self.solver(problem, rng=rng, hint=hint, stop=Clock(self.seconds))


def scored_tuples(scene: Scene) -> tuple[ScoredTuples, float]:
    """Return a scene's tuples, all in the gate or else those worth their while; the CPU time."""
    begun = time.process_time()
    plots = scene_plots(scene)
    try:
        rule = PlotsRule(scene.object_density, area=scene.area, max_tuples=MOST_TUPLES)
        scored = rule(plots)
    except InvalidInputError:
        rule = PlotsRule(
            scene.object_density, area=scene.area, negative_only=True, max_tuples=MOST_NEGATIVE
        )
        scored = rule(plots)
    return scored, time.process_time() - begun


def likeliest(scored: ScoredTuples, solver: Any, seconds: float, seed: int) -> tuple[Told, float]:
    """Return a solver's answer at the cost of the evidence, and the CPU time."""
    begun = time.process_time()
    rows = np.flatnonzero(scored.costs < 0.0)
    some = ScoredTuples(
        scored.tuples[rows], scored.costs[rows], scored.positions[rows], scored.covariances[rows]
    )
    problem = some.problem()
    answer = solve(problem, Limited(solver or Auto(), seconds), rng=np.random.default_rng(seed))
    assert problem.row is not None
    chosen = problem.row[answer.nodes]
    told = Told(some.tuples[chosen] - 1, some.positions[chosen], answer.cost)
    return told, time.process_time() - begun


def true_groups(scene: Scene) -> set[tuple[int, ...]]:
    """Return the plots of each object that two sensors or more see."""
    plots = np.full((len(scene.objects), len(scene.plots)), -1)
    for sensor, label in enumerate(scene.label):
        (seen,) = np.nonzero(label >= 0)
        plots[label[seen], sensor] = seen
    return {tuple(row) for row in plots[np.sum(plots >= 0, axis=1) > 1].tolist()}


def judged(scene: Scene, groups: Any, places: Any, reach: float) -> dict[str, float]:
    """Return the share of right groups, how many objects told are false, and GOSPA."""
    true = true_groups(scene)
    right = sum(tuple(group) in true for group in groups.tolist())
    found = gospa(scene.objects, np.reshape(places, (-1, 2)), cutoff=reach)
    return {
        "right": right / max(1, len(true)), "false": float(found.n_false), "GOSPA": found.total,
    }  # fmt: skip
