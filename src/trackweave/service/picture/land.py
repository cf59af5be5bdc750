"""Land: Natural Earth's, 1:10 million, simplified, in a file of our own.

For each ring the number of its points, then the steps from point to point in thousandths of a
degree, longitude before latitude, the first from where the ring before it ended. All numbers are
variable-length integers (seven bits a byte, the least first), steps zigzag (0, -1, 1, -2, …).
"""

from functools import cache
from importlib.resources import files

import numpy as np

from trackweave.arrays import FloatArray, IntArray

__all__ = ["encode_land", "land_around", "whole_land"]

STEPS_PER_DEGREE = 1000
COARSE_DEG = 0.2
LEAST_FAR_DEG = 0.6
"""Islands smaller than this are left out where nobody looks closely."""


@cache
def whole_land() -> bytes:
    """Return the file of all land."""
    return (files("trackweave.service") / "page" / "coast.bin").read_bytes()


def encode_land(rings: list[FloatArray]) -> bytes:
    """Return a file of rings.

    Parameters
    ----------
    rings
        Longitudes and latitudes [degrees], each ring of shape (points, 2).

    Returns
    -------
    The file.

    Examples
    --------
    >>> import numpy as np
    >>> list(encode_land([np.array([[0.0, 0.0], [0.001, 0.0], [0.0, 0.002]])]))
    [3, 0, 0, 2, 0, 1, 4]
    """
    written = bytearray()
    before = np.zeros((1, 2), dtype=np.int64)
    for ring in rings:
        places = np.round(np.asarray(ring) * STEPS_PER_DEGREE).astype(np.int64)
        steps = np.diff(np.concatenate([before, places]), axis=0).ravel()
        before = places[-1:]
        for number in (len(places), *((steps << 1) ^ (steps >> 63)).tolist()):
            rest = number
            while rest > 127:
                written.append(rest & 127 | 128)
                rest >>= 7
            written.append(rest)
    return bytes(written)


def land_around(west: float, south: float, east: float, north: float) -> bytes:
    """Return the file of land that is fine inside a box [degrees] and coarse elsewhere."""
    kept = []
    for ring in _rings():
        x, y = ring.T
        # The Earth goes round: a box may lie a turn further on.
        turned = x + 360.0 * np.round(((west + east) / 2 - x) / 360.0)
        inside = (turned >= west) & (turned <= east) & (y >= south) & (y <= north)
        # Neighbours of what is inside stay too, so that the border is crossed aright.
        near = inside | np.roll(inside, 1) | np.roll(inside, -1)
        if not near.any() and max(np.ptp(x), np.ptp(y)) < LEAST_FAR_DEG:
            continue
        cell = np.floor(ring / COARSE_DEG)
        moved = np.any(np.diff(cell, axis=0, prepend=cell[:1] - 1) != 0, axis=1)
        places = ring[near | moved]
        if len(places) > 2:
            kept.append(places)
    return encode_land(kept)


@cache
def _rings() -> list[FloatArray]:
    numbers = _numbers(np.frombuffer(whole_land(), dtype=np.uint8))
    rings, at = [], 0
    before = np.zeros(2, dtype=np.int64)
    while at < numbers.size:
        n = int(numbers[at])
        zigzag = numbers[at + 1 : at + 1 + 2 * n].reshape(n, 2)
        places = before + np.cumsum((zigzag >> 1) ^ -(zigzag & 1), axis=0)
        before = places[-1]
        rings.append(places / STEPS_PER_DEGREE)
        at += 1 + 2 * n
    return rings


def _numbers(raw: np.ndarray) -> IntArray:
    """Return the variable-length integers of bytes."""
    ends = np.flatnonzero(raw < 128)
    begins = np.concatenate([[0], ends[:-1] + 1])
    values = np.zeros(ends.size, dtype=np.int64)
    for byte in range(int((ends - begins).max()) + 1):
        at = begins + byte
        within = at <= ends
        values[within] |= (raw[at[within]] & 127).astype(np.int64) << (7 * byte)
    return values
