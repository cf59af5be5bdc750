"""What becomes of tracks: identifiers, confirmation, rows, final assignments."""

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.association.beliefs import Beliefs
from trackweave.association.tree import AssociationTree
from trackweave.domain.tracks import COASTING, CONFIRMED, TENTATIVE, TrackTable
from trackweave.filters.kalman import predicted
from trackweave.trackers.hypothesis import Amendment
from trackweave.trackers.lifecycle import Lifecycle

__all__ = ["Ledger", "LostTrack"]

REPORTED_EXISTENCE = 0.5
"""A track is shown while its object lives at least as probably as not."""


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
        leaves: IntArray,
        report_of: IntArray,
        time: float,
        beliefs: Beliefs | None,
    ) -> tuple[TrackTable, tuple[Amendment, ...]]:
        """Enter a new hypothesis; return the rows of the live tracks and the amendments.

        Parameters
        ----------
        tree
            The sequences.
        leaves
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
        paths = paths_of(tree, leaves)
        slots = np.where(paths >= 0, tree.nodes.report[paths], -1)
        reports = [
            report_of[own[own >= 0]].tolist()
            for own in (slots.T if slots.size else np.empty((0, 0), dtype=np.int64))
        ]
        track = self._name(tree.track[tree.nodes.family[leaves]], reports)
        before, self.assignment = self.assignment, self._assignment(
            tree, paths, slots, report_of, track, beliefs
        )
        self._confirm(tree, leaves, paths, track, beliefs)
        rows = self._rows(tree, leaves, track, time, beliefs)
        return rows, self._amendments(before, report_of.tolist())

    def fix(
        self, tree: AssociationTree, leaves: IntArray, n_fixed: int
    ) -> tuple[LostTrack, ...]:
        """Make the chosen sequences' oldest slots final in the tree; return what was lost.

        ``leaves`` are those of the last ``update``, whose slots have not changed since.
        """
        nodes = tree.nodes
        paths = paths_of(tree, leaves)
        family = nodes.family[leaves]
        report = np.where(paths >= 0, nodes.report[paths], tree.n_nodes)
        # A path stands leaf first, so the last fixed node is the first below the limit.
        is_fixed = (paths >= 0) & (report < n_fixed)
        has_root = is_fixed.any(axis=0)
        place = is_fixed.argmax(axis=0)
        column = np.arange(leaves.shape[0])
        root = np.full(tree.n_families, -1, dtype=np.int64)
        root[family[has_root]] = paths[place, column][has_root]
        track = tree.track.copy()
        track[family[has_root]] = self._names[has_root]
        for index in np.flatnonzero(has_root):
            fixed = paths[is_fixed[:, index], index]
            record = self._records[int(self._names[index])]
            record.score += float(nodes.cost[fixed[0]])
            own = fixed[nodes.report[fixed] >= 0][::-1]
            kept = record.chances + nodes.chances[own].tolist()
            record.chances = kept[-self._lifecycle.confirm_hits :]
        states = {
            int(name): (nodes.mean[leaf].copy(), nodes.covariance[leaf].copy(), nodes.time[leaf])
            for name, leaf in zip(self._names.tolist(), leaves.tolist(), strict=True)
        }
        tree.fix(root, track, n_fixed)
        return tuple(self._strike(set(tree.track.tolist()), states))

    def _strike(
        self, live: set[int], states: dict[int, tuple[FloatArray, FloatArray, float]]
    ) -> Iterable[LostTrack]:
        """Forget the tracks that ended; yield the confirmed ones."""
        open_tracks = {track for track, _ in self.assignment.values()}
        for track in [name for name in self._records if name not in live | open_tracks]:
            record = self._records.pop(track)
            if record.confirmed and track in states:
                mean, covariance, time = states[track]
                dim = mean.shape[0] // 2
                spread = 3.0 * float(np.sqrt(np.trace(covariance[:dim, :dim])))
                yield LostTrack(mean[:dim], spread, float(time))

    def _name(self, track: IntArray, reports: list[list[int]]) -> IntArray:
        """Return an identifier for each chosen sequence.

        One that begins in the window keeps the identifier under which most of its reports were
        known; each identifier serves once.
        """
        names = track.copy()
        used = set(track[track >= 0].tolist())
        for index in np.flatnonzero(track < 0).tolist():
            known = Counter(
                self.assignment[report][0]
                for report in reports[index]
                if report in self.assignment and self.assignment[report][0] not in used
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

    def _assignment(
        self,
        tree: AssociationTree,
        paths: IntArray,
        slots: IntArray,
        report_of: IntArray,
        track: IntArray,
        beliefs: Beliefs | None,
    ) -> dict[int, tuple[int, float]]:
        """Return the track and the probability of each report that a sequence takes."""
        taken = slots >= 0
        holder = np.broadcast_to(track, slots.shape)[taken]
        if beliefs is None:
            probability = np.full(holder.shape[0], np.nan)
        else:
            probability = beliefs.edge_probability[beliefs.edge[paths[taken]]]
        number = report_of[slots[taken]]
        pairs = zip(holder.tolist(), probability.tolist(), strict=True)
        return dict(zip(number.tolist(), pairs, strict=True))

    def _confirm(
        self,
        tree: AssociationTree,
        leaves: IntArray,
        paths: IntArray,
        track: IntArray,
        beliefs: Beliefs | None,
    ) -> None:
        """Confirm the tracks that have been seen often enough."""
        nodes, lifecycle = tree.nodes, self._lifecycle
        for index, name in enumerate(track.tolist()):
            record = self._records[name]
            if record.confirmed:
                continue
            family = nodes.family[leaves[index]]
            if beliefs and beliefs.existence[family] < lifecycle.confirm_probability:
                continue
            if beliefs and beliefs.existence[family] >= lifecycle.certain_probability:
                record.confirmed = lifecycle.certain_probability < 1.0
            path = paths[paths[:, index] >= 0, index][::-1]
            own = path[nodes.report[path] >= 0]
            chances = record.chances + nodes.chances[own].tolist()
            record.confirmed = record.confirmed or lifecycle.is_confirmed_by(chances)

    def _rows(
        self,
        tree: AssociationTree,
        leaves: IntArray,
        track: IntArray,
        time: float,
        beliefs: Beliefs | None,
    ) -> TrackTable:
        """Return a row for each live track."""
        nodes = tree.nodes
        family = nodes.family[leaves]
        if beliefs is not None:
            live = beliefs.existence[family] >= REPORTED_EXISTENCE
        else:
            live = nodes.tail[leaves] <= tree.rule.end_cost
        order = np.flatnonzero(live)[np.argsort(track[live], kind="stable")]
        leaves, track, family = leaves[order], track[order], family[order]
        if beliefs is not None:
            mean, covariance = beliefs.mean[family], beliefs.covariance[family]
        else:
            mean, covariance = predicted(
                nodes.mean[leaves], nodes.covariance[leaves], time - nodes.time[leaves],
                tree.rule.process_noise,
            )  # fmt: skip
        records = [self._records[name] for name in track.tolist()]
        confirmed = np.array([record.confirmed for record in records], dtype=np.bool_)
        missed = nodes.misses[leaves] >= REPORTED_EXISTENCE
        fixed_score = np.array([record.score for record in records], dtype=np.float64)
        return TrackTable(
            time=np.full(track.shape[0], time),
            track=track,
            status=np.where(confirmed, np.where(missed, COASTING, CONFIRMED), TENTATIVE),
            mean=mean,
            covariance=covariance,
            score=fixed_score + nodes.cost[leaves],
            hits=nodes.hits[leaves],
            last_update=nodes.time[leaves],
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


def paths_of(tree: AssociationTree, leaves: IntArray) -> IntArray:
    """Return the nodes of each sequence, shape (longest, leaves), the leaf first, then -1."""
    levels = []
    current = leaves
    while np.any(current >= 0):
        levels.append(current)
        current = np.where(current >= 0, tree.nodes.parent[current], -1)
    return np.array(levels, dtype=np.int64).reshape(len(levels), leaves.shape[0])
