"""Which of the live tracks are of one object, as an assignment problem."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtri

from trackweave.arrays import FloatArray, IntArray
from trackweave.association.problem import AssignmentProblem, Certificate, Status
from trackweave.fusion._growth import Terms, Tuples, grow, judge_all
from trackweave.fusion._pairs import Live, Pairs, label_components, sweep, thin, weigh_pairs
from trackweave.fusion._statistic import Form, Rings
from trackweave.fusion.statistic import Statistic, quantiles
from trackweave.solvers.auto import Auto
from trackweave.solvers.protocol import Solver

__all__ = ["Grouping", "Groups", "Scene", "labelled", "nothing_to_choose"]

NEARLY_NEVER = 1e-9
"""Probability of leaving out a pair of one object for being far apart along an axis."""

TIE = 1e-6
"""What being held is worth where nothing else tells [nats]."""


class Scene(NamedTuple):
    """What there is to group: remembered estimates, the slots that count, and live tracks."""

    rings: Rings
    slots: IntArray
    live: Live


@dataclass(frozen=True, slots=True, eq=False)
class Groups:
    """Live tracks in groups, one object each.

    ``label`` is the group of each live track, numbered from 0; ``value`` and ``threshold`` are the
    statistic of each track's group and what it was allowed to be, 0 for a track alone. The search
    chose from ``n_tuples``; ``n_pruned`` were left out for want of room. The certificate's bound
    covers neither these nor pairs that were left out because both tracks have a far better
    partner.
    """

    label: IntArray
    value: FloatArray
    threshold: FloatArray
    certificate: Certificate
    n_tuples: int
    n_pruned: int


@dataclass(frozen=True, slots=True)
class Grouping:
    """How live tracks are grouped.

    A tuple may be of one object where its statistic is within the threshold; then it costs half
    of what the statistic exceeds the price of its joins by, and a track alone costs nothing.

    A join is worth what the statistic of a pair of one object exceeds with α / M² for M sensors:
    so of the tuples that pass their own test at α, hardly any gains by leaving out a member.
    """

    statistic: Statistic
    # Above 0 and at most 1: what is held as a whole is tested at so many times the false-rejection
    # rate, and two tracks change places only where that is as many times likelier the other way
    # round: each held join is worth −ln of it.
    hysteresis: float = 0.1
    # A pair is left out where both tracks have a partner better by this much [twice nats].
    margin: float = 40.0
    breadth: int = 16  # How many tuples of each size are kept per first track at least
    room: int = 30_000  # More are kept where that makes about so many tuples of a component

    def __call__(self, scene: Scene, search: Solver | None, rng: np.random.Generator) -> Groups:
        """Return the groups of least cost that ``search``, or else ``Auto``, finds."""
        live = scene.live
        n_tracks, n_sensors = live.row.shape[0], int(live.sensor.max(initial=-1)) + 1
        if not n_tracks:
            return nothing_to_choose(0)
        form, terms = self.form_and_terms(scene, n_sensors)
        pairs = self._pairs(scene, form, terms, n_sensors)
        label = label_components(n_tracks, pairs.first, pairs.second)
        order = np.lexsort((np.arange(n_tracks), live.sensor, label))
        easy, hard = self._easy(scene, form, terms, (label, order))
        grown = [self._grow(scene, form, terms, places, pairs) for places in hard]
        parts = [_held_together(part, live) for part, _ in grown]
        candidates = _joined(parts, n_sensors)
        chosen, certificate = _choose(candidates, live, search, rng)
        member = np.concatenate([easy.member, candidates.member[chosen]])
        value = np.concatenate([easy.value, candidates.value[chosen]])
        limit = np.concatenate([easy.limit, candidates.limit[chosen]])
        cost = float(easy.cost.sum())
        return Groups(
            *labelled(member, value, limit, n_tracks),
            _certificate(certificate.cost + cost, certificate.lower_bound + cost),
            len(easy.cost) + len(candidates.cost),
            sum(dropped for _, dropped in grown),
        )

    def form_and_terms(self, scene: Scene, n_sensors: int) -> tuple[Form, Terms]:
        """Return what kernels need to know of the statistic and of costs."""
        statistic, n = self.statistic, scene.live.mean.shape[1]
        n_sensors = max(n_sensors, 2)
        width = n_sensors**2 if statistic.kind == "all-pairs" else n_sensors
        size = n * len(scene.slots) * width
        form = statistic.form(scene.slots, size)
        held = statistic.form(scene.slots, size, statistic.false_rejection * self.hysteresis)
        rate = statistic.false_rejection / n_sensors**2
        table = (form.quantile.shape[0] - 1) // 4
        weight = float(form.weight.sum())
        # Beyond the greatest threshold that any tuple can have.
        bound = float(held.quantile[-1])
        if statistic.kind != "all-pairs":
            freedom = n * len(scene.slots) * (n_sensors - 1)
            rare = float(chdtri(freedom, 1e-3 * statistic.false_rejection))
            wider = 2.0 if statistic.correlation in {"effective", "both"} else 1.0
            bound = weight / len(scene.slots) * rare * wider
        terms = Terms(
            quantiles(rate, table), held.quantile, -float(np.log(self.hysteresis)),
            bound, self.breadth,
        )  # fmt: skip
        return form, terms

    def _pairs(self, scene: Scene, form: Form, terms: Terms, n_sensors: int) -> Pairs:
        live = scene.live
        most = float(chdtri(1.0, NEARLY_NEVER))
        # Sorted along the axis on which tracks are spread the most, beside their sizes.
        variance = np.diagonal(live.spread, axis1=1, axis2=2)
        reach = np.sqrt(most * variance)
        axis = int(np.argmax(np.ptp(live.mean, axis=0) / (np.median(reach, axis=0) + 1e-300)))
        turned = live
        if axis:
            turn = np.roll(np.arange(live.mean.shape[1]), -axis)
            turned = live._replace(
                mean=np.ascontiguousarray(live.mean[:, turn]),
                spread=np.ascontiguousarray(live.spread[:, turn][:, :, turn]),
            )
        first, second = sweep(turned, np.ascontiguousarray(reach[:, axis]), most)
        pairs = weigh_pairs(scene.rings, form, terms.price, live, first, second, terms.bound)
        keep = thin(live, pairs, n_sensors, self.margin)
        return Pairs._make(part[keep] for part in pairs)

    def _easy(
        self, scene: Scene, form: Form, terms: Terms, parts: tuple[IntArray, IntArray]
    ) -> tuple[Tuples, list[IntArray]]:
        """Return the components that are one tuple beyond doubt, and the places of the others."""
        live = scene.live
        label, order = parts
        start = np.flatnonzero(np.diff(label[order], prepend=-1))
        size = np.diff(start, append=order.shape[0])
        same = (np.diff(label[order]) == 0) & (np.diff(live.sensor[order]) == 0)
        crowded = np.zeros(start.shape[0], dtype=np.bool_)
        crowded[label[order[1:]][same]] = True
        lone = np.flatnonzero((size > 1) & ~crowded)
        member = np.full((start.shape[0], int(live.sensor.max()) + 1), -1, dtype=np.int64)
        member[label[order], live.sensor[order]] = order
        whole = judge_all(scene.rings, form, terms, live, member[lone])
        sure = _is_held(whole, live) | (
            whole.is_allowed & _is_best_whole(scene, form, terms, whole)
        )
        easy = Tuples._make(part[sure] for part in whole)
        rest = np.concatenate([lone[~sure], np.flatnonzero(crowded)])
        return easy, [order[start[i] : start[i] + size[i]] for i in np.sort(rest)]

    def _grow(
        self, scene: Scene, form: Form, terms: Terms, places: IntArray, pairs: Pairs
    ) -> tuple[Tuples, int]:
        local = np.full(scene.live.row.shape[0], -1, dtype=np.int64)
        local[places] = np.arange(places.shape[0])
        near = np.zeros((places.shape[0],) * 2, dtype=np.bool_)
        inside = local[pairs.first] >= 0
        first, second = local[pairs.first[inside]], local[pairs.second[inside]]
        near[first, second] = near[second, first] = True
        n_kinds = places.shape[0] * (int(scene.live.sensor.max()) + 1)
        terms = terms._replace(breadth=max(self.breadth, self.room // n_kinds))
        return grow(scene.rings, form, terms, scene.live, places, near)


def _is_best_whole(scene: Scene, form: Form, terms: Terms, whole: Tuples) -> NDArray[np.bool_]:
    """Tell which tuples would not gain by leaving out a member."""
    best = whole.cost <= 0.0
    for column in range(whole.member.shape[1]):
        fewer = whole.member.copy()
        fewer[:, column] = -1
        apart = judge_all(scene.rings, form, terms, scene.live, fewer)
        best &= apart.cost >= whole.cost
    return np.asarray(best)


def _is_held(tuples: Tuples, live: Live) -> NDArray[np.bool_]:
    """Tell which tuples are an object as it is held, and within its threshold."""
    # Places of -1 read an entry too many, which is taken out again.
    held = np.where(tuples.member >= 0, np.append(live.held, -1)[tuples.member], -1)
    number = held.max(axis=1, initial=-1)
    is_one = (tuples.member < 0) | (held == number[:, None])
    size = np.bincount(live.held[live.held >= 0], minlength=1)
    is_all = np.count_nonzero(tuples.member >= 0, axis=1) == size[np.maximum(number, 0)]
    return np.asarray(tuples.is_allowed & (number >= 0) & is_one.all(axis=1) & is_all)


def _held_together(tuples: Tuples, live: Live) -> Tuples:
    """Return tuples where no held object costs more than its own tracks apart."""
    # A member may pay for being left out though all pass their test together: an object would
    # split and merge again and again with nothing else to go to.
    cost = tuples.cost.copy()
    for row in np.flatnonzero(_is_held(tuples, live)):
        own = tuples.member[row]
        inside = ((tuples.member == own) | (tuples.member < 0)).all(axis=1)
        part = np.flatnonzero(inside & tuples.is_allowed)
        left, apart = own >= 0, 0.0
        for other in part[np.argsort(tuples.cost[part], kind="stable")]:
            taken = tuples.member[other] >= 0
            if tuples.cost[other] < 0.0 and left[taken].all():
                apart += tuples.cost[other]
                left &= ~taken
        cost[row] = min(cost[row], apart - TIE, -TIE)
    return tuples._replace(cost=cost)


def _joined(parts: list[Tuples], n_sensors: int) -> Tuples:
    """Return the tuples of several components that may be chosen and are worth it."""
    none = np.empty(0)
    empty = Tuples(
        np.empty((0, n_sensors), dtype=np.int64), none, none, none, np.empty(0, dtype=np.bool_)
    )
    columns = zip(empty, *parts, strict=True)
    every = Tuples._make(np.concatenate(column) for column in columns)
    useful = every.is_allowed & (every.cost < 0.0)
    return Tuples._make(part[useful] for part in every)


def _choose(
    candidates: Tuples, live: Live, search: Solver | None, rng: np.random.Generator
) -> tuple[NDArray[np.intp], Certificate]:
    """Return the chosen tuples, and how good the choice is."""
    none = np.empty(0, dtype=np.intp)
    if not candidates.cost.size:
        return none, _certificate(0.0, 0.0)
    # Numbered from 1 within each sensor, without gaps.
    table = np.zeros_like(candidates.member)
    for column in range(table.shape[1]):
        taken = candidates.member[:, column] >= 0
        _, number = np.unique(candidates.member[taken, column], return_inverse=True)
        table[taken, column] = number + 1
    problem = AssignmentProblem.from_tuples(table, candidates.cost)
    answer = (search or Auto())(problem, rng=rng)
    assert problem.row is not None
    return problem.row[answer.nodes].astype(np.intp), answer.certificate


def labelled(
    member: IntArray, value: FloatArray, limit: FloatArray, n_tracks: int
) -> tuple[IntArray, FloatArray, FloatArray]:
    """Return each track's group, and the statistic and threshold of that."""
    # ``member`` are tuples, one column per sensor with places of tracks, -1 for none; tracks in no
    # tuple are alone.
    label = np.full(n_tracks, -1, dtype=np.int64)
    row, column = np.nonzero(member >= 0)
    label[member[row, column]] = row
    alone = label < 0
    label[alone] = member.shape[0] + np.arange(np.count_nonzero(alone))
    padded = np.concatenate([np.stack([value, limit]), np.zeros((2, int(alone.sum())))], axis=1)
    return label, padded[0, label], padded[1, label]


def nothing_to_choose(n_tracks: int) -> Groups:
    """Return each track alone, where there is nothing that it could be grouped with."""
    zero = np.zeros(n_tracks)
    return Groups(np.arange(n_tracks), zero, zero, _certificate(0.0, 0.0), 0, 0)


def _certificate(cost: float, lower_bound: float) -> Certificate:
    proven = cost - lower_bound <= 1e-9 * max(1.0, abs(cost))
    return Certificate(cost, lower_bound, Status.OPTIMAL if proven else Status.FEASIBLE)
