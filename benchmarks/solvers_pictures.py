"""Quality against time: a panel for each family of problems."""

from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from solvers_families import Records
from solvers_runs import METHODS, OTHERS, Run

mpl.use("Agg")
from matplotlib import pyplot as plt

COLUMNS = 3
COLOURS = dict(zip(METHODS, plt.get_cmap("tab10").colors, strict=False))
MARKS = dict(zip(OTHERS, "v^s*", strict=True))
HOW = {
    True: ("solvers-seeded", "Searches that start from the dual's prices and answer"),
    False: ("solvers-unseeded", "Searches that start from nothing"),
}


def draw(runs: list[Run], records: Records, folder: Path, *, seeded: bool) -> None:
    """Draw how far each method is from the best known after how much CPU time."""
    name, title = HOW[seeded]
    chosen = [run for run in runs if run.method in OTHERS or run.seeded == seeded]
    families = list(dict.fromkeys(run.family for run in chosen))
    n_rows = -(-len(families) // COLUMNS)
    figure, axes = plt.subplots(
        n_rows, COLUMNS, figsize=(14, 3.4 * n_rows), squeeze=False, layout="constrained"
    )
    for axis in axes.flat[len(families) :]:
        axis.axis("off")
    for axis, family in zip(axes.flat, families, strict=False):
        _draw_panel(axis, [run for run in chosen if run.family == family], records)
        axis.set_title(family)
    handles: dict[str, Any] = {}
    for axis in axes.flat:
        lines, labels = axis.get_legend_handles_labels()
        handles.update(zip(labels, lines, strict=True))
    figure.suptitle(f"{title}: above the best known against CPU time")
    figure.legend(list(handles.values()), list(handles), loc="outside lower center", ncols=6)
    folder.mkdir(parents=True, exist_ok=True)
    figure.savefig(folder / f"{name}.png", dpi=80)
    plt.close(figure)


def _draw_panel(axis: Any, runs: list[Run], records: Records) -> None:
    for method in dict.fromkeys(run.method for run in runs):
        x, y = _curve([run for run in runs if run.method == method], records)
        if method in METHODS:
            axis.plot(x, y, "o-", color=COLOURS[method], label=method, markersize=4, linewidth=1.5)
        else:
            style = "full" if method == "patient" else "none"
            label = "default" if method == "patient" else method
            axis.plot(
                x, y, MARKS[method] + ":", color="black", label=label, markersize=9,
                fillstyle=style, linewidth=1,
            )  # fmt: skip
    axis.set_xscale("log")
    axis.set_xlim(3e-4, 2.0)
    axis.set_yscale("symlog", linthresh=1e-3)
    axis.set_ylim(-3e-4, 200)
    axis.set_yticks([0, 1e-3, 1e-2, 0.1, 1, 10, 100])
    axis.set_yticklabels(["0", "0.001", "0.01", "0.1", "1", "10", "100"])
    axis.set_xlabel("CPU time [s]")
    axis.set_ylabel("above the best known [%]")
    axis.grid(alpha=0.3)


def _curve(runs: list[Run], records: Records) -> tuple[list[float], list[float]]:
    """Return a method's mean CPU times and gaps [%], one for each time that it was given."""
    problems = dict.fromkeys(run.problem for run in runs)
    x, y = [], []
    for limit in sorted({run.limit for run in runs if run.limit is not None}):
        known = [run for run in runs if run.is_within(limit)]
        best = [
            min((run for run in known if run.problem == problem), key=lambda r: (r.cost, r.cpu))
            for problem in problems
        ]
        over = [all(r.is_over for r in known if r.problem == problem) for problem in problems]
        cpu = [run.cpu if is_over else limit for run, is_over in zip(best, over, strict=True)]
        x.append(float(np.mean(cpu)))
        y.append(100 * float(np.mean([records.gap(run.problem, run.cost) for run in best])))
    return x, y
