"""What a run's page says beside its map: facts, notes and curves over time."""

from typing import Any

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.domain.tracks import CONFIRMED, STATUSES
from trackweave.io.run_files import RunFiles
from trackweave.plotting.scene import ScanSeries

__all__ = ["curves_of", "facts_of", "notes_of"]

MOST_POINTS = 900
MOST_NOTES = 40


def facts_of(run: RunFiles, scans: ScanSeries, stride: int) -> list[tuple[str, str]]:
    """Return names and values of what the run came to."""
    totals = run.record.get("totals", {})
    confirmed = np.unique(run.tracks.track[run.tracks.status >= CONFIRMED]).size
    facts = [("Tracks confirmed", f"{confirmed:,}"), ("Reports", f"{len(run.assignments):,}")]
    if len(run.assignments):
        share = float((run.assignments.track >= 0).mean())
        facts.append(("of them assigned", _percent(share)))
    facts.append(("Scans", f"{scans.time.size:,}"))
    if scans.time.size:
        facts.append(("proven optimal", _percent(float(scans.proven.mean()))))
    for name, key in (("Worst gap", "worst_gap"), ("Amendments", "amendments")):
        value = totals.get(key)
        if isinstance(value, int | float):
            facts.append((name, _percent(value) if key == "worst_gap" else f"{value:,}"))
    facts += [("Seed", str(run.record.get("seed"))), ("trackweave", str(run.record["trackweave"]))]
    if stride > 1:
        facts.append(("Rows drawn", f"one of {stride}"))
    return facts


def _percent(share: float) -> str:
    return f"{100 * share:.3g} %"


def notes_of(run: RunFiles) -> list[str]:
    """Return the run's notes, as many as one reads."""
    notes = run.record.get("notes")
    return [str(note) for note in notes[:MOST_NOTES]] if isinstance(notes, list) else []


def curves_of(scans: ScanSeries) -> list[dict[str, Any]]:
    """Return the curves over time: each with a title, a kind of number and its lines."""
    if scans.time.size == 0:
        return []
    known = scans.known
    times = np.unique(known.time)
    counts = []
    for status, word in enumerate(STATUSES):
        own, number = np.unique(known.time[known.status == status], return_counts=True)
        values = np.zeros(times.size)
        values[np.searchsorted(times, own)] = number
        counts.append({"name": word, "status": status, "points": _points(times, values)})
    curves = [
        {"title": "Tracks", "kind": "count", "lines": counts[::-1]},
        {
            "title": "Reports, and those assigned, per scan", "kind": "count", "lines": [
                {"name": "", "points": _points(scans.time, scans.reports)},
                {"name": "", "points": _points(scans.time, scans.assigned)},
            ],
        },
        {
            "title": "Gap to the proven bound", "kind": "share",
            "lines": [{"name": "", "points": _points(scans.time, scans.gap)}],
        },
    ]  # fmt: skip
    if scans.cpu_ms is not None:
        line = {"name": "", "points": _points(scans.time, scans.cpu_ms)}
        curves.append({"title": "CPU per scan", "kind": "ms", "lines": [line]})
    return curves


def _points(time: FloatArray, values: FloatArray) -> list[list[float | None]]:
    """Return times and values in order; of very many the greatest of each short while."""
    order = np.argsort(time, kind="stable")
    time, values = time[order], values[order]
    size = -(-time.size // MOST_POINTS) or 1
    if size > 1:
        begins = np.arange(0, time.size, size)
        time, values = time[begins], np.fmax.reduceat(values, begins)
    return [
        [round(when, 3), round(value, 6) if np.isfinite(value) else None]
        for when, value in zip(time.tolist(), values.tolist(), strict=True)
    ]
