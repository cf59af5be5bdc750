"""Disks that are full, may only be read, fail, or lose what was not synced."""

import errno
import os
from collections import defaultdict
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from trackweave.service.disk import Disk, Facts

SECTOR = 512


class Change(NamedTuple):
    """What was done to a file and not synced: bytes from a place on, or None to cut it there."""

    offset: int
    content: bytes | None


class File:
    """A file as programs see it, and as it is on the platter."""

    def __init__(self, content: bytes = b"") -> None:
        self.seen, self.stored = bytearray(content), bytearray(content)
        self.pending: list[Change] = []


def changed(content: bytearray, change: Change) -> None:
    """Do to a content what was done to a file."""
    offset, new = change
    if new is None:
        del content[offset:]
        content.extend(bytes(offset - len(content)))
    else:
        content.extend(bytes(max(0, offset - len(content))))
        content[offset : offset + len(new)] = new


class LossyDisk(Disk):
    """A disk in memory, of one folder level.

    What is written is seen at once, and stored when it is synced: a file by ``sync``, names by
    ``sync_folder``. ``power_cut`` leaves any part of the rest. A ``sync`` that fails forgets what
    it was to store, as systems do, so that a second one succeeds and stores nothing of it.
    """

    def __init__(self) -> None:
        self.names_seen: dict[Path, File] = {}
        self.names_stored: dict[Path, File] = {}
        self.renamings: list[tuple[str, Path, Path | None, File | None]] = []
        self.handles: dict[int, File] = {}
        self.locked: set[Path] = set()
        self.locks: dict[int, Path] = {}
        self.next_handle = 3
        self.space: int | None = None
        self.is_read_only = False
        self.failing: dict[str, int] = defaultdict(int)
        """How often each method fails from now on."""

    def _check(self, method: str, *, writes: bool = True) -> None:
        if self.is_read_only and writes:
            raise OSError(errno.EROFS, os.strerror(errno.EROFS))
        if self.failing[method] > 0:
            self.failing[method] -= 1
            raise OSError(errno.EIO, os.strerror(errno.EIO))

    def _handle(self, file: File) -> int:
        self.next_handle += 1
        self.handles[self.next_handle] = file
        return self.next_handle

    def make_folder(self, folder: Path) -> None:
        self._check("make_folder", writes=False)

    def names(self, folder: Path) -> list[str]:
        return sorted(path.name for path in self.names_seen if path.parent == folder)

    def _file(self, path: Path) -> File:
        if path not in self.names_seen:
            raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT), str(path))
        return self.names_seen[path]

    def facts(self, path: Path) -> Facts:
        return Facts(len(self._file(path).seen), 0.0)

    def read(self, path: Path, most: int | None = None) -> bytes:
        self._check("read", writes=False)
        return bytes(self._file(path).seen[:most])

    def create(self, path: Path) -> int:
        self._check("create")
        if path in self.names_seen:
            raise FileExistsError(errno.EEXIST, os.strerror(errno.EEXIST), str(path))
        if self.space is not None and self.space <= 0:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        file = self.names_seen[path] = File()
        self.renamings.append(("name", path, None, file))
        return self._handle(file)

    def open(self, path: Path) -> int:
        self._check("open")
        return self._handle(self._file(path))

    def write(self, handle: int, content: bytes, offset: int) -> None:
        self._check("write")
        file, content = self.handles[handle], bytes(content)
        more = max(0, offset + len(content) - len(file.seen))
        if self.space is not None:
            if more > self.space:
                part = content[: max(0, len(content) - more + self.space)]
                self._put(file, Change(offset, part))
                self.space = 0
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
            self.space -= more
        self._put(file, Change(offset, content))

    def _put(self, file: File, change: Change) -> None:
        changed(file.seen, change)
        file.pending.append(change)

    def sync(self, handle: int) -> None:
        file = self.handles[handle]
        try:
            self._check("sync", writes=False)
        except OSError:
            file.pending = [each for each in file.pending if each.content is None]
            raise
        for change in file.pending:
            changed(file.stored, change)
        file.pending = []

    def truncate(self, handle: int, size: int) -> None:
        self._check("truncate")
        file = self.handles[handle]
        if self.space is not None:
            self.space += len(file.seen) - size
        self._put(file, Change(size, None))

    def close(self, handle: int) -> None:
        self.locked.discard(self.locks.pop(handle, Path()))
        self.handles.pop(handle, None)

    def rename(self, old: Path, new: Path) -> None:
        self._check("rename")
        self.names_seen[new] = self._file(old)
        del self.names_seen[old]
        self.renamings.append(("rename", old, new, None))

    def remove(self, path: Path) -> None:
        self._check("remove")
        if path in self.names_seen:
            del self.names_seen[path]
            self.renamings.append(("remove", path, None, None))

    def sync_folder(self, folder: Path) -> None:
        self._check("sync_folder", writes=False)
        self._store_names(len(self.renamings))

    def lock(self, path: Path) -> int:
        self._check("lock")
        if path in self.locked:
            raise BlockingIOError(errno.EAGAIN, os.strerror(errno.EAGAIN))
        if path not in self.names_seen:
            self.names_seen[path] = self.names_stored[path] = File()
        self.locked.add(path)
        handle = self._handle(self.names_seen[path])
        self.locks[handle] = path
        return handle

    def killed(self) -> None:
        """End the process that writes: its handles and locks are gone, and nothing else."""
        self.handles, self.locks, self.locked = {}, {}, set()

    def lose_all(self, *, spoils: bool = False) -> None:
        """End everything; nothing of what was not synced is stored, or rubbish in its place."""
        self.killed()
        self.renamings = []
        for file in self.names_stored.values():
            for change in file.pending if spoils else ():
                if change.content is not None:
                    changed(file.stored, Change(change.offset, b"\xa5" * len(change.content)))
            file.pending, file.seen = [], bytearray(file.stored)
        self.names_seen = dict(self.names_stored)

    def power_cut(self, rng: np.random.Generator) -> None:
        """End everything; what was not synced is stored in part, and in any order."""
        self.killed()
        # Names go through the file system's own journal: the first so many changes.
        self._store_names(int(rng.integers(len(self.renamings) + 1)))
        self.renamings = []
        for file in dict.fromkeys(self.names_stored.values()):
            for change in file.pending:
                if change.content is None:
                    if rng.random() < 0.5:
                        changed(file.stored, change)
                else:
                    _store_sectors(file.stored, change.offset, change.content, rng)
            file.pending, file.seen = [], bytearray(file.stored)
        self.names_seen = dict(self.names_stored)

    def _store_names(self, count: int) -> None:
        for what, path, new, file in self.renamings[:count]:
            if what == "name":
                assert file is not None
                self.names_stored[path] = file
            else:
                moved = self.names_stored.pop(path, None)
                if new is not None and moved is not None:
                    self.names_stored[new] = moved
        del self.renamings[:count]


def _store_sectors(
    stored: bytearray, offset: int, content: bytes, rng: np.random.Generator
) -> None:
    """Store any sectors of what was written; of the last one perhaps a part, or rubbish."""
    end = int(rng.integers(offset, offset + len(content) + 1))
    for begin in range(offset - offset % SECTOR, end, SECTOR):
        first, last = max(begin, offset), min(begin + SECTOR, end)
        fate = rng.random()
        if fate < 0.7:
            part: Any = content[first - offset : last - offset]
            if fate < 0.05:
                part = rng.bytes(last - first)
            changed(stored, Change(first, part))
        elif last > len(stored):
            changed(stored, Change(last, None))
