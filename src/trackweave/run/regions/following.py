"""What a worker does: tracks one region's reports, and those of the margin around it."""

import time as clock
from collections.abc import Sequence
from dataclasses import dataclass
from typing import cast

import numpy as np
from numpy.typing import NDArray

from trackweave.arrays import IntArray
from trackweave.domain.scans import Scan
from trackweave.domain.tracks import TrackTable
from trackweave.run.course import Course
from trackweave.run.record import Assigned, Rows, ScanLog
from trackweave.run.regions.bounding import Owned, owned
from trackweave.run.regions.cutting import Region
from trackweave.trackers.multi_hypothesis import MultiHypothesisTracker

__all__ = ["Followed", "Part", "ends_of", "follow"]


@dataclass(frozen=True, slots=True, eq=False)
class Part:
    """All that a worker needs: the tracker before its first step, and every scan of the run."""

    course: Course
    region: Region
    rows: IntArray  # The numbers in the run of its reports, which have numbers from 0 here
    is_own: NDArray[np.bool_]  # Whether each lies in the region
    period: float | None  # Least time between rows [s]
    dim: int
    rng: np.random.Generator  # The region's own


@dataclass(frozen=True, slots=True, eq=False)
class Followed:
    """What came of a region; reports and tracks under its own numbers."""

    tracks: TrackTable
    log: ScanLog
    assigned: Assigned
    owned: list[Owned]  # After each step
    cpu: float  # [s]


def follow(part: Part) -> Followed:
    """Track a region's reports, as a run does without regions."""
    begin = clock.process_time()
    course = part.course
    rows, log = Rows(part.period), ScanLog()
    assigned, own = Assigned.nothing(part.is_own.size), list[Owned]()
    tracker = cast("MultiHypothesisTracker", course.tracker)
    ends = ends_of(course.steps)
    for scans, end, following in zip(course.steps, ends, [*ends[1:], None], strict=True):
        cpu, wall = clock.process_time(), clock.perf_counter()
        wanted = rows.wants(end, following)
        hypothesis = course.take(scans, part.rng, None, tracks=wanted)
        log.add(scans, hypothesis, clock.process_time() - cpu, clock.perf_counter() - wall)
        of_all = tracker.clusters(), hypothesis.certificate
        own.append(owned(*of_all, part.region, part.rows, part.is_own))
        if wanted:
            rows.add(hypothesis.tracks, hypothesis.time)
        assigned.enter(hypothesis.final)
    assigned.enter(course.tracker.pending())
    cpu = clock.process_time() - begin
    return Followed(rows.table(part.dim), log, assigned, own, cpu)


def ends_of(steps: Sequence[tuple[Scan, ...]]) -> list[float]:
    """Return when each step ends [s]."""
    return [max(scan.time for scan in scans) for scans in steps]
