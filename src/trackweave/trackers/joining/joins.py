"""Which ends of tracks and which beginnings after them are one object, hidden in between.

The field calls it track segment association, or track stitching [1]_: tracks with their smoothed
states are items, an end has at most one beginning and a beginning at most one end, and the choice
is an assignment problem with a bound. How often objects fall silent, end and begin, and where, is
learned from the record itself, by expectation and maximisation over all pairs.

References
----------
.. [1] S. Zhang, Y. Bar-Shalom, Track segment association for GMTI tracks of evasive move-stop-move
   maneuvering targets, *IEEE Trans. Aerospace and Electronic Systems* 47 (3), 2011, pp. 1899-1914.
"""

from collections.abc import Collection
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from trackweave.arrays import FloatArray, IntArray
from trackweave.association.problem import AssignmentProblem, Certificate
from trackweave.domain.tracks import TrackTable
from trackweave.randomness import RandomSource
from trackweave.solvers.solving import solve
from trackweave.trackers.joining.merges import merge_pairs
from trackweave.trackers.joining.naming import Named
from trackweave.trackers.joining.places import MOST, Places, Room
from trackweave.trackers.joining.segments import FIRM, Paths, Segments
from trackweave.trackers.joining.straying import Straying, reach

__all__ = ["Join", "Joins", "joins_of"]

EDGE = 4.0
"""What is so many intervals from the record's end or beginning neither ends nor begins."""
MOST_ENDS = 100
"""So many of the last ends before a beginning are looked at, which bounds the work."""
KNOWN_LINK = 2.0
"""What speaks for two segments that the tracker held to be one object [nats]."""
CLEAR, DOUBTED = 0.8, 0.5
"""How probable a join has to be that the tracker had not made, and what it held to be one object
stays so unless this is less probable."""
STOPS, BELIEVED = 0.05, 20.0
"""So many of those that nobody sees stand meanwhile (what is told by its Doppler or its lights is
not seen where it does), believed beforehand as if so many silences told it."""
ROUNDS, MESSAGES = 20, 40
SURE = 25.0
"""Nothing is surer than this [nats]: of larger odds, differences would be lost."""


@dataclass(frozen=True, slots=True)
class Join:
    """Two segments that are one object, hidden in between."""

    before: int
    after: int
    silence: float
    """How long nobody saw it [s]."""
    probability: float


@dataclass(frozen=True, slots=True, eq=False)
class Joins:
    """All joins of a record, and how sure they are.

    Parameters
    ----------
    before
        The segment before each one, -1 for none, shape (segments,).
    found
        Joins that the tracker had not made, in order of time.
    parted
        What it had held to be one object and more probably is two, in order of time.
    births, deaths
        Objects that are taken to begin after the record's beginning, and to end before its end.
    certificate
        Of the choice, against "no two segments are one object".
    """

    before: IntArray
    found: tuple[Join, ...]
    parted: tuple[Join, ...]
    births: float
    deaths: float
    certificate: Certificate


@dataclass(frozen=True, slots=True, eq=False)
class _Pairs:
    """Segments that end, those that begin, and which of them may be one; columns by pair."""

    ends: IntArray  # Segments
    begins: IntArray
    end: IntArray  # Place in ``ends``
    begin: IntArray  # Place in ``begins``
    wait: FloatArray  # [s]

    def at(self, rows: NDArray[np.bool_]) -> "_Pairs":
        return replace(self, end=self.end[rows], begin=self.begin[rows], wait=self.wait[rows])


def joins_of(  # noqa: PLR0913 all by name but the record
    segments: Segments,
    states: TrackTable,
    *,
    named: Named | None = None,
    known: Collection[int] = (),
    longest: float | None = None,
    merge: float | None = None,
    rng: RandomSource = 0,
) -> Joins | None:
    """Return which segments of a finished record are one object's.

    Parameters
    ----------
    segments
        Pieces of tracks, of which each track's own follow one another.
    states
        Smoothed states of each piece by itself; ``track`` is its number.
    named
        Whom the reports of each segment say that it is; None where they say nothing.
    known
        Tracks that were there before the record began.
    longest
        The longest silence [s]; None for any.
    merge
        Only silences count in which objects may have been one report, which they may be within
        this distance [m]; then nothing is parted. None where all silences count.
    rng
        A generator, or a seed.

    Returns
    -------
    The joins; None where too little was seen to tell how objects move.
    """
    paths = Paths(states)
    span = float(segments.end.max() - segments.begin.min())
    least = float(np.median(segments.interval))
    straying = Straying.learned(paths, segments, least) if span > 0.0 else None
    if straying is None:
        return None
    is_new = ~(np.isin(segments.track, list(known)) & (segments.before < 0))
    by_name = np.full(len(segments), -1, dtype=np.int64) if named is None else named.before
    longest = np.inf if longest is None else longest
    pairs = _candidates(paths, segments, is_new, by_name, longest)
    if merge is not None:
        may = merge_pairs(paths, segments, merge)
        pairs = pairs.at(may[pairs.ends[pairs.end], pairs.begins[pairs.begin]])
    if pairs.wait.size == 0:
        return None
    ways = straying.log_density(
        paths, paths.last[pairs.ends[pairs.end]], paths.first[pairs.begins[pairs.begin]]
    )
    # Of how long a silence lasts nothing is known but its order.
    told = -np.log(np.maximum(pairs.wait, least) * np.log(max(span / least, 2.0)))
    is_known = segments.before[pairs.begins[pairs.begin]] == pairs.ends[pairs.end]
    told += np.where(is_known, KNOWN_LINK, 0.0)
    if named is not None:
        early, late = pairs.ends[pairs.end], pairs.begins[pairs.begin]
        told += named.favour(early, late)
        # Whoever alone is called so is one object, whatever way it went.
        is_one = by_name[late] == early
        told[is_one] += 2.0 * SURE
        went, stood = ways
        ways = np.where(is_one, np.maximum(went, -SURE), went), stood
    rates = _Rates(paths, segments, pairs, span)
    gain, probability = rates.settled(pairs, told, ways)
    if merge is not None:
        # Who is who after a merge may be a guess; that both go on is none.
        followed = np.zeros(pairs.ends.size)
        np.add.at(followed, pairs.end, probability)
        probability = followed[pairs.end]
    before, found, certificate = _chosen(segments, pairs, (gain, probability), rng)
    parted = _parted(segments, pairs, probability, before, doubts=merge is None)
    return Joins(before, found, parted, rates.births, rates.deaths, certificate)


def _candidates(
    paths: Paths,
    segments: Segments,
    is_new: NDArray[np.bool_],
    by_name: IntArray,
    longest: float,
) -> _Pairs:
    """Return which ends and beginnings may be one object's, by how fast it is or by its name."""
    first, last = float(segments.begin.min()), float(segments.end.max())
    edge = EDGE * segments.interval
    # A lone report after a silence may be anybody's: it stays where the tracker put it, or goes.
    moves = segments.count > 1
    is_end, is_begin = moves & (segments.end < last - edge), segments.begin > first + edge
    is_end[by_name[by_name >= 0]] = True
    ends = np.flatnonzero(is_end)
    begins = np.flatnonzero(is_new & (moves & is_begin | (by_name >= 0)))
    states, dim = paths.states, paths.dim
    place = states.mean[:, :dim]
    at_end, at_begin = paths.last[ends], paths.first[begins]
    is_firm = np.bincount(segments.track, segments.count)[segments.track] >= FIRM
    own, other, waits = [], [], []
    for number, row in enumerate(at_begin.tolist()):
        wait = segments.begin[begins[number]] - segments.end[ends]
        # Through usual waits the tracker itself has weighed it; its scraps are rivals' reports.
        is_silence = wait > segments.interval[ends]
        is_break = (wait > 0.0) & is_firm[ends] & is_firm[begins[number]]
        apart = np.sqrt(np.sum((place[at_end] - place[row]) ** 2, axis=1))
        fits = apart <= reach(paths, at_end, np.full(at_end.size, row), wait)
        is_one = ends == by_name[begins[number]]
        near = np.flatnonzero(((is_silence | is_break) & fits | is_one) & (wait <= longest))
        near = np.sort(near[np.argsort(wait[near], kind="stable")[:MOST_ENDS]])
        own.append(near)
        other.append(np.full(near.size, number))
        waits.append(np.maximum(wait[near], 0.0))
    nothing = [np.empty(0, np.int64)]
    return _Pairs(
        ends, begins, np.concatenate(own or nothing), np.concatenate(other or nothing),
        np.concatenate(waits or [np.empty(0)]),
    )  # fmt: skip


class _Kind:
    """One kind of event, such as firm tracks that end: how many, and where."""

    def __init__(self, room: Room, places: Places, which: NDArray[np.bool_]) -> None:
        self._which = which
        rows = np.flatnonzero(which)
        own = Places(places.position[rows], places.speed[rows])
        some = np.unique(np.linspace(0, max(rows.size - 1, 0), min(rows.size, MOST)).astype(int))
        samples = own if some.size == rows.size else Places(*(each[some] for each in own))
        self._near = room.near(samples, own)
        self._even = room.even(own)
        self._some, self._scale = rows[some], rows.size / max(some.size, 1)

    def density(self, weight: FloatArray) -> tuple[float, FloatArray]:
        """Return how many there are, each of some weight, and how dense they are at each."""
        number = float(weight[self._which].sum()) + 0.5
        near = self._near @ weight[self._some] * self._scale
        return number, 0.5 * number * self._even + 0.5 * near


class _Rates:
    """How often segments begin and end for good, and how often as silences."""

    def __init__(self, paths: Paths, segments: Segments, pairs: _Pairs, span: float) -> None:
        self.births = self.deaths = 0.0
        self._span, room = span, Room(paths)
        begun = Places.of(paths, paths.first[pairs.begins], onwards=True)
        ended = Places.of(paths, paths.last[pairs.ends], onwards=False)
        firm_begin, firm_end = segments.is_firm[pairs.begins], segments.is_firm[pairs.ends]
        # Of segments of a few reports many are nobody's: they speak for themselves.
        self._begins = [(w, _Kind(room, begun, w)) for w in (firm_begin, ~firm_begin)]
        self._ends = [(w, _Kind(room, ended, w)) for w in (firm_end, ~firm_end)]
        self._presence = room.presence(ended)

    def settled(
        self, pairs: _Pairs, told: FloatArray, ways: tuple[FloatArray, FloatArray]
    ) -> tuple[FloatArray, FloatArray]:
        """Return what speaks for each pair against two objects [nats], and its probability."""
        # Begun where all are silences: what ends for good has to show.
        begun, ended = np.full(pairs.begins.size, 0.9), np.full(pairs.ends.size, 0.9)
        total, share, (went, stood) = told, np.zeros_like(told), ways
        stops = STOPS
        for _ in range(ROUNDS):
            new, odds = self._new(begun), self._odds(ended)
            either = np.logaddexp(np.log1p(-stops) + went, np.log(stops) + stood)
            total = told + either + np.log(odds)[pairs.end] - np.log(new)[pairs.begin]
            share = _marginals(pairs, total)
            n_stood = float(share @ np.exp(np.log(stops) + stood - either))
            stops = (STOPS * BELIEVED + n_stood) / (BELIEVED + float(share.sum()))
            # Where pairs make circles their probabilities may add up to more than one.
            ended = np.minimum(np.bincount(pairs.end, share, pairs.ends.size), 1.0)
            begun = np.minimum(np.bincount(pairs.begin, share, pairs.begins.size), 1.0)
        return total, share

    def _new(self, begun: FloatArray) -> FloatArray:
        """Return the density of beginnings that no silence went before, per second."""
        density = np.empty_like(begun)
        numbers = []
        for which, kind in self._begins:
            number, density[which] = kind.density(1.0 - begun)
            numbers.append(number)
        self.births = numbers[0] - 0.5
        return density / self._span

    def _odds(self, ended: FloatArray) -> FloatArray:
        """Return how many times as often objects fall silent as they end, at each end."""
        odds, numbers = np.empty_like(ended), []
        for which, kind in self._ends:
            number, over = kind.density(1.0 - ended)
            odds[which] = (float(ended[which].sum()) + 0.5) * self._presence[which] / over
            numbers.append(number)
        self.deaths = numbers[0] - 0.5
        return odds


def _marginals(pairs: _Pairs, gain: FloatArray) -> FloatArray:
    """Return how probable each pair is if each end and beginning is in one at most."""
    # Belief propagation, exact where pairs make no circle: J. L. Williams, R. A. Lau, Approximate
    # evaluation of marginal association probabilities with belief propagation, IEEE Trans.
    # Aerospace and Electronic Systems 50 (4), 2014.
    odds = np.exp(np.minimum(gain, SURE))
    back: FloatArray = np.ones(odds.size)
    for _ in range(MESSAGES):
        wanted = odds * back
        others = np.bincount(pairs.end, wanted, pairs.ends.size)[pairs.end] - wanted
        offer = odds / (1.0 + np.maximum(others, 0.0))
        rivals = np.bincount(pairs.begin, offer, pairs.begins.size)[pairs.begin] - offer
        back = np.asarray(1.0 / (1.0 + np.maximum(rivals, 0.0)))
    wanted = odds * back
    return np.asarray(wanted / (1.0 + np.bincount(pairs.end, wanted, pairs.ends.size)[pairs.end]))


def _chosen(
    segments: Segments, pairs: _Pairs, odds: tuple[FloatArray, FloatArray], rng: RandomSource
) -> tuple[IntArray, tuple[Join, ...], Certificate]:
    """Return the best choice; of what it joins anew, what is clear."""
    gain, probability = odds
    worth = np.flatnonzero(gain > 0.0)
    tuples = np.stack([pairs.end[worth] + 1, pairs.begin[worth] + 1], axis=1)
    problem = AssignmentProblem.from_tuples(tuples, -np.minimum(gain[worth], SURE))
    answer = solve(problem, rng=rng)
    assert problem.row is not None
    rows = problem.row[answer.nodes]
    before = np.full(len(segments), -1, dtype=np.int64)
    found = []
    for row in np.sort(worth[rows[rows >= 0]]).tolist():
        early, late = int(pairs.ends[pairs.end[row]]), int(pairs.begins[pairs.begin[row]])
        if segments.before[late] != early:
            if probability[row] < CLEAR:
                continue
            found.append(Join(early, late, float(pairs.wait[row]), float(probability[row])))
        before[late] = early
    found.sort(key=lambda join: segments.begin[join.after])
    return before, tuple(found), answer.certificate


def _parted(
    segments: Segments, pairs: _Pairs, probability: FloatArray, before: IntArray, *, doubts: bool
) -> tuple[Join, ...]:
    """Give ``before`` what the tracker held to be one, and return what is doubted of it."""
    ends, begins = pairs.ends[pairs.end], pairs.begins[pairs.begin]
    # Of a few reports nothing is clear enough to doubt the tracker, which saw its rivals.
    firm = segments.is_firm[ends] & segments.is_firm[begins]
    own = (segments.before[begins] == ends) & firm & (probability < DOUBTED) & doubts
    doubted = dict(zip(begins[own].tolist(), np.flatnonzero(own).tolist(), strict=True))
    followed = np.zeros(len(segments), dtype=np.bool_)
    followed[before[before >= 0]] = True
    parted = []
    for late in np.flatnonzero((segments.before >= 0) & (before < 0)).tolist():
        early = int(segments.before[late])
        if late in doubted:
            row = doubted[late]
            parted.append(Join(early, late, float(pairs.wait[row]), float(probability[row])))
        elif not followed[early]:
            before[late], followed[early] = early, True
    parted.sort(key=lambda join: segments.begin[join.after])
    return tuple(parted)
