"""Axial 3-D assignment: the instances beside the checkout, every one to its proven optimum."""

import argparse
from typing import Any

import numpy as np
from solvers_families import axial_instances, check_rows, measured, solver_named, warm_up
from solvers_highs import columns_of_array, mixed_integer
from text_tables import command, heading, table

from trackweave.association.problem import AssignmentProblem, Status


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--solvers", nargs="+", default=["patient", "Exact"])
    parser.add_argument("--limit", type=float, default=60.0, help="CPU time for each [s]")
    parser.add_argument("--highs", type=int, default=10, help="instances of each size for HiGHS")
    arguments = parser.parse_args()
    instances = axial_instances()
    if not instances:
        print("Skipped: no axial instances beside the checkout.")
        return
    solvers = {name: solver_named(name) for name in arguments.solvers}
    warm_up(*solvers.values())
    rows = []
    for size in sorted({costs.shape[0] for costs, _ in instances.values()}):
        some = {name: pair for name, pair in instances.items() if pair[0].shape[0] == size}
        times = _highs(dict(list(some.items())[: arguments.highs]), arguments.limit)
        for name, solver in solvers.items():
            found = {k: _ours(*pair, solver, arguments.limit) for k, pair in some.items()}
            shown = "default" if name == "patient" else name
            rows.append(_row(f"n = {size}, {shown}", found))
        rows.append(_row(f"n = {size}, HiGHS MIP", times))
    print(heading(command("solvers_axial.py")), end="\n\n")
    head = ["instances, solver", "proven optimal", "CPU ms, mean", "greatest", "its instance"]
    print(table(head, rows))


def _ours(costs: Any, optimum: float, solver: Any, limit: float) -> tuple[bool, float]:
    """Tell whether the optimum was proven, and the CPU time from the array to the answer [s]."""
    found = measured(lambda: AssignmentProblem.from_array(costs), solver, limit)
    check_rows(np.argwhere(np.isfinite(costs)) + 1, costs.ravel(), found.rows, found.answer)
    proven = found.answer.status == Status.OPTIMAL
    if proven and abs(found.answer.cost - optimum) > 1e-6:
        raise SystemExit(f"{found.answer.cost} was proven, but the optimum is {optimum}")
    return proven, found.cpu


def _highs(instances: dict[str, Any], limit: float) -> dict[str, tuple[bool, float]]:
    found = {}
    for name, (costs, _) in instances.items():
        last = mixed_integer(columns_of_array(costs), limit)[-1]
        found[name] = (last.status == "optimal", last.cpu)
    return found


def _row(name: str, found: dict[str, tuple[bool, float]]) -> list[Any]:
    cpu = {key: seconds for key, (_, seconds) in found.items()}
    worst = max(cpu, key=lambda key: cpu[key])
    return [
        name, f"{sum(proven for proven, _ in found.values())} of {len(found)}",
        1e3 * float(np.mean(list(cpu.values()))), 1e3 * cpu[worst], worst,
    ]  # fmt: skip


if __name__ == "__main__":
    main()
