"""What a worker does: tracks one region's reports, and those of the margin around it."""

import time as clock
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from trackweave.domain.scans import Scan
from trackweave.domain.tracks import TrackTable
from trackweave.run.course import Course
from trackweave.run.record import Assigned, Rows, ScanLog

__all__ = ["Followed", "Part", "ends_of", "follow"]


@dataclass(frozen=True, slots=True, eq=False)
class Part:
    """All that a worker needs: the tracker before its first step, and every scan of the run."""

    course: Course
    n_reports: int  # Those in the scans are numbered from 0
    period: float | None  # Least time between rows [s]
    dim: int
    rng: np.random.Generator  # The region's own


@dataclass(frozen=True, slots=True, eq=False)
class Followed:
    """What came of a region; reports and tracks under its own numbers."""

    tracks: TrackTable
    log: ScanLog
    assigned: Assigned
    cpu: float  # [s]


def follow(part: Part) -> Followed:
    """Track a region's reports, as a run does without regions."""
    begin = clock.process_time()
    course = part.course
    rows, log = Rows(part.period), ScanLog()
    assigned = Assigned.nothing(part.n_reports)
    ends = ends_of(course.steps)
    for scans, end, following in zip(course.steps, ends, [*ends[1:], None], strict=True):
        cpu, wall = clock.process_time(), clock.perf_counter()
        wanted = rows.wants(end, following)
        hypothesis = course.take(scans, part.rng, None, tracks=wanted)
        log.add(scans, hypothesis, clock.process_time() - cpu, clock.perf_counter() - wall)
        if wanted:
            rows.add(hypothesis.tracks, hypothesis.time)
        assigned.enter(hypothesis.final)
    assigned.enter(course.tracker.pending())
    return Followed(rows.table(part.dim), log, assigned, clock.process_time() - begin)


def ends_of(steps: Sequence[tuple[Scan, ...]]) -> list[float]:
    """Return when each step ends [s]."""
    return [max(scan.time for scan in scans) for scans in steps]
