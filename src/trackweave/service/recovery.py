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
    "StoredJournal",
    "Whole",
    "firsts_of",
    "mark_of",
    "marked",
    "records_of",
    "stored_records",
    "whole",
]

MARK = "synced"
"""A file that tells a record known to have been on the disk: evidence against a lost tail."""
_SYNCED = struct.Struct("<QI")


class StoredJournal:
    """The records of a folder, found as `Journal.open` would find them, without writing there.

    A service may be writing it: what it writes later is not seen.

    Parameters
    ----------
    folder
        Where the journal is.
    disk
        Where the folder is; left out, the real file system.

    Raises
    ------
    InvalidInputError
        If there is no journal.
    DamagedJournalError
        If its end is missing or damaged.
    OutputError
        If the folder cannot be read.
    """

    def __init__(self, folder: Path, disk: Disk | None = None) -> None:
        self._folder, self._disk = folder, disk or Disk()
        try:
            proven, self._firsts = marked(folder, self._disk), firsts_of(folder, self._disk)
            if not self._firsts:
                raise InvalidInputError(f"{folder}: no journal; expected the folder of a service")
            path = folder / name_of(self._firsts[-1])
            self.last = whole(opened(path, self._disk.read(path)), proven).last
        except OSError as err:
            raise OutputError(f"{folder}: cannot be read ({err.strerror or err})") from err

    @property
    def first(self) -> int:
        """The first record that is kept; all before were forgotten."""
        return self._firsts[0]

    def records(self, after: int = 0) -> Iterator[Record]:
        """Yield the records that follow one, in order; see `Journal.records`."""
        return records_of(self._folder, self._disk, self._firsts, (after, self.last))


def stored_records(folder: Path, disk: Disk | None = None, after: int = 0) -> Iterator[Record]:
    """Yield the records of a folder that follow one; see `StoredJournal`."""
    yield from StoredJournal(folder, disk).records(after)


def records_of(
    folder: Path, disk: Disk, firsts: Sequence[int], span: tuple[int, int]
) -> Iterator[Record]:
    """Yield the records after one up to another.

    Parameters
    ----------
    folder, disk
        Where the segments are.
    firsts
        The first records of the segments, in order.
    span
        The record that they follow, and the last one.

    Yields
    ------
    The records.

    Raises
    ------
    InvalidInputError
        If the one that comes next was forgotten.
    DamagedJournalError
        If one is missing or damaged.
    OutputError
        If the folder cannot be read.
    """
    if span[0] + 1 < firsts[0]:
        raise InvalidInputError(
            f"{folder}: records after {span[0]}: those before {firsts[0]} were forgotten; "
            f"expected {firsts[0] - 1} or more"
        )
    try:
        yield from _between(folder, disk, firsts, span)
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

    Nothing proves that the ``doubtful`` ones have ever been on the disk: they are seen, but a sync
    of them may have failed, and the system may show what it will never write.
    """

    last: int
    end: int
    doubtful: list[Record]


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
    frames = list(segment.frames())
    end, last, proven = HEADER_BYTES, segment.first - 1, marked
    if frames:
        end, last = frames[-1].end, frames[-1].record.sequence
        proven = max(marked, frames[-1].proven)
    if max(marked, segment.proven(end - 1)) > last:
        found = "missing" if end == len(segment.content) else "damaged"
        raise DamagedJournalError(segment.path, end, last + 1, found)
    return Whole(last, end, [each.record for each in frames if each.record.sequence > proven])


def _between(
    folder: Path, disk: Disk, firsts: Sequence[int], span: tuple[int, int]
) -> Iterator[Record]:
    after, last = span
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
