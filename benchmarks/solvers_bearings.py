"""Scenes of bearings: what is found and proven after so much time, beside HiGHS."""

import argparse
from typing import Any

from solvers_families import BEARINGS, Family, Records, on_tuples, percent, solver_named, warm_up
from solvers_highs import at, columns_of_tuples, linear, mixed_integer
from text_tables import command, heading, table

LIMITS = (1.0, 3.0, 10.0)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--solver", default="default")
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
    ours = {limit: on_tuples(scored, solver, limit) for limit in LIMITS}
    columns = columns_of_tuples(scored.tuples, scored.costs)
    program = linear(columns, 60.0)[-1]
    search = mixed_integer(columns, LIMITS[-1])
    for run in ours.values():
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
        answer, other = runs["ours"][limit].answer, at(runs["search"], limit)
        rows[0] += [percent(records.gap(name, answer.cost)), percent(answer.gap)]
        rows[1] += [percent(records.gap(name, other.cost)), percent(other.gap)]
    bounds = (runs["ours"][LIMITS[-1]].answer.lower_bound, at(runs["search"], LIMITS[-1]).bound)
    for row, bound in zip(rows, bounds, strict=True):
        closed = (bound - program.cost) / (best - program.cost) if below > 1e-9 else None
        row.append(None if closed is None else f"{100 * max(closed, -0.99):.0f} %")
    rows[0].append(runs["ours"][LIMITS[-1]].cpu)
    rows[1].append(min(runs["search"][-1].cpu, LIMITS[-1]))
    return rows


if __name__ == "__main__":
    main()
