"""Files appear whole or not at all.

A set of files is written to a staging directory first, each flushed to the disk, and then moved
into place by renaming, which takes no space. A new directory appears by one rename. In a
directory that exists, the old files of ours are moved aside, the new ones in, the record of the
run last; whatever goes wrong before that, everything is moved back. A staging directory that was
left by a killed process or a power cut is found by the next run, which undoes an unfinished
change and removes it.
"""

import contextlib
import json
import os
import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, TypeGuard

from trackweave.errors import InvalidInputError, OutputError
from trackweave.io.run_json import encode_json
from trackweave.io.staging import (
    Staging,
    is_staging,
    recover,
    remove_abandoned,
    translated,
)

__all__ = ["FILES", "RECORD", "OutputDirectory"]

RECORD = "run.json"
# What each command writes besides the record. No other file is ever replaced or removed.
_SIMULATED = frozenset({"reports.csv", "truth.csv"})
_TRACKED = frozenset({"tracks.csv", "assignments.csv", "history.csv"})
FILES = {
    "simulate": _SIMULATED,
    "track": _TRACKED,
    "demo": _SIMULATED | _TRACKED | {"tracker.toml", "demo.png"},
    "fuse": frozenset({"associations.csv", "tracks.csv"}),
    "reproduce": frozenset({"report.md"}),
}
# A study's figures and their numbers, beside its report: it alone knows which there are.
_OF_STUDY = re.compile(r"[a-z0-9-]+\.(csv|png)")


def _writes(command: str, name: str) -> bool:
    """Tell whether a command writes files of a name."""
    return name in FILES[command] or (
        command == "reproduce" and _OF_STUDY.fullmatch(name) is not None
    )


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

    def check(self, inputs: Iterable[str | os.PathLike[str] | None] = ()) -> None:
        """Refuse a place where ``write`` would fail, before any work is done.

        Parameters
        ----------
        inputs
            Files that the run reads, which it must not replace or remove; None for one not given.

        Raises
        ------
        OutputError
            If the path is a file, a directory that is not empty and not ours, or not writable, or
            if an input would be lost.
        """
        with translated(self.path):
            target = self._target()
            if target.is_dir():
                self._recover_in(target)
                old = self._old_files(target)
                self._spare(target, [Path(path) for path in inputs if path is not None])
                self._refuse_strangers(target, FILES[self.command], old)
            place = target
            while not place.exists():
                place = place.parent
            if not place.is_dir():
                raise OutputError(f"{self.path}: {place} is a file; expected a directory")
            if not os.access(place, os.W_OK | os.X_OK):
                raise OutputError(f"{self.path}: no permission to write in {place}")

    def write(self, files: Mapping[str, bytes], record: Mapping[str, Any]) -> None:
        """Write all files and run.json, or nothing.

        Parameters
        ----------
        files
            Each file's name, without folders, and content.
        record
            Content of run.json; it must have the key ``trackweave``, the version. The command and
            the names of all files are added to it as ``command`` and ``files``.

        Raises
        ------
        InvalidInputError
            If a file is none that the command writes, or the record has no version.
        OutputError
            If the place is refused as by ``check``, or the environment fails, such as by a full
            disk; then nothing has changed.
        """
        contents = _contents(files, record, self.command)
        with translated(self.path):
            target = self._target()
            if target.is_dir():
                self._recover_in(target)
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

    def _recover_in(self, target: Path) -> None:
        if not recover(target, RECORD):
            raise OutputError(f"{self.path}: another run is writing there; expected to be alone")
        with contextlib.suppress(OSError):  # we need no right to read the parent
            remove_abandoned(target.parent)

    def _old_files(self, target: Path) -> list[str]:
        """Return the names of an earlier run's files, none of an empty directory."""
        present = {entry.name for entry in target.iterdir() if not is_staging(entry)}
        if not present:
            return []
        record = _read_record(target / RECORD)
        if record is None:
            raise OutputError(
                f"{self.path}: not empty and not a run of trackweave; expected a new or empty "
                "directory, or an earlier run's"
            )
        listed = record.get("files")
        names = {name for name in listed if isinstance(name, str)} if _is_list(listed) else set()
        writer = record.get("command") or _writer_of(names)
        if writer != self.command:
            raise OutputError(
                f"{self.path}: holds a run of `trackweave {writer}`; expected a new or empty "
                f"directory, or an earlier run of `trackweave {self.command}`"
            )
        ours = {name for name in names if _writes(self.command, name)} | {RECORD}
        return sorted(name for name in ours & present if (target / name).is_file())

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
        staging = Staging(target)
        try:
            staging.fill(contents)
            staging.swap(target, old, last=RECORD)
        except BaseException:
            staging.undo(target, RECORD)
            raise
        staging.remove()

    def _create(self, target: Path, contents: Mapping[str, bytes]) -> None:
        missing = [parent for parent in target.parents if not parent.exists()]
        staging: Staging | None = None
        try:
            target.parent.mkdir(parents=True, exist_ok=True)
            remove_abandoned(target.parent)
            staging = Staging(target.parent)
            staging.parents = missing
            staging.fill(contents)
            staging.become(target)
        except BaseException:
            if staging is not None:
                staging.clear()
            for parent in missing:
                with contextlib.suppress(OSError):
                    parent.rmdir()
            raise
        staging.remove()


def _contents(
    files: Mapping[str, bytes], record: Mapping[str, Any], command: str
) -> dict[str, bytes]:
    if "trackweave" not in record:
        raise InvalidInputError("record: no key trackweave; expected the version under it")
    for name in files:
        if not _writes(command, name):
            raise InvalidInputError(
                f"{name!r}: expected the name of a file that `trackweave {command}` writes"
            )
    names = sorted([*files, RECORD])
    # The command stands beside the version, where a reader looks first.
    begin = {"trackweave": record["trackweave"], "command": command}
    return {**files, RECORD: encode_json({**begin, **record, "files": names})}


def _is_list(listed: Any) -> TypeGuard[list[Any]]:
    return isinstance(listed, list)


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
