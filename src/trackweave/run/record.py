"""What a run leaves behind scan by scan, and its record, as in run.json."""

import os
import time
from collections.abc import Collection, Container, Mapping, Sequence
from dataclasses import dataclass, field
from importlib.metadata import version
from typing import TYPE_CHECKING, Any

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.association.certificate import Status, relative_gap
from trackweave.config.fill import UNUSED, Settings
from trackweave.domain.reports import ReportTable
from trackweave.domain.scans import Scan
from trackweave.domain.tracks import TrackTable
from trackweave.trackers.hypothesis import Assignments, Hypothesis

__all__ = [
    "Assigned",
    "Rows",
    "ScanLog",
    "certainty_of",
    "record_of",
    "timing_of",
    "whole_of",
    "with_file",
    "with_seed",
]

if TYPE_CHECKING:
    from trackweave.trackers.fused_plots import FusedHypothesis


IN_A_BLOCK = 1000
"""So many scans' rows are put into one table."""


@dataclass
class Rows:
    """Rows of tracks as they become known; of scans that end together, the last word."""

    # Least time between scans after which rows are written [s], None for every scan. After the
    # last they always are.
    period: float | None = None
    _blocks: list[TrackTable] = field(default_factory=list)
    _parts: list[TrackTable] = field(default_factory=list)
    _waiting: TrackTable | None = None
    _time: float = 0.0
    _written: float | None = None

    def wants(self, time: float, following: float | None) -> bool:
        """Tell whether rows at a time are written if the next come at a following one, if any."""
        if self._waiting is not None and time > self._time:
            self._write()
        return following is None or (following > time and self._is_due(time))

    def due(self, ends: Sequence[float]) -> list[bool]:
        """Tell of steps that end at some times whether rows are written of each."""
        due, nothing = [], TrackTable.empty(2)
        for end, following in zip(ends, [*ends[1:], None], strict=True):
            due.append(self.wants(end, following))
            if due[-1]:
                self.add(nothing, end)
        return due

    def add(self, tracks: TrackTable, time: float) -> None:
        """Take the rows after a scan that ends at ``time``."""
        if self._waiting is not None and time > self._time:
            self._write()
        self._waiting, self._time = tracks, time

    def table(self, dim: int) -> TrackTable:
        """Return all rows, the last whenever they are; ``dim`` serves a run without any."""
        if self._waiting is not None:
            self._write(always=True)
        return TrackTable.concatenate([*self._blocks, *self._parts], dim)

    def _write(self, *, always: bool = False) -> None:
        if not (always or self._is_due(self._time)):
            return
        if self._waiting is not None:
            self._parts.append(self._waiting)
        if len(self._parts) >= IN_A_BLOCK:
            # A table of a row or two takes many times the room of its numbers.
            self._blocks.append(TrackTable.concatenate(self._parts, self._parts[0].dim))
            self._parts = []
        self._waiting, self._written = None, self._time

    def _is_due(self, time: float) -> bool:
        # Times are sums of periods, so that a row due may come a rounding error early.
        wait = 0.0 if self.period is None else self.period * (1 - 1e-9)
        return self._written is None or time >= self._written + wait


@dataclass(frozen=True, slots=True, eq=False)
class Assigned:
    """The track of each row of the reports, and how probable that is."""

    track: IntArray  # -1 for a false alarm, shape (reports,)
    probability: FloatArray  # NaN where the method tells none, shape (reports,)

    @classmethod
    def nothing(cls, n_reports: int) -> "Assigned":
        """Return the state before the first scan: every report a false alarm."""
        return cls(np.full(n_reports, -1, dtype=np.int64), np.full(n_reports, np.nan))

    def enter(self, known: Assignments) -> None:
        """Enter what a tracker says of some reports."""
        self.track[known.report] = known.track
        self.probability[known.report] = known.probability

    def at(self, place: IntArray) -> "Assigned":
        """Return what is known of rows, some of which may be asked for again."""
        return Assigned(self.track[place], self.probability[place])

    def drop_all_but(self, known: Container[int]) -> None:
        """Make false alarms of the reports of tracks that are not among those known."""
        self.drop([track for track in np.unique(self.track).tolist() if track not in known])

    def drop_doubted(self, doubts: Mapping[int, bool]) -> None:
        """Make false alarms of the reports of tracks that were in doubt to their end."""
        self.drop([track for track, is_doubted in doubts.items() if is_doubted])

    def drop(self, tracks: Collection[int]) -> None:
        """Make false alarms of the reports of some tracks."""
        dropped = np.isin(self.track, np.fromiter(tracks, dtype=np.int64))
        self.track[dropped] = -1
        self.probability[dropped] = np.nan

    def by_row(self) -> dict[int, int]:
        """Return the track of each row that has one."""
        rows = np.flatnonzero(self.track >= 0)
        return dict(zip(rows.tolist(), self.track[rows].tolist(), strict=True))


@dataclass
class ScanLog:
    """What each scan cost and how sure its answer is."""

    scans: list[dict[str, Any]] = field(default_factory=list)
    amendments: list[dict[str, Any]] = field(default_factory=list)
    timing: list[dict[str, float]] = field(default_factory=list)
    late: list[int] = field(default_factory=list)
    n_thinned: int = 0
    """Instants at which tuples had to be left out."""
    n_crowded: int = 0
    """Scans in which gates held more reports than a sequence can look at."""

    def add(self, scans: Sequence[Scan], hypothesis: Hypothesis, cpu: float, wall: float) -> None:
        """Enter a scan or those of an instant, the hypothesis after, and the time it took [s]."""
        certificate, pruned = hypothesis.certificate, hypothesis.pruned_probability
        time = max(scan.time for scan in scans)
        fused = {}
        plots = _of_plots(hypothesis)
        if plots is not None:
            fused = {"tuples": plots.n_tuples, "fused": plots.n_fused}
            self.n_thinned += not plots.is_complete
        self.n_crowded += hypothesis.is_crowded
        self.scans.append(
            {
                "time": time,
                "sensor": "+".join(dict.fromkeys(scan.sensor for scan in scans)),
                "reports": sum(len(scan) for scan in scans),
                **fused,
                "tracks": hypothesis.n_tracks,
                "sequences": hypothesis.n_sequences,
                "pruned": hypothesis.n_pruned,
                "pruned_by_deadline": hypothesis.n_pruned_by_deadline,
                "pruned_probability": None if pruned is None else pruned._asdict(),
                "evaluations": hypothesis.evaluations,
                "cost": certificate.cost,
                "lower_bound": certificate.lower_bound,
                "gap": certificate.gap,
                "deadline_gap": hypothesis.deadline_gap,
                "status": certificate.status,
                "stop_reason": hypothesis.stop_reason,
                "amendments": len(hypothesis.amendments),
            }
        )
        self.amendments += [
            {
                "time": time,
                "report": amendment.report,
                "before": amendment.before,
                "after": amendment.after,
            }
            for amendment in hypothesis.amendments
        ]
        self.late += hypothesis.late
        self.timing.append({"cpu_ms": round(cpu * 1e3, 3), "wall_ms": round(wall * 1e3, 3)})

    def notes(self) -> list[str]:
        """Return sentences on what had to be left out because there was too much, if anything."""
        notes = []
        if self.n_thinned:
            notes.append(
                f"plots.max_tuples: at {self.n_thinned} of {len(self.scans)} instants more tuples "
                "lie in the gate; plots were joined with their nearest only, and nothing is "
                "proven there"
            )
        if self.n_crowded:
            notes.append(
                f"growth: at {self.n_crowded} of {len(self.scans)} scans more reports lie in a "
                "gate than a sequence can try; only the nearest were tried, and no bound speaks "
                "of the others"
            )
        return notes


def _of_plots(hypothesis: Hypothesis) -> "FusedHypothesis | None":
    """Return a hypothesis as one of fused plots, None where no plots were fused."""
    if type(hypothesis) is Hypothesis:
        return None
    from trackweave.trackers.fused_plots import FusedHypothesis

    return hypothesis if isinstance(hypothesis, FusedHypothesis) else None


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
        # What was told and not used stands first.
        "notes": sorted(settings.notes, key=lambda note: not note.startswith(UNUSED)),
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


def whole_of(cpu: float, wall: float) -> dict[str, float]:
    """Return what a run took that began when the clocks of CPU and wall told so [ms]."""
    return {
        "run_cpu_ms": round(1e3 * (time.process_time() - cpu), 3),
        "run_wall_ms": round(1e3 * (time.perf_counter() - wall), 3),
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
