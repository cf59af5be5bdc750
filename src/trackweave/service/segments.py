"""How records lie in a segment's file, and whether what does not is torn or rotten.

A segment begins with a header: what it is, its version, the sequence of its first record, a salt
and the CRC-32 of all that. Records follow without a gap, each a frame and its payload. A frame is
a mark, the CRC-32 of all that follows it (begun with the salt), the payload's length, the
record's sequence, its place in its batch, from 1, and its kind. Numbers are little-endian.

A *batch* is what one write and one sync brought to the disk. A new batch begins only when the one
before is on the disk, so that a whole record proves that all batches before its own were there:
what is damaged before such a record is rot. A power cut may leave any part of the last batch.
"""

import struct
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from trackweave.errors import DataFormatError

__all__ = [
    "HEADER_BYTES",
    "MOST_PAYLOAD",
    "SUFFIX",
    "DamagedJournalError",
    "Frame",
    "Record",
    "Segment",
    "encoded",
    "header",
    "name_of",
    "opened",
]

MAGIC, VERSION = b"trackweave log\r\n", 1
_HEADER = struct.Struct("<16sIQ8s")
_CRC = struct.Struct("<I")
HEADER_BYTES = _HEADER.size + _CRC.size
_MARK = b"\xd7TWr"
_FRAME = struct.Struct("<4sI")
_CHECKED = struct.Struct("<IQII")
_FRAME_BYTES = _FRAME.size + _CHECKED.size
MOST_PAYLOAD = 2**26
"""A payload is no longer than this [bytes]."""
SUFFIX = ".journal"


class DamagedJournalError(DataFormatError):
    """What was on the disk is there no more; says in which segment, at which byte, which record.

    Parameters
    ----------
    path
        The segment's file.
    offset
        Where the damage begins [bytes].
    sequence
        The record that should be there.
    found
        What is wrong with it.
    """

    def __init__(self, path: Path, offset: int, sequence: int, found: str) -> None:
        super().__init__(
            f"{path}, byte {offset}, record {sequence}: {found}; expected what was stored. "
            "Nothing after it can be trusted: bring the file back from a copy"
        )
        self.path, self.offset, self.sequence = path, offset, sequence


class Record(NamedTuple):
    """Something that happened, under its number."""

    sequence: int
    kind: int
    payload: bytes


class Frame(NamedTuple):
    """A record as it lies in a file: where it ends, and its place in its batch, from 1."""

    record: Record
    end: int
    place: int

    @property
    def proven(self) -> int:
        """The last record that was on the disk before this one was written."""
        return self.record.sequence - self.place


class Segment(NamedTuple):
    """A segment's file, read."""

    path: Path
    first: int
    seed: int
    content: bytes

    def frames(self) -> Iterator[Frame]:
        """Yield the whole records from the first on, up to the end or what is none."""
        offset, sequence = HEADER_BYTES, self.first
        while (frame := self.at(offset)) is not None and frame.record.sequence == sequence:
            yield frame
            offset, sequence = frame.end, sequence + 1

    def at(self, offset: int) -> Frame | None:
        """Return the whole record at a place, None if there is none."""
        content, begin = self.content, offset + _FRAME.size
        if offset + _FRAME_BYTES > len(content):
            return None
        mark, crc = _FRAME.unpack_from(content, offset)
        length, sequence, place, kind = _CHECKED.unpack_from(content, begin)
        end = offset + _FRAME_BYTES + length
        if mark != _MARK or end > len(content):
            return None
        if zlib.crc32(memoryview(content)[begin:end], self.seed) != crc:
            return None
        return Frame(Record(sequence, kind, content[end - length : end]), end, place)

    def proven(self, offset: int) -> int:
        """Return the last record that whole ones beyond a place prove to have been on the disk."""
        proven = 0
        while (offset := self.content.find(_MARK, offset + 1)) >= 0:
            frame = self.at(offset)
            if frame is not None:
                proven = max(proven, frame.proven)
        return proven


def name_of(first: int) -> str:
    """Return the name of the segment that begins with a record: names sort as segments do."""
    return f"{first:020d}{SUFFIX}"


def header(first: int, salt: bytes) -> bytes:
    """Return a segment's first bytes; the salt has eight."""
    content = _HEADER.pack(MAGIC, VERSION, first, salt)
    return content + _CRC.pack(zlib.crc32(content))


def encoded(record: Record, place: int, seed: int) -> bytes:
    """Return a record's bytes, at its place in its batch."""
    sequence, kind, payload = record
    checked = _CHECKED.pack(len(payload), sequence, place, kind)
    crc = zlib.crc32(payload, zlib.crc32(checked, seed))
    return _FRAME.pack(_MARK, crc) + checked + payload


def opened(path: Path, content: bytes) -> Segment:
    """Return a segment of what its file holds, of which the header is enough.

    Parameters
    ----------
    path
        Its file.
    content
        What that holds.

    Returns
    -------
    The segment.

    Raises
    ------
    DataFormatError
        If it is of another version.
    DamagedJournalError
        If it does not begin with the header that its name promises.
    """
    named = int(path.name.removesuffix(SUFFIX))
    if content[:16] != MAGIC or len(content) < HEADER_BYTES:
        raise DamagedJournalError(path, 0, named, f"begins with {content[:16]!r}")
    _, version, first, salt = _HEADER.unpack_from(content)
    (crc,) = _CRC.unpack_from(content, _HEADER.size)
    if version != VERSION:
        raise DataFormatError(f"{path}: a journal of version {version}; expected {VERSION}")
    if crc != zlib.crc32(content[: _HEADER.size]) or first != named:
        raise DamagedJournalError(path, 0, named, "its header is damaged")
    return Segment(path, first, zlib.crc32(salt), content)
