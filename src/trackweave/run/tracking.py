"""The main job: from reports to tracks."""

import os
import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeAlias, overload

import polars as pl

from trackweave.arrays import is_number
from trackweave.config import Configuration, load_configuration
from trackweave.config.fill import Settings
from trackweave.config.learned import learned_sources
from trackweave.config.presets import preset_notes
from trackweave.domain.reports import ReportTable
from trackweave.domain.tracks import TrackTable
from trackweave.errors import InvalidInputError
from trackweave.formats.reading import is_recording, load
from trackweave.io.encoding import to_native
from trackweave.io.marking import marked, table_of, with_index
from trackweave.io.reports import reports_in, with_heeded_scans
from trackweave.io.tables import OnBadRow
from trackweave.randomness import RandomSource, generator_of, seed_of
from trackweave.run.attempts import Progress, agreed
from trackweave.run.cartesian_to_polar import as_measured
from trackweave.run.consistency_checks import ConsistencyChecks
from trackweave.run.course import attempt_of, prior_table
from trackweave.run.diagnostics import Case, diagnose
from trackweave.run.doubles import Doubles, with_doubles
from trackweave.run.heights import registered
from trackweave.run.history import smoothed_history
from trackweave.run.joining import in_hindsight
from trackweave.run.kept import Kept
from trackweave.run.kernels import compiling_told
from trackweave.run.merging import merged_reports
from trackweave.run.observing import settle
from trackweave.run.pieces import Pieces, pieces_in, with_pieces
from trackweave.run.record import Assigned, record_of, whole_of, with_file, with_seed
from trackweave.run.regions import engaged, require_cuttable
from trackweave.run.result import RunValues, Table, TrackingResult
from trackweave.run.told_places import with_facts

__all__ = ["report_table", "settings_for", "track"]

Config: TypeAlias = str | Path | Mapping[str, Any] | Configuration | None


@overload
def track(
    reports: str | os.PathLike[str] | Sequence[str | os.PathLike[str]],
    config: Config = None,
    *,
    preset: str | None = None,
    priors: Any = None,
    rng: RandomSource = 0,
    deadline: float | None = None,
    on_bad_row: OnBadRow = "fail",
    progress: Progress | None = None,
    engine: str | None = None,
    workers: int | None = None,
) -> TrackingResult[pl.DataFrame]: ...
@overload
def track(
    reports: ReportTable,
    config: Config = None,
    *,
    preset: str | None = None,
    priors: Any = None,
    rng: RandomSource = 0,
    deadline: float | None = None,
    on_bad_row: OnBadRow = "fail",
    progress: Progress | None = None,
    engine: str | None = None,
    workers: int | None = None,
) -> TrackingResult[Any]: ...
@overload
def track(
    reports: Table,
    config: Config = None,
    *,
    preset: str | None = None,
    priors: Any = None,
    rng: RandomSource = 0,
    deadline: float | None = None,
    on_bad_row: OnBadRow = "fail",
    progress: Progress | None = None,
    engine: str | None = None,
    workers: int | None = None,
) -> TrackingResult[Table]: ...
@compiling_told()
def track(  # noqa: PLR0913 the one function that users call with everything
    reports: Any,
    config: Config = None,
    *,
    preset: str | None = None,
    priors: Any = None,
    rng: RandomSource = 0,
    deadline: float | None = None,
    on_bad_row: OnBadRow = "fail",
    progress: Progress | None = None,
    engine: str | None = None,
    workers: int | None = None,
) -> TrackingResult[Any]:
    """Turn reports into tracks.

    Parameters
    ----------
    reports
        A path of a file of any format that ``trackweave formats`` lists, or several (one network
        of sensors), a pandas, polars or Arrow table, or what ``read_reports`` returns. At least
        one report, in any order. Never changed.
    config
        A path of a TOML file, or its content as a mapping. Keys left out are estimated from the
        reports or take defaults; ``run`` says which and with what value.
    preset
        Name of a preset, applied where the configuration is silent.
    priors
        Tracks from which to set out: a tracks file or table; the last row counts of each track
        that is alive at its end.
    rng
        The only source of randomness: a generator, or a seed; the configuration's ``seed`` is for
        the command line.
    deadline
        Wall clock per scan [s], before that of the configuration. None for none. With one, runs
        are not repeatable.
    on_bad_row
        "fail" to refuse a table with a bad row; "skip" to leave bad rows out, which then have no
        track, and list them in ``run``.
    progress
        Called after each scan with the number of scans done and of all.
    engine
        ``local``, ``ray`` or ``ray://HOST`` to cut a large recording into regions of the plane
        and track these on workers; None for this process alone.
    workers
        How many regions are tracked at a time; None for as many as there are processors.

    Returns
    -------
    Tracks, assignments and history in the kind of table that came in, that table with the track
    of each of its rows, and the run's record.

    Raises
    ------
    InvalidInputError
        If a table, a configuration value or an argument cannot be used.
    EngineError
        If Ray is missing, no cluster answers, or every region failed.

    Examples
    --------
    >>> import polars as pl
    >>> from trackweave import track
    >>> reports = pl.DataFrame(
    ...     {"time": [2, 0, 3, 1], "x": [19.9, 0.0, 30.1, 10.2], "y": [4.9, 5.0, 5.0, 5.1]}
    ... )
    >>> result = track(reports)
    >>> result.reports.select("time", "track").rows()
    [(2, 1), (0, 1), (3, 1), (1, 1)]
    >>> result.tracks.select("time", "track", "status").rows()[-1]
    (3.0, 1, 'confirmed')
    """
    generator, began = generator_of(rng), (time.process_time(), time.perf_counter())
    if deadline is not None and not (is_number(deadline) and deadline > 0):
        raise InvalidInputError(f"deadline: {deadline!r:.80}; expected a number > 0 in seconds")
    configuration = load_configuration(config)
    require_cuttable(engine, workers, {"preset": preset, "priors": priors, "deadline": deadline})
    every, came = report_table(reports, configuration, on_bad_row)
    is_judged = not preset_notes(preset) and not every.has_foreign
    heights, registration = registered(every, configuration, looks=is_judged)
    pieces = pieces_in(registration.reports, registration.configuration, looks=is_judged)
    every, configuration = pieces.joined, pieces.configuration
    begun, doubts, kept = prior_table(priors, every), ConsistencyChecks(configuration), Kept()
    before = *heights.notes(), *registration.notes(), *pieces.notes(), *_note_on_none(begun)
    with engaged(engine, workers) as regions:
        while True:
            attempt, done = agreed(
                lambda told: attempt_of(every, told, preset, begun, kept),
                doubts,
                (generator, deadline, regions),
                progress,
            )
            (rows, log, known), table, course = done, attempt.table, attempt.course
            of_run = *before, *attempt.settings.notes, *course.notes, *log.notes()
            settings = registration.entered(pieces.entered(doubts.entered(attempt.settings)))
            settings = replace(settings, notes=(*of_run, *(regions.notes if regions else ())))
            by = generator, regions.smoothed if regions else smoothed_history
            seen = in_hindsight(table, (rows.table(table.dim), known), settings, begun, by)
            # Tracks by a document's letter are no judges of what was told.
            case = (
                table, settings, seen.assigned.track, seen.history, course.looks(),
                registration.unregistered(),
            )  # fmt: skip
            found = diagnose(Case(*case), doubts.findings()) if is_judged else doubts.findings()
            if not doubts.take_back(found, settings):
                break
    assigned, assignment = seen.assigned, seen.assigned.by_row()
    contradicted = (each.sentence for each in found)
    settings = replace(settings, notes=(*contradicted, *settings.notes, *seen.notes()))
    merged = merged_reports(table, assignment, seen.history, settings.sensors, settings.merge)
    record = record_of(table, settings, log, assignment, merged)
    by_row = RunValues(
        table, seen.tracks, seen.history, assignment, settings, assigned.probability, seen.parent
    )
    record, values = _of_all(record, by_row, assigned, merged, (attempt.doubles, pieces))
    record["sources"] = learned_sources(record["sources"], configuration)
    if regions is not None:
        record = regions.entered(record)
    record |= {
        "told": [*doubts.as_record(), *registration.told_record()],
        "heights": heights.as_record(),
        "registration": registration.as_record(),
        "diagnostics": [each.as_record() for each in found],
        **seen.as_record(),
    }
    record["timing"] |= whole_of(*began)
    seed = seed_of(rng)
    record = with_seed(
        record, seed, None if seed == (configuration.said("seed") or 0) else "argument"
    )
    return _handed_back(record, values, (reports, config, priors), came)


def _note_on_none(priors: TrackTable | None) -> list[str]:
    """Return a sentence on priors of which there are none, as in a file with a header alone."""
    if priors is None or len(priors):
        return []
    return ["priors: no tracks in them; the run began as without priors"]


def _of_all(
    record: dict[str, Any],
    values: RunValues,
    assigned: Assigned,
    merged: Mapping[int, int],
    once: tuple[Doubles, Pieces],
) -> tuple[dict[str, Any], RunValues]:
    """Return record and results of all reports that came, from those that were tracked."""
    doubles, pieces = once
    assigned = assigned.at(doubles.place).at(pieces.place)
    assignment = assigned.by_row()
    every = replace(
        values,
        reports=pieces.restored(doubles.restored(values.reports)),
        assignment=assignment,
        probability=assigned.probability,
        shared=None if values.settings.merge is None else pieces.shared(doubles.shared(merged)),
    )
    return with_pieces(with_doubles(record, doubles), pieces, len(assignment)), every


def _handed_back(
    record: dict[str, Any], values: RunValues, given: tuple[Any, ...], came: Any
) -> TrackingResult[Any]:
    """Return a run's results in the kind of table that came in."""
    files = given[0] if isinstance(given[0], list | tuple) else given[:1]
    inputs = tuple(e for e in (*files, *given[1:]) if isinstance(e, str | os.PathLike))
    if is_recording(given[0]):
        record = with_file(record, *files)
    table, frames = values.reports, values.frames()
    native = {name: to_native(frame, table.kind) for name, frame in frames.items()}
    native["assignments"] = with_index(native["assignments"], came, table)
    marks = None if came is None else marked(came, table, frames["assignments"])
    return TrackingResult(**native, run=record, values=values, inputs=inputs, _reports=marks)


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


def report_table(
    reports: Any, configuration: Configuration, on_bad_row: OnBadRow = "fail"
) -> tuple[ReportTable, Any]:
    """Return reports as read, on the plane that a configuration asks for.

    Parameters
    ----------
    reports
        As for ``track``.
    configuration
        As read.
    on_bad_row
        What to do with rows that cannot be used.

    Returns
    -------
    At least one report, as its sensor is told to measure, and the table that came in, None where
    they did not come as one.

    Raises
    ------
    InvalidInputError
        If there is none, or they cannot be read.
    """
    came = None
    if isinstance(reports, ReportTable):
        table = reports
    else:
        origin = configuration.said("frame", "origin")
        raw = load(reports)
        if is_recording(reports):
            came = table_of(raw)
        else:
            from trackweave.io.frames_in import native_of

            came = native_of(reports)
        table = reports_in(
            raw,
            frame_origin=None if origin is None else (origin[0], origin[1]),
            frame_projection=configuration.said("frame", "projection") or "tangent",
            on_bad_row=on_bad_row,
            kinds=configuration.plugins.kinds(),
            places=configuration.places(),
        )
        table = with_heeded_scans(table)
    if len(table) == 0:
        raise InvalidInputError("reports: no rows; expected at least one report")
    return as_measured(table, with_facts(configuration, table).sensor), came
