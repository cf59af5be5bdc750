"""Which tracks began where another divided, looked for over a finished record.

A tracker that sees a cell divide goes on with one daughter under the mother's name and begins a
track for the other. Here every track that begins is weighed: a division of one nearby, at a rate
and with a spread that the record itself tells, or an object that is new there. Which mothers have
which daughters is an assignment problem: nobody has two mothers, nobody divides twice at once.
"""

from collections.abc import Collection, Iterator
from dataclasses import dataclass, replace
from itertools import combinations
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from trackweave.arrays import FloatArray, IntArray
from trackweave.association.problem import AssignmentProblem, Certificate
from trackweave.domain.tracks import TENTATIVE, TrackTable
from trackweave.randomness import RandomSource
from trackweave.solvers.solving import solve

__all__ = ["Division", "Divisions", "divisions_of"]

# A daughter is seen at most so many periods after its mother was.
_REACH = 3.5
_ROUNDS = 60
_MOST = 500.0
"""Nobody is surer than this [nats]."""


@dataclass(frozen=True, slots=True)
class Division:
    """A track that ends in two."""

    mother: int
    time: float
    """When the daughters are first seen [s]."""
    daughters: tuple[int, ...]
    """The tracks that begin then: one where the other goes on under the mother's name."""


@dataclass(frozen=True, slots=True, eq=False)
class Divisions:
    """All divisions of a record, and how sure they are.

    Parameters
    ----------
    found
        In order of time.
    rate
        Divisions per object and second; 0 where the record tells of none.
    spread
        Standard deviation of a daughter's first place along each axis [m], one period after the
        mother's last.
    birth_density
        Objects that begin otherwise per m² (m³) and period.
    certificate
        Of the assignment of daughters to mothers, against "all are new".
    """

    found: tuple[Division, ...]
    rate: float
    spread: float
    birth_density: float
    certificate: Certificate


@dataclass(frozen=True, slots=True, eq=False)
class _Pairs:
    """Tracks that begin, and mothers that they may have; columns are of equal length."""

    child: IntArray  # Counts the tracks that begin
    mother: IntArray  # Number of the track
    time: FloatArray  # When the child is first seen [s]
    waited: FloatArray  # Periods since the mother was seen before, at least 1
    squared: FloatArray  # Squared distance from where the mother was expected then [m²]
    goes_on: NDArray[np.bool_]  # Whether the mother is still seen

    def at(self, rows: NDArray[np.bool_]) -> "_Pairs":
        return _Pairs(*(getattr(self, name)[rows] for name in self.__dataclass_fields__))


_Slot: TypeAlias = tuple[int, float | None]
"""A mother, and when she divides while she goes on; None for her end."""
_Items: TypeAlias = tuple[_Slot, tuple[int, ...]]
"""What an offer takes: who divides, and the children."""


class _Size(NamedTuple):
    """How large a record is."""

    n_begun: int
    """Tracks that begin after the first scan."""
    n_states: int
    room: float
    """Where objects may begin [m² or m³]."""
    n_periods: int
    dim: int


@dataclass(frozen=True, slots=True)
class _Habits:
    """How often objects divide and begin, for one period."""

    rate: float
    variance: float
    births: float
    price: float = 0.0
    """What divisions have to explain, all together, so that there are any [nats]."""


def divisions_of(
    history: TrackTable,
    *,
    known: Collection[int] = (),
    survival: float = 0.999,
    birth_density: float | None = None,
    rng: RandomSource = 0,
) -> Divisions:
    """Return which tracks of a finished record divided.

    Parameters
    ----------
    history
        Smoothed states of all tracks, each from its first report to its last; tentative ones
        neither divide nor are daughters.
    known
        Tracks that were there before the record begins.
    survival
        Chance that an object is still there one period later.
    birth_density
        Objects that begin otherwise per m² (m³) and period; None for what the record tells.
    rng
        A generator, or a seed.

    Returns
    -------
    The divisions. None where they explain no more of the record than chance would.

    Examples
    --------
    >>> import numpy as np
    >>> import trackweave as tw
    >>> from trackweave.trackers.divisions import divisions_of
    >>> divisions_of(tw.TrackTable.empty(2)).found
    ()
    """
    rows = history.at(history.status > TENTATIVE)
    rows = rows.at(np.lexsort((rows.time, rows.track)))
    times = np.unique(rows.time)
    nothing = Divisions((), 0.0, 0.0, birth_density or 0.0, solve(_problem([], 0)).certificate)
    if times.size < 2:
        return nothing
    period = float(np.median(np.diff(times)))
    begins, pairs = _candidates(rows, period, set(known))
    if pairs.child.size == 0:
        return nothing
    place = rows.mean[:, : rows.dim]
    room = float(np.prod(np.maximum(np.ptp(place, axis=0), _least_extent(place))))
    # An end that no division explains; each daughter tells half of it.
    ends = np.where(pairs.goes_on, 0.0, -0.5 * np.log1p(-survival))
    size = _Size(begins.size, len(rows), room, times.size, rows.dim)
    habits = _learned(pairs, ends, size, birth_density)
    offers = list(_offers(pairs, habits, _gain(pairs, ends, habits, rows.dim)))
    problem = _problem([(items, cost) for _, items, cost in offers], begins.size)
    answer = solve(problem, rng=rng)
    if -answer.cost <= habits.price:
        return nothing
    found = [
        Division(mother, time, tuple(begins[list(children)].tolist()))
        for (mother, time, children) in (offers[row][0] for row in _chosen(problem, answer.nodes))
    ]
    found.sort(key=lambda one: (one.time, one.mother))
    return Divisions(
        tuple(found), habits.rate / period, float(np.sqrt(habits.variance)), habits.births,
        answer.certificate,
    )  # fmt: skip


def _candidates(
    rows: TrackTable, period: float, known: Collection[int]
) -> tuple[IntArray, _Pairs]:
    """Return the tracks that begin after the first scan, and whose daughters they may be."""
    first = np.flatnonzero(np.diff(rows.track, prepend=-1))
    last = np.r_[first[1:], len(rows)] - 1
    tracks, dim = rows.track[first], rows.dim
    late = (rows.time[first] > rows.time.min()) & ~np.isin(tracks, list(known))
    begins, parts = np.flatnonzero(late), []
    for number, child in enumerate(begins.tolist()):
        time = float(rows.time[first[child]])
        near = np.flatnonzero(
            (rows.time[first] < time) & (rows.time[last] >= time - _REACH * period)
        )
        before = np.array(
            [
                first[k] + np.searchsorted(rows.time[first[k] : last[k] + 1], time) - 1
                for k in near.tolist()
            ],
            dtype=np.int64,
        )
        waited = time - rows.time[before]
        good = waited <= _REACH * period
        near, before, waited = near[good], before[good], waited[good]
        expected = rows.mean[before, :dim] + waited[:, np.newaxis] * rows.mean[before, dim:]
        apart = expected - rows.mean[first[child], :dim]
        parts.append(
            _Pairs(
                np.full(near.size, number), tracks[near], np.full(near.size, time),
                np.maximum(waited / period, 1.0), np.sum(apart**2, axis=1),
                rows.time[last[near]] >= time,
            )
        )  # fmt: skip
    empty = np.empty(0)
    pairs = _Pairs(
        empty.astype(np.int64), empty.astype(np.int64), empty, empty, empty, empty.astype(np.bool_)
    )
    if parts:
        names = _Pairs.__dataclass_fields__
        pairs = _Pairs(*(np.concatenate([getattr(p, name) for p in parts]) for name in names))
    # Who ends needs two daughters.
    ended, count = np.unique(pairs.mother[~pairs.goes_on], return_counts=True)
    return tracks[begins], pairs.at(pairs.goes_on | np.isin(pairs.mother, ended[count > 1]))


def _least_extent(place: FloatArray) -> float:
    """Return what an axis is long at least [m], along which nothing may spread."""
    return max(1e-3 * float(np.ptp(place, axis=0).max(initial=0.0)), 1e-9)


def _learned(pairs: _Pairs, ends: FloatArray, size: _Size, told: float | None) -> _Habits:
    """Return rate, spread and births by expectation and maximisation."""
    # Tracks begin as a sum of two processes: births that are even over the room, and daughters
    # about their mothers.
    n_begun, n_states, room, n_periods, dim = size
    weight = np.where(pairs.goes_on, 1.0, 0.5)
    nearest = np.full(n_begun, np.inf)
    np.minimum.at(nearest, pairs.child, pairs.squared / (dim * pairs.waited))
    spacing = (room / max(1.0, n_states / n_periods)) ** (2.0 / dim)
    usual = min(float(np.median(nearest[np.isfinite(nearest)])), 0.25 * spacing)
    usual = max(usual, 1e-12 * spacing)
    births = n_begun / (room * n_periods) if told is None else told
    habits = _Habits(0.5 * n_begun / n_states, usual, 0.5 * births if told is None else told)
    for _ in range(_ROUNDS):
        ratio = habits.rate * np.exp(np.minimum(_gain(pairs, ends, habits, dim), _MOST))
        share = ratio / (1.0 + np.bincount(pairs.child, ratio, n_begun))[pairs.child]
        n_divided = float(np.sum(share * weight))
        n_born = max(n_begun - float(np.sum(share)), 0.0)
        squares = float(np.sum(share * pairs.squared / (dim * pairs.waited)))
        # Half a division and half a birth that nobody saw: no rate is ever 0.
        habits = _Habits(
            (0.5 + n_divided) / n_states,
            min((usual + squares) / (1.0 + float(np.sum(share))), 0.25 * spacing),
            (0.5 + n_born) / (room * n_periods) if told is None else told,
        )
    expected = (habits.births - births) * room * n_periods + habits.rate * n_states
    # Two numbers more than births alone have to be worth it (Schwarz's criterion).
    price = n_begun * float(np.log(births / habits.births)) + expected + np.log(n_begun + 1.0)
    return replace(habits, price=price)


def _gain(pairs: _Pairs, ends: FloatArray, habits: _Habits, dim: int) -> FloatArray:
    """Return how much likelier each child is its mother's than new, the rate apart [nats]."""
    own = habits.variance * pairs.waited
    density = -0.5 * (pairs.squared / own + dim * np.log(2.0 * np.pi * own))
    return np.asarray(density - np.log(habits.births) + ends)


def _offers(
    pairs: _Pairs, habits: _Habits, gain: FloatArray
) -> Iterator[tuple[tuple[int, float, tuple[int, ...]], _Items, float]]:
    """Yield who may divide when into whom, what is taken by it, and what it costs [nats]."""
    rate = float(np.log(habits.rate))
    for row in np.flatnonzero(pairs.goes_on & (rate + gain > 0)).tolist():
        mother, time, child = int(pairs.mother[row]), float(pairs.time[row]), int(pairs.child[row])
        yield (mother, time, (child,)), ((mother, time), (child,)), -rate - float(gain[row])
    rows_of: dict[int, list[int]] = {}
    for row in np.flatnonzero(~pairs.goes_on).tolist():
        rows_of.setdefault(int(pairs.mother[row]), []).append(row)
    for mother, rows in rows_of.items():
        for one, other in combinations(rows, 2):
            total = rate + float(gain[one] + gain[other])
            if total > 0:
                children = (int(pairs.child[one]), int(pairs.child[other]))
                time = float(min(pairs.time[one], pairs.time[other]))
                yield (mother, time, children), ((mother, None), children), -total


def _problem(offers: list[tuple[_Items, float]], n_begun: int) -> AssignmentProblem:
    """Return the choice of offers that share neither a child nor a mother at one time."""
    slots: dict[_Slot, int] = {}
    parent, item, total, row = list[int](), list[int](), list[float](), list[int]()
    for number, ((slot, children), cost) in enumerate(offers):
        items = [slots.setdefault(slot, n_begun + len(slots)), *children]
        for place, each in enumerate(items):
            is_last = place == len(items) - 1
            parent.append(len(item) - 1 if place else -1)
            item.append(each)
            total.append(cost if is_last else np.inf)
            row.append(number if is_last else -1)
    n_items = n_begun + len(slots)
    least = np.where(np.isfinite(total), total, 0.0)
    return AssignmentProblem(
        parent=np.array(parent, np.int64), item=np.array(item, np.int64), cost=least,
        total=np.array(total, np.float64), must_cover=np.zeros(n_items, np.bool_),
        instant=np.zeros(n_items, np.int64), row=np.array(row, np.int64),
    )  # fmt: skip


def _chosen(problem: AssignmentProblem, nodes: IntArray) -> list[int]:
    assert problem.row is not None
    return [row for row in problem.row[nodes].tolist() if row >= 0]
