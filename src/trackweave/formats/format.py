"""What a format is: how it is found, what it becomes, and what becomes of its faults."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol, TypeAlias

import polars as pl

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
MOST_LISTED = 1000
"""As many skipped records are listed; all are counted."""
_LONGEST_REASON = 120


@dataclass(frozen=True, slots=True)
class Skipped:
    """A record that could not be decoded.

    Parameters
    ----------
    offset
        Where in the file or stream it begins [bytes].
    what
        What was wrong with it, in a few words.
    """

    offset: int
    what: str


@dataclass(slots=True)
class Skips:
    """The records that a decoder could not use: all are counted, the first are listed.

    Parameters
    ----------
    count
        How many there are.
    listed
        The first of them.
    """

    count: int = 0
    listed: list[Skipped] = field(default_factory=list)

    def add(self, offset: int, what: str) -> None:
        """Enter a record, by where it begins [bytes] and what is wrong with it."""
        self.count += 1
        if len(self.listed) < MOST_LISTED:
            self.listed.append(Skipped(int(offset), what[:_LONGEST_REASON]))


@dataclass(frozen=True, slots=True)
class Place:
    """Where a sensor stands.

    Parameters
    ----------
    latitude_deg, longitude_deg
        WGS-84 [degrees].
    altitude_m
        Height above the ellipsoid [m].
    """

    latitude_deg: float
    longitude_deg: float
    altitude_m: float = 0.0


@dataclass(slots=True)
class Facts:
    """What a file tells beside its reports.

    Parameters
    ----------
    places
        Where sensors stand, by the names that the column ``sensor`` has. They count as told.
    scan_periods
        Seconds of a turn, by the same names. They count as told.
    notes
        Sentences that a user should read: what was assumed, what was left out and why.
    """

    places: dict[str, Place] = field(default_factory=dict)
    scan_periods: dict[str, float] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)


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
    earlier had not. A code for "not available" is null, or for a position of AIS 91 and 181.
    """

    skips: Skips
    facts: Facts

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
        A keyword argument of the decoder.
    default
        Its value where nothing is told; its type is that of what can be told.
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
        Whether a file with such a beginning (at most ``HEAD_BYTES``) and such a name is of this
        format. The content decides; a name alone may confirm it and must not be needed.
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

    def settings(self) -> dict[str, Any]:
        """Return what a decoder is told where a user tells nothing."""
        return {option.name: option.default for option in self.options}
