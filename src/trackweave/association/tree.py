"""The association tree: every sequence of reports worth scoring, each computed once."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackweave.arrays import FloatArray, IntArray
from trackweave.association._moving import copy_nodes, held_slots
from trackweave.association._nodes import (
    Candidates,
    Families,
    Misses,
    Nodes,
    ScanInput,
    State,
    WindowRule,
    is_plain,
    joined,
    n_modes_and_size,
    new_families,
    part_of,
    room_for_candidates,
    workspace,
)
from trackweave.association._pruning import (
    Cut,
    behind_best,
    best_of,
    crossings,
    forget_least,
    hold_out,
    keep_below,
    sum_below,
)
from trackweave.association.crowding import crowding_of, give_way, room_in
from trackweave.association.foreign_growth import appended, proposed, rooted_in
from trackweave.association.growth_limits import GrowthLimits
from trackweave.association.initial_tracks import InitialTracks
from trackweave.association.node_room import NodeRoom
from trackweave.association.problem import AssignmentProblem
from trackweave.association.pruning import Fate, Offer, bounds_of, cut_of, offered, silence_beside

__all__ = ["AssociationTree"]


class AssociationTree(NodeRoom):
    """Sequences over the scans of a window, grown scan by scan.

    A *family* is the sequences with one beginning: a track from before the window or the first
    report of a new object. The tree owns its arrays; they grow by doubling.
    """

    def __init__(self, rule: WindowRule, limits: GrowthLimits) -> None:
        super().__init__(*n_modes_and_size(rule.motion), rule.unseen.shape[0])
        self.dim = rule.motion.dim
        self.rule = rule
        self.limits = limits
        self.most = limits.max_nodes
        """The greatest number of sequences for now, at most that of the limits."""
        self.families = new_families(np.empty(0, dtype=np.int64), np.empty(0))
        self.general: State | None = None
        """Room for states that are not plain; None as long as all are."""
        self._room = 256
        self.is_crowded = False
        """Whether sequences could not look at all reports in their gates at the last scan."""
        self.n_given_way = 0
        """Sequences that the limits let stay, but not ``most`` since that was set."""
        self.n_pruned = 0
        """Sequences left out or not continued so far: no bound on the tree speaks of them."""
        self.cut: Cut | None = None
        """What of that the last scan left out; None as soon as nobody asks any more."""

    def at_rest(self) -> dict[str, Any]:
        """Return what a checkpoint holds: room to work in is empty."""
        general = None if self.general is None else State(*map(np.zeros_like, self.general))
        return {**super().at_rest(), "general": general}

    def limit(self, most: int) -> None:
        """Set the greatest number of sequences for now, and count from 0 what gives way to it."""
        self.most, self.n_given_way = most, 0

    @property
    def n_families(self) -> int:
        """Number of families."""
        return int(self.families.track.shape[0])

    @property
    def track(self) -> IntArray:
        """Identifier of each family's track; -1 for families that begin in the window."""
        return self.families.track

    @property
    def chosen(self) -> IntArray:
        """The nodes that the last hypothesis's sequences end with."""
        return np.flatnonzero(self.nodes.chosen[: self.n_nodes])

    def general_for(self, scan: ScanInput) -> State | None:
        """Return room for states of every kind from the first scan on that is not plain."""
        if self.general is None and not is_plain(scan, self.rule.motion):
            self.general = workspace(self.rule.motion)
        return self.general

    def add_tracks(self, initial: InitialTracks) -> None:
        """Begin a family with each given track."""
        count = initial.track.shape[0]
        if np.any(initial.is_line == 1):
            self.general = workspace(self.rule.motion)
        self._reserve(count)
        span = slice(self.n_nodes, self.n_nodes + count)
        nodes = self.nodes
        nodes.parent[span] = -1
        nodes.report[span] = -1
        nodes.family[span] = np.arange(self.n_families, self.n_families + count)
        nodes.chosen[span] = 1
        nodes.cost[span] = 0.0
        nodes.counted[span] = 0.0
        nodes.price[span] = 0.0
        nodes.belief[span] = 0.0
        for name, column in initial.columns().items():
            getattr(nodes, name)[span] = column
        self.n_nodes += count
        families = new_families(initial.track, np.zeros(count))
        # They are what is believed as long as no hypothesis says otherwise.
        self.add_families(families._replace(fixed_slot=initial.slot, name=initial.track))

    def add_families(self, families: Families) -> None:
        """Append families; they are numbered on from those there are."""
        self.families = joined(self.families, families)

    def grow(self, scan: ScanInput, log_density: FloatArray, *, is_last: bool = True) -> None:
        """Extend every sequence by the scan's reports, begin new objects, prune."""
        # ``log_density`` is that of objects not yet seen at each report's place [m⁻²]; ``is_last``
        # whether ``cut`` is to tell of this scan.
        taken = self._taken(scan)
        candidates, missed = self._propose(scan)
        n_old, n_new = self.n_nodes, scan.measurement.shape[0]
        nodes = self.nodes
        offer = offered(nodes, candidates, missed, self.track < 0, self.rule.end_cost)
        group = self._groups(offer)
        bound, room, is_new = bounds_of(
            offer, group, self.families, self.limits, silence_beside(self.rule.unseen)
        )
        believed = self._believed()
        excess, kept, is_open = hold_out(
            group, offer.family, offer.parent, offer.alive, offer.rank, bound, room, believed
        )
        n_kept, usual = int(np.count_nonzero(kept)), self._room_beside(n_new)
        most = min(usual, max(0, self.most - n_new))
        if n_kept > most:
            behind = behind_best(group, offer.rank, is_new)
            behind[np.isneginf(excess)] = -np.inf
            best = best_of(offer.family, offer.rank, self.n_families)
            behind[best[believed & (best >= 0)]] = -np.inf
            n_gone = give_way(kept, offer.parent, behind, most)
            self.n_given_way += max(0, n_gone - max(0, n_kept - usual))
        chosen = np.flatnonzero(kept[n_old:])
        self.n_pruned += kept.shape[0] - int(np.count_nonzero(kept))
        self.n_pruned += int(np.count_nonzero(np.isfinite(missed.tail) & ~is_open & kept[:n_old]))
        self.cut = None
        if is_last:
            self.cut = cut_of(
                nodes, candidates._replace(report=scan.slot[candidates.report]), missed,
                Fate(kept, is_open), self.rule.end_cost,
            )  # fmt: skip
        nodes.tail[:n_old] = np.where(is_open, missed.tail, np.inf)
        for name in ("hidden", "misses", "counted"):
            getattr(nodes, name)[:n_old] = getattr(missed, name)
        if scan.column >= 0:
            nodes.unseen[:n_old, scan.column] = missed.unseen
        self._reserve(chosen.shape[0] + n_new)
        grown = self.nodes, n_old, self.rule
        appended(grown, candidates, chosen, scan, self.general)
        self.n_nodes += chosen.shape[0]
        self.nodes.price[n_old : self.n_nodes] = offer.price[chosen]
        self._append_roots(scan, log_density - taken)
        begun = np.ones(self.n_nodes - n_old, dtype=np.bool_)
        self._compact(np.concatenate([kept[:n_old], begun]))

    def totals(self) -> FloatArray:
        """Return what each sequence costs if the object has no further report [nats]."""
        n = self.n_nodes
        return self.nodes.cost[:n] + np.minimum(self.nodes.tail[:n], self.rule.end_cost)

    def slots(self) -> tuple[IntArray, IntArray]:
        """Return the slots that some sequence has, ascending, and each node's place among them."""
        # It is -1 for one without a report.
        return held_slots(self.nodes.report, self.n_nodes)

    def problem(self, slots: tuple[IntArray, IntArray], instant: IntArray) -> AssignmentProblem:
        """Return the tree as an assignment problem of which the nodes are the tree's."""
        # Items are the reports by slot, then the tracks from before the window, which must be
        # covered, in the order of their families. ``instant`` is the rank in time of each slot
        # held; equal where reports are of one instant.
        n, n_reports, place = self.n_nodes, slots[0].shape[0], slots[1]
        is_track = self.track >= 0
        n_tracks = int(is_track.sum())
        own_item = np.full(self.n_families, -1, dtype=np.int64)
        own_item[is_track] = n_reports + np.arange(n_tracks)
        must_cover = np.zeros(n_reports + n_tracks, dtype=np.bool_)
        must_cover[n_reports:] = True
        return AssignmentProblem(
            parent=self.nodes.parent[:n].copy(),
            item=np.where(place >= 0, place, own_item[self.nodes.family[:n]]),
            cost=self.nodes.cost[:n].copy(),
            total=self.totals(),
            must_cover=must_cover,
            instant=np.concatenate([instant, np.full(n_tracks, -1, dtype=np.int64)]),
            # Costs are nats, and of one size in all windows.
            unit=1.0,
        )

    def fix(self, root: IntArray, track: IntArray, first_open: int) -> None:
        """Make assignments of the slots before ``first_open`` final, and forget those slots."""
        # A family's root is the node that is its last fixed one, -1 where it has none; a family
        # without one goes on only if it begins after the fixed slots. ``track`` is for families
        # with a root.
        nodes, n = self.nodes, self.n_nodes
        family = nodes.family[:n]
        keep = keep_below(nodes, n, root, first_open)
        roots = root[root >= 0]
        base = np.zeros(self.n_families)
        base[nodes.family[roots]] = nodes.cost[roots]
        slot = nodes.report[root]
        fixed_slot = np.where((root >= 0) & (slot >= 0), slot, self.families.fixed_slot)
        self.families = self.families._replace(
            track=np.where(root >= 0, track, self.track), fixed_slot=fixed_slot
        )
        # A family that can neither grow nor choose between sequences is over.
        n_kept = np.bincount(family[keep], minlength=self.n_families)
        can_grow = np.zeros(self.n_families, dtype=np.bool_)
        can_grow[family[keep & np.isfinite(nodes.tail[:n])]] = True
        keep &= (can_grow | (n_kept > 1))[family]
        is_root = np.zeros(n, dtype=np.bool_)
        is_root[roots] = True
        base, is_root = base[family[keep]], is_root[keep]
        self._compact(keep)
        self._begin_at(np.flatnonzero(is_root), base)
        self._forget_empty_families()

    def forget(self, probability: FloatArray) -> FloatArray:
        """Forget the least probable sequences; return how much that is of each family's."""
        # The last answer stays, and what begins in the window: beside a known object the right
        # one is improbable for minutes. A sequence goes with all that grew on it.
        nodes, n = self.nodes, self.n_nodes
        parent, family = nodes.parent[:n], nodes.family[:n]
        kept, forgotten = (parent < 0) | (nodes.chosen[:n] == 1), np.zeros(self.n_families)
        kept |= self.track[family] < 0
        order = n - 1 - np.argsort(sum_below(parent, probability)[::-1], kind="stable")
        forget_least(order, parent, family, probability, kept, forgotten, self.limits.negligible)
        self.n_pruned += n - int(np.count_nonzero(kept))
        self._compact(kept)
        return forgotten

    def keep(self, kept: NDArray[np.bool_]) -> None:
        """Drop all other nodes, no ancestors of those kept, and families without nodes."""
        self._compact(kept)
        self._forget_empty_families()

    def _begin_at(self, roots: IntArray, base: FloatArray) -> None:
        """Let sequences begin behind some nodes; ``base`` is what each node then costs less."""
        nodes = self.nodes
        nodes.cost[: self.n_nodes] -= base
        lines = roots[nodes.is_line[roots] == 1]
        nodes.covariance[lines, 0, 0, 0] -= base[lines]
        nodes.parent[roots] = -1
        nodes.report[roots] = -1
        nodes.price[roots] = 0.0

    def _forget_empty_families(self) -> None:
        family = self.nodes.family[: self.n_nodes]
        present = np.zeros(self.n_families, dtype=np.bool_)
        present[family] = True
        family[:] = (np.cumsum(present) - 1)[family]
        self.families = part_of(self.families, present)

    def take_in(
        self, source: Nodes, rows: IntArray, parent: IntArray, families: Families
    ) -> slice:
        """Append some nodes of another room, and their families; return where they are now."""
        # Families count from 0 there; a parent counts from the first of the rows, -1 for none.
        count, first = rows.shape[0], self.n_nodes
        self._reserve(count)
        copy_nodes(source, rows, self.nodes, first)
        span = slice(first, first + count)
        self.nodes.parent[span] = np.where(parent >= 0, parent + first, -1)
        self.nodes.family[span] += self.n_families
        self.n_nodes += count
        self.add_families(families)
        return span

    def _room_beside(self, n_new: int) -> int:
        """Return how many sequences the limits let stay beside so many beginnings."""
        return max(0, room_in(self.limits, is_crowded=self.is_crowded) - n_new)

    def _believed(self) -> NDArray[np.bool_]:
        """Tell of each family whether it is a track from before or in the last answer."""
        believed, n = self.track >= 0, self.n_nodes
        believed[self.nodes.family[:n][self.nodes.chosen[:n] == 1]] = True
        return believed

    def _groups(self, offer: Offer) -> IntArray:
        """Return for each sequence and child among which it has to hold its own."""
        # An object seen by its bearing alone is somewhere else with each second report: below
        # a line, what each of them begins is as good as an object of its own.
        nodes, n = self.nodes, self.n_nodes
        if self.general is None or not np.any(nodes.is_line[:n]):
            return offer.family
        return crossings(offer.parent, nodes.is_line[:n], offer.family, self.n_families)

    def _propose(self, scan: ScanInput) -> tuple[Candidates, Misses]:
        self._own()
        n = self.n_nodes
        missed = Misses(*(np.empty(n) for _ in Misses._fields))
        # What was proposed last tells best how much will be now; too little costs a second go.
        room, general = max(self._room, n + 64), self.general_for(scan)
        is_new = self.track[self.nodes.family[:n]] < 0
        crowding = crowding_of(self.nodes, n, is_new, self.limits)
        if scan.measurement.shape[0] > crowding.looks:
            # A crowd is looked at only once.
            room = max(room, int(crowding.children.sum()))
        while True:
            candidates = room_for_candidates(room)
            grown = self.nodes, n, self.rule
            count = proposed(grown, scan, (candidates, missed), crowding, general)
            if count <= room:
                self._room = count + count // 4
                self.n_pruned += int(crowding.left_out.sum())
                self.is_crowded = bool(crowding.left_out[0] > 0)
                kept = {name: column[:count] for name, column in candidates._asdict().items()}
                return Candidates(**kept), missed
            room = count + count // 4

    def _taken(self, scan: ScanInput) -> FloatArray:
        """Return what it costs that a new object has the identity of one that lives [nats]."""
        if not np.any(scan.identity >= 0):
            return np.zeros(scan.identity.shape[0])
        lives = self.nodes.tail[: self.n_nodes] < np.inf
        known = self.nodes.identity[: self.n_nodes][lives]
        is_taken = (scan.identity >= 0) & np.isin(scan.identity, known)
        return np.where(is_taken, scan.identity_loss, 0.0)

    def _append_roots(self, scan: ScanInput, log_density: FloatArray) -> None:
        count = scan.measurement.shape[0]
        first = self.n_nodes
        grown = self.nodes, first, self.rule
        rooted_in(grown, scan, self.n_families, log_density, self.general)
        self.n_nodes += count
        start = np.maximum(self.nodes.cost[first : self.n_nodes], 0.0)
        self.add_families(new_families(np.full(count, -1, dtype=np.int64), start))
