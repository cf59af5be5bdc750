"""What becomes of tracks: identifiers, confirmation, assignments, and which are over."""

from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.association._moving import paths_up
from trackweave.association.beliefs import Beliefs
from trackweave.association.states import states_at
from trackweave.association.tree import AssociationTree
from trackweave.domain.tracks import TrackTable
from trackweave.trackers.hypothesis import Amendment
from trackweave.trackers.lifecycle import Lifecycle
from trackweave.trackers.report_index import ReportIndex

__all__ = ["Chosen", "LostTrack", "TrackManager"]


@dataclass(frozen=True, slots=True)
class _Record:
    """What is known of a live track beyond the tree: the chances its fixed reports took."""

    confirmed: bool = False
    chances: tuple[float, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class LostTrack:
    """A confirmed track that ended: last place [m], its spread [m], and time [s]."""

    position: FloatArray
    spread: float
    time: float


@dataclass(frozen=True, slots=True, eq=False)
class Chosen:
    """The sequences of a hypothesis, one column each."""

    family: IntArray  # Shape (sequences,)
    path: IntArray  # The nodes of each, the last one first, shape (longest, sequences); -1 below
    slot: IntArray  # The slot of each node's report in the window, of the same shape; -1 for none
    track: IntArray  # -1 where it has none yet

    @classmethod
    def of(cls, tree: AssociationTree, leaf: IntArray) -> Self:
        """Return the sequences that end with the given nodes."""
        path = paths_up(tree.nodes.parent, leaf)
        family = tree.nodes.family[leaf]
        slot = np.where(path >= 0, tree.nodes.report[path], -1)
        return cls(family, path, slot, tree.track[family])

    def chances(self, tree: AssociationTree, index: int) -> list[float]:
        """Return the number of the chance that each report of a sequence took, ascending."""
        own = self.path[self.slot[:, index] >= 0, index]
        numbers: list[float] = tree.nodes.chances[own][::-1].tolist()
        return numbers


class TrackManager:
    """Keeps the books of the live tracks and of the window's assignments."""

    def __init__(self, lifecycle: Lifecycle, next_track: int = 1) -> None:
        self._lifecycle = lifecycle
        self._records: dict[int, _Record] = {}
        self.next_track = next_track
        """The name of the next track."""
        self._dropped: set[int] = set()
        """Names that no sequence has had since the window moved."""
        self.doubts: dict[int, bool] = {}
        """Of live tracks, whether they may as well be false alarms that came again; those of which
        it was never so are left out."""

    def __getstate__(self) -> dict[str, Any]:
        # A shallow copy is independent: records are replaced, never changed.
        own = {"_records": self._records.copy(), "_dropped": self._dropped.copy()}
        return {**self.__dict__, **own, "doubts": self.doubts.copy()}

    def anew(self) -> "TrackManager":
        """Return one that knows which names were used."""
        return TrackManager(self._lifecycle, self.next_track)

    def begin(self, priors: TrackTable) -> None:
        """Enter tracks known beforehand, as confirmed."""
        for track in priors.track.tolist():
            self._records[track] = _Record(confirmed=True)
        self.next_track = max(self.next_track, int(priors.track.max(initial=0)) + 1)

    def update(
        self,
        tree: AssociationTree,
        leaf: IntArray,
        slots: ReportIndex,
        concerned: IntArray,
        beliefs: Beliefs | None,
    ) -> tuple[Amendment, ...]:
        """Enter a new hypothesis, its chosen leaves, into the tree's families and the slots."""
        # It speaks of the slots ``concerned``, ascending; the others stay as they are. Without
        # beliefs only the chosen sequences count. What changed of the last hypothesis is returned.
        chosen = Chosen.of(tree, leaf)
        chosen = replace(chosen, track=self._name(tree, chosen, slots))
        rows = concerned - slots.origin
        before, is_known = slots.track[rows], slots.is_known[rows]
        _assign(chosen, slots, rows, beliefs)
        real = _proven(tree, chosen, leaf, slots)
        if beliefs is not None:
            beliefs.existence[chosen.family] *= real
            tree.families = tree.families._replace(existence=beliefs.existence)
        self._confirm(tree, chosen, beliefs, real)
        after = slots.track[rows]
        changed = rows[is_known & (before != after)]
        slots.is_known[rows] = True
        return tuple(
            Amendment(report, _or_none(old), _or_none(new))
            for report, old, new in zip(
                slots.report[changed].tolist(),
                before[is_known & (before != after)].tolist(),
                slots.track[changed].tolist(),
                strict=True,
            )
        )

    def fix(
        self, tree: AssociationTree, first_open: int, slots: ReportIndex
    ) -> tuple[LostTrack, ...]:
        """Make the chosen slots before the first open one final; return the lost tracks."""
        # Lost are confirmed tracks that have ended.
        nodes, leaf = tree.nodes, tree.chosen
        chosen = Chosen.of(tree, leaf)
        name = tree.families.name[chosen.family]
        # A path stands leaf first, so the last fixed node is the first below the limit.
        is_fixed = (chosen.path >= 0) & (chosen.slot < first_open)
        has_root = np.flatnonzero(is_fixed.any(axis=0))
        last_fixed = chosen.path[is_fixed.argmax(axis=0), np.arange(leaf.shape[0])][has_root]
        rooted = chosen.family[has_root]
        is_new = ~tree.families.confirmed[rooted] & (nodes.report[last_fixed] >= 0)
        for index in has_root[is_new].tolist():
            number = int(name[index])
            record = self._records[number]
            count = int(np.count_nonzero(is_fixed[:, index] & (chosen.slot[:, index] >= 0)))
            chances = [*record.chances, *chosen.chances(tree, index)[:count]]
            self._records[number] = replace(record, chances=tuple(self._lifecycle.recent(chances)))
        score = tree.families.score.copy()
        score[rooted] += nodes.cost[last_fixed]
        doubt = tree.families.doubt.copy()
        doubt[rooted] += slots.repeated(np.where(is_fixed, chosen.slot, -1)[:, has_root])
        tree.families = tree.families._replace(score=score, doubt=doubt)
        root, track = np.full(tree.n_families, -1, dtype=np.int64), tree.track.copy()
        root[rooted] = last_fixed
        track[rooted] = name[has_root]
        mean, covariance = states_at(tree, leaf)
        last_seen = nodes.time[leaf]
        tree.fix(root, track, first_open)
        live = {*tree.track.tolist(), *np.delete(name, has_root).tolist()}
        lost = []
        for row, number in enumerate(name.tolist()):
            if number not in live and self._records.pop(number).confirmed:
                spread = covariance[row, : tree.dim, : tree.dim]
                lost.append(_lost(mean[row, : tree.dim], spread, float(last_seen[row])))
        for number in self._dropped - live:
            self._records.pop(number, None)
        self._dropped.clear()
        if self.doubts:
            self.doubts = {
                each: is_so for each, is_so in self.doubts.items() if each in self._records
            }
        return tuple(lost)

    def _name(self, tree: AssociationTree, chosen: Chosen, slots: ReportIndex) -> IntArray:
        """Return an identifier for each sequence; each serves once."""
        # What begins in the window keeps the name under which most of its reports were known.
        names = chosen.track.copy()
        used = set(names[names >= 0].tolist())
        begun = np.flatnonzero(names < 0)
        own = chosen.slot[:, begun].T
        holder = np.where(own >= 0, slots.track[np.maximum(own - slots.origin, 0)], -1)
        for index, holders in zip(begun.tolist(), holder.tolist(), strict=True):
            known = [each for each in holders if each >= 0 and each not in used]
            if known:
                name = max(set(known), key=lambda each: (known.count(each), -each))
            else:
                name, self.next_track = self.next_track, self.next_track + 1
            names[index] = name
            used.add(name)
            if name not in self._records:
                self._records[name] = _Record()
        before = tree.families.name
        self._dropped |= set(before[before >= 0].tolist())
        self._dropped -= used
        after = np.full(tree.n_families, -1, dtype=np.int64)
        after[chosen.family] = names
        tree.families = tree.families._replace(name=after)
        return names

    def _confirm(
        self, tree: AssociationTree, chosen: Chosen, beliefs: Beliefs | None, real: FloatArray
    ) -> None:
        """Confirm the tracks that have been seen often enough, or are certain."""
        names = chosen.track.tolist()
        records = [self._records[name] for name in names]
        for index, record in enumerate(records):
            if record.confirmed:
                continue
            if real[index] < self._lifecycle.confirm_probability:
                self.doubts[names[index]] = True
            elif self._confirms(record, tree, (chosen, index), beliefs):
                records[index] = self._records[names[index]] = replace(record, confirmed=True)
                if self.doubts or real[index] < 1.0:
                    self.doubts[names[index]] = False
        confirmed = np.zeros(tree.n_families, dtype=np.bool_)
        confirmed[chosen.family] = [record.confirmed for record in records]
        tree.families = tree.families._replace(confirmed=confirmed)

    def _confirms(
        self,
        record: _Record,
        tree: AssociationTree,
        sequence: tuple[Chosen, int],
        beliefs: Beliefs | None,
    ) -> bool:
        """Tell whether a tentative track is confirmed now."""
        lifecycle, (chosen, index) = self._lifecycle, sequence
        if beliefs is not None:
            existence = beliefs.existence[chosen.family[index]]
            if lifecycle.certain_probability < 1.0 and existence >= lifecycle.certain_probability:
                return True
            if existence < lifecycle.confirm_probability:
                return False
        return lifecycle.is_confirmed_by([*record.chances, *chosen.chances(tree, index)])


def _proven(
    tree: AssociationTree, chosen: Chosen, leaf: IntArray, slots: ReportIndex
) -> FloatArray:
    """Return how probably what sequences take is no false alarm that came again and again."""
    doubt = tree.families.doubt[chosen.family] + slots.repeated(chosen.slot)
    if not doubt.any():
        return np.ones(leaf.shape[0])
    evidence = -(tree.families.score[chosen.family] + tree.nodes.cost[leaf])
    return np.where(doubt > 0.0, np.exp(-np.logaddexp(0.0, doubt - evidence)), 1.0)


def _or_none(track: int) -> int | None:
    return track if track >= 0 else None


def _lost(position: FloatArray, covariance: FloatArray, time: float) -> LostTrack:
    spread = 3.0 * float(np.sqrt(np.trace(covariance)))
    return LostTrack(position, spread, time)


def _assign(chosen: Chosen, slots: ReportIndex, rows: IntArray, beliefs: Beliefs | None) -> None:
    """Enter the track and the probability of the reports that sequences take."""
    slots.track[rows] = -1
    slots.probability[rows] = np.nan
    taken = chosen.slot >= 0
    own = chosen.slot[taken] - slots.origin
    slots.track[own] = np.broadcast_to(chosen.track, chosen.slot.shape)[taken]
    if beliefs is not None:
        slots.probability[own] = beliefs.edge_probability[beliefs.edge[chosen.path[taken]]]
