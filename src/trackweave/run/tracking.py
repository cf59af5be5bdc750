"""The main job: from reports to tracks."""

import time as clock
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from trackweave.arrays import FloatArray, is_number
from trackweave.config import Configuration, load_configuration
from trackweave.config.fill import Settings
from trackweave.domain.reports import ReportTable
from trackweave.domain.tracks import TENTATIVE, TrackTable
from trackweave.errors import InvalidInputError
from trackweave.io.encoding import to_native
from trackweave.io.frames_out import assignments_frame, tracks_frame
from trackweave.io.priors import read_priors
from trackweave.io.reports import read_reports
from trackweave.models.rotation import Rotation
from trackweave.run.collect import Assigned, Rows, ScanLog
from trackweave.run.course import Course, course_of
from trackweave.run.diagnostics import Case, diagnose
from trackweave.run.history import smoothed_history
from trackweave.run.laying import laid
from trackweave.run.merging import merged_reports
from trackweave.run.observing import settle
from trackweave.run.record import record_of, with_file
from trackweave.run.scans import scan_ends
from trackweave.solvers.auto import Auto

__all__ = ["RunValues", "TrackingResult", "rotations_in", "settings_for", "track"]

Progress = Callable[[int, int], None]


@dataclass(frozen=True, slots=True, eq=False)
class TrackingResult:
    """What a run found.

    Parameters
    ----------
    tracks
        What was known after each scan, one row per live track, in the kind of table that came in.
    assignments
        One row per report with its track, after all amendments; no track = false alarm.
    history
        Like tracks, amended and smoothed after the fact.
    run
        The record of the run: configuration as used, each scan's cost and bound, totals.
    values
        The same as values of the library.
    """

    tracks: Any
    assignments: Any
    history: Any
    run: dict[str, Any]
    values: "RunValues"


@dataclass(frozen=True, slots=True, eq=False)
class RunValues:
    """A run's results as values of ``trackweave.domain``.

    Parameters
    ----------
    reports
        What was tracked.
    tracks
        What was known after each scan.
    history
        Amended and smoothed after the fact.
    assignment
        From a report's row to its track.
    settings
        The configuration as used.
    """

    reports: ReportTable
    tracks: TrackTable
    history: TrackTable
    assignment: Mapping[int, int]
    settings: Settings


def track(  # noqa: PLR0913 the one function that users call with everything
    reports: Any,
    config: str | Path | Mapping[str, Any] | Configuration | None = None,
    *,
    preset: str | None = None,
    priors: Any = None,
    rng: np.random.Generator,
    deadline: float | None = None,
    progress: Progress | None = None,
) -> TrackingResult:
    """Turn reports into tracks.

    Parameters
    ----------
    reports
        A path of a CSV or Parquet file, a pandas, polars or Arrow table, or what
        ``read_reports`` returns. At least one report.
    config
        A path of a TOML file, or its content as a mapping. Keys left out are estimated from the
        reports or take defaults; ``run`` says which and with what value.
    preset
        Name of a preset, applied where the configuration is silent.
    priors
        Tracks from which to set out: a tracks file or table; the last row counts of each track
        that is alive at its end.
    rng
        The only source of randomness.
    deadline
        Wall clock per scan [s], before that of the configuration. None for none. With one, runs
        are not repeatable.
    progress
        Called after each scan with the number of scans done and of all.

    Returns
    -------
    Tracks, assignments and history in the kind of table that came in, and the run's record.

    Raises
    ------
    InvalidInputError
        If a table, a configuration value or an argument cannot be used.
    """
    if deadline is not None and not (is_number(deadline) and deadline > 0):
        raise InvalidInputError(f"deadline: {deadline!r:.80}; expected a number > 0 in seconds")
    configuration = load_configuration(config)
    table = _report_table(reports, configuration)
    begun = _prior_table(priors, table)
    settings = settings_for(table, configuration, preset=preset)
    rotations = rotations_in(settings)
    table, assumed = laid(table, settings.sensors)
    notes = [
        *table.notes,
        *assumed,
        *_notes_on_priors(begun, scan_ends(table, rotations)),
    ]
    settings = replace(settings, notes=(*settings.notes, *notes))
    course = course_of(table, settings, rotations, begun)
    limit = settings.deadline if deadline is None else deadline
    with ExitStack() as stack:
        if limit is not None:
            from trackweave.run.preparing import prepare, without_pauses

            # The first scan's deadline is not for compiling.
            prepare(course, settings.search or Auto(), rng)
            stack.enter_context(without_pauses())
        rows, log, assigned = _followed(course, table, settings, (rng, limit), progress)
    tracks = rows.table(table.dim)
    settings = replace(settings, notes=(*settings.notes, *course.notes, *log.notes()))
    assignment = assigned.by_row()
    history = smoothed_history(table, assignment, tracks, settings, begun)
    found = diagnose(Case(table, settings, assigned.track, history, course.looks()))
    settings = replace(settings, notes=(*(each.sentence for each in found), *settings.notes))
    values = RunValues(table, tracks, history, assignment, settings)
    merged = merged_reports(table, assignment, history, settings.sensors)
    record = record_of(table, settings, log, assignment, merged)
    record["diagnostics"] = [each.as_record() for each in found]
    if isinstance(reports, str | Path):
        record = with_file(record, reports)
    return TrackingResult(
        tracks=_native(tracks_frame(tracks, table.frame, iso_time=table.iso_time), table),
        assignments=_native(assignments_frame(table, assigned.track, assigned.probability), table),
        history=_native(tracks_frame(history, table.frame, iso_time=table.iso_time), table),
        run=record,
        values=values,
    )


def _followed(
    course: Course,
    table: ReportTable,
    settings: Settings,
    search: tuple[np.random.Generator, float | None],
    progress: Progress | None,
) -> tuple[Rows, ScanLog, Assigned]:
    """Take all steps of a course, with a source of randomness and a deadline for each."""
    rng, limit = search
    rows, log, assigned = Rows(settings.period), ScanLog(), Assigned.nothing(len(table))
    # It begins a track with every report left over; those never confirmed were false alarms.
    is_nearest = settings.tracker.kind == "nearest-neighbour"
    confirmed: set[int] = set()
    ends = [max(scan.time for scan in scans) for scans in course.steps]
    for number, (scans, end, following) in enumerate(
        zip(course.steps, ends, [*ends[1:], None], strict=True), start=1
    ):
        cpu, wall = clock.process_time(), clock.perf_counter()
        wanted = rows.wants(end, following) or is_nearest
        hypothesis = course.take(scans, rng, limit, tracks=wanted)
        log.add(scans, hypothesis, clock.process_time() - cpu, clock.perf_counter() - wall)
        if wanted:
            rows.add(hypothesis.tracks, hypothesis.time)
        assigned.enter(hypothesis.final)
        if is_nearest:
            shown = hypothesis.tracks
            confirmed |= set(shown.track[shown.status != TENTATIVE].tolist())
        if progress is not None:
            progress(number, len(course.steps))
    assigned.enter(course.tracker.pending())
    if is_nearest:
        assigned.drop_all_but(confirmed)
    return rows, log, assigned


def settings_for(
    reports: ReportTable, configuration: Configuration, *, preset: str | None = None
) -> Settings:
    """Return a configuration whose gaps are filled from the reports.

    Parameters
    ----------
    reports
        The reports.
    configuration
        As read.
    preset
        Name of a preset, None for none.

    Returns
    -------
    Everything that a tracker needs.
    """
    return settle(reports, configuration, preset=preset)[0]


def rotations_in(settings: Settings) -> dict[str, Rotation]:
    """Return how beams turn, by name of the sensor; sensors that do not turn are left out.

    Parameters
    ----------
    settings
        The configuration as used.

    Returns
    -------
    What ``complete_scans`` takes.
    """
    return {s.name: s.rotation for s in settings.sensors if s.rotation is not None}


def _report_table(reports: Any, configuration: Configuration) -> ReportTable:
    if isinstance(reports, ReportTable):
        table = reports
    else:
        origin = configuration.frame.origin
        table = read_reports(
            reports,
            frame_origin=None if origin is None else (origin[0], origin[1]),
            frame_projection=configuration.frame.projection or "tangent",
        )
    if len(table) == 0:
        raise InvalidInputError("reports: no rows; expected at least one report")
    return table


def _prior_table(priors: Any, reports: ReportTable) -> TrackTable | None:
    if priors is None:
        return None
    table = priors if isinstance(priors, TrackTable) else read_priors(priors, reports.frame)
    if len(table) and table.dim != reports.dim:
        raise InvalidInputError(
            f"priors: states in {table.dim} dimensions; expected {reports.dim} as in the reports"
        )
    if len(table) and table.time.max() > reports.time.max():
        raise InvalidInputError(
            f"priors: newest at {table.time.max():.15g} s, after the last report at "
            f"{reports.time.max():.15g} s, so that every report would be too late; expected "
            "tracks of before the reports"
        )
    return table


def _notes_on_priors(priors: TrackTable | None, ends: FloatArray) -> list[str]:
    """Return a sentence on reports in scans that end before the priors, which come too late."""
    if priors is None or len(priors) == 0:
        return []
    newest = float(priors.time.max())
    n_late = int(np.sum(ends < newest))
    if n_late == 0:
        return []
    return [
        f"priors: newest at {newest:.15g} s; {n_late} of {ends.size} reports are of before "
        "and count as late"
    ]


def _native(frame: Any, reports: ReportTable) -> Any:
    return to_native(frame, reports.kind)
