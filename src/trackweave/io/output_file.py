"""One file appears whole or not at all.

It is written to a staging directory beside its place, flushed to the disk, and then renamed into
place, which replaces an older file in one step.
"""

import contextlib
import os
from collections.abc import Iterable
from pathlib import Path

from trackweave.errors import OutputError
from trackweave.io.staging import Staging, remove_abandoned, translated

__all__ = ["OutputFile"]


class OutputFile:
    """A file for the result of one run, new or in the place of an older file.

    A symbolic link to a file is followed; a dangling one is refused. The folder must exist.

    Parameters
    ----------
    path
        Where the file goes.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = Path(path)

    def check(self, inputs: Iterable[str | os.PathLike[str]] = ()) -> None:
        """Refuse a place where ``write`` would fail, before any work is done.

        Parameters
        ----------
        inputs
            Files that the run reads, which it must not replace.

        Raises
        ------
        OutputError
            If the path is a directory or another thing than a file, its folder is missing or not
            writable, or an input would be lost.
        """
        with translated(self.path):
            target = self._target()
            if target.exists():
                for path in map(Path, inputs):
                    if path.exists() and path.samefile(target):
                        raise OutputError(
                            f"{self.path}: an input of this run, which would be replaced; "
                            "expected another file"
                        )
                if not os.access(target, os.W_OK):
                    raise OutputError(f"{self.path}: no permission to replace it")
            if not os.access(target.parent, os.W_OK | os.X_OK):
                raise OutputError(f"{self.path}: no permission to write in {target.parent}")

    def write(self, content: bytes) -> None:
        """Write the file, or nothing.

        Parameters
        ----------
        content
            What the file will hold.

        Raises
        ------
        OutputError
            If the environment fails, such as by a full disk; then nothing has changed.
        """
        with translated(self.path):
            target = self._target()
            with contextlib.suppress(OSError):  # we need no right to list the folder
                remove_abandoned(target.parent)
            staging = Staging(target.parent)
            try:
                staging.fill({target.name: content})
                (staging.path / "new" / target.name).replace(target)
            finally:
                staging.remove()

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
