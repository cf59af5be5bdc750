"""A study's report: what was run, means, differences, failures, figures."""

from collections.abc import Collection, Mapping, Sequence
from typing import Any

import numpy as np
import polars as pl

from trackweave.experiments.study_file import OF_ITSELF, StudyPlan
from trackweave.experiments.tables import averaged, group_keys, recordings_of
from trackweave.plotting.panels_of_curves import Panel, SpreadCurve, picture_of_panels
from trackweave.studies.writing import text_table

__all__ = ["figures_of", "report_of", "unmeasured"]

MOST_ROWS = 200
"""A longer table is in its file alone."""
MOST_ERRORS = 10
WIDE = 20.0
"""A swept key whose greatest value is so many times its least is drawn by logarithms."""


def figures_of(study: StudyPlan, runs: pl.DataFrame, timing: pl.DataFrame) -> dict[str, bytes]:
    """Return a figure for each swept number, and one of quality against CPU time, by file name."""
    figures = {}
    metrics = [name for name in study.plan.metrics if runs[name].null_count() < len(runs)]
    if not metrics:
        return {}
    same = recordings_of(study)
    swept = [name for name in group_keys(runs) if "." in name and runs.schema[name].is_numeric()]
    for name in swept:
        own = runs.filter(pl.col(name).is_not_null())
        panels = [_against(own, name, metric, same) for metric in metrics]
        figures[f"by-{_file_name(name)}.png"] = picture_of_panels(panels)
    spent = runs.with_columns(timing["cpu_s"])
    figures["quality-by-cpu.png"] = picture_of_panels(
        [_by_cpu(spent, name, same) for name in metrics]
    )
    return figures


def report_of(
    study: StudyPlan,
    tables: Mapping[str, pl.DataFrame],
    figures: Sequence[str],
) -> str:
    """Return the report as Markdown, from the tables ``runs``, ``summary`` and ``differences``."""
    runs, summary, differences = (tables[name] for name in ("runs", "summary", "differences"))
    keys, plan = group_keys(runs), study.plan
    failed = runs.filter(pl.col("error").is_not_null())
    seeds = "one seed" if plan.seeds == 1 else f"{plan.seeds} seeds"
    parts = [
        "# Study",
        f"{len(runs):,} runs: {len(study.scenes)} scenario{'s' * (len(study.scenes) > 1)} × "
        f"{len(study.configurations)} configuration{'s' * (len(study.configurations) > 1)}, with "
        f"what is swept of each, × {seeds}. The same seed gives every configuration the same "
        "reports. Intervals are of 95 %, by Student's t over draws." + _alone(study, summary),
        "## Means",
        _wide(summary.filter(pl.col("metric").is_in(plan.metrics)), keys, "mean", plan.metrics),
        *unmeasured(study, runs),
    ]
    if len(differences):
        parts += [
            "## Differences",
            f"From {study.baseline}, draw by draw on the same reports; an interval without 0 "
            "tells the two apart, a number without an interval does not.",
            _wide(
                differences.filter(pl.col("metric").is_in(plan.metrics)), keys, "difference",
                plan.metrics,
            ),
        ]  # fmt: skip
    parts += ["## CPU time", _cpu(runs.with_columns(tables["timing"]["cpu_s"]), keys)]
    if figures:
        parts += ["## Figures", *(f"![{name}]({name})" for name in figures)]
    if len(failed):
        rows = failed.select(*keys, "piece", "seed", "error").head(MOST_ERRORS).rows()
        parts += [
            "## Failed",
            f"{len(failed):,} of {len(runs):,} runs failed; means are without them.",
            text_table([*keys, "piece", "seed", "error"], rows),
        ]
    return "\n\n".join(parts) + "\n"


def unmeasured(study: StudyPlan, runs: pl.DataFrame) -> list[str]:
    """Return a sentence for each scenario of which a measure to be shown was never found."""
    notes = []
    for name, scene in study.scenes.items():
        own = runs.filter(pl.col("scenario") == name, pl.col("error").is_null())
        missing = [each for each in study.plan.metrics if own[each].null_count() == len(own)]
        if not missing or own.is_empty():
            continue
        why = f"{', '.join(missing)}: not measured in any run of scenario {name}"
        if scene.reports is not None and scene.truth is None:
            why += (
                f", which has no truth; expected `truth` beside its `reports`, or `metrics` that "
                f"need none: {', '.join(OF_ITSELF)}"
            )
        notes.append(f"{why}.")
    return notes


def _alone(study: StudyPlan, summary: pl.DataFrame) -> str:
    """Return what has to be said where there is but one draw of a point, from a space on."""
    if not (summary["draws"] == 1).any():
        return ""
    why = ""
    if summary.filter(pl.col("draws") == 1)["scenario"].is_in(recordings_of(study)).any():
        why = (
            ": of a recording in one piece each seed tracks the same data, unless the search "
            "draws by chance; `pieces` makes several draws of it"
        )
    return f" One draw has none{why}."


def _wide(table: pl.DataFrame, keys: Sequence[str], value: str, metrics: Sequence[str]) -> str:
    """Return a table with a column for each measure, its interval in brackets."""
    if len(table) > MOST_ROWS * len(metrics):
        return f"{len(table) // max(1, len(metrics)):,} rows: see the file."
    rows: dict[tuple[Any, ...], dict[str, str]] = {}
    for row in table.iter_rows(named=True):
        cells = rows.setdefault(tuple(row[key] for key in keys), {})
        known = row[value] is not None and np.isfinite(row[value])
        ends = f" ({row['low']:.4g} to {row['high']:.4g})" if row["low"] is not None else ""
        cells[row["metric"]] = f"{row[value]:.4g}{ends}" if known else "–"
    body = [[*point, *(cells.get(name, "–") for name in metrics)] for point, cells in rows.items()]
    return text_table([*keys, *metrics], body)


def _cpu(runs: pl.DataFrame, keys: Sequence[str]) -> str:
    """Return what a run took; the median, as each worker's first run loads kernels."""
    spent = runs.group_by(keys, maintain_order=True).agg(pl.median("cpu_s").alias("median [s]"))
    if len(spent) > MOST_ROWS:
        return "See timing.csv."
    return text_table([*keys, "median [s]"], spent.rows())


def _against(runs: pl.DataFrame, key: str, metric: str, same: Collection[str]) -> Panel:
    """Return a measure against a swept key, averaged over whatever else is swept."""
    curves = {}
    # A scenario's key shows a curve for each configuration, and the other way round.
    by = "configuration" if key.startswith("scenario") else "scenario"
    for (name,), own in runs.group_by([by], maintain_order=True):
        points = []
        for (x,), at in own.group_by([key], maintain_order=True):
            found = averaged(at, metric, same)
            if np.isfinite(found.value):
                points.append((x, found.value, _half(found.high - found.value)))
        if points:
            curves[str(name)] = SpreadCurve(*np.array(sorted(points), dtype=float).T)
    values = runs[key].to_numpy()
    wide = values.min() > 0 and values.max() >= WIDE * values.min()
    return Panel(metric, key.partition(".")[2], metric, curves, x_logarithmic=bool(wide))


def _by_cpu(runs: pl.DataFrame, metric: str, same: Collection[str]) -> Panel:
    """Return a measure against the CPU time of a run, a mark for each configuration's points."""
    curves = {}
    for (name,), own in runs.group_by(["configuration"], maintain_order=True):
        points = []
        for _, at in own.group_by(group_keys(runs, "configuration"), maintain_order=True):
            found = averaged(at, metric, same)
            if np.isfinite(found.value) and at["cpu_s"].null_count() < len(at):
                points.append((at["cpu_s"].median(), found.value, _half(found.high - found.value)))
        if points:
            curves[str(name)] = SpreadCurve(*np.array(sorted(points), dtype=float).T)
    return Panel(metric, "CPU time of a run [s]", metric, curves, x_logarithmic=True)


def _half(width: float) -> float:
    return width if np.isfinite(width) else 0.0


def _file_name(key: str) -> str:
    return "".join(c if c.isalnum() else "-" for c in key.lower()).strip("-")
