"""Tables of a study: every run, means with intervals, differences in pairs."""

import json
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import polars as pl

from trackweave.experiments.cases import Case
from trackweave.experiments.study_file import MEASURES, StudyPlan
from trackweave.experiments.sweeps import Path
from trackweave.studies.judging import Interval, mean_of
from trackweave.studies.writing import numbers

__all__ = [
    "TIMES", "averaged", "differences_of", "group_keys", "recordings_of", "runs_table",
    "summary_of",
]  # fmt: skip

TIMES = ("cpu_s", "all_cpu_s", "wall_s")
REPLICATE = ("piece", "seed")
"""What tells draws of the same points apart: configurations share them."""
OF_BASELINE = " of baseline"


def runs_table(
    study: StudyPlan, cases: Sequence[Case], found: Mapping[int, Mapping[str, Any]]
) -> tuple[pl.DataFrame, pl.DataFrame]:
    """Return a row for each run that there is, with its measures; and what each took."""
    # What a run measured is the same whenever and wherever it runs; what it took is not.
    numbers_of = sorted(found)
    columns: dict[str, list[Any]] = {"run": numbers_of}
    own = [cases[number] for number in numbers_of]
    columns["scenario"] = [case.scenario for case in own]
    for prefix, sides, point in (
        ("scenario", study.scenes, lambda case: case.scene),
        ("configuration", study.configurations, lambda case: case.point),
    ):
        if prefix == "configuration":
            columns[prefix] = [case.configuration for case in own]
        keys = dict.fromkeys(key for each in sides.values() for key in each.sweep.keys)
        for key in keys:
            columns[f"{prefix}.{'.'.join(key)}"] = _cells(own, key, point)
    columns |= {"piece": [case.piece for case in own], "seed": [case.seed for case in own]}
    names = pl.DataFrame(columns, strict=False)
    runs = [found[number] for number in numbers_of]
    measures = {
        name: pl.Series([(run.get("measures") or {}).get(name) for run in runs], dtype=pl.Float64)
        for name in MEASURES
    }
    errors = pl.Series("error", [run.get("error") for run in runs], dtype=pl.String)
    times = {
        name: pl.Series([(run.get("timing") or {}).get(name) for run in runs], dtype=pl.Float64)
        for name in TIMES
    }
    return names.with_columns(errors).with_columns(**measures), names.with_columns(**times)


def _cells(cases: Sequence[Case], key: Path, point: Callable[[Case], Any]) -> list[Any]:
    """Return a swept key's values: numbers where all are, else text."""
    values = [point(case).get(key) for case in cases]
    kinds = {type(value) for value in values if value is not None}
    if kinds <= {int, float}:
        return [None if value is None else float(value) for value in values]
    is_plain = len(kinds) == 1 and kinds <= {str, bool}
    return values if is_plain else [None if v is None else _text(v) for v in values]


def _text(value: Any) -> str:
    return value if isinstance(value, str) else json.dumps(value)


def group_keys(runs: pl.DataFrame, side: str | None = None) -> list[str]:
    """Return the columns that name a point: of scenarios, of configurations, or of both."""
    sides = ("scenario", "configuration") if side is None else (side,)
    return [name for name in runs.columns if name.partition(".")[0] in sides]


def averaged(own: pl.DataFrame, metric: str, recordings: Collection[str]) -> Interval:
    """Return a measure's mean over draws, with its 95 % interval; open where there is one draw."""
    # Of a recording in several pieces the pieces are the draws, each averaged over its seeds: on
    # the same piece seeds tell of the search alone.
    by = "piece" if own["piece"].n_unique() > 1 else "seed"
    known = own.filter(pl.col(metric).is_not_null())
    if known["scenario"].is_in(recordings).all():
        known = _without_repeats(known)
    return mean_of(numbers(known.group_by(by, maintain_order=True).agg(pl.mean(metric)), metric))


def _without_repeats(own: pl.DataFrame) -> pl.DataFrame:
    """Return runs of recordings, once each where their seeds change nothing."""
    # Each seed tracks the same data. Where no measure has noticed which one it was, that of the
    # baseline neither, nothing was drawn; a search that draws by chance shows in some.
    measures = [name for name in own.columns if name.removesuffix(OF_BASELINE) in MEASURES]
    points = [*group_keys(own), "piece"]
    once = own.unique(points, keep="first", maintain_order=True)
    if len(own.unique([*points, *measures])) > len(once):
        return own
    return once.with_columns(seed=pl.lit(0))


def recordings_of(study: StudyPlan) -> frozenset[str]:
    """Return the names of scenarios whose reports are the same with every seed."""
    return frozenset(name for name, scene in study.scenes.items() if scene.reports is not None)


def summary_of(runs: pl.DataFrame, study: StudyPlan) -> pl.DataFrame:
    """Return each measure's mean with its interval, a row for each point and measure."""
    keys, same = group_keys(runs), recordings_of(study)
    rows = []
    for point, own in runs.group_by(keys, maintain_order=True):
        failed = own["error"].is_not_null().sum()
        for metric in _measured(runs):
            rows.append((*point, metric, *_ends(averaged(own, metric, same)), failed))
    return _rows(runs, keys, rows, ("metric", "mean", "low", "high", "draws", "failed"))


def differences_of(runs: pl.DataFrame, study: StudyPlan) -> pl.DataFrame:
    """Return how much each point's measures are above the baseline's, draw by draw."""
    # The draws are those of the same scenario, piece and seed, whose reports are the same; what
    # they share cancels out, so that intervals are narrower than those of the means. The baseline
    # is the first point of its configuration.
    keys, scene, same = group_keys(runs), group_keys(runs, "scenario"), recordings_of(study)
    way = group_keys(runs, "configuration")
    base = runs.filter(configuration=study.baseline)
    first = base.select(way).unique(maintain_order=True).head(1)
    base = base.join(first, on=way, nulls_equal=True)
    metrics = _measured(runs)
    both = runs.join(base.select(*scene, *REPLICATE, *metrics), on=[*scene, *REPLICATE],
                     how="left", suffix=OF_BASELINE, nulls_equal=True,
                     maintain_order="left")  # fmt: skip
    both = both.join(first, on=way, how="anti", nulls_equal=True, maintain_order="left")
    less = {name: pl.col(name) - pl.col(f"{name}{OF_BASELINE}") for name in metrics}
    rows = []
    for point, own in both.with_columns(**less).group_by(keys, maintain_order=True):
        for metric in metrics:
            rows.append((*point, metric, *_ends(averaged(own, metric, same))))
    return _rows(runs, keys, rows, ("metric", "difference", "low", "high", "draws"))


def _measured(runs: pl.DataFrame) -> list[str]:
    """Return the measures that at least one run has."""
    return [name for name in MEASURES if runs[name].null_count() < len(runs)]


def _ends(found: Interval) -> Iterator[Any]:
    yield found.value
    # One draw has no interval: its cells are empty.
    yield from (end if np.isfinite(end) else None for end in (found.low, found.high))
    yield found.count


def _rows(
    runs: pl.DataFrame, keys: Sequence[str], rows: Sequence[Sequence[Any]], head: Sequence[str]
) -> pl.DataFrame:
    kinds = {"metric": pl.String(), "draws": pl.Int64(), "failed": pl.Int64()}
    schema: dict[str, pl.DataType] = {name: runs.schema[name] for name in keys}
    schema |= {name: kinds.get(name, pl.Float64()) for name in head}
    return pl.DataFrame(rows, schema=schema, orient="row")
