"""The journal: what came in and what was decided, on the disk before it is acted on."""

import secrets
import threading
import zlib
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Self

from trackweave.errors import InvalidInputError, OutputError
from trackweave.service.disk import Disk
from trackweave.service.recovery import MARK, firsts_of, mark_of, marked, records_of, whole
from trackweave.service.segments import (
    MOST_PAYLOAD,
    SUFFIX,
    DamagedJournalError,
    Record,
    encoded,
    header,
    name_of,
    opened,
)

__all__ = ["Cut", "Journal", "Retention"]

SEGMENT_BYTES = 2**25
"""A segment that has reached this is the last no more."""
MOST_WAITING = 2**26
"""So many bytes wait for the disk; beyond, nothing is taken in."""
LOCK, UNFINISHED = "lock", ".new"


@dataclass(frozen=True, slots=True)
class Cut:
    """What a write that never came to its end had left, and recovery cut off."""

    path: Path
    offset: int
    n_bytes: int
    after: int
    """The last record that is whole."""


@dataclass(frozen=True, slots=True)
class Retention:
    """How much is kept of what a snapshot covers: None for no limit."""

    most_bytes: int | None = None
    most_seconds: float | None = None


class Journal:
    """Records by number, from 1, in segments of a folder that one process writes.

    ``append`` gives a record its number; it is on the disk when ``sync`` has returned that number
    or a higher one, and only then. All that waits goes to the disk by one write and one sync.
    ``append`` may be called while another thread is in ``sync``. What could not be written waits
    on, and the next ``sync`` tries again; the file holds nothing of it meanwhile.

    *On the disk* means that the system's ``fdatasync`` (on macOS ``F_FULLFSYNC``) said so. A disk
    that says so and does not do it loses acknowledged records when the power fails, and nothing
    above it can help.
    """

    cut: Cut | None = None
    """What was cut off when the journal was opened."""

    def __init__(self, folder: Path, disk: Disk, segment_bytes: int) -> None:
        self.folder = folder
        self._disk, self._segment_bytes = disk, segment_bytes
        self._firsts: list[int] = []
        self._handle = self._mark = self._lock = -1
        self._size = self._seed = 0
        self._last = self._synced = 0
        self._waiting: list[Record] = []
        self._n_waiting = 0
        self._lost = ""
        self._appending, self._syncing = threading.Lock(), threading.Lock()

    @classmethod
    def open(
        cls, folder: Path, disk: Disk | None = None, *, segment_bytes: int = SEGMENT_BYTES
    ) -> Self:
        """Return the journal of a folder, which is made if it is not there.

        A last write that never came to its end is cut off, and told in ``cut``. What is read then
        is on the disk, and ``last`` and ``synced`` are its last record.

        Parameters
        ----------
        folder
            Where its files are.
        disk
            Where the folder is; left out, the real file system.
        segment_bytes
            A segment that has reached this size is the last no more.

        Returns
        -------
        The journal; give it back by `close`.

        Raises
        ------
        DamagedJournalError
            If something is missing or damaged that was on the disk.
        OutputError
            If another process has the folder, or it cannot be written.
        """
        disk = disk or Disk()
        journal = cls(folder, disk, segment_bytes)
        try:
            disk.make_folder(folder)
            journal._lock = disk.lock(folder / LOCK)
        except BlockingIOError as err:
            raise OutputError(f"{folder}: another service writes here; expected none") from err
        except OSError as err:
            raise OutputError(_refused(folder, err)) from err
        try:
            journal._recover()
        except OSError as err:
            journal._release()
            raise OutputError(_refused(folder, err)) from err
        except BaseException:
            journal._release()
            raise
        return journal

    @property
    def first(self) -> int:
        """The first record that is kept; all before were forgotten."""
        return self._firsts[0]

    @property
    def last(self) -> int:
        """The last record, 0 before the first; it may be on its way to the disk."""
        return self._last

    @property
    def synced(self) -> int:
        """The last record that is on the disk."""
        return self._synced

    def append(self, kind: int, payload: bytes) -> int:
        """Take a record in and return its number; `sync` brings it to the disk.

        Parameters
        ----------
        kind
            What the payload is of: from 0 to 2³² − 1.
        payload
            At most 2²⁶ bytes.

        Returns
        -------
        Its number.

        Raises
        ------
        InvalidInputError
            If it is too long, or its kind no such number.
        OutputError
            If 2²⁶ bytes wait for a disk that takes none, or the journal is closed.
        """
        if len(payload) > MOST_PAYLOAD or not 0 <= kind < 2**32:
            raise InvalidInputError(
                f"record of kind {kind}, {len(payload)} bytes; expected a kind from 0 to 2³² − 1 "
                f"and at most {MOST_PAYLOAD} bytes"
            )
        with self._appending:
            self._require_usable()
            if self._n_waiting and self._n_waiting + len(payload) > MOST_WAITING:
                raise OutputError(f"{self.folder}: {self._n_waiting} bytes wait for the disk")
            self._last += 1
            self._waiting.append(Record(self._last, kind, bytes(payload)))
            self._n_waiting += len(payload)
            return self._last

    def sync(self) -> int:
        """Bring to the disk what waits, all of it or nothing.

        Returns
        -------
        The last record on the disk.

        Raises
        ------
        OutputError
            If it cannot be written: what waits goes on waiting, and is not on the disk.
        """
        with self._syncing:
            with self._appending:
                self._require_usable()
                batch, self._waiting = self._waiting, []
            if not batch:
                return self._synced
            try:
                self._write(batch)
            except BaseException as err:
                with self._appending:
                    # An interrupt may come when all is done.
                    left = [record for record in batch if record.sequence > self._synced]
                    self._waiting = left + self._waiting
                if isinstance(err, OSError):
                    raise OutputError(_refused(self.folder, err)) from err
                raise
            with self._appending:
                self._n_waiting = sum(len(record.payload) for record in self._waiting)
            self._note_synced()
            return self._synced

    def records(self, after: int = 0) -> Iterator[Record]:
        """Return the records on the disk that follow one, in order.

        Parameters
        ----------
        after
            The one that they follow; 0 for all.

        Returns
        -------
        The records, each read when it is asked for. What is missing, damaged or forgotten is an
        error then, as `records_of` says.
        """
        return records_of(self.folder, self._disk, list(self._firsts), (after, self._synced))

    def forget(self, covered: int, retention: Retention | None = None, now: float = 0.0) -> int:
        """Remove whole segments that are not needed any more.

        Parameters
        ----------
        covered
            A snapshot holds what follows from all records up to this one; later ones stay.
        retention
            Only as much is removed as it wants; left out, all that is covered.
        now
            When that is [s since 1970].

        Returns
        -------
        The first record kept.

        Raises
        ------
        OutputError
            If a file cannot be removed.
        """
        with self._syncing:
            self._require_usable()
            try:
                while len(self._firsts) > 1 and self._firsts[1] <= covered + 1:
                    if retention is not None and not self._exceeds(retention, now):
                        break
                    self._disk.remove(self._path(self._firsts[0]))
                    # The next name goes only when this one is gone for good: never a gap.
                    self._disk.sync_folder(self.folder)
                    del self._firsts[0]
            except OSError as err:
                raise OutputError(_refused(self.folder, err)) from err
            return self.first

    def close(self) -> None:
        """Bring to the disk what waits, and let others have the folder, whatever comes of it."""
        try:
            if not self._lost:
                self.sync()
                with suppress(OSError):
                    self._disk.sync(self._mark)
        finally:
            self._release()

    def _path(self, first: int) -> Path:
        return self.folder / name_of(first)

    def _require_usable(self) -> None:
        if self._lost:
            raise OutputError(f"{self.folder}: {self._lost}; expected it to be opened again")

    def _exceeds(self, retention: Retention, now: float) -> bool:
        """Tell whether the oldest segment is more than is wanted."""
        facts = [self._disk.facts(self._path(first)) for first in self._firsts]
        bytes_, seconds = retention.most_bytes, retention.most_seconds
        is_large = bytes_ is not None and sum(fact.size for fact in facts) > bytes_
        # Its last record came when it was last written.
        return is_large or (seconds is not None and now - facts[0].modified > seconds)

    def _recover(self) -> None:
        """Find the segments, cut a torn tail off and begin to write behind it."""
        disk, folder = self._disk, self.folder
        for name in disk.names(folder):
            if name.endswith(SUFFIX + UNFINISHED):
                disk.remove(folder / name)
        # A process that was killed may have given a file its name, and not synced that.
        disk.sync_folder(folder)
        self._firsts, proven = firsts_of(folder, disk), marked(folder, disk)
        if self._firsts:
            self._go_on(proven)
        else:
            if proven:
                raise DamagedJournalError(self._path(1), 0, 1, "missing")
            self._begin_segment(1)
        exists = MARK in disk.names(folder)
        self._mark = disk.open(folder / MARK) if exists else disk.create(folder / MARK)
        self._note_synced()

    def _go_on(self, proven: int) -> None:
        """Go on where the last segment's whole records end."""
        path = self._path(self._firsts[-1])
        segment = opened(path, self._disk.read(path))
        found = whole(segment, proven)
        end, content = found.end, segment.content
        self._handle, self._size, self._seed = self._disk.open(path), end, segment.seed
        if end < len(content):
            self.cut = Cut(path, end, len(content) - end, found.last)
            self._disk.truncate(self._handle, end)
        self._disk.sync(self._handle)
        # What a process before this one may not have synced is written once more: where its sync
        # has failed, another one alone would store nothing and say that all is well. It goes to
        # another place, since it may as well be stored and acknowledged.
        if found.doubtful:
            self._begin_segment(found.doubtful[0].sequence, found.doubtful)
        self._last = self._synced = found.last

    def _write(self, batch: list[Record]) -> None:
        if self._size >= self._segment_bytes:
            self._begin_segment(batch[0].sequence)
        content = _batch(batch, self._seed)
        try:
            self._disk.write(self._handle, content, self._size)
            self._disk.sync(self._handle)
        except BaseException:
            # After a failed sync nobody knows which pages will ever be written: they are thrown
            # away and written anew, not synced again.
            try:
                self._disk.truncate(self._handle, self._size)
            except OSError as err:
                self._lost = f"a write failed and cannot be undone ({err.strerror or err})"
            raise
        self._size, self._synced = self._size + len(content), batch[-1].sequence

    def _begin_segment(self, first: int, records: Sequence[Record] = ()) -> None:
        """Make a segment of a few records; under its name it is whole, whenever the power fails.

        Those that an older segment holds as well are read of the new one from then on.
        """
        disk, path, salt = self._disk, self._path(first), secrets.token_bytes(8)
        content = header(first, salt) + _batch(records, zlib.crc32(salt))
        unfinished = path.with_name(path.name + UNFINISHED)
        disk.remove(unfinished)
        handle = disk.create(unfinished)
        try:
            disk.write(handle, content, 0)
            disk.sync(handle)
            disk.rename(unfinished, path)
            disk.sync_folder(self.folder)
        except BaseException:
            disk.close(handle)
            with suppress(OSError):
                disk.remove(unfinished)
                if first not in self._firsts:
                    disk.remove(path)
            raise
        if self._handle >= 0:
            disk.close(self._handle)
        self._handle, self._size, self._seed = handle, len(content), zlib.crc32(salt)
        if first not in self._firsts:
            self._firsts.append(first)

    def _note_synced(self) -> None:
        """Note what is on the disk, as evidence against a lost tail; this need not be synced."""
        with suppress(OSError):  # without it no more is lost than the evidence
            self._disk.write(self._mark, mark_of(self._synced), 0)

    def _release(self) -> None:
        self._lost = self._lost or "closed"
        for handle in (self._handle, self._mark, self._lock):
            if handle >= 0:
                self._disk.close(handle)
        self._handle = self._mark = self._lock = -1


def _batch(records: Sequence[Record], seed: int) -> bytes:
    return b"".join(encoded(record, place, seed) for place, record in enumerate(records, start=1))


def _refused(folder: Path, err: OSError) -> str:
    return f"{folder}: cannot be written ({err.strerror or err})"
