"""What a folder of segments holds, found without writing there."""

import struct
import zlib
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

from trackweave.errors import InvalidInputError, OutputError
from trackweave.service.disk import Disk
from trackweave.service.segments import (
    HEADER_BYTES,
    SUFFIX,
    DamagedJournalError,
    Record,
    Segment,
    name_of,
    opened,
)

__all__ = [
    "MARK",
    "Whole",
    "firsts_of",
    "mark_of",
    "marked",
    "records_between",
    "stored_records",
    "whole",
]

MARK = "synced"
"""A file that tells a record known to have been on the disk: evidence against a lost tail."""
_SYNCED = struct.Struct("<QI")


def stored_records(folder: Path, disk: Disk | None = None, after: int = 0) -> Iterator[Record]:
    """Yield the records of a folder without writing there, as `Journal.open` would find them.

    Parameters
    ----------
    folder
        Where the journal is; a service may be writing it.
    disk
        Where the folder is.
    after
        Records up to this one are left out.

    Yields
    ------
    The records, in order.

    Raises
    ------
    InvalidInputError
        If there is no journal, or the record that comes next was forgotten.
    DamagedJournalError
        If one is missing or damaged.
    OutputError
        If the folder cannot be read.
    """
    disk = disk or Disk()
    try:
        proven, firsts = marked(folder, disk), firsts_of(folder, disk)
        if not firsts:
            raise InvalidInputError(f"{folder}: no journal; expected the folder of a service")
        if after + 1 < firsts[0]:
            raise InvalidInputError(f"{folder}: records before {firsts[0]} were forgotten")
        path = folder / name_of(firsts[-1])
        found = whole(opened(path, disk.read(path)), proven)
        yield from records_between(folder, disk, firsts, after, found.last)
    except OSError as err:
        raise OutputError(f"{folder}: cannot be read ({err.strerror or err})") from err


def firsts_of(folder: Path, disk: Disk) -> list[int]:
    """Return the first records of a folder's segments, in order."""
    names = [name for name in disk.names(folder) if name.endswith(SUFFIX)]
    return sorted(int(stem) for name in names if (stem := name.removesuffix(SUFFIX)).isdigit())


def mark_of(sequence: int) -> bytes:
    """Return what the mark holds."""
    return _SYNCED.pack(sequence, zlib.crc32(sequence.to_bytes(8, "little")))


def marked(folder: Path, disk: Disk) -> int:
    """Return a record that is known to have been on the disk, 0 for none."""
    try:
        content = disk.read(folder / MARK)
    except FileNotFoundError:
        return 0
    if len(content) != _SYNCED.size:
        return 0
    number, crc = _SYNCED.unpack(content)
    return int(number) if crc == zlib.crc32(content[:8]) else 0


class Whole(NamedTuple):
    """The whole records of the last segment: the last of them, and where they end [bytes].

    Nothing proves that what begins at ``doubtful`` has ever been on the disk: it is seen, but a
    sync of it may have failed, and the system may show what it will never write.
    """

    last: int
    end: int
    doubtful: int


def whole(segment: Segment, marked: int) -> Whole:
    """Return what is whole of the last segment.

    Parameters
    ----------
    segment
        The last segment.
    marked
        A record that is known to have been on the disk.

    Returns
    -------
    What is whole; the last record is the one before the segment if it has none.

    Raises
    ------
    DamagedJournalError
        If that is before what is known to have been on the disk.
    """
    ends, proven = [HEADER_BYTES], marked
    for frame in segment.frames():
        ends.append(frame.end)
        proven = max(proven, frame.proven)
    end, last = ends[-1], segment.first + len(ends) - 2
    if max(marked, segment.proven(end - 1)) > last:
        found = "missing" if end == len(segment.content) else "damaged"
        raise DamagedJournalError(segment.path, end, last + 1, found)
    return Whole(last, end, ends[max(0, proven - segment.first + 1)])


def records_between(
    folder: Path, disk: Disk, firsts: Sequence[int], after: int, last: int
) -> Iterator[Record]:
    """Yield the records after one up to another, all of which have to be there."""
    for place, first in enumerate(firsts):
        until = firsts[place + 1] - 1 if place + 1 < len(firsts) else last
        if until <= after:
            continue
        path = folder / name_of(first)
        segment = opened(path, disk.read(path))
        end, sequence = HEADER_BYTES, first - 1
        for frame in segment.frames():
            if frame.record.sequence > until:
                break
            end, sequence = frame.end, frame.record.sequence
            if sequence > after:
                yield frame.record
        if sequence < until:
            found = "missing" if end == len(segment.content) else "damaged"
            raise DamagedJournalError(path, end, sequence + 1, found)
