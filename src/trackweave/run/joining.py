"""What a run knows in hindsight: names, once it is over, and smoothed states."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from trackweave.arrays import IntArray
from trackweave.config.fill import Settings
from trackweave.domain.reports import ReportTable
from trackweave.domain.tracks import CONFIRMED, TENTATIVE, TrackTable
from trackweave.estimation.estimates import digits
from trackweave.randomness import RandomSource
from trackweave.run.deghosting import Deghosted, deghosted
from trackweave.run.history import Smoothing, smoothed_history
from trackweave.run.lineage import Lineage, with_divisions
from trackweave.run.record import Assigned
from trackweave.run.resting import Resting, told_apart
from trackweave.summaries import counted
from trackweave.trackers.joining.joins import Join, Joins, joins_of
from trackweave.trackers.joining.naming import RARELY, Named, elsewhere, named_by
from trackweave.trackers.joining.segments import Segments, segments_of

__all__ = ["Hindsight", "Joined", "in_hindsight", "with_joins"]


_NUMBERS = "tracks keep the numbers of then, assignments and history have the names of now"


@dataclass(frozen=True, slots=True, eq=False)
class Joined:
    """What was joined in a run, and under which names."""

    joins: Joins
    segments: Segments
    name: IntArray
    """The track that each segment belongs to now, -1 for none."""

    def as_record(self) -> dict[str, Any]:
        """Return what run.json says."""
        joins, certificate = self.joins, self.joins.certificate
        return {
            "births": joins.births,
            "deaths": joins.deaths,
            "cost": certificate.cost,
            "lower_bound": certificate.lower_bound,
            "gap": certificate.gap,
            "status": certificate.status,
            "list": [self._listed(join, self.name[join.before]) for join in joins.found],
            "parted": [self._listed(join, self.name[join.after]) for join in joins.parted],
        }

    def _listed(self, join: Join, name: int) -> dict[str, Any]:
        return {
            "time": float(self.segments.begin[join.after]),
            "track": int(self.segments.track[join.after]),
            "into": int(name),
            "silence": join.silence,
            "probability": join.probability,
        }


@dataclass(frozen=True, slots=True, eq=False)
class Hindsight:
    """A run's results once it is over."""

    tracks: TrackTable
    history: TrackTable
    assigned: Assigned
    lineage: Lineage | None
    joined: Joined | None
    ghosts: Deghosted
    resting: Resting

    @property
    def parent(self) -> Mapping[int, int] | None:
        """From a track to the one that it came of; None where none was looked for."""
        return None if self.lineage is None else self.lineage.parent

    def notes(self) -> list[str]:
        """Return sentences on what were ghosts, what was joined and what was parted, if any."""
        notes = [*self.ghosts.notes(), *self.resting.notes()]
        if self.joined is None:
            return notes
        found, parted = self.joined.joins.found, self.joined.joins.parted
        if found:
            notes.append(
                f"{counted(len(found), 'track')} joined with an earlier one through silences of up"
                f" to {_longest(found):g} s (run.json: joins), as one object explains both"
                f" better than two; {_NUMBERS}"
            )
        if parted:
            notes.append(
                f"{counted(len(parted), 'track')} parted at silences of up to "
                f"{_longest(parted):g} s (run.json: joins), as two objects, of which one "
                f"ends and one begins there, are more probable; {_NUMBERS}"
            )
        return notes

    def as_record(self) -> dict[str, Any]:
        """Return what run.json says."""
        return {
            "ghosts": self.ghosts.as_record(),
            "resting": self.resting.as_record(),
            "divisions": None if self.lineage is None else self.lineage.as_record(),
            "joins": None if self.joined is None else self.joined.as_record(),
        }


def _longest(joins: Sequence[Join]) -> float:
    return digits(max(join.silence for join in joins), 3)


def in_hindsight(
    reports: ReportTable,
    found: tuple[TrackTable, Assigned],
    settings: Settings,
    priors: TrackTable | None,
    by: tuple[RandomSource, Smoothing],
) -> Hindsight:
    """Return a run's tracks as known then, its history and assignments, under their last names."""
    # ``by`` is what is drawn from, and what smooths all tracks at once, which workers may do.
    rng, _ = by
    joined, as_known = None, found[0]
    assigned, ghosts = deghosted(reports, found[1], settings)
    newest = int(max(as_known.track.max(initial=-1), assigned.track.max(initial=-1)))
    assigned, resting = told_apart(reports, assigned, settings, newest)
    found = ghosts.known(as_known), assigned
    # Of objects that divide, what begins may be a daughter, but where a merge explains it.
    if settings.join and settings.divide and settings.merge is not None:
        tracks, assigned = found
        history = smoothed_history(reports, assigned.by_row(), tracks, settings, priors)
        _, assigned, joined = with_joins(
            reports, (tracks, history, assigned), settings, priors, rng
        )
        found = tracks, assigned
    tracks, history, assigned, lineage = with_divisions(reports, found, settings, priors, by)
    history = resting.confirmed(history)
    if settings.join and not settings.divide:
        # Who lay still all the time tells nothing of how objects move, or fall silent.
        moving, still = resting.separated(history)
        moving, assigned, joined = with_joins(
            reports, (tracks, moving, assigned), settings, priors, rng
        )
        history = _together(moving, still)
    tracks = as_known if ghosts.changed else tracks
    resting = resting.called(assigned.track)
    return Hindsight(tracks, history, assigned, lineage, joined, ghosts, resting)


def with_joins(
    reports: ReportTable,
    found: tuple[TrackTable, TrackTable, Assigned],
    settings: Settings,
    priors: TrackTable | None,
    rng: RandomSource,
) -> tuple[TrackTable, Assigned, Joined | None]:
    """Return history and assignments of a run whose tracks are joined, and what was joined."""
    # ``found`` are the tracks as they were known, the history, and the assignments.
    tracks, history, assigned = found
    kept = np.unique(history.track[history.status > TENTATIVE])
    if kept.size < 2:
        return history, assigned, None
    track = _without_rivals(reports, assigned.track, settings)
    segments, of = segments_of(track, reports.time, kept.tolist())
    states = _states(reports, found, (segments, of), settings)
    known = () if priors is None else priors.track.tolist()
    joins = joins_of(
        segments, states, named=_named(reports, of, segments, settings), known=known,
        longest=settings.lifecycle.rejoin,
        merge=settings.merge if settings.divide else None, rng=rng,
    )  # fmt: skip
    if joins is None or not (joins.found or joins.parted):
        return history, assigned, None
    newest = max(int(assigned.track.max()), int(tracks.track.max(initial=0)))
    name = _names(segments, joins, newest + 1)
    row = np.flatnonzero(of >= 0)
    named = track.copy()
    named[row] = name[of[row]]
    is_over = named != assigned.track
    concerned = np.union1d(assigned.track[is_over], named[is_over])
    probability = np.where(named < 0, np.nan, assigned.probability)
    assigned = Assigned(named, probability)
    again = Assigned(np.where(np.isin(named, concerned), named, -1), probability).by_row()
    anew = smoothed_history(reports, again, tracks, settings, priors)
    # A name that is new here has no rows of its own that say that it is believed.
    status = np.where(
        (anew.status == TENTATIVE) & (anew.track > newest), CONFIRMED, anew.status
    )  # fmt: skip
    rest = history.at(~np.isin(history.track, concerned))
    history = _together(rest, replace(anew, status=status))
    return history, assigned, Joined(joins, segments, name)


def _together(one: TrackTable, other: TrackTable) -> TrackTable:
    """Return rows of different tracks as one table, by time, then track."""
    if not len(other):
        return one
    both = TrackTable.concatenate([one, other], one.dim)
    return both.at(np.lexsort((both.track, both.time)))


def _without_rivals(reports: ReportTable, track: IntArray, settings: Settings) -> IntArray:
    """Return the track of each report, -1 for what its name says is elsewhere then."""
    if reports.identity is None or _identity_error(reports, settings) > RARELY:
        return track
    # A sensor that tells no names, such as a radar beside AIS, says nothing by that.
    nameless = np.isin(reports.sensor, _who_names(reports)) & (reports.identity < 0)
    return np.where(elsewhere(track, reports.time, reports.identity, nameless), -1, track)


def _named(
    reports: ReportTable, of: IntArray, segments: Segments, settings: Settings
) -> Named | None:
    """Return whom each segment's reports say it is."""
    if reports.identity is None:
        return None
    return named_by(segments, of, reports.identity, _identity_error(reports, settings))


def _identity_error(reports: ReportTable, settings: Settings) -> float:
    """Return how often the worst sensor's reports are under another's identity."""
    names = (settings.sensors[each].identity_error for each in _who_names(reports))
    return max(names, default=0.5)


def _who_names(reports: ReportTable) -> IntArray:
    """Return the sensors of whose reports any has an identity."""
    assert reports.identity is not None
    return np.unique(reports.sensor[reports.identity >= 0])


def _states(
    reports: ReportTable,
    found: tuple[TrackTable, TrackTable, Assigned],
    cut: tuple[Segments, IntArray],
    settings: Settings,
) -> TrackTable:
    """Return smoothed states of each segment by itself; tracks in one piece have theirs."""
    tracks, history, assigned = found
    segments, of = cut
    _, of_track, n = np.unique(segments.track, return_inverse=True, return_counts=True)
    is_cut = np.isin(segments.track, assigned.track[(of < 0) & (assigned.track >= 0)])
    is_whole = (n[of_track] == 1) & ~is_cut
    number = np.full(int(history.track.max()) + 1, -1, dtype=np.int64)
    number[segments.track[is_whole]] = np.flatnonzero(is_whole)
    own = number[history.track]
    whole = replace(history, track=own).at(own >= 0)
    rows = np.flatnonzero(of >= 0)
    rows = rows[~is_whole[of[rows]]]
    if rows.size == 0:
        return whole
    # Numbers that no track has: each piece is found anew from its own reports.
    beyond = number.size
    pieces = dict(zip(rows.tolist(), (beyond + of[rows]).tolist(), strict=True))
    parts = smoothed_history(reports, pieces, tracks, settings)
    parts = replace(parts, track=parts.track - beyond)
    return TrackTable.concatenate([whole, parts], history.dim)


def _names(segments: Segments, joins: Joins, following: int) -> IntArray:
    """Return the name of each segment: that of the first of its object, or a new one."""
    name = np.full(len(segments), -1, dtype=np.int64)
    followed = np.zeros(len(segments), dtype=np.bool_)
    followed[joins.before[joins.before >= 0]] = True
    for each in np.argsort(segments.begin, kind="stable").tolist():
        before = int(joins.before[each])
        if before >= 0:
            name[each] = name[before]
        elif segments.before[each] < 0:
            name[each] = segments.track[each]
        elif segments.count[each] > 1 or followed[each]:
            # It was of a track that goes on elsewhere now.
            name[each], following = following, following + 1
    return name
