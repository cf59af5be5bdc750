"""What a run sets out with: reports, settings, the tracker, and what it gets step by step."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import NDArray

from trackweave.arrays import FloatArray, IntArray
from trackweave.config import Configuration
from trackweave.config.fill import Settings
from trackweave.config.plots import PlotSettings
from trackweave.domain.reports import ReportTable
from trackweave.domain.scans import Scan
from trackweave.domain.tracks import TrackTable
from trackweave.errors import InvalidInputError
from trackweave.io.marking import notes_on_names
from trackweave.io.tracks_in import read_priors
from trackweave.models.rotation import Rotation
from trackweave.models.sensors import Sensor
from trackweave.run.batches import hearing_in
from trackweave.run.doubles import (
    Doubles,
    doubles_of,
    is_astray,
    is_lone,
    note_on_astray,
    note_on_lone,
)
from trackweave.run.kept import Kept
from trackweave.run.observing import settle
from trackweave.run.polar_to_cartesian import laid
from trackweave.run.scans import (
    complete_scans,
    instants_of,
    notes_on_pauses,
    scan_ends,
    swept_together,
    with_turns,
)
from trackweave.trackers.clock_guard import MAX_AHEAD
from trackweave.trackers.hypothesis import Hypothesis
from trackweave.trackers.multi_hypothesis import MultiHypothesisTracker

__all__ = [
    "Attempt",
    "Course",
    "attempt_of",
    "course_of",
    "prior_table",
    "rotations_in",
    "tracker_of",
]

if TYPE_CHECKING:
    from trackweave.trackers.fused_plots import FusedPlotsTracker, ScanTracker
    from trackweave.trackers.nearest_neighbour import NearestNeighbourTracker


PARTS, EARLY = 3, 1.0
"""What lone reports say is searched for so many times at least while the window moves on by its
depth, and before so much of the pause has passed after which an object may report again."""


@dataclass(frozen=True, slots=True, eq=False)
class Course:
    """A tracker, and what it is given step by step."""

    tracker: "ScanTracker | FusedPlotsTracker"
    # Each one scan; with fused plots the scans of an instant, of sensors that do not look the
    # reports of some seconds.
    steps: Sequence[tuple[Scan, ...]]
    notes: tuple[str, ...] = ()
    is_fused: bool = False  # Whether the tracker takes the scans of an instant

    def of_rows(self, rows: IntArray) -> "Course":
        """Return the course with reports numbered otherwise, each by its number in ``rows``."""
        if rows.size == 0 or rows[-1] == rows.size - 1:
            return self
        steps = [
            tuple(replace(scan, report=rows[scan.report]) for scan in scans)
            for scans in self.steps
        ]
        return replace(self, steps=steps)

    def looks(self) -> dict[str, FloatArray]:
        """Return when each sensor scanned [s], ascending, by its name."""
        times: dict[str, list[float]] = {}
        for scans in self.steps:
            for scan in scans:
                times.setdefault(scan.sensor, []).append(scan.time)
        return {name: np.unique(each) for name, each in times.items()}

    def take(
        self,
        scans: tuple[Scan, ...],
        rng: np.random.Generator,
        deadline: float | None,
        *,
        tracks: bool,
    ) -> Hypothesis:
        """Take a step and return the hypothesis after it; the deadline is of wall clock [s]."""
        # Where plots are fused, tracks are told in any case.
        if self.is_fused:
            return cast("FusedPlotsTracker", self.tracker).step(scans, rng=rng, deadline=deadline)
        tracker = cast("ScanTracker", self.tracker)
        if len(scans) == 1:
            return tracker.step(scans[0], rng=rng, deadline=deadline, tracks=tracks)
        several = cast("MultiHypothesisTracker", tracker)
        return several.step(scans, rng=rng, deadline=deadline, tracks=tracks)


def course_of(
    reports: ReportTable,
    settings: Settings,
    rotations: dict[str, Rotation],
    priors: TrackTable | None,
) -> Course:
    """Return the tracker that a configuration asks for, and the steps that it takes."""
    # Plots are fused only if there are instants of several sensors; else reports are tracked scan
    # by scan, and a note says so.
    periods = {sensor.name: sensor.scan_period for sensor in settings.sensors}
    notes: list[str] = []
    if settings.plots is not None:
        # Sectors of different radars' turns look elsewhere: a whole turn is one scan here.
        table = replace(reports, scan=with_turns(reports, rotations))
        instants = instants_of(complete_scans(table, periods), settings.plots.within)
        notes = _doubts(reports, settings.plots, instants, rotations)
        if any(len(instant) > 1 for instant in instants):
            # Runs that fuse nothing need not wait for the import of what fuses.
            from trackweave.run.fused_course import fused_sensors, fuser_of
            from trackweave.trackers.fused_plots import FusedPlotsTracker

            fuser, assumed = fuser_of(reports, settings, settings.plots)
            sensors = fused_sensors(reports, fuser, instants)
            inside = tracker_of(settings, sensors, reports.dim, priors=priors)
            tracker = FusedPlotsTracker(fuser, inside, max_ahead=None)
            return Course(tracker, instants, (*notes, *assumed), is_fused=True)
    scans = complete_scans(reports, periods, rotations, hearing_in(settings.sensors))
    notes += notes_on_pauses(scans, periods)
    alone = tracker_of(settings, settings.sensors, reports.dim, priors=priors)
    return Course(alone, _steps(scans, settings, rotations), tuple(notes))


def _steps(
    scans: Sequence[Scan], settings: Settings, rotations: dict[str, Rotation]
) -> list[tuple[Scan, ...]]:
    """Return what each step takes: a scan, what beams sweep meanwhile, or some lone reports."""
    is_at_leisure = settings.tracker.kind == "multi-hypothesis" and settings.deadline is None
    if is_at_leisure and len(rotations) > 1:
        return swept_together(scans, rotations)
    together = EARLY * (settings.together or 0.0)
    looks = any(sensor.scans is not False for sensor in settings.sensors)
    if looks or not is_at_leisure:
        together = 0.0
    most = max(1, settings.window.depth // PARTS)
    steps: list[list[Scan]] = [[scan] for scan in scans[:1]]
    due = -np.inf
    for scan in scans[1:]:
        step, last = steps[-1], steps[-1][-1].time
        if last >= due:
            # A row is due, and rows are told at the end of a step.
            due = last + (settings.period or 0.0)
            steps.append([scan])
        elif last < scan.time < step[0].time + together and len(step) < most:
            step.append(scan)
        else:
            steps.append([scan])
    return [tuple(step) for step in steps]


def tracker_of(
    settings: Settings,
    sensors: Sequence[Sensor],
    dim: int | None,
    *,
    priors: TrackTable | None = None,
    max_ahead: float | None = None,
) -> "MultiHypothesisTracker | NearestNeighbourTracker":
    """Return the tracker of scans that a configuration asks for."""
    # No ``dim`` is what the first report tells. No ``max_ahead`` [s] is for a recording, which was
    # judged as a whole.
    if settings.tracker.kind == "nearest-neighbour":
        from trackweave.trackers.nearest_neighbour import NearestNeighbourTracker

        return NearestNeighbourTracker(
            motion=settings.motion,
            sensors=list(sensors),
            lifecycle=settings.lifecycle,
            priors=priors,
            pairing=settings.tracker.pairing,
            dim=dim,
            unscented=settings.unscented,
            max_ahead=max_ahead,
        )
    return MultiHypothesisTracker(
        motion=settings.motion,
        sensors=list(sensors),
        window=settings.window,
        search=settings.search,
        lifecycle=settings.lifecycle,
        priors=priors,
        limits=settings.growth,
        estimate=settings.estimate,
        dim=dim,
        unscented=settings.unscented,
        max_ahead=max_ahead,
    )


def _doubts(
    reports: ReportTable,
    plots: PlotSettings,
    instants: Sequence[tuple[Scan, ...]],
    rotations: dict[str, Rotation],
) -> list[str]:
    """Return sentences on instants that give fusing little or nothing to do."""
    if len(reports.sensors) == 1:
        return [f"plots.fuse: only sensor {reports.sensors[0]}; tracked scan by scan"]
    notes = []
    alone = sum(len(instant) == 1 for instant in instants)
    if alone == len(instants):
        return [
            f"plots.fuse: no two sensors' scans are within {plots.within:g} s; tracked scan by "
            "scan; give plots.within for sensors whose clocks differ"
        ]
    if alone:
        notes.append(
            f"plots.fuse: at {alone} of {len(instants)} instants only one sensor looked within "
            f"{plots.within:g} s, so that nothing was fused there"
        )
    if rotations:
        notes.append(
            f"plots.fuse: {', '.join(sorted(rotations))} turn; each turn is a scan, whose plots "
            "are brought to the time of its last"
        )
    return notes


@dataclass(frozen=True, slots=True, eq=False)
class Attempt:
    """All that a run sets out with."""

    doubles: Doubles  # Those heard twice once, and where each came from
    table: ReportTable  # The reports as tracked
    settings: Settings
    course: Course


def attempt_of(
    every: ReportTable,
    configuration: Configuration,
    preset: str | None,
    begun: TrackTable | None,
    kept: Kept | None = None,
) -> Attempt:
    """Return a run before its first step: reports, settings and steps as a configuration says."""
    # ``kept`` is what attempts of one run share.
    max_ahead = configuration.said("live", "max_ahead") or MAX_AHEAD
    doubles, (settings, _) = doubles_of(
        every,
        lambda once: settle(
            _without(once, is_lone(once, max_ahead) | is_astray(once)),
            configuration,
            preset=preset,
            kept=kept,
        ),
    )
    table, lone = doubles.once, is_lone(doubles.once, max_ahead)
    astray = is_astray(table)
    rotations = rotations_in(settings)
    places = {each.name: each.position for each in settings.sensors if each.position is not None}
    table, assumed = laid(table, places)
    notes = [
        *table.notes,
        *notes_on_names(every),
        *doubles.notes(),
        *assumed,
        *note_on_lone(doubles.once, lone),
        *note_on_astray(doubles.once, astray),
        *_notes_on_priors(begun, scan_ends(table, rotations, hearing_in(settings.sensors))),
    ]
    settings = replace(settings, notes=(*settings.notes, *notes))
    aside = lone | astray
    course = course_of(_without(table, aside), settings, rotations, begun)
    return Attempt(doubles, table, settings, course.of_rows(np.flatnonzero(~aside)))


def rotations_in(settings: Settings) -> dict[str, Rotation]:
    """Return how beams turn, by name of the sensor; sensors that do not turn are left out."""
    return {s.name: s.rotation for s in settings.sensors if s.rotation is not None}


def _without(reports: ReportTable, lone: NDArray[np.bool_]) -> ReportTable:
    """Return the reports that do not stand alone."""
    return reports.part(np.flatnonzero(~lone)) if lone.any() else reports


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


def prior_table(priors: Any, reports: ReportTable) -> TrackTable | None:
    """Return the tracks from which to set out, None for none, refusing those that cannot be."""
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
