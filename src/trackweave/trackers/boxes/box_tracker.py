"""Boxes of a detector, frame by frame: the same object keeps its name."""

from collections.abc import Hashable, Sequence
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from trackweave.arrays import float_array, require_finite
from trackweave.errors import InvalidInputError
from trackweave.fields import checked_choice, checked_number
from trackweave.trackers.boxes.frames import (
    BoxFrame,
    BoxTrack,
    Seen,
    checked_boxes,
    checked_camera,
    checked_items,
    checked_odds,
    placed,
)
from trackweave.trackers.boxes.habits import Habits
from trackweave.trackers.boxes.linking import Linker, existence
from trackweave.trackers.boxes.shapes import boxes_of
from trackweave.trackers.boxes.states import Tracks

__all__ = ["BoxTracker"]

YOUNG = 2.5  # frames without a box after which what had one box only is forgotten
FORGOTTEN = 0.02  # probability to be there below which a track ends


class BoxTracker:
    """Follows what a detector finds in a video or a laser scan, a frame at a time.

    Each frame's boxes go to the tracks by one assignment of the highest probability: centres and
    sizes by a Kalman filter, scores as evidence for an object or against it (none is cut off),
    and whether an object may be hidden. How boxes err, and what a score means, is learned on the
    way.

    Parameters
    ----------
    period
        Seconds from frame to frame where ``update`` is told no time.
    distance
        What boxes are compared by: "centre" (and size), or "iou", their overlap, for boxes in
        the image.
    scores
        What scores are: a "probability" from 0 to 1, or "log-odds" on any scale, such as
        logits.
    coming
        New objects a second, about. Must be positive.
    confirm
        An object is named once its existence is as probable as this, in (0, 1).
    rejoin
        Seconds for which a name stays open while its object is not seen.

    Raises
    ------
    InvalidInputError
        If an argument is of another kind than it has to be, or out of range.

    Examples
    --------
    >>> import trackweave as tw
    >>> tracker = tw.BoxTracker(period=0.04)
    >>> for x in (0, 3, 6):  # pixels: x1, y1, x2, y2
    ...     boxes = [[x, 0, x + 20, 40], [90 - x, 0, 110 - x, 40]]
    ...     frame = tracker.update(boxes, scores=[0.95, 0.99], data=["left", "right"])
    ...
    >>> frame.identifiers
    array([1, 2])
    >>> [track.data for track in frame.tracks if track.visible]
    ['left', 'right']
    """

    def __init__(  # noqa: PLR0913 all by name, each with a default
        self,
        *,
        period: float = 0.04,
        distance: Literal["centre", "iou"] = "centre",
        scores: Literal["probability", "log-odds"] = "probability",
        coming: float = 1.0,
        confirm: float = 0.5,
        rejoin: float = 2.0,
    ) -> None:
        self._period = _positive(period, "period")
        distance_name = checked_choice(distance, "distance", ("centre", "iou"))
        self._by_overlap = distance_name == "iou"
        self._scores = checked_choice(scores, "scores", ("probability", "log-odds"))
        self._coming = _positive(coming, "coming")
        self._confirm = _positive(confirm, "confirm", 1.0)
        self._rejoin = _positive(rejoin, "rejoin")
        self._kinds: dict[Hashable, int] = {}
        self._time: float | None = None
        self._tracks: Tracks | None = None
        self._number, self._next = -1, 1

    def update(  # noqa: PLR0913 what a frame may come with
        self,
        boxes: ArrayLike,
        scores: ArrayLike | None = None,
        classes: Sequence[Hashable] | None = None,
        time: float | None = None,
        data: Sequence[Any] | None = None,
        camera: ArrayLike | None = None,
    ) -> BoxFrame:
        """Take in a frame's boxes and return what is known of it.

        Parameters
        ----------
        boxes
            A row a box, none for a frame without: corners x1, y1, x2, y2 in the image, or x, y, z
            of the centre, length, width, height and yaw in 3-D, z up, yaw from x towards y [rad];
            all lengths in one unit.
        scores
            How sure the detector is of each box.
        classes
            What each box shows; boxes of different classes are never one object's.
        time
            Time of the frame [s], after the last one's; left out, a period after it.
        data
            Anything to be kept with each box.
        camera
            What takes this frame to the first: (2, 3) for the image, (4, 4) in 3-D. Left out, the
            camera has not moved.

        Returns
        -------
        The names of the boxes, in their order, and all tracks whose names are open.

        Raises
        ------
        InvalidInputError
            If an argument is not what it has to be; the tracker is as before then.
        """
        seen = self._checked(boxes, scores, (classes, data), time, camera)
        if self._tracks is None:
            self._linker = Linker(
                Habits(seen.parts.shape[1]), self._coming, by_overlap=self._by_overlap
            )
            self._tracks = self._linker.none(seen)
        wait = None if self._time is None else seen.time - self._time
        self._time, self._number = seen.time, self._number + 1
        self._advance(self._tracks, seen, wait)
        return self._frame(seen)

    def _checked(
        self,
        boxes: ArrayLike,
        scores: ArrayLike | None,
        items: tuple[Any, Any],
        time: float | None,
        camera: ArrayLike | None,
    ) -> Seen:
        """Return a frame whose every part is what it has to be."""
        n_columns = None if self._tracks is None else self._tracks.mean.shape[1]
        array = checked_boxes(boxes, n_columns)
        count = array.shape[0]
        given = np.full(count, np.nan)
        if scores is not None:
            empty = count == 0 and np.size(scores) == 0
            given = given if empty else float_array(scores, "scores", (count,))
            require_finite(given, "scores")
        classes, data = items
        labels = [_plain(label) for label in checked_items(classes, "classes", count)]
        if time is None:
            time = 0.0 if self._time is None else self._time + self._period
        time = checked_number(time, "time")
        if self._time is not None and not time > self._time:
            raise InvalidInputError(f"time: {time}; expected after {self._time}, the last frame's")
        moved = checked_camera(camera, array.shape[1])
        odds = checked_odds(given, self._scores)
        for label in labels:
            self._kinds.setdefault(label, len(self._kinds))
        kinds = np.array([self._kinds[label] for label in labels], dtype=np.int64)
        kept = np.empty(count, dtype=object)
        kept[:] = checked_items(data, "data", count)
        return Seen(array, placed(array, moved), kinds, given, odds, kept, time, moved)

    def _advance(self, tracks: Tracks, seen: Seen, wait: float | None) -> None:
        """Take tracks through a frame."""
        linker = self._linker
        linker.look(seen)
        linker.wait(tracks, wait or 0.0)
        links = linker.linked(linker.odds(tracks, seen, wait or 0.0))
        linker.miss(tracks)
        linker.hit(tracks, seen, links)
        free = np.setdiff1d(np.arange(len(seen.boxes)), links.box)
        tracks = tracks.and_also(linker.born(seen, free, wait))
        silence = seen.time - tracks.last_seen
        is_lost = (tracks.hits < 2.0) & (tracks.name < 0) & (silence > YOUNG * (wait or 0.0))
        ended = (silence > self._rejoin) | (tracks.present < FORGOTTEN) & (tracks.hits >= 2.0)
        linker.habits.note_lost(tracks.of(np.flatnonzero((is_lost | ended) & (tracks.hits < 3.0))))
        self._tracks = tracks.of(np.flatnonzero(~(is_lost | ended)))

    def _frame(self, seen: Seen) -> BoxFrame:
        """Name what has become sure and return what is known."""
        tracks = self._tracks
        assert tracks is not None
        sure = existence(tracks)
        is_seen, is_sure = tracks.row >= 0, sure > self._confirm
        new = np.flatnonzero((tracks.name < 0) & is_seen & is_sure)
        tracks.name[new] = np.arange(self._next, self._next + new.size)
        self._next += new.size
        identifiers = np.full(len(seen.boxes), -1)
        shown = is_seen & is_sure
        identifiers[tracks.row[shown]] = tracks.name[shown]
        own = seen.camera.from_first(tracks.mean) if seen.camera else tracks.mean
        box = boxes_of(own)
        box[is_seen] = seen.boxes[tracks.row[is_seen]]
        labels = list(self._kinds)
        return BoxFrame(
            self._number, seen.time, identifiers,
            tuple(
                BoxTrack(
                    int(tracks.name[k]), box[k], labels[tracks.kind[k]], _score(tracks.score[k]),
                    tracks.data[k], bool(is_seen[k]), float(sure[k]),
                )
                for k in np.flatnonzero(tracks.name >= 0)
            ),
        )  # fmt: skip


def _positive(value: object, name: str, below: float = np.inf) -> float:
    number = checked_number(value, name)
    if not 0.0 < number < below:
        wanted = "a number above 0" if below == np.inf else f"a number between 0 and {below:g}"
        raise InvalidInputError(f"{name}: {value!r:.80}; expected {wanted}")
    return number


def _plain(label: Any) -> Hashable:
    """Return a class as what can be told apart, NumPy's as Python's."""
    label = label.item() if isinstance(label, np.generic) else label
    if not isinstance(label, str | int | type(None)):
        raise InvalidInputError(f"classes: {label!r:.80}; expected texts or whole numbers")
    return label


def _score(score: float) -> float | None:
    return None if np.isnan(score) else float(score)
