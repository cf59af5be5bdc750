"""The commands that run many runs: studies of a user's own."""

from pathlib import Path
from typing import Annotated

import typer

from trackweave.cli.edge import done_by
from trackweave.cli.options import JsonOption, OutOption, QuietOption, required

__all__ = ["study", "tune"]

StudyArgument = Annotated[Path, required("STUDY", "Study (TOML): scenarios, configurations.")]
EngineOption = Annotated[
    str,
    typer.Option(help="local (processes of this machine), ray, or ray://HOST for its cluster."),
]
WorkersOption = Annotated[
    int | None,
    typer.Option(help="Runs at a time; left out, as many as there are processors."),
]


@done_by("study.run_study_file")
def study(
    source: StudyArgument,
    out: OutOption,
    engine: EngineOption = "local",
    workers: WorkersOption = None,
    yes: Annotated[bool, typer.Option("--yes", help="More than 10,000 runs are meant.")] = False,
    json: JsonOption = False,
    quiet: QuietOption = False,
) -> None:
    """Run scenarios × configurations × seeds and compare what comes out.

    Writes runs.parquet (a row for each run), summary.csv (means with 95 % intervals),
    differences.csv (in pairs on the same reports), timing.csv, figures, report.md and run.json.
    A run that fails is a row with its error. With the directory of the same study, goes on where
    it was stopped.
    """


@done_by("study.run_tuning")
def tune(
    source: StudyArgument,
    out: OutOption,
    engine: EngineOption = "local",
    workers: WorkersOption = None,
    yes: Annotated[bool, typer.Option("--yes", help="More than 10,000 runs are meant.")] = False,
    json: JsonOption = False,
    quiet: QuietOption = False,
) -> None:
    """Search a configuration's swept keys for what is best, by successive halving.

    By the likelihood of reports as predicted from the scans before, which needs no truth, or by
    a measure where there is truth: the study's table [tune] says which. Writes tuned.toml (for
    `track --config`), trials.csv, report.md and run.json. With the directory of the same search,
    goes on where it was stopped.
    """
