"""What a box tracker is given and what it returns, frame by frame."""

from collections.abc import Iterable, Mapping, Set
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from trackweave.arrays import FloatArray, IntArray, float_array, n_axes, require_finite
from trackweave.errors import InvalidInputError
from trackweave.summaries import summary
from trackweave.trackers.boxes.shapes import IMAGE, SOLID, Camera, parts_of

__all__ = [
    "BoxFrame",
    "BoxTrack",
    "Seen",
    "checked_boxes",
    "checked_camera",
    "checked_items",
    "checked_odds",
    "placed",
]

FARTHEST = 1e100  # so that squares and their products are finite
# What arrays of more columns hold, as detectors and other trackers have them.
_HINTS = {
    5: ". Scores are the second argument: update(a[:, :4], a[:, 4])",
    6: ". Scores and classes are arguments of their own: update(a[:, :4], a[:, 4], a[:, 5])",
    8: ". Scores are the second argument: update(a[:, :7], a[:, 7])",
}
SUREST = 1e-4  # probabilities nearer to 0 or 1 count as this near


@dataclass(frozen=True, slots=True, eq=False)
class BoxTrack:
    """An object that is followed, as of one frame.

    Parameters
    ----------
    identifier
        Its name, from 1.
    box
        Its box as this frame's camera sees it: the detector's, or the predicted one where it had
        none.
    class_
        Its class as it was given, None where none was.
    score
        Score of its last box, None where none was given.
    data
        What was given with its last box.
    visible
        Whether it had a box in this frame.
    existence
        Probability that it is an object, and still there.

    Examples
    --------
    >>> import trackweave as tw
    >>> tracker = tw.BoxTracker()
    >>> frame = tracker.update([[0, 0, 20, 40]], scores=[0.99], data=["a.png"])  # pixels
    >>> track = frame.tracks[0]
    >>> track.identifier, track.data, track.visible
    (1, 'a.png', True)
    """

    identifier: int
    box: FloatArray
    class_: Any
    score: float | None
    data: Any
    visible: bool
    existence: float

    __repr__ = summary


@dataclass(frozen=True, slots=True, eq=False)
class BoxFrame:
    """What is known of one frame.

    Parameters
    ----------
    number
        Which frame it is, from 0; -1 where a delay leaves nothing to tell yet.
    time
        Its time [s].
    identifiers
        Of each box the name of its track, in the order of the boxes; -1 where none is sure, yet
        or any longer.
    tracks
        All objects whose names are open, those without a box in this frame too.

    Examples
    --------
    >>> import trackweave as tw
    >>> tracker = tw.BoxTracker()
    >>> tracker.update([[0, 0, 20, 40], [90, 0, 110, 40]], scores=[0.99, 0.3]).identifiers
    array([ 1, -1])
    """

    number: int
    time: float
    identifiers: IntArray
    tracks: tuple[BoxTrack, ...]

    __repr__ = summary


class Seen(NamedTuple):
    """Boxes of a frame, checked; ``parts`` as the first frame's camera would see them."""

    boxes: FloatArray
    parts: FloatArray
    kinds: IntArray
    scores: FloatArray
    odds: FloatArray
    data: NDArray[Any]
    time: float
    camera: Camera | None


def checked_boxes(boxes: ArrayLike, n_columns: int | None) -> FloatArray:
    """Return boxes as an array of 4 or 7 columns, or of as many as earlier frames had."""
    if n_axes(boxes, "boxes") == 1 and np.size(boxes) == 0:
        boxes = np.empty((0, n_columns or IMAGE))
    array = float_array(boxes, "boxes", (None, None))
    if len(array) == 0 and array.shape[1] not in (IMAGE, SOLID):
        # A detector's empty array has its columns of scores and classes still.
        array = np.empty((0, n_columns or IMAGE))
    wanted = (n_columns,) if n_columns else (IMAGE, SOLID)
    if array.shape[1] not in wanted:
        raise InvalidInputError(
            f"boxes: {array.shape[1]} columns; expected " + " or ".join(map(str, wanted))
            + (" as in earlier frames" if n_columns else
               ": x1, y1, x2, y2, or x, y, z, length, width, height, yaw")
            + _HINTS.get(array.shape[1], "")
        )  # fmt: skip
    require_finite(array, "boxes")
    is_flat = array.shape[1] == IMAGE
    extents = array[:, 2:] - array[:, :2] if is_flat else array[:, 3:6]
    far = np.argwhere((np.abs(array) > FARTHEST).any(axis=1))
    bad = far if far.size else np.argwhere(~(extents >= 0.0).all(axis=1))
    if bad.size:
        row = int(bad[0, 0])
        wanted_text = "x1 ≤ x2 and y1 ≤ y2" if is_flat else "extents of at least 0"
        wanted_text = f"numbers from {-FARTHEST:g} to {FARTHEST:g}" if far.size else wanted_text
        raise InvalidInputError(f"boxes[{row}]: {array[row].tolist()}; expected {wanted_text}")
    return array


def checked_odds(scores: FloatArray, kind: str) -> FloatArray:
    """Return scores as log-odds."""
    if kind == "log-odds":
        return np.clip(scores, -1e3, 1e3)
    bad = np.flatnonzero((scores < 0.0) | (scores > 1.0))
    if bad.size:
        raise InvalidInputError(
            f"scores[{bad[0]}]: {scores[bad[0]]}; expected a probability from 0 to 1, or "
            'BoxTracker(scores="log-odds") for scores on any other scale'
        )
    inside = np.clip(scores, SUREST, 1.0 - SUREST)
    return np.asarray(np.log(inside / (1.0 - inside)))


def checked_items(values: Any, name: str, n_boxes: int) -> NDArray[Any]:
    """Return an item for each box, Nones where there are none."""
    kept = np.full(n_boxes, None, dtype=object)
    if values is None:
        return kept
    is_row = isinstance(values, Iterable) and not isinstance(values, str | bytes | Mapping | Set)
    if not is_row or (isinstance(values, np.ndarray) and values.ndim == 0):
        raise InvalidInputError(f"{name}: {values!r:.80}; expected one for each box")
    items = list(values)
    if len(items) != n_boxes:
        raise InvalidInputError(f"{name}: {len(items)} of them; expected {n_boxes}, one a box")
    for place, item in enumerate(items):
        kept[place] = item  # at once, NumPy would take items apart that are rows themselves
    return kept


def checked_camera(camera: ArrayLike | None, n_columns: int) -> Camera | None:
    """Return what takes this frame to the first, None where the camera stands still."""
    if camera is None:
        return None
    shape = (2, 3) if n_columns == IMAGE else (4, 4)
    given = np.shape(camera) if n_axes(camera, "camera") == 2 else ()
    if given == (3, 3) and n_columns == IMAGE:
        raise InvalidInputError(
            "camera: an array of shape (3, 3); expected shape (2, 3): camera[:2], without the "
            "last row, where that is 0, 0, 1; what bends parallels (a homography) is not taken"
        )
    if given == (3, 4) and n_columns == SOLID:
        raise InvalidInputError(
            "camera: an array of shape (3, 4); expected shape (4, 4), with a last row 0, 0, 0, 1"
        )
    matrix = float_array(camera, "camera", shape)
    require_finite(matrix, "camera")
    dim = shape[0] if n_columns == IMAGE else 3
    volume = float(np.linalg.det(matrix[:dim, :dim])) if np.abs(matrix).max() < 1e100 else 0.0
    if not 1e-12 < volume < 1e12:
        raise InvalidInputError(
            f"camera: a determinant of {volume:.3g}; expected one above 0: turned, scaled and "
            "shifted, never mirrored"
        )
    if dim == 3 and not np.allclose(matrix[3], [0.0, 0.0, 0.0, 1.0]):
        raise InvalidInputError(f"camera[3]: {matrix[3].tolist()}; expected [0, 0, 0, 1]")
    return Camera(matrix)


def placed(boxes: FloatArray, camera: Camera | None) -> FloatArray:
    """Return the parts of boxes as the first frame's camera would see them."""
    parts = parts_of(boxes)
    return camera.to_first(parts) if camera else parts
