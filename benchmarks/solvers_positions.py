"""Scenes of positions: the default solver beside HiGHS, from the tuples' arrays to the answer."""

import argparse
import math
from typing import Any

import numpy as np
from solvers_families import POSITIONS, Family, Records, on_tuples, percent, solver_named, warm_up
from solvers_highs import columns_of_tuples, linear, mixed_integer
from text_tables import command, heading, table

REPEATS = 3
EARLY = (1.0, 3.0)
"""CPU times after which slow ones are looked at as well [s]."""
MANY = 50_000
"""Of scenes with more tuples HiGHS sees the first of a family: it takes minutes."""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--solver", default="patient")
    parser.add_argument("--limit", type=float, default=20.0, help="CPU time for each [s]")
    parser.add_argument("--families", nargs="+", default=[family.name for family in POSITIONS])
    arguments = parser.parse_args()
    solver = solver_named(arguments.solver)
    warm_up(solver)
    records = Records()
    rows = [
        _row(family, seed, solver, arguments.limit, records)
        for family in POSITIONS
        if family.name in arguments.families
        for seed in family.seeds
    ]
    print(heading(command("solvers_positions.py")), end="\n\n")
    head = ["scene", "tuples", "certified gap", "CPU ms", *(f"at {t:.0f} s, gap" for t in EARLY),
            "HiGHS MIP ms", "its gap",
            "MIP ÷ ours", "HiGHS LP ms", "LP ÷ ours"]  # fmt: skip
    print(table(head, rows))


def _row(family: Family, seed: int, solver: Any, limit: float, records: Records) -> list[Any]:
    scored = family.tuples(seed)
    runs = [on_tuples(scored, solver, limit)]
    # Long runs vary little.
    runs += [on_tuples(scored, solver, limit) for _ in range(REPEATS - 1) if runs[0].cpu < 5]
    cpu = float(np.median([run.cpu for run in runs]))
    answer = runs[0].answer
    early = [on_tuples(scored, solver, t).answer if cpu > t else answer for t in EARLY]
    name = f"{family.name}, seed {seed}"
    records.enter(name, answer.cost, answer.lower_bound)
    ours = [name, len(scored), percent(answer.gap), 1e3 * cpu, *(percent(a.gap) for a in early)]
    if len(scored) > MANY and seed != family.seeds[0]:
        return [*ours, *[None] * 5]
    columns = columns_of_tuples(scored.tuples, scored.costs)
    program = linear(columns, limit)[-1]
    search = mixed_integer(columns, limit)[-1]
    records.enter(name, search.cost, search.bound)
    more = "" if math.isfinite(search.gap) and search.gap <= 1e-4 else "> "
    return [
        *ours, f"{more}{1e3 * search.cpu:.0f}", percent(search.gap),
        f"{more}{search.cpu / cpu:.1f}", 1e3 * program.cpu, program.cpu / cpu,
    ]  # fmt: skip


if __name__ == "__main__":
    main()
