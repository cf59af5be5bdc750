"""What a tracker learns of a detector as it goes: how boxes err, how sure it is, and how often."""

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.trackers.boxes import states
from trackweave.trackers.boxes.states import Tracks

__all__ = [
    "UNKNOWN",
    "Habits",
]

WEIGHT = 30.0  # boxes that the values at the start count for
LONGEST = 500.0  # boxes that count at most, so that the old are forgotten
LOST_MEAN, LOST_SIGMA = -2.0, 2.0  # log-odds of boxes that nothing follows, at the start
LEAST_SIGMA = 0.1  # of the same, where they are all alike
FALSE = 0.5  # such boxes a frame, at the start
UNKNOWN = 2.0  # what a box without a score says for an object [nats]
LARGEST_RATIO = 9.0  # squared surprises over their variances beyond this are odd boxes'
SUREST = 8.0  # nats that one score can say


class Habits:
    """What is known of boxes of each class, the first axis of every array."""

    def __init__(self, n_parts: int) -> None:
        self.factor = np.empty((0, n_parts))
        self._moments = np.empty((0, 3))
        self.false = np.empty(0)
        self._links = np.empty(0)
        self._frames = 1.0

    def __len__(self) -> int:
        return self.false.shape[0]

    def know(self, n_kinds: int) -> None:
        """Have values for so many classes."""
        more = max(0, n_kinds - len(self))
        self.factor = np.vstack([self.factor, np.ones((more, self.factor.shape[1]))])
        square = LOST_MEAN**2 + LOST_SIGMA**2
        start = np.tile(WEIGHT * np.array([1.0, LOST_MEAN, square]), (more, 1))
        self._moments = np.vstack([self._moments, start])
        self.false = np.append(self.false, np.full(more, FALSE))
        self._links = np.append(self._links, np.full(more, WEIGHT))

    def evidence(self, scores: FloatArray, kinds: IntArray) -> FloatArray:
        """Return what each score [log-odds] says for an object [nats]."""
        # Boxes that nothing follows tell how scores of what is no object spread; a score says
        # as much as it stands out from them. At the start this is the score itself.
        count, total, square = self._moments[kinds].T
        mean = total / count
        sigma = np.sqrt(np.maximum(square / count - mean**2, LEAST_SIGMA**2))
        said = np.clip(2.0 * ((scores - mean) / sigma - 1.0), -SUREST, SUREST)
        return np.where(np.isnan(scores), UNKNOWN, said)

    def error(self, tracks: Tracks) -> FloatArray:
        """Return variances of boxes of tracks."""
        deviation = states.columns(states.ERROR, tracks.mean)
        return np.asarray(deviation**2 * self.factor[tracks.kind])

    def note_lost(self, lost: Tracks) -> None:
        """Learn from tracks that ended as soon as they began what scores mean nothing."""
        mean = lost.score_sum / lost.hits
        told = ~np.isnan(mean)
        one = np.stack([np.ones_like(mean), mean, mean**2], axis=1)
        np.add.at(self._moments, lost.kind[told], one[told])
        much = np.maximum(self._moments[:, :1] / LONGEST, 1.0)
        self._moments /= much

    def note_links(self, ratio: FloatArray, kinds: IntArray) -> None:
        """Learn from squared surprises over their variances, shape (links, parts)."""
        dim = ratio.shape[1] // 2
        ratio = np.minimum(ratio, LARGEST_RATIO)
        for kind in np.unique(kinds):
            here = ratio[kinds == kind]
            share = len(here) / (self._links[kind] + len(here))
            for part in (slice(0, dim), slice(dim, 2 * dim), slice(2 * dim, None)):
                mean = here[:, part].mean() if here[:, part].size else 1.0
                self.factor[kind, part] *= 1.0 + share * (mean - 1.0)
            self._links[kind] = min(self._links[kind] + len(here), LONGEST)

    def note_alone(self, probability: FloatArray, kinds: IntArray) -> None:
        """Learn from how probably each box without a track is no object's."""
        seen = np.bincount(kinds, weights=probability, minlength=len(self))
        self.false = np.maximum(self.false + (seen - self.false) / (self._frames + 1.0), 0.02)
        self._frames = min(self._frames + 1.0, 200.0)
