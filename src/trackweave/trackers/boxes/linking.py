"""How probable it is that boxes are of tracks, and what becomes of either."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from trackweave.arrays import FloatArray, IntArray
from trackweave.trackers.boxes import states
from trackweave.trackers.boxes.frames import Seen
from trackweave.trackers.boxes.habits import Habits
from trackweave.trackers.boxes.shapes import IMAGE, boxes_of, overlaps
from trackweave.trackers.boxes.states import Tracks

__all__ = [
    "Linker",
    "Links",
    "clearly",
    "existence",
    "lasting",
    "missed",
    "resting",
    "undoubted",
]

DETECTED = 0.9  # probability that the detector finds what it could see
HIDE, SHOW, LEAVE = 0.5, 1.0, 0.05  # how often objects do, a second
SIZES = np.log(2.0)  # boxes of anything spread over a factor of e² in each extent
STAY = 10.0  # seconds that objects there at the start have been coming
LONGEST = 1e6  # seconds; after more nobody knows more
MOMENT = 2.0  # seconds; of names that stay open for longer, longer silences say nothing
CLEAR = 2.0  # nats of odds from which a box is of a track that was silent for longer
PASSING = 5.0  # and by how many times as many odds, for each false box a frame
LIKENESS = 0.5  # correlation of scores of one object


class Links(NamedTuple):
    """Which tracks have which boxes, and the logarithm of the odds for each."""

    track: IntArray
    box: IntArray
    odds: FloatArray


def existence(tracks: Tracks) -> FloatArray:
    """Return how probable it is that each is an object and there."""
    # That something is followed says that it is there; what it is, its scores say, which are
    # alike from frame to frame: as many as there may be, they count as two at most.
    said = tracks.evidence / (1.0 + LIKENESS * (tracks.hits - 1.0))
    return np.asarray(tracks.present / (1.0 + np.exp(-said)))


def lasting(visible: FloatArray, hidden: FloatArray, seconds: float) -> tuple[FloatArray, ...]:
    """Return the probabilities to be visible and hidden after some time."""
    hide, show, leave = (-np.expm1(-rate * seconds) for rate in (HIDE, SHOW, LEAVE))
    shown = visible * (1.0 - hide) + hidden * show
    return shown * (1.0 - leave), (visible + hidden - shown) * (1.0 - leave)


def missed(visible: FloatArray, hidden: FloatArray) -> tuple[FloatArray, ...]:
    """Return the probabilities to be visible and hidden of what had no box."""
    likely = 1.0 - visible * DETECTED
    return visible * (1.0 - DETECTED) / likely, hidden / likely


def resting(tracks: Tracks, seen: Seen, wait: float) -> NDArray[np.bool_]:
    """Tell which tracks had been silent for more than a moment before a frame."""
    # A little more, so that rounded times let none rest where names are open for a moment only.
    return np.asarray(seen.time - wait - tracks.last_seen > 1.001 * MOMENT)


def clearly(odds: FloatArray, rests: NDArray[np.bool_], false: FloatArray) -> NDArray[np.bool_]:
    """Tell which boxes may be of which tracks, by log-odds of shape (tracks, boxes)."""
    # ``false`` is how many false boxes a frame has of each box's class: over a long silence some
    # of them comes by that is a little likelier than not.
    least = CLEAR + np.log1p(PASSING * false)
    return np.asarray(odds > np.where(rests[:, None], least[None], 0.0))


def undoubted(
    visible: FloatArray, hidden: FloatArray, present: FloatArray, rests: NDArray[np.bool_]
) -> tuple[FloatArray, ...]:
    """Return the probabilities to be visible and hidden, in sum as before of those that rest."""
    share = np.where(rests, present / np.maximum(visible + hidden, 1e-300), 1.0)
    return visible * share, hidden * share


class Linker:
    """Weighs boxes against tracks by what is known of the detector.

    Parameters
    ----------
    habits
        What is known of it.
    coming
        New objects of a class a second.
    by_overlap
        Whether boxes in the image are compared by intersection over union instead of by centre
        and size.
    """

    def __init__(self, habits: Habits, coming: float, *, by_overlap: bool) -> None:
        self.habits, self._coming, self._by_overlap = habits, coming, by_overlap
        self._low = self._high = np.empty(0)

    def look(self, seen: Seen) -> None:
        """Note where boxes are found at all, as the frame's own camera sees them."""
        self.habits.know(int(seen.kinds.max(initial=-1)) + 1)
        if len(seen.boxes):
            dim = seen.parts.shape[1] // 2
            own = seen.camera.from_first(seen.parts) if seen.camera else seen.parts
            low, high = own[:, :dim].min(axis=0), own[:, :dim].max(axis=0)
            self._low = np.minimum(low, self._low) if self._low.size else low
            self._high = np.maximum(high, self._high) if self._high.size else high

    def wait(self, tracks: Tracks, seen: Seen, wait: float) -> None:
        """Take tracks to the time of a frame, in place."""
        seconds, rests = min(wait, LONGEST), resting(tracks, seen, wait)
        if rests.any():
            # They stay where they were expected, or they would be wherever something new is.
            moving = np.flatnonzero(~rests)
            some = tracks.of(moving)
            states.predict(some, self.habits.factor[some.kind], seconds)
            for name in states.MOVED:
                setattr(tracks, name, getattr(tracks, name).copy())
            tracks.put(moving, some, states.MOVED)
        else:
            states.predict(tracks, self.habits.factor[tracks.kind], seconds)
        tracks.visible, tracks.hidden = lasting(tracks.visible, tracks.hidden, seconds)

    def _alone(self, seen: Seen, wait: float | None) -> tuple[FloatArray, FloatArray]:
        """Return of each box what its score says, and how probably it is new if it is alone."""
        said = self.habits.evidence(seen.odds, seen.kinds)
        new = self._coming * (STAY if wait is None else wait)
        odds = np.log(new) + said - np.log(self.habits.false[seen.kinds])
        return said, 1.0 / (1.0 + np.exp(-odds))

    def odds(self, tracks: Tracks, seen: Seen, wait: float) -> FloatArray:
        """Return the log-odds that each box is of each track, against neither being so."""
        if not (len(tracks) and len(seen.boxes)):
            return np.empty((len(tracks), len(seen.boxes)))
        said = self.habits.evidence(seen.odds, seen.kinds)
        false = self.habits.false[seen.kinds]
        others = np.logaddexp(np.log(false), np.log(self._coming * wait) + said)
        found = np.clip(tracks.visible * DETECTED, 1e-12, None)
        own = np.log(found / (1.0 - found))
        odds = own[:, None] + self._alike(tracks, seen) + (said - others)[None]
        odds[tracks.kind[:, None] != seen.kinds[None]] = -np.inf
        return np.asarray(odds)

    def _alike(self, tracks: Tracks, seen: Seen) -> FloatArray:
        """Return how much likelier each track's box would be so than any box."""
        error = self.habits.error(tracks)
        n_parts = seen.parts.shape[1]
        if self._by_overlap and n_parts == IMAGE:
            spread = tracks.variance + error
            scale = states.columns((1.0, 1.0, 1.0), tracks.mean)
            apart = 1.0 - overlaps(boxes_of(tracks.mean), boxes_of(seen.parts))
            total = (spread / scale**2).sum(axis=1)[:, None]
            likely = -n_parts / 4.0 * apart**2 / total
            likely -= 0.5 * np.log(2 * np.pi * spread).sum(axis=1)[:, None]
            likely[apart >= 1.0] = -np.inf
        else:
            likely = np.logaddexp(*states.likelihoods(
                tracks, states.surprises(tracks.mean[:, None], seen.parts[None]), error
            ))  # fmt: skip
        dim = n_parts // 2
        extents = states.mean_extents(seen.parts)
        growth = seen.camera.growth if seen.camera else 0.0
        span = np.maximum(self._high - self._low, 5.0 * extents.mean() * np.exp(-growth))
        anywhere = np.log(span).sum() + dim * (growth + SIZES) + (n_parts % 2) * np.log(np.pi)
        return np.asarray(likely + anywhere)

    def miss(self, tracks: Tracks, before: Tracks, rests: NDArray[np.bool_]) -> None:
        """Take it in that tracks had no box, in place; ``before`` they were a frame ago."""
        visible, hidden = missed(tracks.visible, tracks.hidden)
        tracks.visible, tracks.hidden = undoubted(visible, hidden, before.present, rests)
        tracks.row = np.full(len(tracks), -1)
        tracks.ratio = np.full_like(tracks.mean, np.nan)

    def hit(self, tracks: Tracks, seen: Seen, links: Links) -> None:
        """Take in boxes of tracks that were missed until then, in place."""
        rows, boxes = links.track, links.box
        sure = 1.0 / (1.0 + np.exp(-np.minimum(links.odds, 50.0)))
        tracks.visible[rows] = sure + (1.0 - sure) * tracks.visible[rows]
        tracks.hidden[rows] *= 1.0 - sure
        some, error = tracks.of(rows), self.habits.error(tracks.of(rows))
        surprise = states.surprises(some.mean, seen.parts[boxes])
        known = (some.hits >= 3.0) & (sure > 0.9)
        tracks.ratio[rows[known]] = (surprise**2 / (some.variance + error))[known]
        states.update(some, surprise, error)
        tracks.put(rows, some, states.MOVED)
        tracks.evidence[rows] += self.habits.evidence(seen.odds[boxes], seen.kinds[boxes])
        tracks.hits[rows] += 1.0
        tracks.score_sum[rows] += seen.odds[boxes]
        tracks.row[rows], tracks.last_seen[rows] = boxes, seen.time
        tracks.score[rows], tracks.data[rows] = seen.scores[boxes], seen.data[boxes]

    def note_alone(self, seen: Seen, boxes: IntArray, wait: float | None) -> None:
        """Learn from boxes of no track how many are false."""
        _, new = self._alone(seen, wait)
        self.habits.note_alone(1.0 - new[boxes], seen.kinds[boxes])

    def born(self, seen: Seen, wait: float | None) -> Tracks:
        """Return the tracks that begin with each box."""
        said, new = self._alone(seen, wait)
        one, kinds = np.ones(len(seen.boxes)), seen.kinds
        others: dict[str, NDArray[Any]] = {
            "visible": new, "hidden": 0.0 * one, "kind": kinds,
            "name": np.full(len(seen.boxes), -1), "hits": one.copy(), "evidence": said,
            "score_sum": seen.odds, "last_seen": seen.time * one,
            "row": np.arange(len(seen.boxes)), "score": seen.scores, "data": seen.data,
        }  # fmt: skip
        return states.born(seen.parts, self.habits.factor[kinds], others)
