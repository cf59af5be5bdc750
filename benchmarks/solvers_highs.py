"""HiGHS on the same problems, in a process of its own that can be ended.

A process that has run HiGHS keeps its threads, and HiGHS may overshoot its time limit by much:
the child tells what it has found while it searches, and the operating system ends it when its CPU
time is spent.
"""

import json
import resource
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

GRACE = 20
"""CPU time beyond its limit after which a child is ended [s]; it also imports and reads."""
GAP = 1e-4


class Columns(NamedTuple):
    """A choice among columns: ``item`` lists each column's rows, from ``start[column]`` on.

    Each row is covered at most once, and at least once where ``must``.
    """

    cost: Any
    start: Any
    item: Any
    must: Any


@dataclass(frozen=True)
class Found:
    """What HiGHS has found after a CPU time [s], model building included."""

    cpu: float
    cost: float
    bound: float
    status: str

    @property
    def gap(self) -> float:
        """As ``Certificate.gap``."""
        # Here, so that the process in which HiGHS is timed does without it.
        from trackweave.association.certificate import relative_gap

        return relative_gap(self.cost, self.bound)


def columns_of_tuples(tuples: Any, costs: Any) -> Columns:
    """Return the columns of tuples whose items may be left at no cost."""
    size = tuples.max(axis=0, initial=0)
    offset = np.concatenate([[0], np.cumsum(size)])
    is_there = tuples > 0
    return Columns(
        cost=costs,
        start=np.concatenate([[0], np.cumsum(is_there.sum(axis=1))]),
        item=(tuples - 1 + offset[:-1])[is_there],
        must=np.zeros(offset[-1], dtype=bool),
    )


def columns_of_array(costs: Any) -> Columns:
    """Return the columns of a dense array, every index of which has to be covered."""
    index = np.argwhere(np.isfinite(costs))
    columns = columns_of_tuples(index + 1, costs[np.isfinite(costs)])
    return columns._replace(must=np.ones(sum(costs.shape), dtype=bool))


def columns_of_problem(problem: Any) -> Columns:
    """Return the columns of an assignment problem: its sequences that may end."""
    leaves = np.flatnonzero(np.isfinite(problem.total))
    node, items, places = leaves.copy(), [], []
    while np.any(node >= 0):
        at = np.flatnonzero(node >= 0)
        items.append(problem.item[node[at]])
        places.append(at)
        node[at] = problem.parent[node[at]]
    item, place = np.concatenate(items), np.concatenate(places)
    return Columns(
        cost=problem.total[leaves],
        start=np.concatenate([[0], np.cumsum(np.bincount(place, minlength=leaves.size))]),
        item=item[np.argsort(place, kind="stable")],
        must=problem.must_cover,
    )


def linear(columns: Columns, limit: float) -> list[Found]:
    """Return how HiGHS's linear program goes, last what it ends with."""
    return _searched(columns, limit, integer=False)


def mixed_integer(columns: Columns, limit: float) -> list[Found]:
    """Return how HiGHS's search goes over the CPU time, last what it ends with."""
    return _searched(columns, limit, integer=True)


def at(found: list[Found], cpu: float) -> Found:
    """Return what was known after a CPU time [s]."""
    known = [one for one in found if one.cpu <= cpu]
    return known[-1] if known else Found(cpu, float("inf"), float("-inf"), "nothing yet")


def _searched(columns: Columns, limit: float, *, integer: bool) -> list[Found]:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "columns.npz"
        np.savez(path, **columns._asdict())
        done = subprocess.run(
            [sys.executable, __file__, str(path), str(limit), str(int(integer))],
            stdout=subprocess.PIPE, text=True, check=False,
        )  # fmt: skip
    found = [Found(**json.loads(line)) for line in done.stdout.splitlines() if line[-1:] == "}"]
    if not found or found[-1].status == "running":
        last = found[-1] if found else Found(0.0, float("inf"), float("-inf"), "")
        found.append(Found(limit + GRACE, last.cost, last.bound, "ended"))
    return found


def _child(path: str, limit: float, *, integer: bool) -> None:
    import highspy

    with np.load(path) as file:
        columns = Columns(**file)
    begun = time.process_time()
    seconds = int(begun + limit + GRACE)
    resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds))
    solver = _model(highspy, columns, integer=integer)
    last: list[Any] = []

    def look(event: Any) -> None:
        out = event.data_out
        state = [out.mip_primal_bound, out.mip_dual_bound]
        if state != last:
            last[:] = state
            _tell(begun, *state, "running")
        event.data_in.user_interrupt = time.process_time() - begun > limit

    def look_at_clock(event: Any) -> None:
        event.data_in.user_interrupt = time.process_time() - begun > limit

    if integer:
        solver.cbMipInterrupt.subscribe(look)
    solver.cbSimplexInterrupt.subscribe(look_at_clock)
    solver.run()
    information = solver.getInfo()
    status = solver.modelStatusToString(solver.getModelStatus())
    cost = information.objective_function_value
    if information.primal_solution_status != 2:
        cost = float("inf")
    bound = information.mip_dual_bound if integer else cost
    _tell(begun, cost, bound, status.lower())


def _model(highspy: Any, columns: Columns, *, integer: bool) -> Any:
    solver = highspy.Highs()
    solver.setOptionValue("output_flag", False)
    solver.setOptionValue("threads", 1)
    solver.setOptionValue("mip_rel_gap", GAP)
    n_columns, n_rows = columns.cost.size, columns.must.size
    model = highspy.HighsLp()
    model.num_col_, model.num_row_ = n_columns, n_rows
    model.col_cost_ = columns.cost
    model.col_lower_, model.col_upper_ = np.zeros(n_columns), np.ones(n_columns)
    model.row_lower_, model.row_upper_ = columns.must.astype(float), np.ones(n_rows)
    model.a_matrix_.format_ = highspy.MatrixFormat.kColwise
    model.a_matrix_.start_, model.a_matrix_.index_ = columns.start, columns.item
    model.a_matrix_.value_ = np.ones(columns.item.size)
    if integer:
        model.integrality_ = [highspy.HighsVarType.kInteger] * n_columns
    solver.passModel(model)
    return solver


def _tell(begun: float, cost: float, bound: float, status: str) -> None:
    line = {"cpu": time.process_time() - begun, "cost": cost, "bound": bound, "status": status}
    print(json.dumps(line), flush=True)


if __name__ == "__main__":
    _child(sys.argv[1], float(sys.argv[2]), integer=sys.argv[3] == "1")
