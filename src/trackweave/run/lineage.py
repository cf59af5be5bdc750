"""Who came of whom: tracks that divided are renamed, and their daughters know their mother."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.config.fill import Settings
from trackweave.domain.reports import ReportTable
from trackweave.domain.tracks import CONFIRMED, TENTATIVE, TrackTable
from trackweave.randomness import RandomSource
from trackweave.run.batches import hearing_in
from trackweave.run.course import rotations_in
from trackweave.run.history import Smoothing, smoothed_history
from trackweave.run.record import Assigned
from trackweave.run.scans import scan_ends
from trackweave.trackers.divisions import Division, Divisions, divisions_of

__all__ = ["Lineage", "lineage_of", "with_divisions"]


@dataclass(frozen=True, slots=True, eq=False)
class Lineage:
    """The divisions of a run, with names as biologists have them: each daughter has a new one."""

    divisions: Divisions
    parent: Mapping[int, int]
    """From a track to the track that it came of."""
    begins: Mapping[int, tuple[FloatArray, IntArray]]
    """Of tracks that went on as one of their daughters: when [s], and as which track."""

    def renamed(self, track: IntArray, time: FloatArray) -> IntArray:
        """Return whose each state or report is; negative for nobody's."""
        names = track.copy()
        for mother, (since, later) in self.begins.items():
            rows = np.flatnonzero(track == mother)
            piece = np.searchsorted(since, time[rows], "right")
            names[rows] = np.r_[mother, later][piece]
        return names

    def renamed_tracks(self, tracks: TrackTable) -> TrackTable:
        """Return the same rows under the tracks' names, by time, then track."""
        table = replace(tracks, track=self.renamed(tracks.track, tracks.time))
        return table.at(np.lexsort((table.track, table.time)))

    def as_record(self) -> dict[str, Any]:
        """Return what run.json says."""
        found, certificate = self.divisions, self.divisions.certificate
        return {
            "rate": found.rate,
            "spread": found.spread,
            "birth_density": found.birth_density,
            "cost": certificate.cost,
            "lower_bound": certificate.lower_bound,
            "gap": certificate.gap,
            "status": certificate.status,
            "list": [self._told(one) for one in found.found],
        }

    def _told(self, one: Division) -> dict[str, Any]:
        at = np.array([one.time])
        # A moment before, the mother had her own name.
        mother = self.renamed(np.array([one.mother]), np.nextafter(at, -np.inf))
        daughters = set(one.daughters)
        if len(daughters) == 1:
            daughters.add(int(self.renamed(np.array([one.mother]), at)[0]))
        return {"time": one.time, "mother": int(mother[0]), "daughters": sorted(daughters)}


def with_divisions(
    table: ReportTable,
    found: tuple[TrackTable, Assigned],
    settings: Settings,
    priors: TrackTable | None,
    by: tuple[RandomSource, Smoothing],
) -> tuple[TrackTable, TrackTable, Assigned, Lineage | None]:
    """Return tracks, history and assignments of a run, and who came of whom where it is asked."""
    (tracks, assigned), (rng, smooth) = found, by
    history = smooth(table, assigned.by_row(), tracks, settings, priors)
    if not settings.divide:
        return tracks, history, assigned, None
    lineage = lineage_of(history, tracks, settings, priors, rng)
    if not lineage.begins:
        return tracks, history, assigned, lineage
    ends = scan_ends(table, rotations_in(settings), hearing_in(settings.sensors))
    assigned = replace(assigned, track=lineage.renamed(assigned.track, ends))
    tracks = lineage.renamed_tracks(tracks)
    # A daughter is smoothed by her own reports alone.
    history = smoothed_history(table, assigned.by_row(), tracks, settings, priors)
    # Rows may be so rare that none is of a daughter: she is believed as her mother was.
    is_new = np.isin(history.track, np.concatenate([one for _, one in lineage.begins.values()]))
    status = np.where(is_new & (history.status == TENTATIVE), CONFIRMED, history.status)
    return tracks, replace(history, status=status), assigned, lineage


def lineage_of(
    history: TrackTable,
    tracks: TrackTable,
    settings: Settings,
    priors: TrackTable | None,
    rng: RandomSource,
) -> Lineage:
    """Return who came of whom in a run's history; tracks known beforehand began before it."""
    key = "lifecycle.new_target_density"
    is_told = settings.sources.get(key) in ("file", "preset")
    divisions = divisions_of(
        history,
        known=() if priors is None else priors.track.tolist(),
        survival=settings.lifecycle.survival,
        birth_density=settings.lifecycle.new_target_density if is_told else None,
        rng=rng,
    )
    number = int(max(history.track.max(initial=0), tracks.track.max(initial=0))) + 1
    parent: dict[int, int] = {}
    begins: dict[int, tuple[list[float], list[int]]] = {}
    for one in divisions.found:  # in order of time, so that pieces are too
        since, later = begins.setdefault(one.mother, ([], []))
        mother = later[-1] if later else one.mother
        parent |= dict.fromkeys(one.daughters, mother)
        if len(one.daughters) == 1:
            since.append(one.time)
            later.append(number)
            parent[number] = mother
            number += 1
    pieces = {
        mother: (np.array(since), np.array(later, np.int64))
        for mother, (since, later) in begins.items()
        if later
    }
    return Lineage(divisions, parent, pieces)
