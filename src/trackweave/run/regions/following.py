"""What a worker does: tracks one region's reports, and those of the margin around it."""

import time as clock
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from trackweave.arrays import IntArray
from trackweave.association.certificate import Status
from trackweave.domain.scans import Scan
from trackweave.domain.tracks import TrackTable
from trackweave.run.course import Course
from trackweave.run.record import Assigned, Rows, ScanLog
from trackweave.run.regions.bounding import Owned, owned
from trackweave.run.regions.cutting import Region
from trackweave.trackers.multi_hypothesis import MultiHypothesisTracker

__all__ = ["Followed", "Part", "ends_of", "follow"]


QUIET: dict[str, Any] = {
    "pruned": 0, "pruned_by_deadline": 0, "pruned_probability": None, "evaluations": 0,
}  # fmt: skip
"""What a step says in which nothing looked at the region."""
NOTHING = Owned(0.0, 0.0, Status.OPTIMAL)


@dataclass(frozen=True, slots=True, eq=False)
class Part:
    """All that a worker needs: the tracker before its first step, and what looks at the region."""

    course: Course  # Of all steps of the run, some of which look elsewhere and have no scans
    passed: Sequence[tuple[tuple[str, float], ...]]  # Sensors that do in each step, until when [s]
    ends: Sequence[float]  # Of the steps [s]
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
    doubts: dict[int, bool] = {}
    tracker = cast("MultiHypothesisTracker", course.tracker)
    after = [*part.ends[1:], None]
    steps = zip(course.steps, part.passed, part.ends, after, strict=True)
    for scans, elsewhere, end, following in steps:
        for sensor, until in elsewhere:
            tracker.pass_over(sensor, until)
        if not scans:
            log.scans.append({**QUIET, "sequences": log.scans[-1]["sequences"] if own else 0})
            log.timing.append({"cpu_ms": 0.0, "wall_ms": 0.0})
            own.append(own[-1] if own else NOTHING)
            continue
        cpu, wall = clock.process_time(), clock.perf_counter()
        wanted = rows.wants(end, following)
        hypothesis = course.take(scans, part.rng, None, tracks=wanted)
        log.add(scans, hypothesis, clock.process_time() - cpu, clock.perf_counter() - wall)
        of_all = tracker.clusters(), hypothesis.certificate
        own.append(owned(*of_all, part.region, part.rows, part.is_own))
        if wanted:
            rows.add(hypothesis.tracks, hypothesis.time)
        assigned.enter(hypothesis.final)
        doubts |= tracker.doubts
    assigned.enter(course.tracker.pending())
    assigned.drop_doubted(doubts)
    cpu = clock.process_time() - begin
    return Followed(rows.table(part.dim), log, assigned, own, cpu)


def ends_of(steps: Sequence[tuple[Scan, ...]]) -> list[float]:
    """Return when each step ends [s]."""
    return [max(scan.time for scan in scans) for scans in steps]
