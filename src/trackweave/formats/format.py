"""What a format is: how it is found, what it becomes, and what becomes of its faults."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol, TypeAlias

import polars as pl

from trackweave.domain.facts import Facts, Place, Skipped, Skips
from trackweave.domain.frames import LocalFrame

__all__ = [
    "HEAD_BYTES",
    "Decoder",
    "Facts",
    "Format",
    "Option",
    "Output",
    "Place",
    "Skipped",
    "Skips",
    "Writer",
]

HEAD_BYTES = 65_536
"""As much of a file's beginning as ``recognise`` is shown."""


class Decoder(Protocol):
    """Bytes in, tables out; the same for a file, a pipe and a live service.

    Bytes may be split anywhere: the rows of all tables together are the same. What cannot be
    decoded goes to ``skips``; only a document that is no such document as a whole raises
    ``DataFormatError``. Nothing else is ever raised, whatever the bytes, and what is kept back
    between calls is bounded (by the document, where one must be read as a whole).

    Tables have the columns of a reports table, numbers as numbers: ``time`` (seconds, or
    ``Datetime("us", "UTC")`` where the day is known), a measurement, and what else there is, such
    as ``sensor``, ``identity``, ``strength``, ``height_m``, ``scan``, ``target``. Columns that are
    not of a reports table pass through to the assignments; a later table may have columns that an
    earlier had not. A code for "not available" is null, or for a position of AIS 91 and 181. A
    ``time`` is null where nothing tells it: the reader of a file leaves such rows out and says how
    many, a live service puts the time of receipt.

    One that has a method ``cut()`` is told where a datagram ends: what it kept back of it will
    never be completed. It returns what ``finish`` would, and goes on. One that has a dictionary
    ``marks`` says there when each sensor, by name, last told that its beam came by somewhere,
    in the seconds of the reports.
    """

    @property
    def skips(self) -> Skips:
        """What could not be decoded so far."""

    @property
    def facts(self) -> Facts:
        """What was told beside the reports so far."""

    def feed(self, data: bytes) -> pl.DataFrame | None:
        """Return the reports that further bytes complete, None where there are none."""

    def finish(self) -> pl.DataFrame | None:
        """Return what is left at the end of the file or stream."""


@dataclass(frozen=True, slots=True)
class Option:
    """What a user may tell a reader, as in ``--from mot?frame_rate=30``.

    Parameters
    ----------
    name
        A keyword argument of the decoder, which has a default of its own.
    default
        What the decoder does where nothing is told; its type is that of what can be told.
    meaning
        In a few words, with the unit.
    choices
        All that may be told; empty where anything of the type may be.
    """

    name: str
    default: float | str
    meaning: str
    choices: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class Output:
    """What a writer may write of a run.

    Parameters
    ----------
    tracks
        What was known after each scan, with the columns of a tracks file.
    history
        The same, amended and smoothed after the fact; None where there is none.
    assignments
        One row for each report, with its track and the columns that passed through; None where
        there is none.
    frame
        The plane of ``x`` and ``y``, None where positions are not on the Earth.
    """

    tracks: pl.DataFrame
    history: pl.DataFrame | None = None
    assignments: pl.DataFrame | None = None
    frame: LocalFrame | None = None


Writer: TypeAlias = Callable[[Output], Mapping[str, bytes]]
"""Returns files by their names, with ``/`` where they lie in folders; raises
``InvalidInputError`` where the format cannot say what is there, such as a place on the Earth."""


@dataclass(frozen=True, slots=True)
class Format:
    """A format that can be read, written, or both.

    Parameters
    ----------
    name
        What ``--from``, ``--to`` and ``--also`` call it, such as "asterix".
    title
        What its users call it.
    endings
        How names of its files end, with the dot, in lower case; the first is used for writing.
    carries, loses
        What comes through and what does not, in a few words each.
    recognise
        Whether a file with such a beginning (at most ``HEAD_BYTES``, unpacked where it is gzip
        data) and such a name is of this format. The content decides; a name alone may confirm it
        and must not be needed. Of a directory the beginning is empty, and the name its path.
    decoder
        Makes a decoder, with the values of ``options`` as keyword arguments; None where the format
        is only written.
    options
        What a reader may be told.
    folder
        Reads a directory at once, where the format is one.
    writer
        Writes a run; None where the format is only read.
    extra
        The extra with which the libraries come that reading or writing needs; None for none.
    is_table
        Whether ``trackweave.io`` reads its files as tables; a decoder is for streams then.
    takes_reports
        Whether its writer takes reports as well, as ``tracks`` of the output.
    """

    name: str
    title: str
    endings: tuple[str, ...]
    carries: str
    loses: str
    recognise: Callable[[bytes, str], bool] | None = None
    decoder: Callable[..., Decoder] | None = None
    options: tuple[Option, ...] = ()
    folder: Callable[[Path], tuple[pl.DataFrame, Facts]] | None = None
    writer: Writer | None = None
    extra: str | None = None
    is_table: bool = False
    takes_reports: bool = False

    @property
    def can_read(self) -> bool:
        """Whether files of it can be read."""
        return self.is_table or self.decoder is not None or self.folder is not None
