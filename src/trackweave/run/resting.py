"""Objects at rest that report themselves, told apart in hindsight.

A window of seconds takes ships that are moored side by side for one, or one for several. Once all
reports are there, those of a place are given to its objects anew (`estimation.resting`), which
keep the numbers of the tracks that they have most in common with.
"""

import itertools
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from trackweave.arrays import FloatArray, IntArray
from trackweave.config.fill import Settings
from trackweave.domain.reports import ReportTable
from trackweave.domain.tracks import CONFIRMED, TENTATIVE, TrackTable
from trackweave.run.record import Assigned
from trackweave.summaries import counted

__all__ = ["Resting", "told_apart"]

CLEAR = 20.0  # Nothing changes at a place where that is not likelier by so much [nats]
CONFIRMING = 3  # Fewer reports are of nobody
MOSTLY, ALWAYS = 0.9, 0.8
"""Who was at rest at so many of its reports lies still if it was heard for so much of the time, or
was not known before to come or go."""
LATE, PACED, REACH = 3.0, 3, 6.0
"""Who comes to rest lies there within so many waits of where it is then, with the speed of so many
reports, and so many deviations."""
A_RUN, OFTEN = 2.0, 0.5
"""Of two side by side the seldomer has so many reports in succession at most, on
average; more of a place are beside another."""
WILD = 1  # So many reports elsewhere are none of a track's own


class Resting(NamedTuple):
    """What was told apart."""

    places: int
    before: int  # How many tracks there were at these places
    names: tuple[int, ...]  # What those that lie there are called now
    still: tuple[int, ...]  # Who lay at one place all the time
    rows: IntArray  # The reports of these places

    def called(self, track: IntArray) -> "Resting":
        """Return the same under the last names, those of the tracks of all reports."""
        own = track[self.rows]
        return self._replace(names=tuple(np.unique(own[own >= 0]).tolist()))

    def separated(self, history: TrackTable) -> tuple[TrackTable, TrackTable]:
        """Return the history of those that moved or came or went, and that of the others."""
        is_still = np.isin(history.track, self.still)
        return history.at(~is_still), history.at(is_still)

    def confirmed(self, history: TrackTable) -> TrackTable:
        """Return a history in which all of them are believed."""
        doubted = np.setdiff1d(self.names, history.track[history.status > TENTATIVE])
        is_doubted = np.isin(history.track, doubted)
        return replace(history, status=np.where(is_doubted, CONFIRMED, history.status))

    def notes(self) -> list[str]:
        """Return a sentence, if anything changed."""
        if not self.names:
            return []
        return [
            f"{counted(len(self.names), 'object')} at rest at {counted(self.places, 'place')}, "
            f"where {counted(self.before, 'track')} had been, told apart in hindsight by where and"
            " at which intervals they report (run.json: resting); tracks keep what was known "
            "then, assignments and history are those of now"
        ]

    def as_record(self) -> dict[str, Any] | None:
        """Return what run.json says; None where nothing changed."""
        if not self.names:
            return None
        return {"places": self.places, "before": self.before, "tracks": [*self.names]}


class _Place(NamedTuple):
    """A place at which several lie."""

    rows: IntArray  # Its reports
    owner: IntArray  # Whose each of them is
    sure: FloatArray  # How probable that is


NONE = Resting(0, 0, (), (), np.empty(0, dtype=np.int64))


def told_apart(
    reports: ReportTable, assigned: Assigned, settings: Settings, newest: int
) -> tuple[Assigned, Resting]:
    """Return assignments in which objects at rest have their own reports, and what changed."""
    # ``newest`` is the highest number that a track has.
    sensors = [settings.sensors[k] for k in np.unique(reports.sensor)]
    if not (
        settings.join
        and not settings.divide
        and reports.identity is None
        and all(each.scans is False and each.measurement.is_position for each in sensors)
    ):
        return assigned, NONE
    # Most runs need none of this.
    from trackweave.estimation.resting import Berth, parted, sureness
    from trackweave.estimation.resting_places import grain_of, places_of

    order = np.argsort(reports.time, kind="stable")
    time, place = reports.time[order], reports.measurement[order]
    track = assigned.track[order]
    sigma = float(np.mean([each.sigmas(reports.dim).mean() for each in sensors]))
    span = float(time[0]), float(time[-1]), grain_of(time)
    named, probability = track.copy(), assigned.probability[order]
    at_rest, anew = np.zeros((2, time.size), dtype=np.bool_)
    shared: list[_Place] = []
    for rows in places_of(time, place, track, sigma):
        at_rest[rows] = True
        extent = float(np.prod(np.ptp(place[rows], axis=0) + 2.0 * sigma))
        berth = Berth(sigma**2, extent, span[0], span[1], span[2])
        owner, gain = parted(time[rows], place[rows], track[rows], berth)
        if gain >= CLEAR and _are_side_by_side(time[rows], owner):
            shared.append(_Place(rows, owner, sureness(time[rows], place[rows], owner, berth)))
    named = _named(shared, (time, place, track), (at_rest, sigma), newest)
    whole = [each for each in shared if not _is_torn(each.rows, track, named)]
    if len(whole) < len(shared):
        named = _named(whole, (time, place, track), (at_rest, sigma), newest)
    for each in whole:
        anew[each.rows] = True
        probability[each.rows] = np.where(named[each.rows] < 0, np.nan, each.sure)
    if np.array_equal(named, track):
        return assigned, NONE
    told = np.unique(named[anew & (named >= 0)]).tolist()
    still = tuple(
        each
        for each in told
        if at_rest[named == each].mean() >= MOSTLY
        and (each > newest or np.ptp(time[named == each]) >= ALWAYS * (span[1] - span[0]))
    )
    n_before = np.unique(track[anew & (track >= 0)]).size
    found = Resting(len(whole), n_before, tuple(told), still, order[anew])
    back = np.argsort(order, kind="stable")
    return Assigned(named[back], probability[back]), found


def _named(
    places: list[_Place],
    known: tuple[FloatArray, FloatArray, IntArray],
    resting: tuple[NDArray[np.bool_], float],
    newest: int,
) -> IntArray:
    """Return the track of each report where those of some places have their owners anew."""
    # Known are times, positions and tracks as they were; which are at rest, and the noise [m].
    (time, place, track), (at_rest, sigma) = known, resting
    named, anew = track.copy(), np.zeros(time.size, dtype=np.bool_)
    next_name = newest + 1
    for rows, owner, _ in places:
        names = _names((time, named), rows, owner, next_name)
        next_name = max(next_name, int(names.max(initial=0)) + 1)
        named[rows], anew[rows] = names[owner], True
    for sense in (1.0, -1.0):
        _continue(sense * time, place, named, (anew, at_rest, sigma))
    return named


def _is_torn(rows: IntArray, track: IntArray, named: IntArray) -> bool:
    """Tell whether of most of those that come to a place or leave it no report there is."""
    # Who waits there for its turn and goes on lies beside nobody: its waits make an object at rest
    # of several that come one after the other.
    torn = passing = 0
    for each in np.unique(track[rows[track[rows] >= 0]]).tolist():
        elsewhere = np.setdiff1d(np.flatnonzero(track == each), rows)
        if elsewhere.size < CONFIRMING:
            continue
        passing += 1
        torn += int(not np.isin(named[rows], named[elsewhere]).any())
    return 2 * torn > passing


def _are_side_by_side(time: FloatArray, owner: IntArray) -> bool:
    """Tell whether most of a place's objects report meanwhile others do, not by turns."""
    # Reflections make one object lie here for some seconds and there for some.
    chains = [time[owner == each] for each in np.unique(owner)]
    chains = [each for each in chains if each.size >= CONFIRMING]
    beside = np.zeros(len(chains), dtype=np.bool_)
    for one, other in itertools.permutations(range(len(chains)), 2):
        runs = np.unique(np.searchsorted(chains[one], chains[other])).size
        if runs * A_RUN > chains[other].size:
            beside[[one, other]] = True
    return bool(beside.size and beside.mean() > OFTEN)


def _continue(
    time: FloatArray,
    place: FloatArray,
    named: IntArray,
    found: tuple[NDArray[np.bool_], NDArray[np.bool_], float],
) -> None:
    """Give those at rest the name of who arrived there just before, in place.

    With times that run backwards, give who left just after the name of who lay there.
    """
    # ``found`` are the reports that have their owners anew, all those at rest, and the noise [m].
    anew, at_rest, sigma = found
    forwards = time[-1] >= time[0]
    order = np.arange(time.size) if forwards else np.arange(time.size)[::-1]
    of = named[order]
    last = {int(each): row for row, each in zip(order, of, strict=True) if each >= 0}
    pairs = []
    for name in np.unique(named[anew & (named >= 0)]).tolist():
        rows = order[of == name]
        if rows.size < CONFIRMING:
            continue
        wait, begin = float(np.median(np.diff(time[rows]))), time[rows[0]]
        middle = place[rows[at_rest[rows]]].mean(axis=0)
        for other, row in last.items():
            gap = begin - time[row]
            if other != name and not at_rest[row] and 0.0 < gap <= LATE * wait:
                off = float(np.linalg.norm(place[row] - middle))
                way = order[of == other][-PACED:]
                pace = np.linalg.norm(place[way[-1]] - place[way[0]])
                pace /= max(time[way[-1]] - time[way[0]], 1e-9)
                if off <= pace * gap + REACH * sigma:
                    pairs.append((off, name, other))
    done: set[int] = set()
    for _, name, other in sorted(pairs):
        if not {name, other} & done:
            done |= {name, other}
            early, late = (other, name) if forwards else (name, other)
            named[named == late] = early


def _names(
    known: tuple[FloatArray, IntArray], rows: IntArray, owner: IntArray, following: int
) -> IntArray:
    """Return what each object is called: as the track that most of its reports were of."""
    # Of those that share one the others have new names; who hardly reports is nobody.
    from scipy.optimize import linear_sum_assignment

    time, track = known
    size, own = np.bincount(owner), track[rows]
    tracks = np.unique(own[own >= 0])
    common = np.zeros((size.size, tracks.size))
    is_of = own >= 0
    np.add.at(common, (owner[is_of], np.searchsorted(tracks, own[is_of])), 1.0)
    first = np.array([time[rows[owner == each][0]] for each in range(size.size)])
    last = np.array([time[rows[owner == each][-1]] for each in range(size.size)])
    for column, each in enumerate(tracks.tolist()):
        # Who is elsewhere meanwhile is another.
        elsewhere = np.sort(time[np.setdiff1d(np.flatnonzero(track == each), rows)])
        meanwhile = np.searchsorted(elsewhere, last, "left")
        meanwhile -= np.searchsorted(elsewhere, first, "right")
        common[meanwhile > WILD, column] = 0.0
    common[size < CONFIRMING] = 0.0
    names = np.full(size.size, -1, dtype=np.int64)
    for one, other in zip(*linear_sum_assignment(-common), strict=True):
        if common[one, other] > 0.0:
            names[one] = tracks[other]
    is_new = (names < 0) & (size >= CONFIRMING)
    names[is_new] = following + np.arange(is_new.sum())
    return names
