"""The books of tracks that stand by a single hypothesis."""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackweave.arrays import FloatArray, IntArray
from trackweave.association.states import shown, states_at
from trackweave.association.tree import AssociationTree
from trackweave.domain.tracks import COASTING, CONFIRMED, TENTATIVE, TrackTable
from trackweave.trackers.lifecycle import Lifecycle

__all__ = ["SingleHypothesisManager"]

NOBODY = -1


class SingleHypothesisManager:
    """Identifiers, confirmation and scores, one of each for each family of a tree.

    The priors, tracks known beforehand and confirmed, are the first families; ``next_track`` is
    the least name of a new track.
    """

    def __init__(self, lifecycle: Lifecycle, priors: TrackTable, next_track: int = 1) -> None:
        self._lifecycle = lifecycle
        self.next_track = max(next_track, int(priors.track.max(initial=0)) + 1)
        """The name of the next track."""
        self._score = np.zeros(len(priors))
        self._chances: list[list[float]] = [[] for _ in range(len(priors))]
        self.track = priors.track.copy()
        """Identifiers; -1 for families that are no track."""
        self.is_confirmed = np.ones(len(priors), dtype=np.bool_)
        """Whether each is confirmed."""

    def __getstate__(self) -> dict[str, Any]:
        # A shallow copy is independent: what is changed in place is the copy's own.
        return {
            **self.__dict__,
            "_score": self._score.copy(),
            "_chances": self._chances.copy(),
            "is_confirmed": self.is_confirmed.copy(),
        }

    def enter(self, is_track: NDArray[np.bool_]) -> None:
        """Enter new families behind the others; those that are tracks get identifiers."""
        number = self.next_track + np.cumsum(is_track) - 1
        self.next_track += int(np.count_nonzero(is_track))
        self.track = np.concatenate([self.track, np.where(is_track, number, NOBODY)])
        fresh = np.zeros(is_track.shape[0], dtype=np.bool_)
        self.is_confirmed = np.concatenate([self.is_confirmed, fresh])
        self._score = np.concatenate([self._score, np.zeros(is_track.shape[0])])
        self._chances += [[] for _ in range(is_track.shape[0])]

    def hit(self, family: IntArray, chance: FloatArray, cost: FloatArray) -> None:
        """Enter a report of each given family: which of its chances that took, and its cost."""
        self._score[family] += cost
        new = ~self.is_confirmed[family]
        needed = self._lifecycle.confirm_hits
        for row, number in zip(family[new].tolist(), chance[new].tolist(), strict=True):
            own = [*self._chances[row], number]
            if len(own) >= needed:
                self.is_confirmed[row] = self._confirms(own, float(self._score[row]))
                own = self._lifecycle.recent(own)
            self._chances[row] = own

    def is_hopeless(self, family: IntArray, chances: FloatArray) -> NDArray[np.bool_]:
        """Tell which families are tentative and cannot be confirmed within the chances left."""
        # ``chances`` is how many each has had from its first report.
        lifecycle = self._lifecycle
        hits = np.array([len(self._chances[row]) for row in family.tolist()], dtype=np.int64)
        left = lifecycle.confirm_opportunities - chances
        # Once hit often enough, a track may wait for its score.
        is_short = (hits < lifecycle.confirm_hits) & (hits + left < lifecycle.confirm_hits - 0.5)
        return is_short & ~self.is_confirmed[family]

    def keep(self, track: IntArray) -> None:
        """Forget all families but those of the given tracks."""
        kept = np.isin(self.track, track)
        self.track, self.is_confirmed = self.track[kept], self.is_confirmed[kept]
        self._score = self._score[kept]
        self._chances = [self._chances[row] for row in np.flatnonzero(kept).tolist()]

    def rows(self, tree: AssociationTree, time: float) -> TrackTable:
        """Return a row for each track, of which the tree holds a node each, by identifier."""
        nodes, family = tree.nodes, tree.nodes.family[: tree.n_nodes]
        node = np.argsort(self.track[family], kind="stable")
        family = family[node]
        mean, covariance = states_at(tree, node, time)
        place, spread = shown(mean, covariance, tree.rule)
        ahead = tree.rule.motion.acceleration_at
        confirmed = np.where(nodes.misses[node] >= 0.5, COASTING, CONFIRMED)
        return TrackTable(
            time=np.full(node.shape[0], time),
            track=self.track[family],
            status=np.where(self.is_confirmed[family], confirmed, TENTATIVE),
            mean=place,
            covariance=spread,
            score=self._score[family],
            hits=nodes.hits[node],
            last_update=nodes.time[node],
            acceleration=mean[:, ahead : ahead + tree.dim] if ahead >= 0 else mean[:, :0],
        )

    def _confirms(self, chances: list[float], score: float) -> bool:
        """Tell whether hits at these chances confirm a track of such a score."""
        existence = 1.0 / (1.0 + math.exp(min(score, 500.0)))
        return existence >= self._lifecycle.confirm_probability and (
            self._lifecycle.is_confirmed_by(chances)
        )
