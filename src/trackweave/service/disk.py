"""The few calls to the file system that journal and snapshots are made of.

They are methods so that tests can put a disk in their place that is full, may only be read, or
loses what was not synced when the power fails.
"""

import fcntl
import os
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

__all__ = ["Disk", "Facts"]

_MODE = 0o600
"""Reports are nobody's business but the service's."""


class Facts(NamedTuple):
    """What the file system says of a file."""

    size: int  # bytes
    modified: float  # seconds since 1970


class Disk:
    """The real file system; files are known by the handles that ``create`` and ``open`` give.

    Every method raises what the system raises, an `OSError`; who calls says what it means.
    """

    def make_folder(self, folder: Path) -> None:
        """Make a folder, if it is not there, so that it is still there after a power cut."""
        if folder.is_dir():
            return
        self.make_folder(folder.parent)
        folder.mkdir(mode=0o700, exist_ok=True)
        self.sync_folder(folder.parent)

    def names(self, folder: Path) -> list[str]:
        """Return the names of a folder's files, sorted."""
        return sorted(entry.name for entry in folder.iterdir() if entry.is_file())

    def facts(self, path: Path) -> Facts:
        """Return size and time of the last change of a file."""
        found = path.stat()
        return Facts(found.st_size, found.st_mtime)

    def read(self, path: Path, most: int | None = None) -> bytes:
        """Return what a file holds, or its first bytes."""
        with path.open("rb") as file:
            return file.read(-1 if most is None else most)

    def create(self, path: Path) -> int:
        """Make an empty file, which must not be there yet, and return a handle to write it."""
        return os.open(path, os.O_CREAT | os.O_EXCL | os.O_WRONLY | os.O_CLOEXEC, _MODE)

    def open(self, path: Path) -> int:
        """Return a handle to write a file that is there."""
        return os.open(path, os.O_WRONLY | os.O_CLOEXEC)

    def write(self, handle: int, content: bytes, offset: int) -> None:
        """Write at a place of a file; on an error any part of it may have been written."""
        rest = memoryview(content)
        while rest:
            done = os.pwrite(handle, rest, offset)
            rest, offset = rest[done:], offset + done

    def sync(self, handle: int) -> None:
        """Return once what was written to a file, and its length, are on the disk."""
        _flushed(handle)

    def truncate(self, handle: int, size: int) -> None:
        """Cut a file off at a size."""
        os.ftruncate(handle, size)

    def close(self, handle: int) -> None:
        """Give a handle back."""
        os.close(handle)

    def rename(self, old: Path, new: Path) -> None:
        """Give a file another name in its folder, in the place of a file of that name."""
        old.replace(new)

    def remove(self, path: Path) -> None:
        """Remove a file; it is no error if there is none."""
        path.unlink(missing_ok=True)

    def sync_folder(self, folder: Path) -> None:
        """Return once the names that a folder's files were given are on the disk."""
        handle = os.open(folder, os.O_RDONLY | os.O_CLOEXEC)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)

    def lock(self, path: Path) -> int:
        """Return a handle whose file is locked until it is closed; raise where another has it."""
        handle = os.open(path, os.O_CREAT | os.O_RDWR | os.O_CLOEXEC, _MODE)
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BaseException:
            os.close(handle)
            raise
        return handle


def _flush() -> Callable[[int], object]:
    """Return the system's call that comes back when data are on the disk itself."""
    full: int | None = getattr(fcntl, "F_FULLFSYNC", None)
    if full is not None:  # macOS: fsync leaves them in the disk's own memory
        return lambda handle: fcntl.fcntl(handle, full)
    return getattr(os, "fdatasync", os.fsync)


_flushed = _flush()
