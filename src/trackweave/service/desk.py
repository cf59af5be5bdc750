"""The counter between those who ask and the clerk who answers: reports over it, pictures back.

Whoever is behind it keeps the journal and the engine; whoever stands before it (``service.web``)
knows neither. All calls come from the one thread of the event loop.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol, TypeAlias

import numpy as np
import polars as pl

from trackweave.domain.facts import Facts
from trackweave.domain.frames import LocalFrame
from trackweave.errors import TrackweaveError

__all__ = [
    "Desk",
    "Json",
    "OverloadedError",
    "Picture",
    "Receipt",
    "Rejected",
    "Rows",
    "Subscription",
]

Json: TypeAlias = dict[str, Any]
"""An object as it is sent: texts, finite numbers, truths, None, and lists and objects of them."""


class OverloadedError(TrackweaveError):
    """More comes than can be taken: nothing of it was kept, the same may be sent again later."""


@dataclass(frozen=True, slots=True, eq=False)
class Rows:
    """Reports as a format's decoder left them: columns known, values not yet checked.

    Parameters
    ----------
    table
        Columns of a reports table, shape (rows, columns); ``time`` is null where nothing told it.
    row
        Number of each row in what was sent, from 1, shape (rows,): how a message names it.
    source
        Who sent them, such as "http 127.0.0.1"; short, printable.
    facts
        What was told beside them: where sensors stand, how long they turn.
    """

    table: pl.DataFrame
    row: np.ndarray[Any, np.dtype[np.int64]]
    source: str
    facts: Facts = field(default_factory=Facts)


@dataclass(frozen=True, slots=True)
class Rejected:
    """A report that was not taken.

    Parameters
    ----------
    row
        Its number in what was sent, from 1; None where it has none.
    message
        What came and what was expected.
    """

    row: int | None
    message: str


@dataclass(frozen=True, slots=True)
class Receipt:
    """What became of reports handed over. Whoever holds it knows that they are on the disk.

    Parameters
    ----------
    accepted
        How many reports are in the journal.
    rejected
        Those that are not.
    sequence
        The last record of the journal that is on the disk, these reports' included; 0 where there
        is none.
    """

    accepted: int
    rejected: tuple[Rejected, ...]
    sequence: int


@dataclass(frozen=True, slots=True, eq=False)
class Picture:
    """All live tracks at one time.

    Parameters
    ----------
    time
        Up to when reports are in it [s], from 1970 UTC where the reports were dated; None as long
        as there was no scan.
    tracks
        One row for each live track with the columns of a tracks file: ``time`` (seconds, or
        ``Datetime`` where the reports were dated), ``track``, ``status``, ``x``, ``y``, ``vx``,
        ``vy``, ``p_x_x``, …, and ``lat``, ``lon`` where positions are on the Earth. Further
        columns, such as ``identity``, ``existence``, ``visible`` and ``sensors`` (lists of names),
        may follow.
    frame
        The plane of ``x`` and ``y``, None where positions are not on the Earth.
    """

    time: float | None
    tracks: pl.DataFrame
    frame: LocalFrame | None = None


class Subscription(Protocol):
    """Messages for one listener, each a JSON text, first a full picture.

    One that falls behind is given a fresh full picture in place of what it missed; what waits for
    it never grows. The same text goes to all listeners: it is made once.
    """

    def __aiter__(self) -> "Subscription":
        """Return itself."""

    async def __anext__(self) -> str:
        """Return the next message once there is one; the iteration ends with ``close``."""

    def close(self) -> None:
        """Want no more. The iteration ends; a second call does nothing."""


class Desk(Protocol):
    """Where reports are handed in and pictures are asked for."""

    async def accept(self, rows: Rows) -> Receipt:
        """Check reports, write them to the journal and return once they are on the disk.

        Whoever stops waiting learns nothing: the reports may be in the journal or not.

        Parameters
        ----------
        rows
            The reports.

        Returns
        -------
        How many are on the disk, which are not and why, and the last sequence on the disk.

        Raises
        ------
        OverloadedError
            If more comes than can be taken; nothing was kept.
        OutputError
            If the disk refuses, full or read-only; nothing is acknowledged.
        InvalidInputError
            If no row can be made a report of, whatever its values: a column has two meanings.
        """

    def picture(self) -> Picture:
        """Return all live tracks as they are now."""

    def track(self, identifier: str) -> Json | None:
        """Return one track with its trail and innovations, as the page wants it; None for none."""

    def sensors(self) -> list[Json]:
        """Return the sensors.

        Each with ``name``, ``kind``, ``place``, ``last_heard``, ``reports``, ``reports_per_s``,
        ``silent`` and ``coverage``, a polygon, as far as each is known.
        """

    def health(self) -> Json:
        """Return how the service is.

        ``status`` ("ok", "starting" until kernels are loaded, "waiting" until enough is heard to
        be configured, "failing" where nothing can be taken any more), ``message`` where there is
        something to say, ``sequence`` (the last on the disk), ``lag_s``, ``configured``,
        ``set_aside``.
        """

    def counters(self) -> Mapping[str, float]:
        """Return numbers for ``/metrics`` by name, in base units.

        Names are of small letters, digits and ``_``; one that ends in ``_total`` only ever grows.
        """

    def subscribe(self, *, reports: bool = False) -> Subscription:
        """Return messages from now on, with those of type "reports" where they are wanted."""
