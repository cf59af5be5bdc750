"""A study from its file to its tables, figures and report."""

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import polars as pl

from trackweave.engine import engine_of
from trackweave.errors import InvalidInputError
from trackweave.experiments.cases import cases_of, jobs_of
from trackweave.experiments.report import figures_of, report_of, unmeasured
from trackweave.experiments.running import LOG, Log, Progress, record_of, run_jobs
from trackweave.experiments.study_file import StudyPlan, read_study
from trackweave.experiments.tables import differences_of, runs_table, summary_of
from trackweave.io.encoding import encode_table
from trackweave.io.output import OutputDirectory
from trackweave.summaries import counted

__all__ = ["MANY", "StudyResult", "place_of", "require_few", "study"]

MANY = 10_000
"""More runs than this have to be asked for."""
MOST = 10_000_000
"""More than this do not fit in memory."""


@dataclass(frozen=True, eq=False, repr=False)
class StudyResult:
    """What a study found.

    Parameters
    ----------
    runs
        A row for each run: scenario, configuration, their swept keys, piece, seed, error and
        every measure.
    summary
        Each measure's mean with its 95 % interval, a row for each point and measure.
    differences
        How far each is from the baseline, draw by draw, with its 95 % interval.
    timing
        CPU and wall-clock time of each run [s].
    report
        All of it as Markdown.
    metrics
        Measures that the report shows, the most important first.
    figures
        Pictures (PNG) by file name.
    notes
        Which measures could not be had, and why.

    Examples
    --------
    >>> import trackweave as tw
    >>> tw.StudyResult.__dataclass_fields__["runs"].name
    'runs'
    """

    runs: pl.DataFrame
    summary: pl.DataFrame
    differences: pl.DataFrame
    timing: pl.DataFrame
    report: str
    metrics: tuple[str, ...] = ()
    figures: Mapping[str, bytes] = field(default_factory=dict)
    notes: tuple[str, ...] = ()

    def __repr__(self) -> str:
        failed = int(self.runs["error"].is_not_null().sum())
        return f"StudyResult: {counted(len(self.runs), 'run')}, {failed} of them failed"

    def files(self) -> dict[str, bytes]:
        """Return the files of a study but for its log and record, by name."""
        tables = {"runs.parquet": self.runs, "summary.csv": self.summary,
                  "differences.csv": self.differences, "timing.csv": self.timing}  # fmt: skip
        told = {name: encode_table(table, name) for name, table in tables.items()}
        return {**told, **self.figures, "report.md": self.report.encode()}


def study(  # noqa: PLR0913 the one function that users call with everything
    source: str | os.PathLike[str] | Mapping[str, Any],
    out: str | os.PathLike[str] | None = None,
    *,
    engine: str = "local",
    workers: int | None = None,
    yes: bool = False,
    progress: Progress | None = None,
) -> StudyResult:
    """Run scenarios × configurations × seeds, and compare what comes out.

    Parameters
    ----------
    source
        The path of a study file (the reference page "Study files"), or a mapping of its keys.
    out
        A directory for the files of ``trackweave study``: new, empty, or that of the same study,
        which goes on where it was stopped. None to keep everything in memory.
    engine
        ``local`` for processes of this machine, ``ray`` or ``ray://HOST`` for Ray. What is found
        is the same on each.
    workers
        How many runs are carried out at a time; None for as many as there are processors.
    yes
        Whether more than 10,000 runs are meant.
    progress
        Called after each run with the number of runs done and of those that were left to do.

    Returns
    -------
    Tables, figures and a report. A run that failed is a row with its error.

    Raises
    ------
    InvalidInputError
        If a key or a value of the study cannot be used, or there are more runs than meant.
    OutputError
        If the directory holds something else.

    Examples
    --------
    >>> import trackweave as tw
    >>> tw.study({"scenarios": {"one": {}}, "configurations": {"plain": {}}})
    Traceback (most recent call last):
        ...
    trackweave.errors.InvalidInputError: study, scenarios.one: {}; expected one of file (a
    scenario file), scene (its keys) and reports (a recording)
    """
    planned = read_study(source)
    require_few(planned.runs(), planned.name, yes=yes)
    cases = list(cases_of(planned))
    jobs = jobs_of(planned, cases)
    place = place_of(planned, source, out, "study")
    limit = planned.plan.time_limit
    with engine_of(engine, workers, time_limit=limit) as pool, Log(planned, place) as log:
        run_jobs(jobs, range(len(jobs)), log, pool, progress)
    runs, timing = runs_table(planned, cases, log.found)
    tables = {"runs": runs, "timing": timing, "summary": summary_of(runs, planned),
              "differences": differences_of(runs, planned)}  # fmt: skip
    figures = figures_of(planned, runs, timing)
    found = StudyResult(**tables, report=report_of(planned, tables, list(figures)),
                        metrics=planned.plan.metrics, figures=figures,
                        notes=tuple(unmeasured(planned, runs)))  # fmt: skip
    if place is not None:
        kept = (place.path / LOG).read_bytes()
        place.write({**found.files(), LOG: kept}, {**record_of(planned), "complete": True})
    return found


def require_few(runs: int, name: str, *, yes: bool) -> None:
    """Refuse a study of more runs than anyone meant."""
    if runs > MOST:
        raise InvalidInputError(f"{name}: {runs:,} runs; expected at most {MOST:,}")
    if runs > MANY and not yes:
        raise InvalidInputError(
            f"{name}: {runs:,} runs; expected at most {MANY:,}, or --yes (from Python yes=True)"
        )


def place_of(
    planned: StudyPlan, source: Any, out: str | os.PathLike[str] | None, command: str
) -> OutputDirectory | None:
    """Return the directory for a study's files, checked before anything runs."""
    if out is None:
        return None
    if not isinstance(out, str | os.PathLike):
        raise InvalidInputError(f"out: {out!r:.80}; expected the path of a directory, or None")
    place = OutputDirectory(out, command)
    inputs = [each for scene in planned.scenes.values() for each in (scene.reports, scene.truth)]
    place.check([*inputs, None if isinstance(source, Mapping) else source])
    return place
