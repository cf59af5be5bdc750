"""Bytes in, reports out: the decoder of all categories."""

import numpy as np
import polars as pl

from trackweave.formats.asterix import (
    cat001,
    cat002,
    cat010,
    cat020,
    cat021,
    cat034,
    cat048,
    cat062,
)
from trackweave.formats.asterix.category import Category, Part
from trackweave.formats.asterix.clock import DayClock, ShortClock
from trackweave.formats.asterix.framing import CAPTURES, Framing, framing_of
from trackweave.formats.asterix.gathering import KNOWN_CATEGORIES, Gathering
from trackweave.formats.asterix.station import Stations
from trackweave.formats.asterix.table import table_of
from trackweave.formats.asterix.values import TIME_S
from trackweave.formats.format import HEAD_BYTES, Facts, Skips

__all__ = ["AsterixDecoder", "categories_of", "is_asterix"]


# Texts have none but such octets; data blocks have others, if only in their lengths.
_TEXT_OCTETS = bytes([9, 10, 13, *range(32, 127)])
_TEXT = 4096
_BLOCK_HEADER = 3
_OTHER_EDITION = (
    "category 021: no record has a position; edition_021 may be another (--from "
    f"'asterix?edition_021=0.26'; {', '.join(cat021.EDITIONS)})"
)


def is_asterix(head: bytes, name: str) -> bool:
    """Tell whether a file begins with data blocks, however wrapped, most of which are right.

    Parameters
    ----------
    head
        The file's beginning.
    name
        Its name, which is not needed.

    Returns
    -------
    Whether it does.
    """
    if head[:4] in CAPTURES:
        return True
    if not head[:_TEXT].translate(None, _TEXT_OCTETS):
        return False
    read = (2 * _octets_read(head, edition) > len(head) for edition in cat021.EDITIONS)
    return any(read) or _is_of_blocks(head)


def _is_of_blocks(head: bytes) -> bool:
    """Tell whether a file begins with data blocks of known categories, if none that is read."""
    place = 0
    while place + _BLOCK_HEADER <= len(head):
        size = int.from_bytes(head[place + 1 : place + _BLOCK_HEADER], "big")
        if head[place] not in KNOWN_CATEGORIES or size <= _BLOCK_HEADER:
            return False
        place += size
    # Of the last block of a longer file there need be no more.
    return place == len(head) or len(head) >= HEAD_BYTES


def _octets_read(head: bytes, edition: str) -> int:
    """Return how much of a file's beginning is records, or surely waits for more of them."""
    decoder = AsterixDecoder(edition)
    decoder.feed(head)
    return decoder.n_octets if decoder.n_records else 0


def categories_of(edition_021: str = cat021.DEFAULT_EDITION) -> dict[int, Category]:
    """Return the categories that are decoded, by their numbers."""
    return {
        1: cat001.CATEGORY,
        2: cat002.CATEGORY,
        10: cat010.CATEGORY,
        20: cat020.CATEGORY,
        21: cat021.EDITIONS[edition_021],
        34: cat034.CATEGORY,
        48: cat048.CATEGORY,
        62: cat062.CATEGORY,
    }


class AsterixDecoder:
    """Decodes data blocks, recorders' frames and network captures, found out by the first octets.

    Parameters
    ----------
    edition_021
        The edition of category 021, a key of ``cat021.EDITIONS``.
    """

    def __init__(self, edition_021: str = cat021.DEFAULT_EDITION) -> None:
        self.skips = Skips()
        self.facts = Facts()
        self.marks: dict[str, float] = {}
        self.received = 0.0
        """When octets come that no capture's clock tells of [s from 1970]; 0 for unknown."""
        self.n_records = 0
        self.n_octets = 0
        self._categories = categories_of(edition_021)
        self._framing: Framing | None = None
        self._pending = b""
        self._base = 0
        self._placed_021: bool | None = None  # Whether any record has a place, None for no record
        self._days, self._short = DayClock(), ShortClock()
        self._stations = Stations(self.facts)

    def feed(self, data: bytes) -> pl.DataFrame | None:
        """Return the reports that further bytes complete, None where there are none."""
        return self._advance(data, at_end=False)

    def finish(self) -> pl.DataFrame | None:
        """Return what is left at the end."""
        table = self._advance(b"", at_end=True)
        if self._placed_021 is False:
            self.facts.notes.append(_OTHER_EDITION)
        return table

    def cut(self) -> pl.DataFrame | None:
        """Return what a datagram's last block holds: the next datagram begins a block."""
        return self._advance(b"", at_end=True) if self._pending else None

    def _advance(self, data: bytes, *, at_end: bool) -> pl.DataFrame | None:
        buffer = self._pending + data
        if self._framing is None:
            self._framing = framing_of(buffer, at_end=at_end)
        if self._framing is None:
            self._pending = buffer
            return None
        gathering = Gathering(
            buffer, self._base, self._categories, self.skips, self.facts.left_out
        )
        gathering.received = self.received
        done = self._framing.scan(gathering, at_end=at_end)
        self._pending = buffer[done:]
        self.n_octets += gathering.n_octets
        self._base += done
        return self._table(gathering)

    def _table(self, gathering: Gathering) -> pl.DataFrame | None:
        """Return all reports of a buffer in the order in which they came."""
        crossed = list[tuple[str, float, int]]()
        for number in (2, 34):
            for records in gathering.records(number):
                crossed += self._stations.tell(records)
                if number == 2:
                    self._short.tell(records.begin, records.number("030", scale=TIME_S))
        parts = list[Part]()
        for number, readers in gathering.readers.items():
            self.n_records += sum(reader.count for reader in readers)
            columns = self._categories[number].columns
            for records in gathering.records(number) if columns else ():
                if records.count and columns:
                    part = Part(number, records.begin, gathering.clock_of(records.begin))
                    part.columns.update(columns(records))
                    parts.append(part)
        self._short.complete(parts)
        table = table_of(parts, self._days, self.facts.left_out) if parts else None
        if any(reader.count for reader in gathering.readers.get(21, ())):
            placed = table is not None and bool((table["category"] == 21).any())
            self._placed_021 = bool(self._placed_021) or placed
        self._mark(crossed, gathering)
        return table

    def _mark(self, crossed: list[tuple[str, float, int]], gathering: Gathering) -> None:
        """Note when beams last crossed a sector's border, in the time of the reports."""
        for name, of_day, begin in sorted(crossed, key=lambda each: each[2]):
            clock = float(gathering.clock_of(np.array([begin]))[0])
            moment = self._days.moment(of_day, clock)
            if moment is not None:
                self.marks[name] = moment
