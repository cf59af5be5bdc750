"""Each method alone: at equal evaluations, at equal time, seeded by prices and not."""

import argparse
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from bench_data import CACHE, add_arguments
from solvers_families import Records, percent
from solvers_pictures import draw
from solvers_runs import (
    BUDGETS,
    METHODS,
    OTHERS,
    Run,
    Task,
    families_of,
    is_there,
    keep,
    kept,
    warm_up_methods,
)
from text_tables import command, heading, table

PICTURES = Path(__file__).resolve().parent.parent / "docs" / "images"
KEPT = CACHE / "solvers_alone.json"
SHOWN = (1.0,)
"""Times of tables [s]."""
Choice: TypeAlias = Callable[[list[Run]], Run | None]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    add_arguments(parser, seeds=1)
    parser.add_argument(
        "--longest", type=float, default=1.5, help="CPU time that ends runs by evaluations [s]"
    )
    parser.add_argument("--scenes", type=int, default=1, help="problems of each family")
    parser.add_argument("--methods", nargs="+", default=[*OTHERS, *METHODS])
    parser.add_argument(
        "--keep-others", action="store_true", help="take other methods' runs from the last time"
    )
    parser.add_argument("--families", nargs="+", help="names of families; left out = all")
    parser.add_argument("--pictures", type=Path, default=PICTURES)
    arguments = parser.parse_args()
    missing = [name for name in arguments.methods if not is_there(name)]
    methods = [name for name in arguments.methods if name not in missing]
    families = families_of(arguments)
    warm_up_methods(methods)
    runs = kept(KEPT, methods) if arguments.keep_others else []
    for family, problems in families.items():
        for name, problem in problems.items():
            for method in methods:
                runs += Task(family, name, problem, method, arguments.longest).runs()
    runs.sort(key=lambda run: [*OTHERS, *METHODS].index(run.method))
    keep(runs, KEPT)
    records = Records()
    for run in runs:
        records.enter(run.problem, run.cost, run.bound)
    print(heading(command("solvers_alone.py")), end="\n\n")
    if missing:
        print(f"Not there, so not run: {', '.join(missing)}.", end="\n\n")
    print(text_of(runs, list(families), records))
    for seeded in (True, False):
        draw(runs, records, arguments.pictures, seeded=seeded)


def text_of(runs: list[Run], families: list[str], records: Records) -> str:
    """Return the tables: at equal evaluations, then at equal times."""
    parts = []
    for title, choose in (
        *((f"After {n:,} evaluations per component", _after_evaluations(n)) for n in BUDGETS),
        *((f"After {seconds:g} s of CPU time", _after_time(seconds)) for seconds in SHOWN),
    ):
        rows = []
        for method, seeded in _variants(runs):
            cells = [_gap(runs, family, (method, seeded), choose, records) for family in families]
            if any(cell is not None for cell in cells):
                rows.append([_called(method, seeded), *cells])
        parts += [f"{title}:", table(["method", *families], _with_best(rows))]
    return "\n\n".join(parts)


def _variants(runs: list[Run]) -> list[tuple[str, bool]]:
    return list(dict.fromkeys((run.method, run.seeded) for run in runs))


def _called(method: str, seeded: bool) -> str:
    if method not in METHODS:
        return {"patient": "default"}.get(method, method)
    return f"{method}, {'seeded' if seeded else 'unseeded'}"


def _after_evaluations(budget: int) -> Choice:
    def choose(runs: list[Run]) -> Run | None:
        known = [run for run in runs if run.budget is not None and run.budget <= budget]
        if not known or known[-1].ended == "stopped":
            return None
        return known[-1] if known[-1].budget == budget or known[-1].is_over else None

    return choose


def _after_time(seconds: float) -> Choice:
    def choose(runs: list[Run]) -> Run | None:
        known = [run for run in runs if run.is_within(seconds)]
        return min(known, key=lambda run: run.cost) if known else None

    return choose


def _gap(
    runs: list[Run], family: str, variant: tuple[str, bool], choose: Choice, records: Records
) -> float | None:
    """Return the mean gap to the best known over a family, None where a run is missing."""
    gaps = []
    for problem in _problems(runs, family):
        own = [r for r in runs if r.problem == problem and (r.method, r.seeded) == variant]
        run = choose(own)
        if run is None:
            return None
        gaps.append(records.gap(problem, run.cost))
    return float(np.mean(gaps))


def _problems(runs: list[Run], family: str) -> list[str]:
    return list(dict.fromkeys(run.problem for run in runs if run.family == family))


def _with_best(rows: list[list[Any]]) -> list[list[Any]]:
    """Return gaps as text, the least of the searches in bold."""
    names = {_called(method, seeded) for method in METHODS for seeded in (True, False)}
    shown = [[row[0]] for row in rows]
    for column in range(1, len(rows[0]) if rows else 0):
        gaps = [row[column] for row in rows]
        searched = [row[column] for row in rows if row[0] in names and row[column] is not None]
        least = min(searched, default=math.inf)
        for row, out, gap in zip(rows, shown, gaps, strict=True):
            text = "–" if gap is None else percent(gap)
            is_best = gap is not None and row[0] in names and gap <= least + 1e-12
            out.append(f"**{text}**" if is_best else text)
    return shown


if __name__ == "__main__":
    main()
