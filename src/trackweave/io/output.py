"""Files appear whole or not at all.

Files are written to a hidden directory beside their place first, each flushed to the disk, and
then renamed into place, which takes no space: a new directory by one rename, the files of one
that exists one after the other, the record of the run last. Signals wait until that is done.
"""

import contextlib
import json
import os
import re
import shutil
import signal
import tempfile
import threading
import time
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from trackweave.errors import InvalidInputError, OutputError
from trackweave.io.encoding import encode_json

__all__ = ["FILES", "RECORD", "OutputDirectory", "OutputFile", "write_folder"]

RECORD = "run.json"
STAGING_PREFIX = ".trackweave-staging-"
ABANDONED_S = 3600.0
"""Nobody writes for so long: what is older was left by a killed run."""
# What each command writes besides the record. No other file is ever replaced or removed,
# but for the picture of a run.
_SIMULATED = frozenset({"reports.csv", "truth.csv"})
_TRACKED = frozenset({"tracks.csv", "assignments.csv", "history.csv"})
FILES = {
    "simulate": _SIMULATED,
    "track": _TRACKED,
    "demo": _SIMULATED | _TRACKED | {"tracker.toml", "demo.png"},
    "fuse": frozenset({"associations.csv", "tracks.csv"}),
    "reproduce": frozenset({"report.md"}),
    "study": frozenset({"report.md", "runs.jsonl", "runs.parquet"}),
    "tune": frozenset({"report.md", "runs.jsonl", "trials.csv", "tuned.toml"}),
}
# What `plot` draws of them, which tells of another run once they are replaced.
DRAWN = {"track": "plot.png", "demo": "plot.png"}
# Further formats of tracks; some are folders of files.
_OF_FORMAT = re.compile(r"tracks[a-z0-9.-]+(/(?!\.\.?(/|$))[A-Za-z0-9_.-]+)*")
# A study's figures and their numbers, beside its report: it alone knows which there are.
_OF_STUDY = re.compile(r"[a-z0-9-]+\.(csv|png)")


class OutputDirectory:
    """A directory for the files of one run: new, empty, or that of the command's earlier run.

    A directory is ours when its run.json is an object with the key ``trackweave``. Only files
    that it lists under ``files`` and that the command itself writes are ever replaced or removed;
    a run of another command is refused, because its files are no result of this one, and yet
    would look like it. A missing parent is created. A symbolic link to a directory is followed; a
    dangling one is refused.

    Parameters
    ----------
    path
        Where the files go.
    command
        Who writes them, a key of ``FILES``.
    """

    def __init__(self, path: str | os.PathLike[str], command: str) -> None:
        self.path = Path(path)
        self.command = command

    def check(
        self, inputs: Iterable[str | os.PathLike[str] | None] = (), further: Iterable[str] = ()
    ) -> None:
        """Refuse a place where ``write`` would fail, or lose an input, before any work is done."""
        # ``further`` are names of files that the command writes this time.
        with _translated(self.path):
            target = self._target()
            if target.is_dir():
                old = self._old_files(target)
                self._spare(target, [Path(path) for path in inputs if path is not None])
                self._refuse_strangers(target, {*FILES[self.command], *further}, old)
            place = target
            while not place.exists():
                place = place.parent
            if not place.is_dir():
                raise OutputError(f"{self.path}: {place} is a file; expected a directory")
            if not os.access(place, os.W_OK | os.X_OK):
                raise OutputError(f"{self.path}: no permission to write in {place}")

    def write(self, files: Mapping[str, bytes], record: Mapping[str, Any]) -> None:
        """Write all files and run.json, which then tells the command and all names, or nothing."""
        contents = self._contents(files, record)
        with _translated(self.path), _signals_held():
            target = self._target()
            if target.is_dir():
                self._replace(target, contents)
            else:
                self._create(target, contents)

    def record(self) -> dict[str, Any] | None:
        """Return the record of the run that the directory holds, None where it holds none."""
        return _read_record(self.path / RECORD)

    def _target(self) -> Path:
        if self.path.is_symlink() and not self.path.exists():
            raise OutputError(f"{self.path}: a symbolic link to nowhere; expected a directory")
        if self.path.exists() and not self.path.is_dir():
            raise OutputError(f"{self.path}: a file; expected a new or empty directory")
        return self.path.resolve()

    def _writes(self, name: str) -> bool:
        patterns = {"reproduce": _OF_STUDY, "study": _OF_STUDY, "track": _OF_FORMAT}
        pattern = patterns.get(self.command)
        return name in FILES[self.command] or (
            pattern is not None and pattern.fullmatch(name) is not None
        )

    def _contents(self, files: Mapping[str, bytes], record: Mapping[str, Any]) -> dict[str, bytes]:
        if "trackweave" not in record:
            raise InvalidInputError("record: no key trackweave; expected the version under it")
        for name in files:
            if not self._writes(name):
                raise InvalidInputError(
                    f"{name!r}: expected the name of a file that `trackweave {self.command}` "
                    "writes"
                )
        names = sorted([*files, RECORD])
        # The command stands beside the version, where a reader looks first.
        begin = {"trackweave": record["trackweave"], "command": self.command}
        return {**files, RECORD: encode_json({**begin, **record, "files": names})}

    def _old_files(self, target: Path) -> list[str]:
        """Return the names of an earlier run's files, none of an empty directory."""
        entries = {entry.name for entry in target.iterdir()}
        present = {name for name in entries if not name.startswith(STAGING_PREFIX)}
        if not present:
            return []
        record = _read_record(target / RECORD)
        if record is None:
            raise OutputError(
                f"{self.path}: not empty and not a run of trackweave; expected a new or empty "
                "directory, or an earlier run's"
            )
        listed = record.get("files")
        names = set(map(str, listed)) if isinstance(listed, list) else set()
        writer = record.get("command") or _writer_of(names)
        if writer != self.command:
            raise OutputError(
                f"{self.path}: holds a run of `trackweave {writer}`; expected a new or empty "
                f"directory, or an earlier run of `trackweave {self.command}`"
            )
        ours = {name for name in names if self._writes(name)} | {RECORD}
        return sorted(name for name in ours if (target / name).is_file())

    def _spare(self, target: Path, inputs: Iterable[Path]) -> None:
        """Refuse to replace or remove what the run reads."""
        for path in inputs:
            for name in sorted(FILES[self.command] | {RECORD}):
                place = target / name
                if place.exists() and path.exists() and place.samefile(path):
                    raise OutputError(
                        f"{self.path}: its {name} is an input of this run and would be replaced; "
                        "expected another directory"
                    )

    def _refuse_strangers(self, target: Path, names: Iterable[str], old: list[str]) -> None:
        for name in sorted(names):
            if name not in old and os.path.lexists(target / name):
                raise OutputError(
                    f"{self.path}: has a {name} that is not of the earlier run; "
                    "expected only our own files under our names"
                )

    def _replace(self, target: Path, contents: Mapping[str, bytes]) -> None:
        old = self._old_files(target)
        self._refuse_strangers(target, contents, old)
        # Inside the target: it may be the only place on its disk where we may write.
        with _staged(target, contents) as new:
            for name in sorted(contents, key=lambda name: name == RECORD):
                if "/" in name:
                    (target / name).parent.mkdir(parents=True, exist_ok=True)
                (new / name).replace(target / name)
            for name in set(old) - set(contents):
                (target / name).unlink()
                for folder in (target / name).relative_to(target).parents[:-1]:
                    with contextlib.suppress(OSError):  # it may hold what is not ours
                        (target / folder).rmdir()
            if old and self.command in DRAWN:
                (target / DRAWN[self.command]).unlink(missing_ok=True)

    def _create(self, target: Path, contents: Mapping[str, bytes]) -> None:
        missing = [parent for parent in target.parents if not parent.exists()]
        try:
            if missing:
                target.parent.mkdir(parents=True, exist_ok=True)
            with _staged(target.parent, contents) as new:
                new.rename(target)
        except BaseException:
            for parent in missing:
                with contextlib.suppress(OSError):
                    parent.rmdir()
            raise


class OutputFile:
    """A file for the result of one run, new or in the place of an older file."""

    # A symbolic link to a file is followed; a dangling one is refused. The folder must exist.

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = Path(path)

    def check(self, inputs: Iterable[str | os.PathLike[str]] = ()) -> None:
        """Refuse a place where ``write`` would fail, or lose an input, before any work is done."""
        with _translated(self.path):
            target = self._target()
            if target.exists():
                if any(Path(path).exists() and target.samefile(path) for path in inputs):
                    raise OutputError(
                        f"{self.path}: an input of this run, which would be replaced; "
                        "expected another file"
                    )
                if not os.access(target, os.W_OK):
                    raise OutputError(f"{self.path}: no permission to replace it")
            if not os.access(target.parent, os.W_OK | os.X_OK):
                raise OutputError(f"{self.path}: no permission to write in {target.parent}")

    def write(self, content: bytes) -> None:
        """Write the file, or nothing."""
        with _translated(self.path), _signals_held():
            target = self._target()
            with _staged(target.parent, {target.name: content}) as new:
                (new / target.name).replace(target)

    def _target(self) -> Path:
        if self.path.is_symlink() and not self.path.exists():
            raise OutputError(f"{self.path}: a symbolic link to nowhere; expected a file")
        target = self.path.resolve()
        if target.is_dir():
            raise OutputError(f"{self.path}: a directory; expected the name of a file")
        if target.exists() and not target.is_file():
            raise OutputError(f"{self.path}: not a regular file; expected a file")
        if not target.parent.is_dir():
            raise OutputError(f"{self.path}: no such directory {target.parent}")
        return target


def write_folder(path: Path, contents: Mapping[str, bytes]) -> None:
    """Write files to a new or empty directory, all of them or none."""
    with _translated(path), _signals_held():
        if path.exists() and not (path.is_dir() and not any(path.iterdir())):
            raise OutputError(f"{path}: there already; expected a new or empty directory")
        target = path.resolve()
        target.parent.mkdir(parents=True, exist_ok=True)
        with _staged(target.parent, contents) as new:
            new.rename(target)


@contextlib.contextmanager
def _staged(folder: Path, contents: Mapping[str, bytes]) -> Iterator[Path]:
    """Write files to a hidden directory in a folder and yield it; it is gone afterwards."""
    with contextlib.suppress(OSError):  # we need no right to list the folder
        for left in folder.glob(f"{STAGING_PREFIX}*"):
            if time.time() - left.stat().st_mtime > ABANDONED_S:
                shutil.rmtree(left, ignore_errors=True)
    staging = Path(tempfile.mkdtemp(prefix=STAGING_PREFIX, dir=folder))
    try:
        new = staging / "new"  # with the permissions that the user's mask gives
        new.mkdir()
        for name, content in contents.items():
            if "/" in name:
                (new / name).parent.mkdir(parents=True, exist_ok=True)
            with (new / name).open("xb") as file:
                file.write(content)
                file.flush()
                os.fsync(file.fileno())
        yield new
    finally:
        shutil.rmtree(staging, ignore_errors=True)


@contextlib.contextmanager
def _signals_held() -> Iterator[None]:
    """Let Control-C and SIGTERM wait for the end of the block: half of its renames are a mix."""
    if threading.current_thread() is not threading.main_thread():
        yield  # Python handles signals in the main thread alone
        return
    came: list[int] = []
    ours = (signal.SIGINT, signal.SIGTERM)
    handlers = [signal.signal(number, lambda number, _: came.append(number)) for number in ours]
    try:
        yield
    finally:
        for number, handler in zip(ours, handlers, strict=True):
            signal.signal(number, signal.SIG_DFL if handler is None else handler)
        for held in came:
            signal.raise_signal(held)


@contextlib.contextmanager
def _translated(path: Path) -> Iterator[None]:
    """Turn what the system complains of into an OutputError that names the file and the reason."""
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


def _writer_of(names: set[str]) -> str:
    """Return which command wrote a run whose record does not say so."""
    known = names & FILES["demo"]
    return next((name for name, files in FILES.items() if known and known <= files), "track")


def _read_record(path: Path) -> dict[str, Any] | None:
    try:
        record = json.loads(path.read_bytes())
    except (FileNotFoundError, IsADirectoryError, ValueError, RecursionError):
        return None
    return record if isinstance(record, dict) and "trackweave" in record else None
