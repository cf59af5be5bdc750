"""Regions given to workers and put together again, in place of a run's steps."""

import time as clock
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass, field, replace
from itertools import compress
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackweave.arrays import FloatArray, IntArray
from trackweave.config.fill import Settings
from trackweave.domain.reports import ReportTable
from trackweave.domain.scans import Scan
from trackweave.domain.tracks import TrackTable
from trackweave.engine import EngineError, Pool, engine_of
from trackweave.errors import InvalidInputError
from trackweave.randomness import generator_for
from trackweave.run.course import Attempt
from trackweave.run.history import smoothed_history
from trackweave.run.record import Assigned, Rows, ScanLog
from trackweave.run.regions.bounding import UNKNOWN, together
from trackweave.run.regions.cutting import (
    Region,
    cut,
    margin_of,
    part_of,
    positions_of,
    unplaced_sensors,
    why_whole,
)
from trackweave.run.regions.following import Followed, Part, ends_of, follow
from trackweave.run.regions.joining import Found, Key, joined_rows, owned_tracks, same_objects
from trackweave.run.regions.sight import Looks
from trackweave.run.regions.smoothing import smoothed_on

__all__ = ["Engaged", "engaged", "require_cuttable"]

ONE_REGION = "engine: the recording is one region, tracked without workers"
Progress = Callable[[int, int], None]


@dataclass
class Engaged:
    """The engine of a run, and what there is to tell of its regions."""

    name: str
    workers: int
    pool: Pool
    record: dict[str, Any] = field(default_factory=dict)
    timing: dict[str, Any] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)

    def followed(
        self, attempt: Attempt, rng: np.random.Generator, progress: Progress | None
    ) -> tuple[Rows, ScanLog, Assigned] | None:
        """Track all regions of a recording; None where it is one, which needs no worker."""
        begin = clock.process_time()
        _require_places(attempt)
        table, steps = attempt.table, attempt.course.steps
        position = positions_of(table, attempt.settings)
        margin = margin_of(table, attempt.settings, steps)
        step, scan = _taken_in(steps, len(table))
        regions = cut(position, margin, step)
        self.record = {"engine": self.name, "count": len(regions), "margin": margin, "list": []}
        self.timing, self.notes = {}, []
        if len(regions) == 1:
            self.notes = [f"{ONE_REGION}, as {why_whole(position, margin)}"]
            return None
        seed = int(rng.integers(2**62))
        found: list[Found] = []
        done: list[Followed] = []
        looked = [np.flatnonzero(each.wider(margin).holds(position)) for each in regions]
        looks = Looks.of([each for scans in steps for each in scans], attempt.settings.sensors)
        # Rows are of all regions at once.
        looks.is_needed[_due(attempt)] = True
        for number, (region, rows) in enumerate(zip(regions, looked, strict=True)):
            chance = generator_for(seed, f"region {number}")
            # A track may stray beyond the margin; its object is another region's by then.
            seen = looks.into(region.wider(2.0 * margin))
            seen[scan[rows]] = True
            part = _part(attempt, (rows, seen), region, position, chance)
            self.pool.submit(follow, part)
        cut_cpu = clock.process_time() - begin
        for number, outcome in enumerate(self.pool.gather()):
            self._note(number, looked[number].size, outcome.error)
            if outcome.error is None:
                own: Followed = outcome.value
                track = own.assigned.track
                found.append(Found(regions[number], number, looked[number], track, own.tracks))
                done.append(own)
            if progress is not None:
                progress(number + 1, len(regions))
        if not found:
            why = self.record["list"][0]["error"]
            raise EngineError(f"engine: no region could be tracked, the first because of: {why}")
        begin = clock.process_time()
        joined = _joined(attempt, (found, done), _owner(regions, position))
        self.record["joined"] = joined[3]
        self.timing = {
            "regions_cpu_ms": [round(each.cpu * 1e3, 3) for each in done],
            "cutting_cpu_ms": round(cut_cpu * 1e3, 3),
            "joining_cpu_ms": round((clock.process_time() - begin) * 1e3, 3),
        }
        return joined[:3]

    def smoothed(
        self,
        reports: ReportTable,
        assignment: Mapping[int, int],
        tracks: TrackTable,
        settings: Settings,
        priors: TrackTable | None,
    ) -> TrackTable:
        """Return the history of tracks as `smoothed_history` does, on the workers of regions."""
        if self.record["count"] == 1:
            return smoothed_history(reports, assignment, tracks, settings, priors)
        found = reports, assignment, tracks
        history, cpu = smoothed_on(self.pool, self.record["count"], found, settings)
        self.timing["smoothing_cpu_ms"] = [round(each * 1e3, 3) for each in cpu]
        return history

    def entered(self, record: dict[str, Any]) -> dict[str, Any]:
        """Return a run's record with what there is to tell of its regions."""
        timing = {**record["timing"], "regions": self.timing}
        return {**record, "regions": self.record, "timing": timing}

    def _note(self, number: int, n_reports: int, error: str | None) -> None:
        self.record["list"].append({"reports": n_reports, "error": error})
        if error is not None:
            self.notes.append(f"engine: region {number} was left out, whose worker said: {error}")


@contextmanager
def engaged(name: str | None, workers: int | None) -> Iterator[Engaged | None]:
    """Give an engine by its name and end its workers afterwards; None where none is named."""
    if name is None:
        yield None
        return
    with closing(engine_of(name, workers)) as pool:
        yield Engaged(name, pool.workers, pool)


def require_cuttable(engine: str | None, workers: int | None, given: Mapping[str, Any]) -> None:
    """Refuse arguments that regions on workers cannot follow."""
    if engine is None:
        if workers is not None:
            raise InvalidInputError(f"workers: {workers!r:.80}; expected an engine as well")
        return
    told = [name for name, value in given.items() if value is not None]
    if told:
        raise InvalidInputError(
            f"engine: {engine!r:.80} with {', '.join(told)}, which regions on workers cannot "
            "follow; expected one of both"
        )


def _require_places(attempt: Attempt) -> None:
    """Refuse what cannot be tracked in regions."""
    table, settings, course = attempt.table, attempt.settings, attempt.course
    unplaced = unplaced_sensors(table)
    why = None
    if unplaced:
        why = f"sensor {', '.join(unplaced)} tells no places"
    elif course.is_fused:
        why = "plots.fuse joins reports of an instant"
    elif settings.deadline is not None:
        why = "a deadline is for one tracker"
    elif settings.tracker.kind != "multi-hypothesis":
        why = f"tracker.kind is {settings.tracker.kind}"
    if why is not None:
        raise InvalidInputError(
            f"engine: {why}, so that the recording cannot be cut into regions; expected reports "
            "that tell places and the multi-hypothesis tracker, or no engine"
        )


def _taken_in(steps: Sequence[tuple[Scan, ...]], n_reports: int) -> tuple[IntArray, IntArray]:
    """Return in which step each report is taken, and the number of its scan in order."""
    step, scan = np.zeros((2, n_reports), dtype=np.int64)
    count = 0
    for number, scans in enumerate(steps):
        for each in scans:
            step[each.report], scan[each.report] = number, count
            count += 1
    return step, scan


def _due(attempt: Attempt) -> NDArray[np.bool_]:
    """Tell of each scan whether it is the last of a step after which rows are written."""
    steps, ends = attempt.course.steps, ends_of(attempt.course.steps)
    due = Rows(attempt.settings.period).due(ends)
    return np.array([
        is_due and each.time == end
        for scans, end, is_due in zip(steps, ends, due, strict=True)
        for each in scans
    ], dtype=np.bool_)  # fmt: skip


def _part(
    attempt: Attempt,
    kept: tuple[IntArray, NDArray[np.bool_]],
    region: Region,
    position: FloatArray,
    rng: np.random.Generator,
) -> Part:
    """Return a region's part of a run: the scans that look there, with its reports."""
    # ``kept`` are its reports, and whether each scan looks there or counts all the same.
    rows, seen = kept
    wanted = np.zeros(len(attempt.table), dtype=bool)
    wanted[rows] = True
    place = np.cumsum(wanted) - 1
    sensors = {each.name: each for each in attempt.settings.sensors}
    steps, passed, looks = [], [], iter(seen.tolist())
    for scans in attempt.course.steps:
        at = [next(looks) for _ in scans]
        steps.append(tuple(
            part_of(scan, sensors[scan.sensor], wanted[scan.report], place[scan.report])
            for scan in compress(scans, at)
        ))  # fmt: skip
        passed.append(tuple(
            (scan.sensor, scan.time) for scan, is_at in zip(scans, at, strict=True) if not is_at
        ))  # fmt: skip
    course = replace(attempt.course, steps=steps)
    is_own = region.holds(position[rows])
    told = attempt.settings.period, attempt.table.dim
    ends = ends_of(attempt.course.steps)
    return Part(course, passed, ends, region, rows, is_own, *told, rng)


def _owner(regions: Sequence[Region], position: FloatArray) -> IntArray:
    """Return the region in which each report lies."""
    owner = np.zeros(len(position), dtype=np.int64)
    for number, region in enumerate(regions):
        owner[region.holds(position)] = number
    return owner


def _joined(
    attempt: Attempt, parts: tuple[list[Found], list[Followed]], owner: IntArray
) -> tuple[Rows, ScanLog, Assigned, int]:
    """Return rows, log and assignments of all regions, and how many tracks several of them had."""
    (found, done), table = parts, attempt.table
    scan = np.full(len(table), -1, dtype=np.int64)
    numbers = [each for scans in attempt.course.steps for each in scans]
    for number, each in enumerate(numbers):
        scan[each.report] = number
    objects = same_objects(found, table.time)
    name: dict[Key, int] = {key: n for n, keys in enumerate(objects) for key in keys}
    rows, _ = joined_rows(found, _with_unassigned(found, name), table.dim)
    track = owned_tracks(found, owner, scan, name)
    rows, track, final = _renamed(rows, track, table.time)
    assigned = Assigned.nothing(len(table))
    assigned.track[:] = track
    for part, own in zip(found, done, strict=True):
        mine = np.flatnonzero((owner[part.rows] == part.number) & (track[part.rows] >= 0))
        assigned.probability[part.rows[mine]] = own.assigned.probability[mine]
    told = {key: final[number] for key, number in name.items() if number in final}
    log = _log(attempt, parts, owner, rows, told)
    result = Rows()
    result.add(rows, float(rows.time.max(initial=0.0)))
    return result, log, assigned, sum(len(keys) > 1 for keys in objects)


def _with_unassigned(found: Sequence[Found], name: dict[Key, int]) -> dict[Key, int]:
    """Return names in which tracks that have lost all their reports have one too."""
    every = dict(name)
    count = max(name.values(), default=-1) + 1
    for part in found:
        for track in np.unique(part.tracks.track).tolist():
            if (part.number, track) not in every:
                every[part.number, track] = count
                count += 1
    return every


def _renamed(
    rows: TrackTable, track: IntArray, time: FloatArray
) -> tuple[TrackTable, IntArray, dict[int, int]]:
    """Return rows and reports with names from 1 in order of first appearance, and the names."""
    own = np.flatnonzero(track >= 0)
    names = np.concatenate([rows.track, track[own]])
    when = np.concatenate([rows.time, time[own]])
    known, place = np.unique(names, return_inverse=True)
    first = np.full(known.size, np.inf)
    np.minimum.at(first, place, when)
    new = np.empty(known.size, dtype=np.int64)
    new[np.lexsort((known, first))] = np.arange(1, known.size + 1)
    track = track.copy()
    track[own] = new[place[len(rows) :]]
    rows = replace(rows, track=new[place[: len(rows)]])
    rows = rows.at(np.lexsort((rows.track, rows.time)))
    return rows, track, dict(zip(known.tolist(), new.tolist(), strict=True))


def _log(
    attempt: Attempt,
    parts: tuple[list[Found], list[Followed]],
    owner: IntArray,
    rows: TrackTable,
    name: dict[Key, int],
) -> ScanLog:
    """Return what each scan of all regions cost, as far as clusters are some region's own."""
    (found, done), log = parts, ScanLog()
    is_all = bool(np.isin(owner, [part.number for part in found]).all())
    for number, (scans, end) in enumerate(
        zip(attempt.course.steps, ends_of(attempt.course.steps), strict=True)
    ):
        each = [own.log.scans[number] for own in done]
        shares = [one["pruned_probability"] for one in each if one["pruned_probability"]]
        entry: dict[str, Any] = {
            "time": end,
            "sensor": "+".join(dict.fromkeys(scan.sensor for scan in scans)),
            "reports": sum(len(scan) for scan in scans),
            "tracks": None,
        }  # fmt: skip
        entry |= {key: sum(one[key] for one in each) for key in ("sequences", "pruned",
                  "pruned_by_deadline")}  # fmt: skip
        entry |= {"pruned_probability": None, "evaluations": sum(o["evaluations"] for o in each)}
        entry |= together([own.owned[number] for own in done]) if is_all else UNKNOWN
        entry["deadline_gap"] = None
        there = int(np.diff(np.searchsorted(rows.time, [end, np.nextafter(end, np.inf)]))[0])
        # Between two rows nobody has counted them.
        entry["tracks"] = None if attempt.settings.period and not there else there
        entry["pruned_probability"] = None if not shares else {
            "worst": max(one["worst"] for one in shares),
            "sum": sum(one["sum"] for one in shares),
        }  # fmt: skip
        entry["stop_reason"], entry["amendments"] = "regions", 0
        log.scans.append(entry)
        times = [own.log.timing[number] for own in done]
        log.timing.append({
            "cpu_ms": round(sum(one["cpu_ms"] for one in times), 3),
            "wall_ms": max(one["wall_ms"] for one in times),
        })  # fmt: skip
    for part, own in zip(found, done, strict=True):
        log.late += [row for row in part.rows[own.log.late].tolist() if owner[row] == part.number]
        for change in own.log.amendments:
            row = int(part.rows[change["report"]])
            if owner[row] == part.number:
                told = {key: name.get((part.number, change[key])) for key in ("before", "after")}
                log.amendments.append({**change, **told, "report": row})
    log.late.sort()
    log.amendments.sort(key=lambda change: (change["time"], change["report"]))
    return log
