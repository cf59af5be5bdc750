"""Scenes of bearings: what is found and proven after so much time, beside HiGHS."""

import argparse
from typing import Any

import numpy as np
from solvers_families import BEARINGS, Family, Records, on_tuples, percent, solver_named, warm_up
from solvers_highs import at, columns_of_tuples, linear, mixed_integer
from text_tables import command, heading, table

LIMITS = {1.0: 5, 3.0: 1, 10.0: 1}
"""CPU times [s], and how many seeds of ours are run with each."""
LAST = max(LIMITS)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--solver", default="patient")
    parser.add_argument("--families", nargs="+", default=[family.name for family in BEARINGS])
    arguments = parser.parse_args()
    solver = solver_named(arguments.solver)
    warm_up(solver)
    records = Records()
    found: dict[str, Any] = {}
    for family in BEARINGS:
        for seed in family.seeds if family.name in arguments.families else ():
            found[f"{family.name}, seed {seed}"] = _measure(family, seed, solver, records)
    print(heading(command("solvers_bearings.py")), end="\n\n")
    head = ["scene", "tuples", "HiGHS LP s", "LP below the best known", "solver"]
    for limit in LIMITS:
        head += [f"{limit:.0f} s: above the best known", "certified"]
    head += ["LP's gap closed", "CPU s in all"]
    print(table(head, [row for name, runs in found.items() for row in _rows(name, runs, records)]))


def _measure(family: Family, seed: int, solver: Any, records: Records) -> dict[str, Any]:
    scored = family.tuples(seed)
    name = f"{family.name}, seed {seed}"
    ours = {
        limit: [on_tuples(scored, solver, limit, seed=1 + draw) for draw in range(n_draws)]
        for limit, n_draws in LIMITS.items()
    }
    columns = columns_of_tuples(scored.tuples, scored.costs)
    program = linear(columns, 60.0)[-1]
    search = mixed_integer(columns, LAST)
    for run in (run for several in ours.values() for run in several):
        records.enter(name, run.answer.cost, run.answer.lower_bound)
    for one in search:
        records.enter(name, one.cost, one.bound)
    return {"tuples": len(scored), "ours": ours, "program": program, "search": search}


def _rows(name: str, runs: dict[str, Any], records: Records) -> list[list[Any]]:
    """Return our row and HiGHS's: distance to the best known, certified gap, bound's progress."""
    program, best = runs["program"], records.cost(name)
    below = (best - program.cost) / max(1.0, abs(best))
    rows: list[list[Any]] = [
        [name, runs["tuples"], program.cpu, percent(below), "ours"],
        ["", "", "", "", "HiGHS MIP"],
    ]
    for limit in LIMITS:
        other = at(runs["search"], limit)
        answers = [run.answer for run in runs["ours"][limit]]
        gaps = [records.gap(name, answer.cost) for answer in answers]
        worst = f"; worst {percent(max(gaps))}" if len(gaps) > 1 else ""
        certified = float(np.median([answer.gap for answer in answers]))
        rows[0] += [percent(float(np.median(gaps))) + worst, percent(certified)]
        rows[1] += [percent(records.gap(name, other.cost)), percent(other.gap)]
    longest = runs["ours"][LAST][0]
    for row, bound in zip(
        rows, (longest.answer.lower_bound, at(runs["search"], LAST).bound), strict=True
    ):
        closed = (bound - program.cost) / (best - program.cost) if below > 1e-9 else None
        row.append(None if closed is None else f"{100 * max(closed, -0.99):.0f} %")
    rows[0].append(longest.cpu)
    rows[1].append(min(runs["search"][-1].cpu, LAST))
    return rows


if __name__ == "__main__":
    main()
