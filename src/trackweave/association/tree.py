"""The association tree: every sequence of reports worth scoring, each computed once."""

from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackweave.arrays import FloatArray, IntArray
from trackweave.association._crowding import Crowding
from trackweave.association._growth import append_children, append_roots, propose
from trackweave.association._nodes import (
    Candidates,
    Misses,
    Nodes,
    ScanInput,
    State,
    WindowRule,
    is_plain,
    n_modes_and_size,
    workspace,
)
from trackweave.association._pruning import (
    accumulate_prices,
    crossings,
    keep_ancestors,
    keep_below,
    part_ties,
    raise_ancestors,
    rank_bounds,
)
from trackweave.association.growth_limits import GrowthLimits
from trackweave.association.problem import AssignmentProblem

__all__ = ["AssociationTree", "Beginning"]

CHILDREN, LOOKS = 4, 10
"""Continuations kept and reports looked at in a scan, by all sequences, for each of the greatest
number of sequences: so a gate with thousands of reports takes bounded time and memory."""
SHARE_IN_CROWDS = 4
"""Of the greatest number of sequences no more than this part is kept where some could not look at
all reports in their gate: what is to be told apart there cannot be, and costs most to solve."""
FEWEST, FEWEST_LOOKS, FEWEST_ANYWHERE = 4, 32, 1_000
"""What every sequence may keep and look at all the same; the last of scans that do not tell
places, where the nearest reports cannot be picked out."""


@dataclass(frozen=True, slots=True, eq=False)
class Beginning:
    """States with which tracks enter a tree, one row per track.

    Parameters
    ----------
    track
        Identifiers.
    time
        Time of each state [s].
    mean, covariance, weight
        The state by modes of motion, shapes (tracks, modes, size), (tracks, modes, size, size)
        and (tracks, modes).
    hits, chances
        Reports taken so far, and chances to be seen from the first report on.
    tail, misses
        Cost [nats] and number of the chances missed since ``time``.
    identity, former, sensor
        Whom the track has been of, and which sensor saw it last; -1 for nobody and none.
    is_line
        1 for an object that has been seen by its bearing alone.
    """

    track: IntArray
    time: FloatArray
    mean: FloatArray
    covariance: FloatArray
    weight: FloatArray
    hits: IntArray
    chances: FloatArray
    tail: FloatArray
    misses: FloatArray
    identity: IntArray
    former: IntArray
    sensor: IntArray
    is_line: IntArray

    def columns(self) -> dict[str, NDArray[Any]]:
        """Return what a tree's nodes hold of it, by name."""
        names = (each.name for each in fields(self))
        return {name: getattr(self, name) for name in names if name != "track"}


class AssociationTree:
    """Sequences over the scans of a window, grown scan by scan.

    A *family* is the sequences with one beginning: a track from before the window or the first
    report of a new object. The tree owns its arrays; they grow by doubling.
    """

    def __init__(self, rule: WindowRule, limits: GrowthLimits) -> None:
        self.dim = rule.motion.dim
        self.rule = rule
        self.limits = limits
        self.n_nodes = 0
        self.nodes = _allocate(256, *n_modes_and_size(rule.motion))
        self.track = np.empty(0, dtype=np.int64)
        """Identifier of each family's track; -1 for families that begin in the window."""
        self.start_cost = np.empty(0)
        """What each family's first report cost if it began in the window, at least 0 [nats]."""
        self.fixed_slot = np.empty(0, dtype=np.int64)
        """For each family the slot of its last report among those fixed last; -1 for none."""
        self.general: State | None = None
        """Room for states that are not plain; None as long as all are."""
        self.is_crowded = False
        """Whether sequences could not look at all reports in their gates at the last scan."""
        self.n_pruned = 0
        """Sequences left out or not continued so far: no bound on the tree speaks of them."""

    @property
    def n_families(self) -> int:
        """Number of families."""
        return self.track.shape[0]

    def general_for(self, scan: ScanInput) -> State | None:
        """Return room for states of every kind from the first scan on that is not plain."""
        if self.general is None and not is_plain(scan, self.rule.motion):
            self.general = workspace(self.rule.motion)
        return self.general

    def add_tracks(self, beginning: Beginning) -> None:
        """Begin a family with each given track."""
        count = beginning.track.shape[0]
        if np.any(beginning.is_line == 1):
            self.general = workspace(self.rule.motion)
        self._reserve(count)
        span = slice(self.n_nodes, self.n_nodes + count)
        nodes = self.nodes
        nodes.parent[span] = -1
        nodes.report[span] = -1
        nodes.family[span] = np.arange(self.n_families, self.n_families + count)
        nodes.chosen[span] = 0
        nodes.cost[span] = 0.0
        nodes.counted[span] = 0.0
        nodes.price[span] = 0.0
        for name, column in beginning.columns().items():
            getattr(nodes, name)[span] = column
        self.n_nodes += count
        self.track = np.concatenate([self.track, beginning.track])
        self.start_cost = np.concatenate([self.start_cost, np.zeros(count)])

    def grow(self, scan: ScanInput, log_density: FloatArray) -> None:
        """Extend every sequence by the scan's reports, begin new objects, prune.

        Parameters
        ----------
        scan
            The scan.
        log_density
            Log of the expected density of objects not yet seen at each report's place [m⁻²].
        """
        candidates, missed = self._propose(scan)
        n_old, n_new = self.n_nodes, scan.measurement.shape[0]
        nodes = self.nodes
        priced = np.empty(n_old)
        accumulate_prices(nodes, n_old, priced)
        group = self._groups(candidates)
        alive = nodes.cost[:n_old] + missed.tail + priced
        ended = nodes.cost[:n_old] + np.minimum(missed.tail, self.rule.end_cost) + priced
        grown = candidates.cost + priced[candidates.node]
        rank = np.concatenate([ended, grown])
        bound, room = self._bounds(candidates, group, rank)
        bound = bound[group]
        excess = rank - bound
        part_ties(group, excess, room)
        excess[:n_old][nodes.parent[:n_old] < 0] = -np.inf
        parent = np.concatenate([nodes.parent[:n_old], candidates.node])
        most = self.limits.max_nodes // (SHARE_IN_CROWDS if self.is_crowded else 1)
        kept = _kept(parent, excess, max(0, most - n_new))
        chosen = np.flatnonzero(kept[n_old:])
        stopped = np.isfinite(missed.tail) & (alive > bound[:n_old])
        self.n_pruned += kept.shape[0] - int(np.count_nonzero(kept))
        self.n_pruned += int(np.count_nonzero(stopped & kept[:n_old]))
        nodes.tail[:n_old] = np.where(alive <= bound[:n_old], missed.tail, np.inf)
        nodes.misses[:n_old] = missed.misses
        nodes.counted[:n_old] = missed.counted
        self._reserve(chosen.shape[0] + n_new)
        append_children(self.nodes, n_old, candidates, chosen, scan, self.rule, self.general)
        self.n_nodes += chosen.shape[0]
        self._append_roots(scan, log_density)
        keep = np.ones(self.n_nodes, dtype=np.bool_)
        keep[:n_old] = kept[:n_old]
        self._compact(keep)

    def totals(self) -> FloatArray:
        """Return what each sequence costs if the object has no further report [nats]."""
        n = self.n_nodes
        return self.nodes.cost[:n] + np.minimum(self.nodes.tail[:n], self.rule.end_cost)

    def problem(self, instant: IntArray) -> AssignmentProblem:
        """Return the tree as an assignment problem.

        Items are the window's reports by slot, then the tracks from before the window, which
        must be covered, in the order of their families.

        Parameters
        ----------
        instant
            Rank in time of each slot; equal where reports are of one instant.

        Returns
        -------
        The problem; its nodes are the tree's.
        """
        n, n_reports = self.n_nodes, instant.shape[0]
        is_track = self.track >= 0
        n_tracks = int(is_track.sum())
        own_item = np.full(self.n_families, -1, dtype=np.int64)
        own_item[is_track] = n_reports + np.arange(n_tracks)
        report = self.nodes.report[:n]
        must_cover = np.zeros(n_reports + n_tracks, dtype=np.bool_)
        must_cover[n_reports:] = True
        return AssignmentProblem(
            parent=self.nodes.parent[:n].copy(),
            item=np.where(report >= 0, report, own_item[self.nodes.family[:n]]),
            cost=self.nodes.cost[:n].copy(),
            total=self.totals(),
            must_cover=must_cover,
            instant=np.concatenate([instant, np.full(n_tracks, -1, dtype=np.int64)]),
        )

    def fix(self, root: IntArray, track: IntArray, n_fixed: int) -> None:
        """Make the assignments of the oldest ``n_fixed`` slots final and forget those slots.

        Parameters
        ----------
        root
            For each family the node that is its last fixed one, -1 where it has none. A family
            without one goes on only if it begins after the fixed slots.
        track
            Identifier for each family that has a root.
        n_fixed
            How many slots, the oldest, are fixed.
        """
        nodes, n = self.nodes, self.n_nodes
        keep = keep_below(nodes, n, root, n_fixed)
        roots = root[root >= 0]
        base = np.zeros(self.n_families)
        base[nodes.family[roots]] = nodes.cost[roots]
        nodes.cost[:n] -= base[nodes.family[:n]]
        lines = roots[nodes.is_line[roots] == 1]
        nodes.covariance[lines, 0, 0, 0] -= base[nodes.family[lines]]
        self.fixed_slot = np.where(root >= 0, nodes.report[root], -1)
        nodes.parent[roots] = -1
        nodes.report[roots] = -1
        nodes.price[roots] = 0.0
        self.track = np.where(root >= 0, track, self.track)
        # A family that can neither grow nor choose between sequences is over.
        n_kept = np.bincount(nodes.family[:n][keep], minlength=self.n_families)
        can_grow = np.zeros(self.n_families, dtype=np.bool_)
        can_grow[nodes.family[:n][keep & np.isfinite(nodes.tail[:n])]] = True
        goes_on = can_grow | (n_kept > 1)
        keep &= goes_on[nodes.family[:n]]
        self._compact(keep)
        n = self.n_nodes
        present = np.zeros(self.n_families, dtype=np.bool_)
        present[nodes.family[:n]] = True
        number = np.cumsum(present) - 1
        nodes.family[:n] = number[nodes.family[:n]]
        self.track, self.start_cost = self.track[present], self.start_cost[present]
        self.fixed_slot = self.fixed_slot[present]
        report = nodes.report[:n]
        report[report >= 0] -= n_fixed

    def _groups(self, candidates: Candidates) -> IntArray:
        """Return for each sequence, then each candidate, among which it has to hold its own."""
        # An object seen by its bearing alone is somewhere else with each second report: below
        # a line, what each of them begins is as good as an object of its own.
        nodes, n = self.nodes, self.n_nodes
        family = np.concatenate([nodes.family[:n], nodes.family[candidates.node]])
        if self.general is None or not np.any(nodes.is_line[:n]):
            return family
        parent = np.concatenate([nodes.parent[:n], candidates.node])
        return crossings(parent, nodes.is_line[:n], family, self.n_families)

    def _bounds(
        self, candidates: Candidates, group: IntArray, rank: FloatArray
    ) -> tuple[FloatArray, IntArray]:
        """Return the worst rank that each group keeps, and how many sequences."""
        limits, nodes, n = self.limits, self.nodes, self.n_nodes
        family = np.arange(self.n_families)
        if group.max(initial=-1) >= self.n_families:
            every = np.concatenate([nodes.family[:n], nodes.family[candidates.node]])
            family = np.zeros(group.max() + 1, dtype=np.int64)
            family[: self.n_families] = np.arange(self.n_families)
            family[group] = every
        is_new = self.track[family] < 0
        keep = np.where(is_new, limits.new_keep, limits.keep)
        margin = np.where(is_new, limits.new_margin, limits.margin)
        ceiling = np.where(is_new, self.start_cost[family] + limits.new_ceiling, np.inf)
        return rank_bounds(group, rank, margin, keep, ceiling), keep

    def _propose(self, scan: ScanInput) -> tuple[Candidates, Misses]:
        n = self.n_nodes
        missed = Misses(np.empty(n), np.empty(n), np.empty(n))
        room, general, crowding = 2 * n + 64, self.general_for(scan), self.crowding()
        if scan.measurement.shape[0] > crowding.looks:
            # A crowd is looked at only once.
            room = max(room, int(crowding.children.sum()))
        while True:
            candidates = Candidates(
                np.empty(room, dtype=np.int64), np.empty(room, dtype=np.int64), np.empty(room)
            )
            count = propose(self.nodes, n, scan, self.rule, candidates, missed, crowding, general)
            if count <= room:
                self.n_pruned += int(crowding.left_out.sum())
                self.is_crowded = bool(crowding.left_out[0] > 0)
                return Candidates(
                    candidates.node[:count], candidates.report[:count], candidates.cost[:count]
                ), missed
            room = count

    def crowding(self) -> Crowding:
        """Return what a sequence may look at and keep of a scan, so that all of them can."""
        nodes, n, limits = self.nodes, self.n_nodes, self.limits
        n_growing = max(1, int(np.count_nonzero(np.isfinite(nodes.tail[:n]))))
        most = max(FEWEST, CHILDREN * limits.max_nodes // n_growing)
        # No family keeps more children of a sequence than sequences in all.
        is_new = self.track[nodes.family[:n]] < 0
        children = np.minimum(np.where(is_new, limits.new_keep, limits.keep), most)
        # Below a line every child is a group of its own.
        children[nodes.is_line[:n] == 1] = most
        return Crowding(
            max(FEWEST_LOOKS, LOOKS * limits.max_nodes // n_growing), FEWEST_ANYWHERE, children,
            np.zeros(2, dtype=np.int64), np.zeros(1, dtype=np.int64),
        )  # fmt: skip

    def _append_roots(self, scan: ScanInput, log_density: FloatArray) -> None:
        count = scan.measurement.shape[0]
        first = self.n_nodes
        append_roots(
            self.nodes, first, scan, self.rule, self.n_families, log_density, self.general
        )
        self.n_nodes += count
        self.track = np.concatenate([self.track, np.full(count, -1, dtype=np.int64)])
        start = np.maximum(self.nodes.cost[first : self.n_nodes], 0.0)
        self.start_cost = np.concatenate([self.start_cost, start])

    def _reserve(self, count: int) -> None:
        capacity = self.nodes.parent.shape[0]
        if self.n_nodes + count <= capacity:
            return
        size = n_modes_and_size(self.rule.motion)
        larger = _allocate(max(2 * capacity, self.n_nodes + count), *size)
        for old, new in zip(self.nodes, larger, strict=True):
            new[: self.n_nodes] = old[: self.n_nodes]
        self.nodes = larger

    def _compact(self, keep: NDArray[np.bool_]) -> None:
        """Drop the nodes that are not kept; order stays."""
        rows = np.flatnonzero(keep)
        if rows.shape[0] == self.n_nodes:
            return
        number = np.cumsum(keep) - 1
        for column in self.nodes:
            column[: rows.shape[0]] = column[rows]
        parent = self.nodes.parent[: rows.shape[0]]
        parent[parent >= 0] = number[parent[parent >= 0]]
        self.n_nodes = rows.shape[0]


def _kept(parent: IntArray, excess: FloatArray, room: int) -> NDArray[np.bool_]:
    """Return which sequences stay: without excess, or below such; under a cap the best."""
    # Beginnings, of excess minus infinity, stay whatever the cap.
    kept = excess <= 0.0
    keep_ancestors(parent, parent.shape[0], kept)
    if np.count_nonzero(kept) > room:
        worth = excess.copy()
        raise_ancestors(parent, worth)
        best = np.argsort(worth, kind="stable")[:room]
        inside = np.isneginf(excess)
        inside[best] = True
        kept &= inside
    return kept


def _allocate(capacity: int, modes: int, size: int) -> Nodes:
    def column(*shape: int, dtype: Any = np.float64) -> NDArray[Any]:
        return np.empty((capacity, *shape), dtype=dtype)

    whole = (
        "parent", "report", "family", "hits", "chosen", "identity", "former", "sensor", "is_line",
    )  # fmt: skip
    real = ("cost", "tail", "misses", "counted", "chances", "price", "time")
    return Nodes(
        **{name: column(dtype=np.int64) for name in whole},
        **{name: column() for name in real},
        mean=column(modes, size),
        covariance=column(modes, size, size),
        weight=column(modes),
    )
