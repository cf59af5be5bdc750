"""Deadlines at T100: how many scans keep them, and what they cost in gap, GOSPA and switches.

Wall clock: run it on a machine with nothing else to do. ``--clock cpu`` lets a busy one tell
something too; deadlines then count CPU time.
"""

import argparse
import time
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from bench_data import Bench, add_arguments, bench_of, repeats
from runs import CONFIGURATION, rows_of, tracked, warm_up
from text_tables import command, heading, table

from trackweave.trackers import pacing

mpl.use("Agg")
from matplotlib import pyplot as plt

BUDGETS = (1, 2, 5, 10, 20, 50, 100, 1000)
TARGETS = 100
LATE = 1.1
IMAGES = Path(__file__).resolve().parent.parent / "docs" / "images"
CLOCKS = {"wall": ("wall_ms", time.perf_counter), "cpu": ("cpu_ms", time.process_time)}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    add_arguments(parser, seeds=3)
    parser.add_argument("--config", type=Path, default=CONFIGURATION)
    parser.add_argument("--budgets", type=float, nargs="+", default=BUDGETS, help="ms")
    parser.add_argument("--depths", type=int, nargs="+", default=[5, 7])
    parser.add_argument("--clock", choices=CLOCKS, default="wall")
    parser.add_argument("--images", type=Path, default=IMAGES)
    arguments = parser.parse_args()
    bench, (key, clock) = bench_of(arguments), CLOCKS[arguments.clock]
    pacing.perf_counter = clock  # type: ignore[attr-defined] # so that a busy machine can tell
    warm_up(bench, arguments.config)
    found: dict[tuple[int, float | None], dict[str, float]] = {}
    for depth in arguments.depths:
        for budget in (*arguments.budgets, None):
            runs = [
                _run(bench, arguments, (depth, budget), repeat, key)
                for repeat in repeats(arguments)
            ]
            found[depth, budget] = _summary(runs, budget)
    print(heading(command("deadlines.py")), end="\n\n")
    head = ["window", "deadline ms", f"within {LATE}×", "ms, median", "99 %", "worst", "sequences",
            "stopped", "gap", "GOSPA", "switches"]  # fmt: skip
    print(table(head, [_row(*case, values) for case, values in found.items()]))
    print("\n![Gap and GOSPA against the deadline](images/deadlines.png)")
    _draw(found, arguments.images)


def _run(
    bench: Bench, arguments: argparse.Namespace, case: tuple[int, float | None], repeat: int,
    key: str,
) -> dict[str, Any]:  # fmt: skip
    """Return what a run takes and is worth."""
    (depth, budget), scene = case, bench.scene(TARGETS, 1, repeat)
    changes: dict[str, dict[str, Any]] = {"window": {"depth": depth}}
    if budget is not None:
        changes["search"] = {"deadline_ms": float(budget)}
    result = tracked(scene, arguments.config, priors=True, changes=changes)
    scans = result.run["scans"]
    judged = bench.score(scene, rows_of(result))
    return {
        "ms": [scan[key] for scan in result.run["timing"]["scans"]],
        "sequences": [scan["sequences"] for scan in scans],
        "stopped": [scan["stop_reason"] == "stopped" for scan in scans],
        "gap": [scan["gap"] for scan in scans],
        "gospa": judged["gospa"],
        "switches": judged["switches"],
    }


def _summary(runs: list[dict[str, Any]], budget: float | None) -> dict[str, float]:
    ms = np.concatenate([run["ms"] for run in runs])
    median, late, worst = np.percentile(ms, [50, 99, 100])
    within = np.nan if budget is None else float(np.mean(ms <= LATE * budget))
    means = {key: float(np.mean([run[key] for run in runs]))
             for key in ("stopped", "gap", "gospa", "switches")}  # fmt: skip
    sequences = float(np.median(np.concatenate([run["sequences"] for run in runs])))
    return {"within": within, "median": median, "late": late, "worst": worst,
            "sequences": sequences, **means}  # fmt: skip


def _row(depth: int, budget: float | None, values: dict[str, float]) -> list[Any]:
    return [
        depth,
        "none" if budget is None else f"{budget:g}",
        "–" if budget is None else f"{100 * values['within']:.1f} %",
        *(f"{values[key]:.1f}" for key in ("median", "late", "worst")),
        f"{values['sequences']:,.0f}",
        f"{100 * values['stopped']:.0f} %",
        f"{values['gap']:.4f}",
        f"{values['gospa']:.1f}",
        f"{values['switches']:.1f}",
    ]


def _draw(found: dict[tuple[int, float | None], dict[str, float]], folder: Path) -> None:
    """Draw gap and GOSPA against the deadline, without one as a dashed line."""
    figure, axes = plt.subplots(1, 2, figsize=(10, 3.6), layout="constrained")
    for axis, key, label in zip(
        axes, ("gap", "gospa"), ("mean gap", f"GOSPA [m], T{TARGETS}"), strict=True
    ):
        for depth in dict.fromkeys(depth for depth, _ in found):
            budgets = [b for d, b in found if d == depth and b is not None]
            values = [found[depth, budget][key] for budget in budgets]
            (line,) = axis.plot(budgets, values, "o-", label=f"window {depth}")
            axis.axhline(
                found[depth, None][key], linestyle="--", color=line.get_color(), alpha=0.6
            )
        axis.set_xscale("log")
        axis.set_xlabel("deadline per scan [ms]")
        axis.set_ylabel(label)
        axis.set_ylim(bottom=0.0)
        axis.grid(alpha=0.3)
        axis.legend(title="dashed: no deadline")
    folder.mkdir(parents=True, exist_ok=True)
    figure.savefig(folder / "deadlines.png", dpi=90)
    plt.close(figure)


if __name__ == "__main__":
    main()
