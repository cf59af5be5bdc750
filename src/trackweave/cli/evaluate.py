"""The command ``evaluate``."""

from pathlib import Path
from typing import Any

import numpy as np

from trackweave.cli.edge import Voice, shown
from trackweave.domain.truth import TruthTable
from trackweave.errors import InvalidInputError
from trackweave.formats.reading import load
from trackweave.io.tables import is_table_file
from trackweave.metrics import evaluate
from trackweave.run.judging import compared, doubts_on_cutoff, doubts_on_times, quality_in
from trackweave.run.judging import evaluate as evaluate_reports

__all__ = ["run_evaluate", "show_evaluation"]

MOST_TARGETS = 20
"""As many targets are listed on a terminal; all are in the JSON."""
LEAST_PRESENCE = 0.6
"""Share of the times within its life at which a target is usually there."""

# Measures that are distances.
LENGTHS = ("gospa", "ospa", "motp", "rmse", "cutoff")
OF_REPORTS = ("right_share", "report_idf1", "report_purity", "report_mota", "report_switches")


def run_evaluate(
    voice: Voice,
    truth: Path | None,
    tracks: Path | None,
    assignments: Path | None,
    told: str | None = None,
    **how: Any,
) -> dict[str, Any]:
    """Return every measure of tracks against the truth by its name, and show them."""
    if truth is None and tracks is None and assignments is not None:
        found = {**evaluate_reports(assignments=assignments).as_dict(), "notes": []}
        show_evaluation(found, voice)
        return found
    if truth is None or tracks is None:
        raise InvalidInputError(
            f"{'--truth' if truth is None else '--tracks'}: missing; expected --truth and "
            "--tracks, or --assignments alone, with a column target, for the measures of reports"
        )
    # A truth that is a table stands beside tracks of the format.
    is_beside = is_table_file(truth) and not is_table_file(tracks)
    table = load(truth, None if is_beside else told)
    true, claimed = compared(table, tracks, told)
    measures = evaluate(true, claimed, **how)
    doubts = [*doubts_on_times(true, claimed), *doubts_on_cutoff(measures, true, claimed)]
    if assignments is not None:
        measures = measures.with_assignments(quality_in(assignments))
    notes = [*table.notes, *doubts, *_notes(true)]
    found = {**measures.as_dict(), "notes": notes}
    show_evaluation(found, voice)
    return found


def _notes(truth: TruthTable) -> list[str]:
    """Return a sentence where targets are at times of their own, so that few are ever together."""
    times, moment = np.unique(truth.time, return_inverse=True)
    names, target = np.unique(truth.target.astype(str), return_inverse=True)
    first, last = np.full(names.size, times.size), np.zeros(names.size, dtype=np.int64)
    np.minimum.at(first, target, moment)
    np.maximum.at(last, target, moment)
    within_lives = int((last - first + 1).sum())
    share = len(truth) / within_lives if within_lives else 1.0
    if share >= LEAST_PRESENCE:
        return []
    return [
        f"truth: a target is there at {100 * share:.2g} % of the times within its life; at the "
        "others its track counts as false. Bring targets that have times of their own to common "
        "times first"
    ]


def show_evaluation(found: dict[str, Any], voice: Voice) -> None:
    """Show every measure, then the targets that were followed worst."""
    if not voice.on_terminal:
        _say_briefly(found, voice)
        return
    is_of_reports = found["n_times"] is None
    measures = [
        (name, shown(value, "m" if name.startswith(LENGTHS) else ""))
        for name, value in found.items()
        if not isinstance(value, list) and (name in OF_REPORTS or not is_of_reports)
    ]
    if is_of_reports:
        voice.table("Reports against targets", measures)
        return
    voice.table("Tracks against truth", measures)
    worst = sorted(found["targets"], key=lambda record: record["covered"])[:MOST_TARGETS]
    rows = [(f"target {record['target']}", _told(record)) for record in worst]
    more = len(found["targets"]) - len(rows)
    title = "Targets" if more == 0 else f"The {len(rows)} targets that were followed worst"
    voice.table(title, rows)
    if more:
        voice.say(f"{more} more targets: see --json")
    for note in found["notes"]:
        voice.say(note)


def _say_briefly(found: dict[str, Any], voice: Voice) -> None:
    """Say the measures that count most, where nobody looks at tables."""
    if found["n_times"] is None:
        told = f"report_idf1 {shown(found['report_idf1'])}, {found['report_switches']} switches"
    else:
        gospa = shown(found["gospa"], "m")
        told = f"idf1 {shown(found['idf1'])}, {found['switches']} switches, gospa {gospa}"
    voice.say(f"{told}; --json tells every measure")
    for note in found["notes"]:
        voice.say(note)


def _told(record: dict[str, Any]) -> str:
    """Return what is to be said of a target, in one line."""
    names = record["tracks"]
    tracks = ", ".join(names[:4]) + (f" and {len(names) - 4} more" if len(names) > 4 else "")
    return (
        f"tracked {record['time_tracked']:.6g} of {record['time_present']:.6g} s, "
        f"{100 * record['covered']:.1f} % of positions, "
        f"rmse {shown(record['rmse'], 'm')}, switches {record['switches']}, "
        f"fragmentations {record['fragmentations']}, tracks {tracks or '–'}"
    )
