"""The commands ``study`` and ``tune``."""

from pathlib import Path
from time import perf_counter
from typing import Any

from trackweave.cli.edge import Voice, shown
from trackweave.errors import InvalidInputError
from trackweave.experiments import study, tune

__all__ = ["run_study_file", "run_tuning"]

MOST_ROWS = 40
"""As many points are listed on a terminal; all are in the files."""


def run_study_file(
    voice: Voice, source: Path, out: Path, *, engine: str, workers: int | None, yes: bool
) -> dict[str, Any]:
    """Run a study, or the rest of it, and write its files; return how many runs there are."""
    begin = perf_counter()
    with voice.progress("studying") as progress:
        found = study(source, out, engine=engine, workers=workers, yes=yes, progress=progress)
    failed = int(found.runs["error"].is_not_null().sum())
    first = found.summary.filter(metric=found.metrics[0])
    points = first.columns[: first.columns.index("metric")]
    voice.table(
        f"Mean {found.metrics[0]}",
        [
            (
                ", ".join(str(row[name]) for name in points if row[name] is not None),
                shown(row["mean"])
                + (
                    "" if row["low"] is None else f" ({shown(row['low'])} to {shown(row['high'])})"
                ),
            )
            for row in first.head(MOST_ROWS).iter_rows(named=True)
        ],
    )
    for note in found.notes:
        voice.say(note)
    voice.say(f"{len(found.runs):,} runs, {failed:,} of them failed: {out / 'report.md'}")
    if failed == len(found.runs):
        why = found.runs["error"][0]
        raise InvalidInputError(f"{source}: every run failed, the first with: {why}")
    return {
        "runs": len(found.runs),
        "failed": failed,
        "summary": first.to_dicts(),
        "notes": list(found.notes),
        "report": str(out / "report.md"),
        "time_s": perf_counter() - begin,
        "out": str(out),
    }


def run_tuning(
    voice: Voice, source: Path, out: Path, *, engine: str, workers: int | None, yes: bool
) -> dict[str, Any]:
    """Search for the best keys, or go on with it, and write its files; return the best."""
    begin = perf_counter()
    with voice.progress("searching") as progress:
        found = tune(source, out, engine=engine, workers=workers, yes=yes, progress=progress)
    best = found.trials.row(0, named=True)
    voice.results(f"The best of {len(found.trials) - 1} candidates", best)
    use = f"track with --config {out / 'tuned.toml'}"
    if not found.best:
        use = "nothing that was tried is better than the usual values"
    voice.say(f"{use}; how it was found: {out / 'report.md'}")
    return {
        "best": found.best,
        "preset": found.preset,
        "trials": found.trials.to_dicts(),
        "report": str(out / "report.md"),
        "time_s": perf_counter() - begin,
        "out": str(out),
    }
