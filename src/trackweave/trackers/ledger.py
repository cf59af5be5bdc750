"""What becomes of tracks: identifiers, confirmation, rows, final assignments."""

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from typing import Self

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.association.beliefs import Beliefs
from trackweave.association.states import states_at
from trackweave.association.tree import AssociationTree
from trackweave.domain.tracks import COASTING, CONFIRMED, TENTATIVE, TrackTable
from trackweave.trackers.hypothesis import Amendment
from trackweave.trackers.lifecycle import Lifecycle

__all__ = ["Chosen", "Ledger", "LostTrack"]

TENTATIVE_EXISTENCE = 0.5
"""A tentative track is shown while its object lives at least as probably as not."""
COASTING_EXISTENCE = 0.01
"""A confirmed track is shown until it is all but certain that its object is gone."""


@dataclass(slots=True)
class _Record:
    """What is known of a live track beyond the tree: its fixed part."""

    confirmed: bool = False
    score: float = 0.0
    chances: list[float] = field(default_factory=list)


@dataclass(frozen=True, slots=True, eq=False)
class LostTrack:
    """A confirmed track that ended: last place [m], its spread [m], and time [s]."""

    position: FloatArray
    spread: float
    time: float


@dataclass(frozen=True, slots=True, eq=False)
class Chosen:
    """The sequences of a hypothesis, one column each.

    Parameters
    ----------
    leaf
        Last node, shape (sequences,).
    family
        Its family.
    path
        The nodes of each sequence, the last one first, shape (longest, sequences); -1 below.
    slot
        The slot of each node's report in the window, of the same shape; -1 for none.
    track
        Identifier of each sequence's track; -1 where it has none yet.
    """

    leaf: IntArray
    family: IntArray
    path: IntArray
    slot: IntArray
    track: IntArray

    @classmethod
    def of(cls, tree: AssociationTree, leaf: IntArray) -> Self:
        """Return the sequences that end with the given nodes."""
        # One level at least, so that no sequences at all are no special case.
        levels = [leaf]
        current = tree.nodes.parent[leaf]
        while np.any(current >= 0):
            levels.append(current)
            current = np.where(current >= 0, tree.nodes.parent[current], -1)
        path = np.array(levels, dtype=np.int64).reshape(len(levels), leaf.shape[0])
        family = tree.nodes.family[leaf]
        slot = np.where(path >= 0, tree.nodes.report[path], -1)
        return cls(leaf, family, path, slot, tree.track[family])

    def chances(self, tree: AssociationTree, index: int) -> list[float]:
        """Return the number of the chance that each report of a sequence took, ascending."""
        own = self.path[self.slot[:, index] >= 0, index]
        numbers: list[float] = tree.nodes.chances[own][::-1].tolist()
        return numbers


class Ledger:
    """Keeps the books of the live tracks and of the window's assignments."""

    def __init__(self, lifecycle: Lifecycle) -> None:
        self._lifecycle = lifecycle
        self._records: dict[int, _Record] = {}
        self._next_track = 1
        self._names = np.empty(0, dtype=np.int64)
        self._known: set[int] = set()
        self.assignment: dict[int, tuple[int, float]] = {}
        """Track and probability of each report of the window; absent = false alarm."""

    def begin(self, priors: TrackTable) -> None:
        """Enter tracks known beforehand, as confirmed."""
        for track in priors.track.tolist():
            self._records[track] = _Record(confirmed=True)
        self._next_track = max(self._next_track, int(priors.track.max(initial=0)) + 1)

    def update(
        self,
        tree: AssociationTree,
        leaf: IntArray,
        report_of: IntArray,
        time: float,
        beliefs: Beliefs | None,
    ) -> tuple[TrackTable, tuple[Amendment, ...]]:
        """Enter a new hypothesis; return the rows of the live tracks and the amendments.

        Parameters
        ----------
        tree
            The sequences.
        leaf
            The last node of each chosen one.
        report_of
            Report number of each slot of the window.
        time
            Time of the rows [s].
        beliefs
            Probabilities and average states; None to report the chosen sequences' own states.

        Returns
        -------
        The rows in order of identifier, and what changed of the last hypothesis.
        """
        chosen = Chosen.of(tree, leaf)
        chosen = replace(chosen, track=self._name(chosen, report_of))
        before, self.assignment = self.assignment, _assignment(chosen, report_of, beliefs)
        self._confirm(tree, chosen, beliefs)
        rows = self._rows(tree, chosen, time, beliefs)
        return rows, self._amendments(before, report_of.tolist())

    def fix(self, tree: AssociationTree, leaf: IntArray, n_fixed: int) -> tuple[LostTrack, ...]:
        """Make the chosen sequences' oldest slots final in the tree; return what was lost.

        Parameters
        ----------
        tree
            The sequences.
        leaf
            The last node of each one chosen at the last ``update``.
        n_fixed
            How many slots, the oldest, become final.

        Returns
        -------
        The confirmed tracks that have ended.
        """
        nodes = tree.nodes
        chosen = Chosen.of(tree, leaf)
        # A path stands leaf first, so the last fixed node is the first below the limit.
        is_fixed = (chosen.path >= 0) & (chosen.slot < n_fixed)
        has_root = np.flatnonzero(is_fixed.any(axis=0))
        last_fixed = chosen.path[is_fixed.argmax(axis=0), np.arange(leaf.shape[0])][has_root]
        for index, node in zip(has_root.tolist(), last_fixed.tolist(), strict=True):
            record = self._records[int(self._names[index])]
            record.score += float(nodes.cost[node])
            count = int(np.count_nonzero(is_fixed[:, index] & (chosen.slot[:, index] >= 0)))
            record.chances = self._lifecycle.recent(
                record.chances + chosen.chances(tree, index)[:count]
            )
        mean, covariance = states_at(tree, leaf)
        states = {
            name: _lost(mean[row, : tree.dim], covariance[row], float(nodes.time[leaf[row]]))
            for row, name in enumerate(self._names.tolist())
        }
        root, track = np.full(tree.n_families, -1, dtype=np.int64), tree.track.copy()
        root[chosen.family[has_root]] = last_fixed
        track[chosen.family[has_root]] = self._names[has_root]
        tree.fix(root, track, n_fixed)
        live = set(tree.track.tolist()) | set(np.delete(self._names, has_root).tolist())
        return tuple(self._strike(live, states))

    def _strike(self, live: set[int], states: dict[int, LostTrack]) -> Iterable[LostTrack]:
        """Forget the tracks that are not live any more; yield the confirmed ones."""
        for track in [name for name in self._records if name not in live]:
            record = self._records.pop(track)
            if record.confirmed and track in states:
                yield states[track]

    def _name(self, chosen: Chosen, report_of: IntArray) -> IntArray:
        """Return an identifier for each sequence; each serves once."""
        # What begins in the window keeps the name under which most of its reports were known.
        names = chosen.track.copy()
        used = set(names[names >= 0].tolist())
        for index in np.flatnonzero(names < 0).tolist():
            own = chosen.slot[:, index]
            holders = (self.assignment.get(report) for report in report_of[own[own >= 0]].tolist())
            known = Counter(
                holder[0] for holder in holders if holder is not None and holder[0] not in used
            )
            if known:
                name = max(sorted(known), key=lambda key: known[key])
            else:
                name, self._next_track = self._next_track, self._next_track + 1
            names[index] = name
            used.add(name)
            self._records.setdefault(name, _Record())
        self._names = names
        return names

    def _confirm(self, tree: AssociationTree, chosen: Chosen, beliefs: Beliefs | None) -> None:
        """Confirm the tracks that have been seen often enough, or are certain."""
        lifecycle = self._lifecycle
        for index, name in enumerate(chosen.track.tolist()):
            record = self._records[name]
            if record.confirmed:
                continue
            if beliefs is not None:
                existence = beliefs.existence[chosen.family[index]]
                if lifecycle.certain_probability < 1.0:
                    record.confirmed = bool(existence >= lifecycle.certain_probability)
                if existence < lifecycle.confirm_probability:
                    continue
            chances = record.chances + chosen.chances(tree, index)
            record.confirmed = record.confirmed or lifecycle.is_confirmed_by(chances)

    def _rows(
        self, tree: AssociationTree, chosen: Chosen, time: float, beliefs: Beliefs | None
    ) -> TrackTable:
        """Return a row for each live track."""
        nodes = tree.nodes
        known = [self._records[name].confirmed for name in chosen.track.tolist()]
        is_known = np.array(known, dtype=np.bool_)
        if beliefs is not None:
            needed = np.where(is_known, COASTING_EXISTENCE, TENTATIVE_EXISTENCE)
            live = beliefs.existence[chosen.family] >= needed
        else:
            tail = nodes.tail[chosen.leaf]
            live = tail <= np.where(is_known, np.finfo(np.float64).max, tree.rule.end_cost)
        live &= nodes.is_line[chosen.leaf] == 0
        order = np.flatnonzero(live)[np.argsort(chosen.track[live], kind="stable")]
        leaf, track, family = chosen.leaf[order], chosen.track[order], chosen.family[order]
        if beliefs is not None:
            mean, covariance = beliefs.mean[family], beliefs.covariance[family]
        else:
            mean, covariance = states_at(tree, leaf, time)
        size, ahead = 2 * tree.dim, tree.rule.motion.acceleration_at
        missed = nodes.misses[leaf] >= 0.5
        fixed_score = np.array([self._records[name].score for name in track.tolist()])
        return TrackTable(
            time=np.full(track.shape[0], time),
            track=track,
            status=np.where(is_known[order], np.where(missed, COASTING, CONFIRMED), TENTATIVE),
            mean=mean[:, :size],
            covariance=covariance[:, :size, :size],
            score=fixed_score + nodes.cost[leaf],
            hits=nodes.hits[leaf],
            last_update=nodes.time[leaf],
            acceleration=mean[:, ahead : ahead + tree.dim] if ahead >= 0 else mean[:, :0],
        )

    def _amendments(
        self, before: dict[int, tuple[int, float]], reports: list[int]
    ) -> tuple[Amendment, ...]:
        """Return what changed of the last hypothesis among the window's reports."""
        after = self.assignment
        changed = []
        for report in reports:
            old = before.get(report, (None, 0.0))[0]
            new = after.get(report, (None, 0.0))[0]
            if old != new and report in self._known:
                changed.append(Amendment(report, old, new))
        self._known = set(reports)
        return tuple(changed)


def _lost(position: FloatArray, covariance: FloatArray, time: float) -> LostTrack:
    dim = position.shape[0]
    spread = 3.0 * float(np.sqrt(np.trace(covariance[:dim, :dim])))
    return LostTrack(position, spread, time)


def _assignment(
    chosen: Chosen, report_of: IntArray, beliefs: Beliefs | None
) -> dict[int, tuple[int, float]]:
    """Return the track and the probability of each report that a sequence takes."""
    taken = chosen.slot >= 0
    holder = np.broadcast_to(chosen.track, chosen.slot.shape)[taken]
    if beliefs is None:
        probability = np.full(holder.shape[0], np.nan)
    else:
        probability = beliefs.edge_probability[beliefs.edge[chosen.path[taken]]]
    number = report_of[chosen.slot[taken]]
    pairs = zip(holder.tolist(), probability.tolist(), strict=True)
    return dict(zip(number.tolist(), pairs, strict=True))
