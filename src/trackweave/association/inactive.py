"""Components that no scan concerns for a while: inactive clusters, which nobody goes over."""

import copy
import math
from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from trackweave.arrays import FloatArray, IntArray
from trackweave.association._gating import most_moved
from trackweave.association._inactive import Whereabouts, concerned, label_families, locate
from trackweave.association._moving import copy_nodes
from trackweave.association._nodes import (
    Nodes,
    ScanInput,
    WindowRule,
    allocate,
    bare,
    joined,
    larger,
    n_modes_and_size,
    new_families,
    part_of,
    sizes_of,
)
from trackweave.association.problem import Certificate, Status
from trackweave.association.tree import AssociationTree

__all__ = ["InactiveClusters"]

LITTLE = 500
"""So few sequences are sooner gone over than made inactive."""


@dataclass(slots=True)
class _Components:
    """The inactive clusters, a row each.

    ``first`` and ``count`` say where its nodes are, ``first_family`` and ``n_families`` where its
    families; ``living`` is what living on had cost until then and ``settling`` how far, in powers
    of e, who was hidden then had become as anybody [nats, 1], ``cost`` what its part of the
    answer costs [nats], and ``debt`` under which number its gap is owed, -1 for none.
    """

    first: IntArray
    count: IntArray
    first_family: IntArray
    n_families: IntArray
    living: FloatArray
    settling: FloatArray
    cost: FloatArray
    debt: IntArray
    time: FloatArray
    begin: FloatArray
    end: FloatArray
    radius: FloatArray

    @classmethod
    def none(cls) -> Self:
        """Return no components."""
        zero, nothing, place = np.empty(0, dtype=np.int64), np.empty(0), np.empty((0, 2))
        return cls(
            zero, zero, zero, zero, nothing, nothing, nothing, zero, nothing, place, place, nothing
        )

    def joined(self, other: Self) -> Self:
        """Return these and others behind them."""
        names = [field.name for field in fields(self)]
        pairs = [(getattr(self, name), getattr(other, name)) for name in names]
        return type(self)(*map(np.concatenate, pairs))

    def part(self, which: NDArray[np.bool_]) -> Self:
        """Return some of them."""
        rows = np.flatnonzero(which)
        return type(self)(*(getattr(self, f.name)[rows] for f in fields(self)))

    def whereabouts(self) -> Whereabouts:
        """Return where their objects are."""
        return Whereabouts(self.time, self.begin, self.end, self.radius)


class InactiveClusters:
    """Holds the components of a tree that the latest scans cannot have seen.

    A component is families that share reports, directly or over others. Where a scan does not
    look, nothing happens but that time passes: its sequences cost more by what living on costs,
    and that is made up for when a scan concerns it again. So a scan costs as much as there is
    where it looks, not as much as there is. After ``horizon`` seconds a component is looked at
    whatever happens.
    """

    def __init__(self, rule: WindowRule, horizon: float) -> None:
        self._rule = rule
        self._horizon = horizon
        self._components = _Components.none()
        self._living = self._settling = self._usually_hidden = 0.0
        self._last_time = -np.inf
        self._debts: dict[int, float] = {}
        self._next_debt = 0
        self.nodes = allocate(256, *n_modes_and_size(rule.motion), rule.unseen.shape[0])
        """The sequences: of a component the parents count from its first, and so do families
        from the first of all. What has been brought back is neither chosen nor believed in."""
        self.n_rows = 0
        """How many rows of ``nodes`` are in use."""
        self.families = new_families(np.empty(0, dtype=np.int64), np.empty(0))
        self._taken: list[tuple[Nodes, IntArray, IntArray, FloatArray]] = []
        """What rows brought back since ``saved`` held: chosen or not, and beliefs."""

    def saved(self) -> Self:
        """Return the inactive clusters as they are now; ``undone`` makes it so again."""
        self._taken = []
        return copy.copy(self)

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_debts": self._debts.copy()}

    def at_rest(self) -> dict[str, Any]:
        """Return what a checkpoint holds: neither spare rows nor what would undo a step."""
        nodes = larger(self.nodes, self.n_rows, self.n_rows)
        return {**self.__getstate__(), "nodes": nodes, "_taken": []}

    def undone(self) -> Self:
        """Return what was ``saved``, with its rows as they were then."""
        for nodes, rows, chosen, belief in self._taken:
            nodes.chosen[rows], nodes.belief[rows] = chosen, belief
        return self

    @property
    def n_nodes(self) -> int:
        """Number of sequences of inactive clusters."""
        return int(self._components.count.sum())

    @property
    def cost(self) -> float:
        """What the parts of the answer that are inactive cost, as of then [nats]."""
        return float(self._components.cost.sum())

    @property
    def gap(self) -> float:
        """How much better they may be at most, by the bounds of then [nats]."""
        return sum(self._debts.values())

    def parts(self) -> tuple[FloatArray, FloatArray, IntArray, IntArray]:
        """Return what each cluster costs and where it was; slots of reports, and whose each is."""
        # Of what is long inactive the slots may be closed.
        known = self._components
        slot = self.nodes.report[_spans(known.first, known.count)]
        owner = np.repeat(np.arange(known.count.shape[0]), known.count)
        return known.cost, known.begin, slot[slot >= 0], owner[slot >= 0]

    def beside(self, rows: IntArray) -> tuple[Nodes, int, IntArray]:
        """Return the clusters of some rows as a room of their own, and the rows' places there."""
        known = self._components
        owner = np.searchsorted(known.first, rows, side="right") - 1
        own, number = np.unique(owner, return_inverse=True)
        first, count = known.first[own], known.count[own]
        held = _spans(first, count)
        room = allocate(held.shape[0], *sizes_of(self.nodes))
        copy_nodes(self.nodes, held, room, 0)
        shift = first - _starts(count)
        return room, held.shape[0], rows - shift[number]

    def certificate(self, awake: Certificate) -> Certificate:
        """Return the certificate of the whole, given that of what was looked at."""
        if not self.n_nodes:
            return awake
        bound = awake.lower_bound + self.cost - self.gap
        status = Status.FEASIBLE if self.gap > 0.0 else awake.status
        return Certificate(awake.cost + self.cost, bound, status)

    def exchange(
        self,
        tree: AssociationTree,
        scan: ScanInput,
        gap: float,
        ahead: Sequence[ScanInput] | None = (),
    ) -> None:
        """Make inactive what a scan cannot concern, and bring back what it may, before growth."""
        # The tree is changed; the gap is how much better the last answer may be at most [nats].
        # ``ahead`` are scans by which the tree grows before anything else is brought back, for
        # which None is given then.
        if ahead is not None:
            self._exchange(tree, (scan, *ahead), gap)
        self._living += scan.survival_cost
        if scan.hiding > 0.0:
            self._settling -= math.log1p(-min(scan.hiding + scan.showing, 1.0 - 1e-12))
            self._usually_hidden = scan.hiding / (scan.hiding + scan.showing)
        self._last_time = scan.time

    def _exchange(self, tree: AssociationTree, scans: Sequence[ScanInput], gap: float) -> None:
        if self._rule.way is not None or any(each.coverage.everywhere for each in scans):
            # What moves as no kernel knows is looked at by every scan.
            self.bring_back(tree, scans[0].time)
        else:
            if tree.n_nodes >= LITTLE:
                self._deactivate(tree, scans, gap)
            told = self._concerned(self._components.whereabouts(), scans)
            self._take(tree, told, scans[0].time)

    def bring_back(self, tree: AssociationTree, time: float) -> None:
        """Bring back everything; ``time`` is that of the scan that comes next [s]."""
        self._take(tree, np.ones(self._components.count.shape[0], dtype=np.bool_), time)

    def _concerned(self, known: Whereabouts, scans: Sequence[ScanInput]) -> NDArray[np.bool_]:
        """Tell which components one of several scans may concern."""
        count = known.time.shape[0]
        told = np.zeros(count, dtype=np.bool_)
        for scan in scans:
            slack = float(most_moved(bare(scan), self._rule.motion.max_speed))
            at, horizon = scan.reference, self._horizon
            told |= concerned(known, count, scan.coverage, at, horizon, slack)
        return told

    def _deactivate(self, tree: AssociationTree, scans: Sequence[ScanInput], gap: float) -> None:
        """Make inactive the components of the tree that no scan can concern."""
        nodes, n = tree.nodes, tree.n_nodes
        slots, place = tree.slots()
        label, count = label_families(nodes.family, place, n, slots.shape[0], tree.n_families)
        own = label[nodes.family[:n]]
        # What a scan may see of one sequence it may see of the component: that is most of those
        # that grow, and saves asking where all their sequences are.
        growing = np.flatnonzero(nodes.tail[:n] != math.inf)
        example = np.full(count, -1, dtype=np.int64)
        example[own[growing]] = growing
        known = self._located(tree, example[example >= 0], label, count)
        seen = self._concerned(known, scans)
        rows = np.flatnonzero(~seen[own])
        known = self._located(tree, rows, label, count)
        is_over = ~(seen | self._concerned(known, scans))
        if not is_over.any():
            return
        chosen = np.flatnonzero(nodes.chosen[:n])
        cost = np.zeros(count)
        np.add.at(cost, own[chosen], tree.totals()[chosen])
        n_put = int(is_over.sum())
        rows = _in_order(own, is_over)
        family = _in_order(label, is_over)
        put = _Components(
            first=np.empty(0, dtype=np.int64),
            count=np.bincount(own, minlength=count)[is_over],
            first_family=np.empty(0, dtype=np.int64),
            n_families=np.bincount(label, minlength=count)[is_over],
            living=np.full(n_put, self._living),
            settling=np.full(n_put, self._settling),
            cost=cost[is_over],
            debt=np.full(n_put, self._owed(gap)),
            **{name: getattr(known, name)[is_over] for name in Whereabouts._fields},
        )
        put.first = self.n_rows + _starts(put.count)
        put.first_family = self.families.track.shape[0] + _starts(put.n_families)
        self._store(nodes, rows, family, put)
        self.families = joined(self.families, part_of(tree.families, family))
        tree.keep(~is_over[own])

    def _located(
        self, tree: AssociationTree, rows: IntArray, label: IntArray, count: int
    ) -> Whereabouts:
        """Return where some nodes of a tree are from the last scan on, by component."""
        begin, horizon, motion = self._last_time, self._horizon, self._rule.motion
        return locate(tree.nodes, rows, label, count, begin, horizon, motion, tree.general)

    def _store(self, nodes: Nodes, rows: IntArray, family: IntArray, put: _Components) -> None:
        """Copy nodes of a tree behind those held."""
        first, count = self.n_rows, rows.shape[0]
        if first + count > self.nodes.parent.shape[0]:
            self.nodes = larger(self.nodes, first, 2 * (first + count))
        copy_nodes(nodes, rows, self.nodes, first)
        span = slice(first, first + count)
        number = np.empty(nodes.parent.shape[0], dtype=np.int64)
        number[rows] = np.arange(count)
        above = self.nodes.parent[span]
        offset = np.repeat(put.first - first, put.count)
        self.nodes.parent[span] = np.where(above >= 0, number[above] - offset, -1)
        number[family] = self.families.track.shape[0] + np.arange(family.shape[0])
        self.nodes.family[span] = number[self.nodes.family[span]]
        self.n_rows += count
        self._components = self._components.joined(put)

    def _take(self, tree: AssociationTree, which: NDArray[np.bool_], time: float) -> None:
        """Bring some components back into the tree."""
        if not which.any():
            return
        taken = self._components.part(which)
        rows = _spans(taken.first, taken.count)
        parent = self.nodes.parent[rows]
        parent = np.where(parent >= 0, parent + np.repeat(_starts(taken.count), taken.count), -1)
        shift = taken.first_family - _starts(taken.n_families)
        families = part_of(self.families, _spans(taken.first_family, taken.n_families))
        span = tree.take_in(self.nodes, rows, parent, families)
        tree.nodes.family[span] -= np.repeat(shift, taken.count)
        tree.nodes.tail[span] += np.repeat(self._living - taken.living, taken.count)
        settled = np.exp(np.repeat(taken.settling - self._settling, taken.count))
        hidden = tree.nodes.hidden[span]
        hidden += (1.0 - settled) * (self._usually_hidden - hidden)
        slept = np.repeat(taken.time != time, taken.count)
        tree.nodes.counted[span][slept] = 0.0
        nodes = self.nodes
        self._taken.append((nodes, rows, nodes.chosen[rows], nodes.belief[rows]))
        self.nodes.chosen[rows] = 0
        self.nodes.belief[rows] = 0.0
        self._components = self._components.part(~which)
        self._tidy()

    def _owed(self, gap: float) -> int:
        """Enter a gap that stays open as long as any of the clusters now made inactive does."""
        if gap <= 0.0:
            return -1
        self._next_debt += 1
        self._debts[self._next_debt] = gap
        return self._next_debt

    def _tidy(self) -> None:
        """Forget gaps that are nobody's, and rows once more are free than in use."""
        if self._debts:
            held = set(self._components.debt.tolist())
            self._debts = {debt: gap for debt, gap in self._debts.items() if debt in held}
        kept = self._components
        if self.n_rows < 2 * self.n_nodes + LITTLE:
            return
        rows = _spans(kept.first, kept.count)
        # Into another room: this one is still as it was before the step.
        room = allocate(3 * rows.shape[0] + LITTLE, *sizes_of(self.nodes))
        copy_nodes(self.nodes, rows, room, 0)
        self.nodes, self.n_rows = room, rows.shape[0]
        shift = kept.first_family - _starts(kept.n_families)
        self.nodes.family[: self.n_rows] -= np.repeat(shift, kept.count)
        self.families = part_of(self.families, _spans(kept.first_family, kept.n_families))
        self._components = replace(
            kept, first=_starts(kept.count), first_family=_starts(kept.n_families)
        )


def _starts(count: IntArray) -> IntArray:
    """Return where each of some spans starts if they stand one behind the other."""
    return np.cumsum(count) - count


def _spans(first: IntArray, count: IntArray) -> IntArray:
    """Return the numbers of all spans, one behind the other."""
    return np.repeat(first - _starts(count), count) + np.arange(int(count.sum()))


def _in_order(label: IntArray, which: NDArray[np.bool_]) -> IntArray:
    """Return the places that have some labels, label after label."""
    own = np.flatnonzero(which[label])
    return own[np.argsort(label[own], kind="stable")]
