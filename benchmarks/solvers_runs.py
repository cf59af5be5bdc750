"""Runs of each method alone, budget by budget, on every family of problems.

A method is run anew for each budget of evaluations, without a limit of time that matters, and for
each time, without a limit of evaluations; a run also ends when its gap is closed.
"""

import argparse
import json
import time
import zlib
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from bench_data import bench_of
from solvers_families import (
    BEARINGS,
    ENDLESS,
    POSITIONS,
    SEED,
    Clock,
    axial_instances,
    solver_named,
    warm_up,
)
from solvers_windows import collected

import trackweave.solvers
from trackweave import solve
from trackweave.association.problem import AssignmentProblem, Status

BUDGETS = (1_000, 10_000)
TIMES = (0.1, 0.3, 1.0)
"""CPU times that runs are given [s]."""
PATIENT = {"patience": ENDLESS}
WINDOWS = "windows, T100"
OTHERS = ("Greedy", "Dual", "Exact", "patient")
# Further limits than evaluations are lifted.
METHODS: dict[str, tuple[str, dict[str, Any]]] = {
    "Genetic": ("Genetic", {"generations": ENDLESS}),
    "Genetic, association lists": (
        "Genetic", {"generations": ENDLESS, "genotype": "association-list"}
    ),
    "ListGenetic": ("ListGenetic", {"generations": ENDLESS, **PATIENT}),
    "AntSystem": ("AntSystem", {"ants": 30, "cycles": ENDLESS}),
    "Annealing": ("Annealing", PATIENT),
    "TabuSearch": ("TabuSearch", PATIENT),
}  # fmt: skip


@dataclass(frozen=True)
class Run:
    """What a run came to; ``budget`` and ``limit`` are None where there was none."""

    family: str
    problem: str
    method: str
    seeded: bool
    budget: int | None
    limit: float | None
    evaluations: int
    cpu: float
    cost: float
    bound: float
    ended: str

    @property
    def is_over(self) -> bool:
        """Whether nothing is left to gain from more time or evaluations."""
        return self.ended not in ("stopped", "evaluations", "budget spent")

    def is_within(self, seconds: float) -> bool:
        """Tell whether this could be had in a CPU time, but for how late a stop is seen.

        Runs with few evaluations count too: one without a limit of them may spend all its time
        on the first component.
        """
        if self.limit is not None:
            return self.limit <= seconds
        return self.cpu <= seconds


@dataclass(frozen=True)
class Task:
    """A method on a problem; ``longest`` ends runs that evaluations do not [s]."""

    family: str
    name: str
    problem: AssignmentProblem
    method: str
    longest: float

    def runs(self) -> list[Run]:
        """Return the runs with ever greater times and budgets, until nothing is left to gain."""
        found: list[Run] = []
        for seeded in (True, False) if self.method in METHODS else (False,):
            for limit in TIMES:
                found.append(self._run(None, limit, seeded=seeded))
                if found[-1].is_over:
                    break
            cpu = 0.0
            for budget in BUDGETS if self.method in METHODS else ():
                # Ten times the evaluations take ten times as long, beyond the start.
                if cpu > self.longest / 3:
                    break
                found.append(self._run(budget, None, seeded=seeded))
                cpu = found[-1].cpu
                if found[-1].ended != "evaluations":
                    break
        return found

    def _run(self, budget: int | None, limit: float | None, *, seeded: bool) -> Run:
        if self.method in METHODS:
            kind, options = METHODS[self.method]
            evaluations = ENDLESS if budget is None else budget
            solver = solver_named(kind, **options, seeded=seeded, evaluations=evaluations)
        else:
            solver = solver_named(self.method)
        begun = time.process_time()
        stop = Clock(self.longest if limit is None else limit)
        answer = solve(self.problem, solver, rng=np.random.default_rng(SEED), stop=stop)
        cpu = time.process_time() - begun
        return Run(
            family=self.family, problem=self.name, method=self.method, seeded=seeded,
            budget=budget, limit=limit, evaluations=answer.evaluations, cpu=cpu,
            cost=answer.cost, bound=answer.lower_bound,
            ended="closed" if answer.status == Status.OPTIMAL else answer.stop_reason,
        )  # fmt: skip


def families_of(arguments: argparse.Namespace) -> dict[str, dict[str, AssignmentProblem]]:
    """Return the problems of each family by their names."""
    n, chosen = arguments.scenes, arguments.families
    found: dict[str, dict[str, AssignmentProblem]] = {}
    for size in (20, 30):
        if chosen is None or f"axial, n = {size}" in chosen:
            some = [(k, c) for k, (c, _) in axial_instances().items() if len(c) == size]
            found[f"axial, n = {size}"] = {
                name: AssignmentProblem.from_array(costs) for name, costs in some[:n]
            }
    if (chosen is None or WINDOWS in chosen) and (arguments.bench / "gen.py").exists():
        windows = collected(bench_of(arguments).scene(100, 1, 1), priors=False)
        scans = np.linspace(20, len(windows) - 1, n).astype(int).tolist()
        found[WINDOWS] = {_window_name(k, windows[k][0]): windows[k][0] for k in scans}
    for family in (*POSITIONS, *BEARINGS):
        if chosen is None or family.name in chosen:
            scored = {seed: family.tuples(seed) for seed in family.seeds[:n]}
            found[family.name] = {
                f"{family.name}, seed {seed}": AssignmentProblem.from_tuples(s.tuples, s.costs)
                for seed, s in scored.items()
            }
    return {name: problems for name, problems in found.items() if problems}


def _window_name(scan: int, problem: AssignmentProblem) -> str:
    """Return a name that another tracker's window of the same scan does not have."""
    return f"{WINDOWS}, scan {scan}, {zlib.crc32(problem.total.tobytes()):08x}"


def is_there(method: str) -> bool:
    """Tell whether the library has a method yet."""
    name = METHODS[method][0] if method in METHODS else method
    return name == "patient" or hasattr(trackweave.solvers, name)


def warm_up_methods(methods: list[str]) -> None:
    """Compile all that methods need."""
    for method in methods:
        if method in METHODS:
            name, options = METHODS[method]
            for seeded in (True, False):
                warm_up(solver_named(name, **options, seeded=seeded, evaluations=300))
        else:
            warm_up(solver_named(method))


def keep(runs: list[Run], path: Path) -> None:
    """Write runs to a file, for a look at them later."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps([asdict(run) for run in runs]), encoding="utf-8")


def kept(path: Path, but: list[str]) -> list[Run]:
    """Return the runs in a file, but those of some methods."""
    runs = [Run(**values) for values in json.loads(path.read_text(encoding="utf-8"))]
    return [run for run in runs if run.method not in but]
