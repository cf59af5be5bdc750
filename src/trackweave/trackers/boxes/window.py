"""Several explanations of the last frames' boxes, until later frames tell which is right."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from trackweave.arrays import FloatArray, IntArray
from trackweave.trackers.boxes.frames import Seen
from trackweave.trackers.boxes.linking import (
    DETECTED,
    Linker,
    Links,
    clearly,
    lasting,
    missed,
    resting,
    undoubted,
)
from trackweave.trackers.boxes.states import Tracks

__all__ = [
    "Moment",
    "Window",
]

BoolArray = NDArray[np.bool_]

MOST = 6  # explanations of one object, by their probability
FARTHEST = 15.0  # nats by which the others may fall behind
YOUNG = 2.5  # frames without a box after which what had one box only is forgotten
FORGOTTEN = 0.02  # probability to be there below which a track ends


class Moment(NamedTuple):
    """A frame of the window: its boxes, the leaves after it, and the leaf before of each."""

    seen: Seen
    leaves: Tracks
    parent: IntArray


class Window:
    """Track-oriented multiple hypotheses over the last frames, with N-scan pruning.

    Each leaf is a way in which one object may have had boxes: ``_path`` holds its box in each
    frame of the window, ``_family`` the object, ``_score`` the log-likelihood ratio of its links
    and misses. ``chosen`` are the leaves of the best explanation of all boxes.

    Parameters
    ----------
    linker
        What weighs boxes against tracks.
    depth
        Frames before the last one whose boxes may still go to other tracks; 0 for none.
    rejoin
        Seconds without a box after which a track ends.
    none
        No tracks, of as many parts as boxes have.
    """

    def __init__(self, linker: Linker, depth: int, rejoin: float, none: Tracks) -> None:
        self._linker, self._depth, self._rejoin = linker, depth, rejoin
        self.leaves = none
        self.moments: list[Moment] = []
        self.chosen = self._family = np.empty(0, dtype=np.int64)
        self._score = np.empty(0)
        self._path = np.empty((0, 0), dtype=np.int64)
        self._silent = np.empty((0, 3, 0))
        self._n_families = 0

    def advance(self, seen: Seen, wait: float | None) -> None:
        """Take in a frame and choose the best explanation of the window's boxes."""
        if len(self.moments) > self._depth:
            self._path, self._silent = self._path[:, 1:], self._silent[:, :, 1:]
            self.moments.pop(0)
        linker, n_boxes = self._linker, len(seen.boxes)
        linker.look(seen)
        parents = self._grow(seen, wait or 0.0)
        self.leaves = self.leaves.and_also(linker.born(seen, wait))
        families = np.arange(self._n_families, self._n_families + n_boxes)
        self._n_families += n_boxes
        self._family = np.append(self._family[parents], families)
        self._score = np.append(self._score, np.zeros(n_boxes))
        begun = np.full((n_boxes, self._path.shape[1]), -1)
        self._path = np.column_stack([np.vstack([self._path[parents], begun]), self.leaves.row])
        new = np.zeros((n_boxes, 3, self._path.shape[1]))
        new[:, 0] = self.leaves.visible[-n_boxes:, None] if n_boxes else 0.0
        self._silent = np.concatenate([self._silent[parents], new])
        parents = np.append(parents, np.full(n_boxes, -1))
        self._choose()
        self._learn(seen, wait)
        self._prune(seen, wait or 0.0, parents)

    def _grow(self, seen: Seen, wait: float) -> IntArray:
        """Let every leaf be missed, and have any box that may be its own; return the parents."""
        linker, leaves = self._linker, replace(self.leaves)
        rests = resting(leaves, seen, wait)
        linker.wait(leaves, seen, wait)
        odds = linker.odds(leaves, seen, wait)
        track, box = np.nonzero(clearly(odds, rests, linker.habits.false[seen.kinds]))
        self._stay_silent(wait, rests)
        misses = np.log1p(-leaves.visible * DETECTED)
        parents = np.append(np.arange(len(leaves)), track)
        self._score = (self._score + misses)[parents]
        self._score[len(leaves) :] += odds[track, box]
        linker.miss(leaves, self.leaves, rests)
        links = Links(np.arange(len(leaves), parents.size), box, odds[track, box])
        self.leaves = leaves.of(parents)
        linker.hit(self.leaves, seen, links)
        return parents

    def _stay_silent(self, wait: float, rests: BoolArray) -> None:
        """Take on what would have been of leaves that had no box from each frame on."""
        now = np.stack([self.leaves.visible, self.leaves.hidden, self._score], axis=1)
        silent = np.concatenate([self._silent, now[:, :, None]], axis=2)
        visible, hidden = lasting(silent[:, 0], silent[:, 1], wait)
        score = silent[:, 2] + np.log1p(-visible * DETECTED)
        present = silent[:, 0] + silent[:, 1]
        visible, hidden = missed(visible, hidden)
        visible, hidden = undoubted(visible, hidden, present, rests[:, None])
        self._silent = np.stack([visible, hidden, score], axis=1)

    def _choose(self) -> None:
        """Choose at most one leaf of each family, so that each box is of one leaf at most."""
        family, path, score = self._family, self._path, self._score
        is_silent = (path < 0).all(axis=1) | (self.leaves.hits < 2.0)
        worth = score - self._silent[:, 2, 0]
        rows = np.flatnonzero(~is_silent & (worth > 0.0))
        taken = rows[self._solved(rows, worth[rows])]
        # A box that a track has begins none; other tracks had no box.
        free = np.flatnonzero(is_silent)
        free = free[~np.isin(family[free], family[taken])]
        has_begun = free[(path[free] >= 0).any(axis=1)]
        used = (path[has_begun][:, None] == path[taken][None]) & (path[has_begun] >= 0)[:, None]
        self.chosen = np.sort(np.concatenate([
            taken, np.setdiff1d(free, has_begun[used.any(axis=(1, 2))])
        ]))  # fmt: skip

    def _solved(self, rows: IntArray, worth: FloatArray) -> IntArray:
        """Return which of some leaves are chosen."""
        family, places = np.unique(self._family[rows], return_inverse=True)
        path = self._path[rows]
        if path.shape[1] == 1 and rows.size:
            gain = np.zeros((family.size, int(path.max()) + 1))
            gain[places, path[:, 0]] = worth
            first, second = linear_sum_assignment(gain, maximize=True)
            chosen = np.full(gain.shape, False)
            chosen[first, second] = gain[first, second] > 0.0
            return np.flatnonzero(chosen[places, path[:, 0]])
        if not rows.size:
            return np.empty(0, dtype=np.int64)
        # Their kernels take a second to load, which frames decided one by one do not need.
        from trackweave.association.problem import AssignmentProblem
        from trackweave.solvers.dual import Dual

        tuples = np.column_stack([places, path]) + 1
        problem = AssignmentProblem.from_tuples(tuples, -worth)
        row = problem.row
        assert row is not None
        return np.asarray(row[Dual()(problem, rng=0).nodes])

    def _learn(self, seen: Seen, wait: float | None) -> None:
        """Learn from what was chosen in the last frame."""
        habits, leaves = self._linker.habits, self.leaves
        sure = self.chosen[np.isfinite(leaves.ratio[self.chosen]).all(axis=1)]
        habits.note_links(leaves.ratio[sure], leaves.kind[sure])
        had = self._path[self.chosen, -1][leaves.hits[self.chosen] > 1.0]
        free = np.setdiff1d(np.arange(len(seen.boxes)), had)
        self._linker.note_alone(seen, free, wait)

    def _prune(self, seen: Seen, wait: float, parents: IntArray) -> None:
        """Keep the most probable leaves that agree with what has become final."""
        leaves = self.leaves
        is_chosen = np.zeros(len(leaves), dtype=bool)
        is_chosen[self.chosen] = True
        keep = self._agreeing() & (is_chosen | self._probable())
        silence = seen.time - leaves.last_seen
        is_lost = (leaves.hits < 2.0) & (leaves.name < 0) & (silence > YOUNG * wait)
        is_over = (silence > self._rejoin) | (leaves.present < FORGOTTEN) & (leaves.hits >= 2.0)
        fleeting = is_chosen & (is_lost | is_over) & (leaves.hits < 3.0)
        self._linker.habits.note_lost(leaves.of(np.flatnonzero(fleeting)))
        kept = np.flatnonzero(keep & ~(is_lost | is_over))
        self.leaves, self._path = leaves.of(kept), self._path[kept]
        self._family = np.unique(self._family[kept], return_inverse=True)[1]
        self._n_families = 1 + int(self._family.max(initial=-1))
        self._silent = self._silent[kept]
        base = self._silent[:, 2, 0].copy()
        self._score, self._silent[:, 2] = (
            self._score[kept] - base,
            self._silent[:, 2] - base[:, None],
        )
        self.moments.append(Moment(seen, self.leaves, parents[kept]))
        self.chosen = np.flatnonzero(is_chosen[kept])

    def _agreeing(self) -> BoolArray:
        """Tell which leaves are of chosen families and, in the oldest frame, as was chosen."""
        first = np.full(self._n_families, -2)
        first[self._family[self.chosen]] = self._path[self.chosen, 0]
        # A box that a track has in the best explanation begins no other.
        agreeing = first[self._family] > -2
        if len(self.moments) >= self._depth:
            agreeing &= self._path[:, 0] == first[self._family]
        return agreeing

    def _probable(self) -> BoolArray:
        """Tell which leaves are among the best of their families."""
        family, had = self._family, self._path >= 0
        # Of those that had no box for as long, the best stays: it may have to be.
        since = np.where(had.any(axis=1), np.argmax(had[:, ::-1], axis=1), had.shape[1])
        probable = _rank(self._score, family) < MOST
        probable |= _rank(self._score, family * (had.shape[1] + 1) + since) < 1
        best = np.full(self._n_families, -np.inf)
        np.maximum.at(best, family, self._score)
        return np.asarray(probable & (self._score > best[family] - FARTHEST))

    def ago(self, n_frames: int) -> tuple[Seen, Tracks, IntArray]:
        """Return what was seen some frames ago, the chosen tracks then, and their leaves now."""
        rows = leaves = self.chosen
        for moment in self.moments[: -n_frames - 1 : -1]:
            rows = moment.parent[rows]
            leaves, rows = leaves[rows >= 0], rows[rows >= 0]
        then = self.moments[-n_frames - 1]
        return then.seen, then.leaves.of(rows), leaves

    def name(self, leaf: int, name: int) -> None:
        """Name the object of a leaf."""
        self.leaves.name[self._family == self._family[leaf]] = name


def _rank(score: FloatArray, group: IntArray) -> IntArray:
    """Return how many of its group have a higher score."""
    order = np.lexsort([-score, group])
    rank = np.empty(group.size, dtype=np.int64)
    rank[order] = np.arange(group.size) - np.searchsorted(group[order], group[order])
    return rank
