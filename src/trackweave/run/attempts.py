"""What a run sets out with: reports, settings and steps."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from trackweave.arrays import FloatArray
from trackweave.config import Configuration
from trackweave.config.fill import Settings
from trackweave.domain.reports import ReportTable
from trackweave.domain.tracks import TrackTable
from trackweave.io.marking import notes_on_names
from trackweave.models.rotation import Rotation
from trackweave.run.course import Course, course_of
from trackweave.run.doubles import Doubles, doubles_of
from trackweave.run.lone_stamps import is_lone, note_on_lone
from trackweave.run.observing import settle
from trackweave.run.scans import scan_ends
from trackweave.run.slant_range import laid
from trackweave.trackers.clock_guard import MAX_AHEAD

__all__ = ["Attempt", "attempt_of", "rotations_in"]


@dataclass(frozen=True, slots=True, eq=False)
class Attempt:
    """All that a run sets out with."""

    doubles: Doubles  # Those heard twice once, and where each came from
    table: ReportTable  # The reports as tracked
    settings: Settings
    course: Course


def attempt_of(
    every: ReportTable, configuration: Configuration, preset: str | None, begun: TrackTable | None
) -> Attempt:
    """Return a run before its first step: reports, settings and steps as a configuration says."""
    max_ahead = configuration.said("live", "max_ahead") or MAX_AHEAD
    doubles, (settings, _) = doubles_of(
        every,
        lambda once: settle(
            _without(once, is_lone(once, max_ahead)), configuration, preset=preset
        ),
    )
    table, lone = doubles.once, is_lone(doubles.once, max_ahead)
    rotations = rotations_in(settings)
    places = {each.name: each.position for each in settings.sensors if each.position is not None}
    table, assumed = laid(table, places)
    notes = [
        *table.notes,
        *notes_on_names(every),
        *doubles.notes(),
        *assumed,
        *note_on_lone(table, lone),
        *_notes_on_priors(begun, scan_ends(table, rotations)),
    ]
    settings = replace(settings, notes=(*settings.notes, *notes))
    course = course_of(_without(table, lone), settings, rotations, begun)
    return Attempt(doubles, table, settings, course.of_rows(np.flatnonzero(~lone)))


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
