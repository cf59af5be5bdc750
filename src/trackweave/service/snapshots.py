"""Snapshots: all that follows from the records up to one, so that a restart need not repeat it.

A file is a header and blocks of the content, in order: of each how long it is stored and whether
it is deflated. Most of a tracker's columns shrink to a tenth; states, which are half of it, hardly
do, so that a sample of each block decides.
"""

import hashlib
import struct
import zlib
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

from trackweave.errors import DataFormatError, OutputError
from trackweave.service.disk import Disk

__all__ = ["KEPT", "Snapshot", "Snapshots"]

KEPT = 2
"""So many are kept: should the newest be unreadable, there is the one before."""
SUFFIX, UNFINISHED = ".snapshot", ".new"
MAGIC, VERSION = b"trackweave snap\n", 2
_HEADER, _BLOCK = struct.Struct("<16sIQQ16s"), struct.Struct("<IB")
BLOCK_BYTES, SAMPLE_BYTES = 2**17, 2**12
_LEVEL, _WORTH = 1, 0.4
"""Blocks are deflated, at this level, whose sample shrinks below such a share."""


class Snapshot(NamedTuple):
    """What follows from all records up to one, as whoever wrote it packed it."""

    sequence: int
    content: bytes


class Snapshots:
    """The snapshots in a folder, beside the journal that they are of and under its lock.

    One is written beside its place, synced, and renamed into place, so that under its name it is
    whole whenever the power fails.
    """

    unreadable: tuple[str, ...] = ()
    """What was wrong with those that `newest` has passed over."""

    def __init__(self, folder: Path, disk: Disk | None = None) -> None:
        self.folder = folder
        self._disk = disk or Disk()
        self._good: list[int] = []

    @property
    def covered(self) -> int:
        """The last record that nobody needs again: of the older of two that are good, else 0."""
        return self._good[-KEPT] if len(self._good) >= KEPT else 0

    def newest(self, first: int, last: int) -> Snapshot | None:
        """Return the newest that can be read and that the journal goes on from.

        Parameters
        ----------
        first, last
            The records that the journal holds.

        Returns
        -------
        The snapshot, None if there is none. What is wrong with newer ones is in ``unreadable``.

        Raises
        ------
        DataFormatError
            If one is of a later record than the journal holds, which has lost records then, or
            none can be read and the journal no longer begins with its first record.
        OutputError
            If the folder cannot be read.
        """
        found: list[Snapshot] = []
        unreadable = []
        try:
            for sequence in reversed(self._sequences()):
                path = self._path(sequence)
                try:
                    snapshot = _decoded(path, self._disk.read(path))
                except DataFormatError as err:
                    unreadable.append(str(err))
                    continue
                _require_reached(path, sequence, last)
                if sequence >= first - 1:
                    found.append(snapshot)
                if len(found) == KEPT:
                    break
        except OSError as err:
            raise OutputError(f"{self.folder}: cannot be read ({err.strerror or err})") from err
        self.unreadable = tuple(unreadable)
        self._good = [snapshot.sequence for snapshot in reversed(found)]
        if not found and first > 1:
            raise DataFormatError(
                f"{self.folder}: the journal begins with record {first}, and no snapshot can be "
                f"read that tells what was before ({'; '.join(unreadable) or 'none is there'})"
            )
        return found[0] if found else None

    def write(self, sequence: int, content: bytes) -> None:
        """Write one, and remove those that are not needed any more.

        Parameters
        ----------
        sequence
            The last record that it follows from; the journal must have synced it.
        content
            What it holds.

        Raises
        ------
        OutputError
            If it cannot be written; those there were are as before then.
        """
        path, disk = self._path(sequence), self._disk
        unfinished = path.with_name(path.name + UNFINISHED)
        try:
            disk.remove(unfinished)
            handle = disk.create(unfinished)
            try:
                disk.write(handle, _encoded(sequence, content), 0)
                disk.sync(handle)
            finally:
                disk.close(handle)
            disk.rename(unfinished, path)
            disk.sync_folder(self.folder)
        except OSError as err:
            with suppress(OSError):
                disk.remove(unfinished)
            raise OutputError(f"{path}: cannot be written ({err.strerror or err})") from err
        self._good = [*(good for good in self._good if good < sequence), sequence][-KEPT:]
        with suppress(OSError):  # another one will see to what is left
            for old in self._sequences():
                if old < self.covered:
                    disk.remove(self._path(old))
            for name in disk.names(self.folder):
                if name.endswith(SUFFIX + UNFINISHED):  # left by a process that was killed
                    disk.remove(self.folder / name)

    def _path(self, sequence: int) -> Path:
        return self.folder / f"{sequence:020d}{SUFFIX}"

    def _sequences(self) -> list[int]:
        names = [name for name in self._disk.names(self.folder) if name.endswith(SUFFIX)]
        return sorted(int(stem) for n in names if (stem := n.removesuffix(SUFFIX)).isdigit())


def _require_reached(path: Path, sequence: int, last: int) -> None:
    if sequence > last:
        raise DataFormatError(
            f"{path}: proves that record {sequence} was stored, and the journal ends with record "
            f"{last}; expected it to reach that: bring the journal back from a copy"
        )


def _digest(sequence: int, stored: bytes) -> bytes:
    number = sequence.to_bytes(8, "little")
    return hashlib.blake2b(stored, digest_size=16, salt=number).digest()


def _encoded(sequence: int, content: bytes) -> bytes:
    stored = b"".join(_blocks(content))
    return _HEADER.pack(MAGIC, VERSION, sequence, len(stored), _digest(sequence, stored)) + stored


def _blocks(content: bytes) -> Iterator[bytes]:
    """Yield what is stored of a content."""
    view = memoryview(content)
    for begin in range(0, len(content), BLOCK_BYTES):
        block = bytes(view[begin : begin + BLOCK_BYTES])
        sample = block[len(block) // 2 :][:SAMPLE_BYTES]
        is_deflated = len(zlib.compress(sample, _LEVEL)) < _WORTH * len(sample)
        stored = zlib.compress(block, _LEVEL) if is_deflated else block
        yield _BLOCK.pack(len(stored), is_deflated)
        yield stored


def _content(stored: bytes) -> Iterator[bytes]:
    """Yield the blocks of a content; what is stored must be whole."""
    view, at = memoryview(stored), 0
    while at < len(stored):
        length, is_deflated = _BLOCK.unpack_from(view, at)
        block = view[at + _BLOCK.size : at + _BLOCK.size + length]
        yield zlib.decompress(block) if is_deflated else bytes(block)
        at += _BLOCK.size + length


def _decoded(path: Path, file: bytes) -> Snapshot:
    """Return what a file holds; refuse one that is foreign, damaged or of another version."""
    if len(file) < _HEADER.size or file[:16] != MAGIC:
        raise DataFormatError(f"{path}: begins with {file[:16]!r}; expected a snapshot")
    _, version, sequence, length, digest = _HEADER.unpack_from(file)
    if version != VERSION:
        raise DataFormatError(f"{path}: a snapshot of version {version}; expected {VERSION}")
    stored = file[_HEADER.size :]
    if len(stored) != length:
        raise DataFormatError(f"{path}: {len(stored)} bytes are stored; expected {length}")
    if _digest(sequence, stored) != digest or path.name != f"{sequence:020d}{SUFFIX}":
        raise DataFormatError(f"{path}: damaged; expected what its digest is of")
    return Snapshot(sequence, b"".join(_content(stored)))
