"""The record of a run, as in run.json."""

import os
from collections.abc import Collection, Mapping, Sequence
from importlib.metadata import version
from typing import Any

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.association.certificate import Status, relative_gap
from trackweave.config.fill import Settings
from trackweave.domain.reports import ReportTable
from trackweave.run.collect import ScanLog

__all__ = ["certainty_of", "record_of", "timing_of", "with_file", "with_seed"]


def record_of(
    reports: ReportTable,
    settings: Settings,
    log: ScanLog,
    assignment: Mapping[int, int],
    merged: Collection[int],
) -> dict[str, Any]:
    """Return the record of a run, for JSON, but for the seed."""
    # Only ``timing`` differs from run to run with the same seed. ``merged`` are the rows of
    # reports that may be of two objects at once.
    return {
        "trackweave": version("trackweave"),
        "seed": None,
        "configuration": settings.values,
        "sources": settings.sources,
        "notes": list(settings.notes),
        "input": _input(reports),
        "totals": {
            "reports": len(reports),
            "assigned_reports": len(assignment),
            "late_reports": len(log.late),
            "skipped_rows": len(reports.skipped),
            "undecoded_records": reports.undecoded.count,
            "merged_reports": len(merged),
            "scans": len(log.scans),
            "empty_scans": sum(scan["reports"] == 0 for scan in log.scans),
            "tracks": len(set(assignment.values())),
            "amendments": len(log.amendments),
            "evaluations": sum(scan["evaluations"] for scan in log.scans),
            **certainty_of(log.scans, "scans"),
            **_pruning(log),
            **_haste(log),
        },
        "late_reports": [str(reports.report[row]) for row in log.late],
        "skipped_rows": [
            {"row": bad.row, "column": bad.column, "found": bad.found, "expected": bad.expected}
            | ({"file": bad.file} if bad.file else {})
            for bad in reports.skipped
        ],
        "undecoded_records": [
            {"offset": each.offset, "what": each.what} for each in reports.undecoded.listed
        ],
        "scans": log.scans,
        "amendments": [
            {**amendment, "report": str(reports.report[amendment["report"]])}
            for amendment in log.amendments
        ],
        "timing": timing_of(log.timing),
    }


def timing_of(entries: Sequence[Mapping[str, float]]) -> dict[str, Any]:
    """Return what all scans or updates took [ms], and each."""
    return {
        "cpu_ms": round(sum(entry["cpu_ms"] for entry in entries), 3),
        "wall_ms": round(sum(entry["wall_ms"] for entry in entries), 3),
        # The median, because the first scan of a fresh installation compiles.
        "median_cpu_ms": float(np.median([entry["cpu_ms"] for entry in entries])),
        "scans": entries,
    }


def certainty_of(entries: Sequence[Mapping[str, Any]], what: str) -> dict[str, Any]:
    """Return how sure the answers of scans or updates are."""
    # ``what`` names scans or updates in the plural; distances are in nats, and None where nothing
    # is known. A cost near zero makes a large gap of a small distance: so costs are the weights of
    # the mean.
    cost, bound, gap = (
        np.array([entry[key] for entry in entries], dtype=float)
        for key in ("cost", "lower_bound", "gap")
    )
    known = np.isfinite(cost) & np.isfinite(bound)
    size, distance = np.abs(cost[known]), np.maximum(cost[known] - bound[known], 0.0)
    gap = gap[np.isfinite(gap)]
    return {
        f"proven_{what}": sum(entry["status"] == Status.OPTIMAL for entry in entries),
        "mean_gap": _mean_gap(size, distance) if size.size else None,
        "worst_gap": float(gap.max()) if gap.size else None,
        "worst_distance": float(distance.max()) if distance.size else None,
    }


def _mean_gap(size: FloatArray, distance: FloatArray) -> float:
    return relative_gap(float(size.sum()), float(size.sum() - distance.sum()))


def with_file(
    record: dict[str, Any], *paths: str | os.PathLike[str], told: str | None = None
) -> dict[str, Any]:
    """Return a record with the files of the reports, as given, and their format where told."""
    names = [str(path) for path in paths]
    source = {"file": names[0] if len(names) == 1 else names}
    return {**record, "input": {**record["input"], **source, "format": told}}


def with_seed(
    record: dict[str, Any], seed: int | None, source: str | None = None
) -> dict[str, Any]:
    """Return a record with the seed, None for a generator, and its source if not the usual."""
    sources = dict(record["sources"])
    if source is not None:
        sources["seed"] = source
    configuration = {**record["configuration"], "seed": seed}
    return {**record, "seed": seed, "configuration": configuration, "sources": sources}


def _input(reports: ReportTable) -> dict[str, Any]:
    frame = reports.frame
    return {
        "file": None,
        "format": None,
        "sensors": list(reports.sensors),
        "dimensions": reports.dim,
        "first_time": float(reports.time[0]),
        "last_time": float(reports.time[-1]),
        "frame_origin": None if frame is None else [frame.latitude_deg, frame.longitude_deg],
        "frame_projection": None if frame is None else frame.projection,
    }


def _haste(log: ScanLog) -> dict[str, Any]:
    """Return what deadlines cost: scans cut short, sequences left out, mean and worst gap."""
    gaps = [scan["deadline_gap"] for scan in log.scans if scan["deadline_gap"] is not None]
    finite = [gap for gap in gaps if np.isfinite(gap)]
    return {
        "scans_cut_short": sum(gap > 0.0 for gap in gaps),
        "pruned_by_deadline": sum(scan["pruned_by_deadline"] for scan in log.scans),
        "mean_deadline_gap": float(np.mean(finite)) if finite else None,
        "worst_deadline_gap": float(max(finite)) if finite else None,
    }


def _pruning(log: ScanLog) -> dict[str, Any]:
    """Return how many answers are best of what was kept alone, and the worst share cut off."""
    told = [scan["pruned_probability"] for scan in log.scans]
    among = [scan["status"] == Status.OPTIMAL_AMONG_KEPT for scan in log.scans]
    return {
        "scans_optimal_among_kept": sum(among),
        "worst_pruned_probability": max((each["worst"] for each in told if each), default=None),
    }
