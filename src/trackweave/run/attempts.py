"""A run's attempts: step by step, until nothing that is told or learned is contradicted."""

import time as clock
from collections.abc import Callable
from contextlib import ExitStack
from typing import Any, TypeAlias

import numpy as np

from trackweave.config import Configuration
from trackweave.domain.tracks import TENTATIVE
from trackweave.run.consistency_checks import ConsistencyChecks
from trackweave.run.course import Attempt
from trackweave.run.record import Assigned, Rows, ScanLog
from trackweave.run.regions import Engaged
from trackweave.solvers.auto import Auto

__all__ = ["Done", "Progress", "agreed"]

Progress: TypeAlias = Callable[[int, int], None]
Done: TypeAlias = tuple[Rows, ScanLog, Assigned]

MOST_LEFT = 2
"""So many attempts that were left off are kept: what was doubted may prove right."""


class _Run:
    """An attempt, and how far it has come."""

    def __init__(self, configuration: Configuration, attempt: Attempt) -> None:
        self.configuration, self.attempt = configuration, attempt
        self.state: Any = None
        """That of the source of randomness where it was left off."""
        self._rows, self._log = Rows(attempt.settings.period), ScanLog()
        self._assigned = Assigned.nothing(len(attempt.table))
        self._confirmed: set[int] = set()
        self._doubts: dict[int, bool] = {}
        self._n_done = 0

    def go(
        self,
        doubts: ConsistencyChecks,
        search: tuple[np.random.Generator, float | None],
        progress: Progress | None,
    ) -> Done | None:
        """Go on, with randomness and a deadline; return None where something is contradicted."""
        rng, limit = search
        limit = self.attempt.settings.deadline if limit is None else limit
        with ExitStack() as stack:
            if limit is not None:
                from trackweave.run.preparing import prepare, without_pauses

                # The first scan's deadline is not for compiling.
                prepare(self.attempt.course, self.attempt.settings.search or Auto(), rng)
                stack.enter_context(without_pauses())
            return self._stepped(doubts, (rng, limit), progress)

    def _stepped(
        self,
        doubts: ConsistencyChecks,
        search: tuple[np.random.Generator, float | None],
        progress: Progress | None,
    ) -> Done | None:
        """Take all steps that are left, as ``go`` does once all is ready."""
        (rng, limit), course = search, self.attempt.course
        table, settings, assigned = self.attempt.table, self.attempt.settings, self._assigned
        # It begins a track with every report left over; those never confirmed were false alarms.
        is_nearest = settings.tracker.kind == "nearest-neighbour"
        ends = [max(scan.time for scan in scans) for scans in course.steps]
        while self._n_done < len(ends):
            scans, end = course.steps[self._n_done], ends[self._n_done]
            self._n_done += 1
            following = ends[self._n_done] if self._n_done < len(ends) else None
            cpu, wall = clock.process_time(), clock.perf_counter()
            wanted = self._rows.wants(end, following) or is_nearest
            hypothesis = course.take(scans, rng, limit, tracks=wanted)
            spent = clock.process_time() - cpu, clock.perf_counter() - wall
            self._log.add(scans, hypothesis, *spent)
            if wanted:
                self._rows.add(hypothesis.tracks, hypothesis.time)
            assigned.enter(hypothesis.final)
            self._doubts |= course.tracker.doubts
            if is_nearest:
                shown = hypothesis.tracks
                self._confirmed |= set(shown.track[shown.status != TENTATIVE].tolist())
            if progress is not None:
                progress(self._n_done, len(ends))
            if doubts.contradict(table, settings, assigned.track):
                return None
        assigned.enter(course.tracker.pending())
        assigned.drop_doubted(self._doubts)
        if doubts.contradict(table, settings, assigned.track, at_end=True):
            return None
        if is_nearest:
            assigned.drop_all_but(self._confirmed)
        return self._rows, self._log, assigned


def agreed(
    attempted: Callable[[Configuration], Attempt],
    doubts: ConsistencyChecks,
    search: "tuple[np.random.Generator, float | None, Engaged | None]",
    progress: Progress | None,
) -> tuple[Attempt, Done]:
    """Track until nothing that is told or learned is contradicted; return the last attempt."""
    rng, _, regions = search
    begin = rng.bit_generator.state
    left: list[_Run] = []
    while True:
        configuration = doubts.configuration
        known = [run for run in left if run.configuration == configuration]
        # What is found out on the way counts from the first scan on; what was doubted and proves
        # right goes on where it was left off.
        rng.bit_generator.state = known[0].state if known else begin
        run = known[0] if known else _Run(configuration, attempted(configuration))
        done = _tracked(run, doubts, search, progress)
        if done is not None:
            return run.attempt, done
        run.state = rng.bit_generator.state
        left = [each for each in left if each is not run]
        left = [] if regions is not None else [*left, run][-MOST_LEFT:]


def _tracked(
    run: _Run,
    doubts: ConsistencyChecks,
    search: "tuple[np.random.Generator, float | None, Engaged | None]",
    progress: Progress | None,
) -> Done | None:
    """Take all steps, in regions where there is an engine and more than one of them."""
    (rng, limit, regions), attempt = search, run.attempt
    found = None if regions is None else regions.followed(attempt, rng, progress)
    if found is None:
        return run.go(doubts, (rng, limit), progress)
    if doubts.contradict(attempt.table, attempt.settings, found[2].track, at_end=True):
        return None
    return found
