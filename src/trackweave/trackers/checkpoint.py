"""Checkpoints: all that a tracker knows in a file, from which another process goes on.

A file begins with what it is, the version of its layout, the version of trackweave that wrote it,
and how long its content is with a digest. That finds damage; it is no proof of who wrote it.
"""

import contextlib
import hashlib
import os
import struct
from collections.abc import Sequence
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any, Self

from trackweave.errors import DataFormatError, InvalidInputError, OutputError
from trackweave.fields import checked_members
from trackweave.trackers.packing import packed
from trackweave.trackers.unpacking import unpacked

__all__ = ["LAYOUT", "Saved", "pack", "unpack"]

LAYOUT = 1
"""Goes up whenever what is in a file would be misread, or would go on otherwise."""
MAGIC = b"trackweave checkpoint\n"
_HEADER = struct.Struct("<22sI16sQ16s")


def pack(value: Any, classes: Sequence[type] = ()) -> bytes:
    """Return a value as the content of a checkpoint.

    Parameters
    ----------
    value
        A tracker, or numbers, texts, tuples, lists, dictionaries, sets of numbers and texts,
        arrays, random generators and objects of trackweave's classes, in one another.
    classes
        Classes of your own whose objects it may hold.

    Returns
    -------
    The bytes. The same value gives the same.

    Raises
    ------
    InvalidInputError
        If it holds something else; the message says where and what.

    Examples
    --------
    >>> from trackweave.trackers.checkpoint import pack, unpack
    >>> unpack(pack({"turn": 3, "seen": ("north", 12.5)}))
    {'turn': 3, 'seen': ('north', 12.5)}
    """
    content = packed(value, classes)
    digest = hashlib.blake2b(content, digest_size=16).digest()
    return _HEADER.pack(MAGIC, LAYOUT, _own(), len(content), digest) + content


def unpack(content: bytes, classes: Sequence[type] = ()) -> Any:
    """Return the value that `pack` made a checkpoint of.

    Parameters
    ----------
    content
        What `pack` gave.
    classes
        The classes of your own that it was given.

    Returns
    -------
    The value.

    Raises
    ------
    DataFormatError
        If it is foreign, damaged or of another layout; the message says what came.
    """
    if content[: len(MAGIC)] != MAGIC or len(content) < _HEADER.size:
        raise DataFormatError(f"begins with {content[:22]!r}; expected a checkpoint of trackweave")
    _, layout, writer, length, digest = _HEADER.unpack_from(content)
    if layout != LAYOUT:
        said = writer.rstrip(b"\0").decode("ascii", "replace")
        raise DataFormatError(
            f"layout {layout}, written by trackweave {said}; expected layout {LAYOUT}"
        )
    body = content[_HEADER.size :]
    if len(body) != length:
        raise DataFormatError(f"damaged: {len(body)} bytes of content; expected {length}")
    if hashlib.blake2b(body, digest_size=16).digest() != digest:
        raise DataFormatError("damaged: its content is not what its digest is of")
    return unpacked(body, classes)


class Saved:
    """What can be saved to a file, and go on from it in another process."""

    def save(self, path: str | os.PathLike[str], *, classes: Sequence[type] = ()) -> None:
        """Write all that is known to a file, which appears whole or not at all.

        Parameters
        ----------
        path
            The file; one that is there is replaced.
        classes
            Classes of your own whose objects it holds: motions, solvers, kinds of measurement.

        Raises
        ------
        InvalidInputError
            If it holds objects of other classes that are not trackweave's, or an argument is of
            another kind than it has to be.
        OutputError
            If the file cannot be written.

        Examples
        --------
        >>> import tempfile
        >>> from pathlib import Path
        >>> import trackweave as tw
        >>> tracker = tw.BoxTracker()
        >>> for x in (0.0, 3.0):  # pixels
        ...     frame = tracker.update([[x, 0.0, x + 20.0, 40.0]])
        ...
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     tracker.save(Path(folder) / "boxes.checkpoint")
        ...     later = tw.BoxTracker.load(Path(folder) / "boxes.checkpoint")
        ...
        >>> later.update([[6.0, 0.0, 26.0, 40.0]]).number
        2
        """
        place = _checked(path)
        _write(place, pack(self, _checked_classes(classes)))

    @classmethod
    def load(cls, path: str | os.PathLike[str], *, classes: Sequence[type] = ()) -> Self:
        """Return what was saved, as it was; it goes on as if nothing had happened.

        Parameters
        ----------
        path
            A file that `save` wrote, of a source that you trust as you trust your own program.
        classes
            The classes of your own that `save` was given.

        Returns
        -------
        The tracker. What steps take on this machine, which deadlines go by, it learns anew.

        Raises
        ------
        DataFormatError
            If it is foreign, damaged, of another version, or of another class.
        InvalidInputError
            If the file cannot be read, or an argument is of another kind than it has to be.
        """
        place, known = _checked(path), _checked_classes(classes)
        try:
            content = place.read_bytes()
        except (OSError, ValueError) as err:
            told = getattr(err, "strerror", None) or err
            raise InvalidInputError(f"{path}: cannot be read ({told})") from err
        try:
            found = unpack(content, known)
        except DataFormatError as err:
            raise DataFormatError(f"{path}: {err}") from err
        if type(found) is not cls:
            raise DataFormatError(
                f"{path}: a checkpoint of {type(found).__name__}; expected one of {cls.__name__}"
            )
        return found


def _checked(path: Any) -> Path:
    if not isinstance(path, str | os.PathLike):
        raise InvalidInputError(f"path: {path!r:.80}; expected a path of a file")
    return Path(path)


def _checked_classes(classes: Any) -> list[type]:
    return checked_members(classes, type, "classes")


def _write(path: Path, content: bytes) -> None:
    """Write a file beside its place, flush it to the disk and rename it into place."""
    if not path.name:  # of "." and of nothing at all
        raise OutputError(f"{path}: a directory; expected the path of a file")
    unfinished = path.with_name(f".{path.name}-{os.getpid()}")
    try:
        with unfinished.open("xb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        unfinished.replace(path)
    except (OSError, ValueError) as err:
        if not isinstance(err, FileExistsError):
            with contextlib.suppress(OSError, ValueError):
                unfinished.unlink()
        raise OutputError(
            f"{path}: cannot be written ({getattr(err, 'strerror', None) or err})"
        ) from err


def _own() -> bytes:
    try:
        return version("trackweave").encode()[:16]
    except PackageNotFoundError:
        return b"unknown"
