"""Cell Tracking Challenge: a folder of label images, and ``res_track.txt`` (label, begin, end, parent).

Labels are painted as discs about the tracks' positions, which are pixels. A label of the challenge
is in every frame from its begin to its end: a track with a gap goes on as its own child, and so
does one that goes on after a division. A track that came of another is the child of that one's
last label before it.
"""  # noqa: E501

import struct
from pathlib import Path

import numpy as np
import polars as pl

from trackweave.arrays import FloatArray, IntArray
from trackweave.errors import DataFormatError, InvalidInputError
from trackweave.formats.format import Facts, Format, Output
from trackweave.formats.track_rows import branches, framed_rows

__all__ = ["FORMAT"]

_RADIUS = 5
_MOST_LABELS, _MOST_PIXELS = 65_535, 1 << 28
_IMAGES = ("mask*.tif", "man_track*.tif")
_TABLES = ("res_track.txt", "man_track.txt")


def _write(output: Output) -> dict[str, bytes]:
    rows = framed_rows(output, "ctc")
    pieces = _pieces(rows)
    if len(pieces) > _MOST_LABELS:
        raise InvalidInputError(f"format ctc: {len(pieces)} labels; expected at most 65,535")
    place = rows.select("x", "y").to_numpy().astype(np.float64)
    if (place.round() < 0).any():
        raise InvalidInputError("format ctc: positions below 0; expected pixels of an image")
    most = place.max(axis=0).round().astype(np.int64) if len(rows) else np.full(2, -_RADIUS)
    width, height = (most + _RADIUS + 1).tolist()
    frame, label = rows["frame"].to_numpy(), np.zeros(len(rows), np.int64)
    n_frames = int(frame.max()) + 1 if len(rows) else 0
    if width * height * max(n_frames, 1) > _MOST_PIXELS:
        raise InvalidInputError(f"format ctc: {n_frames} images of {width} by {height}: too large")
    lines = []
    for number, (begin, end, parent) in enumerate(pieces, start=1):
        label[begin : end + 1] = number
        lines.append(f"{number} {frame[begin]} {frame[end]} {parent}\n")
    files = {"tracks.ctc/res_track.txt": "".join(lines).encode("ascii")}
    for number in range(n_frames):
        here = frame == number
        image = _painted(place[here], label[here], (width, height))
        files[f"tracks.ctc/mask{number:03d}.tif"] = _tiff(image)
    return files


def _pieces(rows: pl.DataFrame) -> list[tuple[int, int, int]]:
    """Return first and last row of each label, and its parent's label, 0 for none."""
    track, frame = rows["track"].to_numpy(), rows["frame"].to_numpy()
    if len(rows) == 0:
        return []
    after = branches(rows)
    is_end = (np.diff(track) != 0) | (np.diff(frame) > 1)
    is_end[[row for row in after.values() if row < len(rows) - 1]] = True
    ends = [*np.flatnonzero(is_end).tolist(), len(rows) - 1]
    label = {end: number for number, end in enumerate(ends, start=1)}
    pieces = []
    for begin, end in zip([0, *(end + 1 for end in ends[:-1])], ends, strict=True):
        own = int(track[begin])
        is_first = begin == 0 or track[begin - 1] != own
        mother = after.get(own, -1) if is_first else begin - 1
        pieces.append((begin, end, label.get(mother, 0)))
    return pieces


def _painted(place: FloatArray, label: IntArray, size: tuple[int, int]) -> np.ndarray:
    """Return an image in which each label is a disc, and what two could have is the nearer's."""
    image = np.zeros((size[1], size[0]), np.uint16)
    nearest = np.full(image.shape, np.inf)
    for (x, y), number in zip(place, label, strict=True):
        rows, columns, distance = _disc(x, y, _RADIUS, size)
        nearer = distance < nearest[rows, columns]
        rows, columns = rows[nearer], columns[nearer]
        image[rows, columns] = number
        nearest[rows, columns] = distance[nearer]
    _drop_crumbs(image, place, label)
    _give_pixels(image, place, label)
    return image


def _drop_crumbs(image: np.ndarray, place: FloatArray, label: IntArray) -> None:
    """Take from labels what others cut off from their middles."""
    for (x, y), number in zip(place, label, strict=True):
        rows, columns, distance = _disc(x, y, _RADIUS, (image.shape[1], image.shape[0]))
        own = image[rows, columns] == number
        if own.all() or not own.any():
            continue
        from scipy.ndimage import label as numbered

        rows, columns = rows[own], columns[own]
        patch = np.zeros((np.ptp(rows) + 1, np.ptp(columns) + 1), np.bool_)
        patch[rows - rows.min(), columns - columns.min()] = True
        part = numbered(patch)[0][rows - rows.min(), columns - columns.min()]
        crumbs = part != part[np.argmin(distance[own])]
        image[rows[crumbs], columns[crumbs]] = 0


def _give_pixels(image: np.ndarray, place: FloatArray, label: IntArray) -> None:
    """Give a pixel to each label that has none, as where two tracks are one report.

    The challenge's own readers refuse a frame in which a track of that time has no pixel.
    """
    height, width = image.shape
    count = np.bincount(image.ravel(), minlength=int(label.max(initial=0)) + 1)
    for (x, y), number in zip(place, label, strict=True):
        radius = _RADIUS
        while count[number] == 0 and radius < 2 * max(width, height):
            rows, columns, distance = _disc(x, y, radius, (width, height))
            owner = image[rows, columns]
            free = np.flatnonzero((owner == 0) | (count[owner] > 1))
            if free.size:
                at = free[np.argmin(distance[free])]
                count[owner[at]] -= 1
                count[number] += 1
                image[rows[at], columns[at]] = number
            radius *= 2


def _disc(
    x: float, y: float, radius: int, size: tuple[int, int]
) -> tuple[IntArray, IntArray, FloatArray]:
    """Return rows and columns of the pixels about a place, and their squared distances from it."""
    down, right = np.mgrid[-radius : radius + 1, -radius : radius + 1]
    inside = down**2 + right**2 <= radius**2
    rows, columns = round(y) + down[inside], round(x) + right[inside]
    seen = (rows >= 0) & (columns >= 0) & (rows < size[1]) & (columns < size[0])
    rows, columns = rows[seen], columns[seen]
    return rows, columns, (rows - y) ** 2 + (columns - x) ** 2


def _tiff(image: np.ndarray) -> bytes:
    """Return an image of 16 bits as a TIFF file without compression."""
    height, width = image.shape
    data = image.astype("<u2").tobytes()
    tags = (
        (256, 4, width), (257, 4, height), (258, 3, 16), (259, 3, 1), (262, 3, 1), (273, 4, 8),
        (277, 3, 1), (278, 4, height), (279, 4, len(data)),
    )  # fmt: skip
    entries = b"".join(struct.pack("<HHII", tag, kind, 1, value) for tag, kind, value in tags)
    head = struct.pack("<2sHI", b"II", 42, 8 + len(data))
    return head + data + struct.pack("<H", len(tags)) + entries + bytes(4)


def _read(folder: Path) -> tuple[pl.DataFrame, Facts]:
    try:
        from tifffile import imread
    except ImportError as err:
        raise InvalidInputError(
            "format ctc: reading images needs tifffile; pip install 'trackweave[ctc]'"
        ) from err
    images = sorted(path for pattern in _IMAGES for path in folder.glob(pattern))
    if not images:
        raise DataFormatError(f"{folder}: no {' and no '.join(_IMAGES)}; expected label images")
    frames = []
    for number, path in enumerate(images):
        try:
            image = np.squeeze(np.asarray(imread(path)))
        except Exception as err:  # of damaged images it raises whatever its parts do
            told = f"{type(err).__name__}: {err}"
            raise DataFormatError(f"{path}: no label image ({told:.120})") from err
        if image.ndim not in (2, 3) or not np.issubdtype(image.dtype, np.integer):
            raise DataFormatError(f"{path}: {image.dtype} {image.shape}; expected whole numbers")
        frames.append(_middles(image, number))
    facts = Facts(notes=["ctc: frames are taken for seconds and pixels for metres"])
    return pl.concat(frames), facts


def _middles(image: np.ndarray, number: int) -> pl.DataFrame:
    """Return the middle of each label's pixels, and how many there are."""
    where = np.nonzero(image)
    labels, index, count = np.unique(image[where], return_inverse=True, return_counts=True)
    middle = [np.bincount(index.ravel(), axis) / np.maximum(count, 1) for axis in where[::-1]]
    return pl.DataFrame(
        {
            "time": np.full(len(labels), float(number)),
            **dict(zip("xyz", middle, strict=False)),
            "pixels": count.astype(np.int64),
            "frame": np.full(len(labels), number),
            "target": labels.astype(np.int64),
        }
    )


def _recognise(head: bytes, name: str) -> bool:
    folder = Path(name)
    if head or not folder.is_dir():
        return False
    has_table = any((folder / table).is_file() for table in _TABLES)
    return has_table or next(folder.glob(_IMAGES[0]), None) is not None


FORMAT = Format(
    name="ctc",
    title="Cell Tracking Challenge folder",
    endings=(".ctc",),
    carries="positions in pixels by frame, labels as target; lineage is written",
    loses="shapes of cells (discs are painted), uncertainty",
    recognise=_recognise,
    folder=_read,
    writer=_write,
    extra="ctc",
)
