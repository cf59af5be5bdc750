"""The families of problems on which solvers are measured, and how a solver is run on one."""

import json
import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from bench_data import BESIDE

import trackweave.solvers
from trackweave import solve
from trackweave.association.plots_rule import PlotsRule, ScoredTuples, scene_plots
from trackweave.association.problem import Answer, AssignmentProblem
from trackweave.simulation.scenes import BearingKind, PositionKind, Scene, SceneKind, draw_scene

RECORDS = Path(__file__).with_name("best_known.json")
AXIAL = BESIDE / "data" / "ap3"
SEED = 1
"""What solvers draw from."""
ENDLESS = 10**12
"""A budget that no time limit leaves anything of."""


@dataclass(frozen=True)
class Family:
    """Scenes of one kind, drawn from ``seeds``; ``reach`` is how far off an object may be [m]."""

    name: str
    kind: SceneKind
    seeds: tuple[int, ...]
    reach: float

    def scene(self, seed: int) -> Scene:
        """Return a scene."""
        return draw_scene(self.kind, np.random.default_rng(seed))

    def tuples(self, seed: int) -> ScoredTuples:
        """Return a scene's tuples at eq. 1's cost, those of negative cost."""
        rule = PlotsRule(cost="equation-1", negative_only=True, max_tuples=2_000_000)
        return rule(scene_plots(self.scene(seed)))


def _bearings(n_sensors: int, n_objects: int, sigma: float) -> BearingKind:
    return BearingKind(n_sensors, n_objects, sigma)


# At spacing 4 the size varies much from seed to seed: those whose size is nearest to 70,000 and
# to 210,000 tuples, out of the first eight.
POSITIONS = (
    Family("position 3×30, spacing 4", PositionKind(3, 30, 4.0), (1, 2, 3), 50.0),
    Family("position 3×100, spacing 4", PositionKind(3, 100, 4.0), (1, 2, 3), 50.0),
    Family("position 5×100, spacing 10", PositionKind(5, 100, 10.0), (1, 2, 3), 50.0),
    Family("position 5×30, spacing 4", PositionKind(5, 30, 4.0), (2, 3, 4), 50.0),
    Family("position 5×100, spacing 4", PositionKind(5, 100, 4.0), (2, 5, 6), 50.0),
)
# Five standard deviations across the line of sight at the centre, as 50 m are for positions.
BEARINGS = (
    Family("bearings 3×30, 0.5°", _bearings(3, 30, math.radians(0.5)), (1, 2, 3), 393.0),
    Family("bearings 3×100, 2 mrad", _bearings(3, 100, 0.002), (1, 2), 90.0),
    Family("bearings 5×30, 2 mrad", _bearings(5, 30, 0.002), (1, 2), 90.0),
)


class Clock:
    """A stop that looks at this process's CPU time, from when it is made."""

    def __init__(self, limit: float) -> None:
        self._end = time.process_time() + limit

    def __call__(self) -> bool:
        """Tell whether the time is over."""
        return time.process_time() >= self._end


@dataclass(frozen=True)
class Measured:
    """An answer, the CPU time from arrays to it [s], and the tuples that it takes."""

    answer: Answer
    cpu: float
    rows: Any


def measured(
    make: Callable[[], AssignmentProblem], solver: Any, limit: float | None = None,
    seed: int = SEED,
) -> Measured:  # fmt: skip
    """Make a problem and solve it, with a limit of CPU time for both [s]."""
    begun = time.process_time()
    stop = None if limit is None else Clock(limit)
    problem = make()
    answer = solve(problem, solver, rng=np.random.default_rng(seed), stop=stop)
    cpu = time.process_time() - begun
    return Measured(answer, cpu, None if problem.row is None else problem.row[answer.nodes])


def on_tuples(
    scored: ScoredTuples, solver: Any, limit: float | None = None, seed: int = SEED
) -> Measured:
    """Solve a scene from its arrays, and see that the answer keeps the rules."""
    found = measured(
        lambda: AssignmentProblem.from_tuples(scored.tuples, scored.costs), solver, limit, seed
    )
    check_rows(scored.tuples, scored.costs, found.rows, found.answer)
    return found


def check_rows(tuples: Any, costs: Any, rows: Any, answer: Answer) -> None:
    """Exit where an answer takes an item twice, tells a wrong cost or a bound above it."""
    for chosen in tuples[rows].T:
        if np.any(np.bincount(chosen[chosen > 0]) > 1):
            raise SystemExit("an answer takes an item twice")
    cost = float(costs[rows].sum())
    if abs(cost - answer.cost) > 1e-6 * max(1.0, abs(cost)):
        raise SystemExit(f"an answer costs {cost}, not {answer.cost}")
    if answer.lower_bound > cost + 1e-6 * max(1.0, abs(cost)):
        raise SystemExit(f"a bound of {answer.lower_bound} is above an answer's cost, {cost}")


def warm_up(*solvers: Any) -> None:
    """Compile all that a solver may need: these small problems leave gaps that it searches."""
    scored = Family("", _bearings(3, 16, math.radians(0.5)), (5,), 0.0).tuples(5)
    dense = AssignmentProblem.from_array(np.random.default_rng(3).random((12, 12, 12)))
    # The default comes to annealing and to branching in large problems only.
    parts = [trackweave.solvers.Annealing(evaluations=10_000), trackweave.solvers.Exact()]
    for solver in (*parts, *solvers):
        on_tuples(scored, solver, 3.0)
        measured(lambda: dense, solver, 3.0)


def solver_named(name: str, **options: Any) -> Any:
    """Return a solver; None, which ``solve`` takes for its default, for "default".

    "patient" is the default without a budget but its time, as the command takes it for a limit.
    """
    if name == "default":
        return None
    if name == "patient":
        return trackweave.solvers.Auto(evaluations=ENDLESS, branches=ENDLESS)
    if not hasattr(trackweave.solvers, name):
        raise SystemExit(f"{name}: trackweave.solvers has no such solver")
    return getattr(trackweave.solvers, name)(**options)


class Records:
    """The least costs ever found, by the names of problems; kept beside this file."""

    def __init__(self) -> None:
        self._known: dict[str, dict[str, Any]] = (
            json.loads(RECORDS.read_text(encoding="utf-8")) if RECORDS.exists() else {}
        )

    def enter(self, name: str, cost: float, bound: float) -> None:
        """Keep a cost if it is less than that known, and a bound if it is greater."""
        old = self._known.get(name, {"cost": math.inf, "bound": -math.inf})
        new = {"cost": min(cost, old["cost"]), "bound": max(bound, old["bound"])}
        if new["bound"] > new["cost"] + 1e-6 * max(1.0, abs(new["cost"])):
            raise SystemExit(f"{name}: the bound {new['bound']} is above the cost {new['cost']}")
        if new != old:
            self._known[name] = new
            text = json.dumps(dict(sorted(self._known.items())), indent=2)
            RECORDS.write_text(text + "\n", encoding="utf-8")

    def cost(self, name: str) -> float:
        """Return the least known cost."""
        return float(self._known[name]["cost"])

    def bound(self, name: str) -> float:
        """Return the greatest known bound."""
        return float(self._known[name]["bound"])

    def gap(self, name: str, cost: float) -> float:
        """Return how far a cost is from the least known, relative to that."""
        best = self.cost(name)
        return (cost - best) / abs(best)


def percent(share: float) -> str:
    """Return a share to two digits; 0 is only what is 0 but for rounding."""
    if not math.isfinite(share):
        return "∞"
    if abs(share) < 1e-9:
        return "0"
    return f"{100 * share:.0f} %" if abs(share) >= 0.1 else f"{100 * share:.2g} %"


def axial_instances() -> dict[str, tuple[Any, float]]:
    """Return each axial instance's costs and its optimum, as told by its maker; {} without any."""
    found = {}
    for path in sorted(AXIAL.glob("*.txt"), key=lambda p: [int(n) for n in p.stem.split(".")[1:]]):
        words = path.read_text(encoding="utf-8").split()
        size = int(words[1])
        costs = np.array(words[-(size**3) :], dtype=float).reshape(size, size, size)
        optimum = path.with_suffix(".sol").read_text(encoding="utf-8").split()[1]
        found[path.stem] = (costs, float(optimum))
    return found
