"""A hidden directory in which files wait until they are whole, and from which moves are undone.

Layout: ``lock`` (held while its process lives), ``new`` (files not yet in place), ``old`` (files
moved aside) and, once files are about to be moved, ``journal.json`` (their names). A change is
complete when the file named as the last has left ``new``; as long as it is there, everything that
was moved can be moved back, by anybody and as often as one likes.
"""

import contextlib
import json
import os
import secrets
import shutil
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

from trackweave.errors import OutputError

try:
    import fcntl
except ImportError:  # Windows: every staging directory then counts as left behind
    _HAS_LOCKS = False
else:
    _HAS_LOCKS = True

__all__ = [
    "STAGING_PREFIX",
    "Staging",
    "clear_all",
    "is_staging",
    "recover",
    "remove_abandoned",
    "translated",
]

STAGING_PREFIX = ".trackweave-staging-"
_JOURNAL = "journal.json"
_ALIVE: "set[Staging]" = set()
"""What this process is writing at the moment."""


class Staging:
    """A staging directory of this process.

    Parameters
    ----------
    folder
        The directory in which it is made; new files end up on the same disk.
    """

    def __init__(self, folder: Path) -> None:
        # Named before it is made, so that an interruption in between leaves nothing behind.
        self.path = folder / f"{STAGING_PREFIX}{secrets.token_hex(8)}"
        self._lock: int | None = None
        self._change: tuple[Path, str] | None = None
        self.parents: list[Path] = []
        """Directories that were made for it, the innermost first."""
        _ALIVE.add(self)
        try:
            self.path.mkdir(mode=0o700)
            self._lock = _take_lock(self.path)
        except BaseException:
            self.remove()
            raise

    def fill(self, contents: Mapping[str, bytes]) -> None:
        """Write the files, each flushed to the disk."""
        new = self.path / "new"
        new.mkdir()
        for name, content in contents.items():
            _write(new / name, content)
        _flush_directory(new)

    def become(self, target: Path) -> None:
        """Let the new files appear as a directory that did not exist."""
        (self.path / "new").rename(target)
        _flush_finished(target.parent)

    def swap(self, target: Path, old: Iterable[str], last: str) -> None:
        """Move old files out of a directory and the new ones in.

        Parameters
        ----------
        target
            The directory.
        old
            Names of the files to move out.
        last
            The new file that is moved last.
        """
        self._change = target, last
        new, aside = self.path / "new", self.path / "old"
        names = {"old": list(old), "new": sorted(entry.name for entry in new.iterdir())}
        aside.mkdir()
        _write(self.path / _JOURNAL, json.dumps(names).encode())
        _flush_directory(self.path)
        for name in names["old"]:
            (target / name).rename(aside / name)
        _flush_directory(aside)
        for name in sorted(names["new"], key=lambda name: name == last):
            if name == last:
                _flush_directory(target)
            (new / name).rename(target / name)
        _flush_finished(target)

    def undo(self, target: Path, last: str) -> None:
        """Move everything back, unless the change is complete, and remove the staging directory.

        Where that fails too, the staging directory stays for the next run to do so.

        Parameters
        ----------
        target
            The directory that was to change.
        last
            The new file that is moved last.
        """
        try:
            _move_back(self.path, target, last)
        except OSError:
            self._release()
            _ALIVE.discard(self)
        else:
            self.remove()

    def remove(self) -> None:
        """Remove the staging directory with all that it holds."""
        self._release()
        shutil.rmtree(self.path, ignore_errors=True)
        _ALIVE.discard(self)

    def clear(self) -> None:
        """Undo a change that has begun and is not complete, and remove the directory."""
        if self._change is not None:
            self.undo(*self._change)
            return
        self.remove()
        for parent in self.parents:
            with contextlib.suppress(OSError):  # others may have used it
                parent.rmdir()

    def _release(self) -> None:
        if self._lock is not None:
            lock, self._lock = self._lock, None
            os.close(lock)


def clear_all() -> None:
    """Undo whatever this process is writing, before a signal ends it."""
    for staging in list(_ALIVE):
        with contextlib.suppress(OSError):
            staging.clear()


def recover(target: Path, last: str) -> bool:
    """Undo what killed processes left unfinished in a directory, and remove their staging.

    Parameters
    ----------
    target
        The directory.
    last
        The new file that is moved last.

    Returns
    -------
    False if a living process is at work there.
    """
    return all(_settle(left, target, last) for left in _stagings(target))


def remove_abandoned(folder: Path) -> None:
    """Remove staging of killed processes for directories that never appeared.

    Parameters
    ----------
    folder
        Where such a directory would have appeared.
    """
    for left in _stagings(folder):
        # One with a journal belongs to a change of the folder itself, which is not ours to undo.
        if not (left / _JOURNAL).exists():
            with contextlib.suppress(OSError):
                _settle(left, folder, last="")


def is_staging(entry: Path) -> bool:
    """Return whether a directory's entry is a staging directory."""
    return entry.name.startswith(STAGING_PREFIX) and entry.is_dir() and not entry.is_symlink()


def _stagings(folder: Path) -> list[Path]:
    return [entry for entry in sorted(folder.iterdir()) if is_staging(entry)]


def _settle(left: Path, target: Path, last: str) -> bool:
    try:
        lock = _take_lock(left)
    except BlockingIOError:
        return False
    try:
        _move_back(left, target, last)
        shutil.rmtree(left)
    finally:
        if lock is not None:
            os.close(lock)
    return True


def _move_back(staging: Path, target: Path, last: str) -> None:
    new, aside = staging / "new", staging / "old"
    try:
        names = json.loads((staging / _JOURNAL).read_bytes())
    except (FileNotFoundError, ValueError):
        return  # a journal is whole before anything moves
    if not (new / last).exists():
        return
    for name in names["new"]:
        in_place = not (new / name).exists() and (target / name).exists()
        if in_place and (name not in names["old"] or (aside / name).exists()):
            (target / name).rename(new / name)
    for name in names["old"]:
        if (aside / name).exists():
            (aside / name).rename(target / name)
    _flush_finished(target)


def _take_lock(staging: Path) -> int | None:
    """Return a descriptor that holds a staging directory's lock, None where locks are unknown."""
    if not _HAS_LOCKS:
        return None
    descriptor = os.open(staging / "lock", os.O_RDWR | os.O_CREAT, 0o600)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        os.close(descriptor)
        raise
    except OSError:  # a file system without locks
        os.close(descriptor)
        return None
    return descriptor


def _write(path: Path, content: bytes) -> None:
    descriptor = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666)
    try:
        view = memoryview(content)
        while view:
            view = view[os.write(descriptor, view) :]
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def _flush_finished(path: Path) -> None:
    # The files are whole and in their place: a complaint now would say that they are not.
    with contextlib.suppress(OSError):
        _flush_directory(path)


def _flush_directory(path: Path) -> None:
    if os.name != "posix":
        return
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


@contextlib.contextmanager
def translated(path: Path) -> Iterator[None]:
    """Turn what the system complains of into an OutputError that names the file and the reason.

    Parameters
    ----------
    path
        What was to be written.

    Raises
    ------
    OutputError
        If it cannot be.
    """
    try:
        yield
    except OutputError:
        raise
    except OSError as err:
        place = err.filename if isinstance(err.filename, str) else str(path)
        if STAGING_PREFIX in place:  # nobody asked for that one
            place = str(path)
        raise OutputError(f"{place}: cannot be written ({err.strerror or err})") from err
    except (RuntimeError, ValueError) as err:  # a loop of links, a NUL in the name
        raise OutputError(f"{str(path)!r}: not a place for files ({err})") from err
