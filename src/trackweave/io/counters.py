"""Scan numbers that begin anew, as counters of 8 or 16 bits and radars set up again have them."""

import numpy as np

from trackweave.arrays import IntArray

__all__ = ["unwrapped"]

# Reports of neighbouring scans may be out of order by so many numbers.
ASTRAY = 3


def unwrapped(scan: IntArray) -> tuple[IntArray, int]:
    """Return a sensor's scan numbers, in order of time, that never begin anew, and how often."""
    if scan.size == 0 or np.all(np.maximum.accumulate(scan) - scan <= ASTRAY):
        return scan, 0
    # Of each run of one number, which it counts on from there.
    begins = np.flatnonzero(np.diff(scan, prepend=scan[0] - 1))
    offset, top, before = 0, int(scan[0]), None
    added, count = np.zeros(begins.size, dtype=np.int64), 0
    for run, number in enumerate(scan[begins].tolist()):
        if before is not None and abs(number - before[0]) <= ASTRAY < abs(number - top):
            # A late one of those before the new beginning.
            added[run] = before[1]
            continue
        if number < top - ASTRAY:
            before, count = (top, offset), count + 1
            # Beyond all that may still come late.
            offset, top = offset + top + ASTRAY + 1 - number, number
        added[run], top = offset, max(top, number)
    lengths = np.diff(np.r_[begins, scan.size])
    return scan + np.repeat(added, lengths), count
