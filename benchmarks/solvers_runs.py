"""Runs of each method alone, budget by budget, on every family of problems.

A method is run anew for each budget of evaluations, because annealing cools as its budget goes;
a run ends when its evaluations are spent, its gap is closed, or the time is over.
"""

import argparse
import json
import time
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from bench_data import bench_of
from solvers_families import (
    BEARINGS,
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

ENDLESS = 10**9
BUDGETS = (100, 300, 1_000, 3_000, 10_000, 30_000, 100_000, 300_000)
WINDOWS = "windows, T100"
OTHERS = ("Greedy", "Dual", "Exact", "default")
# Further limits than evaluations are lifted.
METHODS: dict[str, tuple[str, dict[str, Any]]] = {
    "Genetic": ("Genetic", {"generations": ENDLESS}),
    "Genetic, association lists": (
        "Genetic", {"generations": ENDLESS, "genotype": "association-list"}
    ),
    "ListGenetic": ("ListGenetic", {"generations": ENDLESS, "patience": ENDLESS}),
    "AntSystem": ("AntSystem", {"cycles": ENDLESS}),
    "MaxMinAntSystem": ("MaxMinAntSystem", {}),
    "Annealing": ("Annealing", {}),
    "TabuSearch": ("TabuSearch", {}),
}  # fmt: skip


@dataclass(frozen=True)
class Run:
    """What a run of a method with a budget came to; no budget where there is none."""

    family: str
    problem: str
    method: str
    seeded: bool
    budget: int | None
    evaluations: int
    cpu: float
    cost: float
    bound: float
    ended: str


@dataclass(frozen=True)
class Task:
    """A method on a problem, within a CPU time [s]."""

    family: str
    name: str
    problem: AssignmentProblem
    method: str
    limit: float

    def runs(self) -> list[Run]:
        """Return the runs with ever greater budgets, until nothing is left to gain."""
        if self.method not in METHODS:
            return [self._run(None, seeded=False)]
        found: list[Run] = []
        for seeded in (True, False):
            for budget in BUDGETS:
                found.append(self._run(budget, seeded=seeded))
                if found[-1].ended in ("stopped", "closed", "converged"):
                    break
        return found

    def _run(self, budget: int | None, *, seeded: bool) -> Run:
        if budget is None:
            solver = solver_named(self.method)
        else:
            kind, options = METHODS[self.method]
            solver = solver_named(kind, **options, seeded=seeded, evaluations=budget)
        begun = time.process_time()
        stop = Clock(self.limit)
        answer = solve(self.problem, solver, rng=np.random.default_rng(SEED), stop=stop)
        cpu = time.process_time() - begun
        return Run(
            family=self.family, problem=self.name, method=self.method, seeded=seeded,
            budget=budget, evaluations=answer.evaluations, cpu=cpu, cost=answer.cost,
            bound=answer.lower_bound,
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
    for family in (*POSITIONS, *BEARINGS):
        if chosen is None or family.name in chosen:
            scored = {seed: family.tuples(seed) for seed in family.seeds[:n]}
            found[family.name] = {
                f"{family.name}, seed {seed}": AssignmentProblem.from_tuples(s.tuples, s.costs)
                for seed, s in scored.items()
            }
    if (chosen is None or WINDOWS in chosen) and (arguments.bench / "gen.py").exists():
        windows = collected(bench_of(arguments).scene(100, 1, 1), priors=False)
        scans = np.linspace(10, len(windows) - 1, n).astype(int).tolist()
        found[WINDOWS] = {f"{WINDOWS}, scan {k}": windows[k][0] for k in scans}
    return {name: problems for name, problems in found.items() if problems}


def is_there(method: str) -> bool:
    """Tell whether the library has a method yet."""
    name = METHODS[method][0] if method in METHODS else method
    return name == "default" or hasattr(trackweave.solvers, name)


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
