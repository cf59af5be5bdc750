"""Boxes of a detector, frame by frame: the same object keeps its name."""

import warnings
from collections.abc import Hashable, Sequence
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from trackweave.arrays import float_array, require_finite
from trackweave.errors import InvalidInputError
from trackweave.fields import checked_choice, checked_count, checked_number
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
from trackweave.trackers.boxes.window import Window
from trackweave.trackers.checkpoint import Saved

__all__ = [
    "BoxTracker",
]

FAR = 100.0  # periods; frames as far apart at once are of another unit, or of another period


class BoxTracker(Saved):
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
        New objects of a class a second, about. Must be positive.
    confirm
        An object is named once its existence is as probable as this, in (0, 1).
    rejoin
        Seconds for which a name stays open while its object is not seen. Beyond 2 s silence says
        no more against an object, which is looked for where it was last expected.
    window
        Frames before the last one of which several explanations are kept, until later boxes tell
        which is right (multiple hypotheses); 0 decides each frame for good.
    delay
        Frames by which the answer lags; the window is as long at least. The last frames come from
        ``rest``.

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
        window: int = 0,
        delay: int = 0,
    ) -> None:
        self._period = _positive(period, "period")
        distance_name = checked_choice(distance, "distance", ("centre", "iou"))
        self._by_overlap = distance_name == "iou"
        self._scores = checked_choice(scores, "scores", ("probability", "log-odds"))
        self._coming = _positive(coming, "coming")
        self._confirm = _positive(confirm, "confirm", 1.0)
        self._rejoin = _positive(rejoin, "rejoin")
        self._delay = checked_count(delay, "delay")
        self._depth = max(checked_count(window, "window"), self._delay)
        self._kinds: dict[Hashable, int] = {}
        self._time: float | None = None
        self._window: Window | None = None
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
            What each box shows, texts or whole numbers; boxes of different classes are never one
            object's.
        time
            Time of the frame [s], after the last one's; left out, a period after it.
        data
            Anything to be kept with each box.
        camera
            What takes this frame to the first: (2, 3) for the image, (4, 4) in 3-D. Left out, the
            camera has not moved.

        Returns
        -------
        The names of the boxes, in their order, and all tracks whose names are open; of an earlier
        frame where there is a delay.

        Raises
        ------
        InvalidInputError
            If an argument is not what it has to be; the tracker is as before then.
        """
        seen = self._checked(boxes, scores, (classes, data), time, camera)
        if self._window is None:
            self._window = self._begun(seen)
        wait = None if self._time is None else seen.time - self._time
        self._time = seen.time
        self._window.advance(seen, wait)
        self._number += 1
        return self._frame(self._window, self._delay)

    def rest(self) -> list[BoxFrame]:
        """Return the last frames, which a delay has kept back.

        Returns
        -------
        As many as the delay, or as there were frames; `update` may go on afterwards.
        """
        if self._window is None:
            return []
        last = min(self._delay, self._number + 1)
        return [self._frame(self._window, ago) for ago in range(last - 1, -1, -1)]

    def _checked(
        self,
        boxes: ArrayLike,
        scores: ArrayLike | None,
        items: tuple[Any, Any],
        time: float | None,
        camera: ArrayLike | None,
    ) -> Seen:
        """Return a frame whose every part is what it has to be."""
        n_columns = None if self._window is None else self._window.leaves.mean.shape[1]
        array = checked_boxes(boxes, n_columns)
        count = array.shape[0]
        given = np.full(count, np.nan)
        if scores is not None:
            empty = count == 0 and np.size(scores) == 0
            given = given if empty else float_array(scores, "scores", (count,))
            require_finite(given, "scores")
        classes, data = items
        # A tensor's entries are tensors, an array's can be told apart.
        classes = np.asarray(classes) if hasattr(classes, "__array__") else classes
        labels = [_plain(label) for label in checked_items(classes, "classes", count)]
        if time is None:
            time = 0.0 if self._time is None else self._time + self._period
        time = checked_number(time, "time")
        if self._time is not None and not time > self._time:
            raise InvalidInputError(f"time: {time}; expected after {self._time}, the last frame's")
        if self._number == 0:
            _ask_about_step(time - float(self._time or 0.0), self._period)
        moved = checked_camera(camera, array.shape[1])
        odds = checked_odds(given, self._scores)
        kept = checked_items(data, "data", count)
        for label in labels:
            self._kinds.setdefault(label, len(self._kinds))
        kinds = np.array([self._kinds[label] for label in labels], dtype=np.int64)
        return Seen(array, placed(array, moved), kinds, given, odds, kept, time, moved)

    def _begun(self, seen: Seen) -> Window:
        """Return the window before the first frame."""
        habits = Habits(seen.parts.shape[1])
        habits.know(1 + int(seen.kinds.max(initial=-1)))
        linker = Linker(habits, self._coming, by_overlap=self._by_overlap)
        none = linker.born(seen, None).of(np.empty(0, dtype=np.int64))
        return Window(linker, self._depth, self._rejoin, none)

    def _frame(self, window: Window, ago: int) -> BoxFrame:
        """Name what has become sure and return what is known of a frame."""
        if ago > self._number:
            return BoxFrame(-1, np.nan, np.empty(0, dtype=np.int64), ())
        seen, then, leaves = window.ago(ago)
        sure = existence(window.leaves.of(leaves))
        is_seen, is_sure = then.row >= 0, sure > self._confirm
        for leaf in leaves[(window.leaves.name[leaves] < 0) & is_seen & is_sure]:
            window.name(leaf, self._next)
            self._next += 1
        name = window.leaves.name[leaves]
        identifiers = np.full(len(seen.boxes), -1)
        shown = is_seen & is_sure
        identifiers[then.row[shown]] = name[shown]
        box = boxes_of(seen.camera.from_first(then.mean) if seen.camera else then.mean)
        box[is_seen] = seen.boxes[then.row[is_seen]]
        labels = list(self._kinds)
        tracks = tuple(
            BoxTrack(
                int(name[k]), box[k], labels[then.kind[k]], _score(then.score[k]),
                then.data[k], bool(is_seen[k]), float(sure[k]),
            )
            for k in np.flatnonzero(name >= 0)
        )  # fmt: skip
        return BoxFrame(self._number - ago, seen.time, identifiers, tracks)


def _ask_about_step(step: float, period: float) -> None:
    """Warn of a first step of so many periods that seconds are hardly meant."""
    if step >= FAR * period:
        warnings.warn(
            f"time: {step:.6g} s after the frame before, {step / period:,.0f} periods of "
            f"{period:g} s; expected seconds: are they milliseconds? Give period where frames "
            "are so far apart",
            UserWarning,
            stacklevel=4,
        )


def _positive(value: object, name: str, below: float = np.inf) -> float:
    number = checked_number(value, name)
    if not 0.0 < number < below:
        wanted = "a number above 0" if below == np.inf else f"a number between 0 and {below:g}"
        raise InvalidInputError(f"{name}: {value!r:.80}; expected {wanted}")
    return number


def _plain(label: Any) -> Hashable:
    """Return a class as what can be told apart, NumPy's as Python's."""
    label = label.item() if isinstance(label, np.generic) else label
    # Detectors have classes as columns of floats.
    label = int(label) if isinstance(label, float) and label.is_integer() else label
    if not isinstance(label, str | int | type(None)):
        raise InvalidInputError(f"classes: {label!r:.80}; expected texts or whole numbers")
    return label


def _score(score: float) -> float | None:
    return None if np.isnan(score) else float(score)
