"""Compiling beforehand what a solver will need, so that no clock counts it."""

import dataclasses
from typing import Any

import numpy as np

from trackweave.association.problem import AssignmentProblem
from trackweave.solvers._dual import bound_components
from trackweave.solvers._kernels import cheapest_first
from trackweave.solvers.components import Components
from trackweave.solvers.dual import Dual, Stretch, climb
from trackweave.solvers.exact.exact import BranchingLimits, branch
from trackweave.solvers.greedy import Greedy
from trackweave.solvers.islands import Islands
from trackweave.solvers.lists import lists_of
from trackweave.solvers.metaheuristic import polish
from trackweave.solvers.protocol import Solver

__all__ = ["warm_up"]

# Budgets that are enough to reach every kernel of a solver, by the names of their fields.
LITTLE = {
    "evaluations": 600,
    "branches": 1,
    "epochs": 2,
    "generations": 2,
    "cycles": 3,
    "visits": 2_000,
    "solves": 1,
}


def warm_up(solver: Solver, rng: np.random.Generator) -> None:
    """Compile, or load from the disk, the kernels that a solver needs; ``rng`` is advanced."""
    # Solves a small problem that prices alone do not decide, with small budgets. Takes half a
    # second when the kernels are on the disk, and up to a minute when they are not.
    if isinstance(solver, Greedy):
        return
    rows = rng.integers(1, 26, (2_000, 5))
    hard = AssignmentProblem.from_tuples(rows, rng.normal(-5.0, 1.0, rows.shape[0]))
    small = _with_little(solver)
    for stop in (None, lambda: False):
        small(hard, rng=rng, stop=stop)
    _touch(hard)


def _with_little(solver: Any) -> Any:
    """Return a solver with small budgets; what lives on islands gets them, too."""
    if not dataclasses.is_dataclass(solver) or isinstance(solver, type):
        return solver
    names = {field.name for field in dataclasses.fields(solver)}
    values: dict[str, Any] = {name: LITTLE[name] for name in names & set(LITTLE)}
    if isinstance(solver, Islands):
        values["methods"] = tuple(map(_with_little, solver.methods))
    return dataclasses.replace(solver, **values)


def _touch(problem: AssignmentProblem) -> None:
    """Call the kernels that a small problem does not always reach."""
    AssignmentProblem.from_array(np.eye(2))
    components = Components.of(problem, None, whole=True)
    Dual().bound(components, None)
    for is_smooth in (False, True):
        climb(components, 0, Stretch(2, is_smooth), None)
    parts = components.parts
    bound_components(parts, components.price, components.taken, components.cost, components.lower)
    component = components.component(0)
    cheapest_first(component, components.taken.copy())
    lists = lists_of(component, problem.instant[parts.item_of])
    polish(component, lists, components.taken.copy())
    branch(components, 0, BranchingLimits(1), None)
