"""The records of a buffer, category by category, before they become tables."""

import numpy as np
from numpy.typing import NDArray

from trackweave.formats.asterix.category import Category
from trackweave.formats.asterix.layout import UndecodableError
from trackweave.formats.asterix.records import Reader, Records
from trackweave.formats.format import Skips

__all__ = ["KNOWN_CATEGORIES", "Gathering"]

KNOWN_CATEGORIES = frozenset(
    (1, 2, 3, 4, 7, 8, 9, 10, 11, 15, 16, 17, 18, 19, 20, 21, 23, 25, 30, 31, 32, 34, 48, 62, 63,
     65, 129, 150, 205, 240, 247, 252)
)  # fmt: skip
"""Categories that EUROCONTROL publishes, and some in wide use."""

_HEADER = 3
_HINTS = {21: "; edition_021 may be another (--from asterix?edition_021=0.26)"}
# Some networks put a header of so many octets before each block; the first two say its length.
_ENVELOPE = 6


class Gathering:
    """Gathers records of data blocks.

    Parameters
    ----------
    buffer
        Octets.
    base
        Where they begin in the file or stream.
    categories
        The categories to decode.
    skips
        Takes what cannot be decoded.
    counts
        Takes what is left out by its nature, by what it is.
    """

    def __init__(
        self,
        buffer: bytes,
        base: int,
        categories: dict[int, Category],
        skips: Skips,
        counts: dict[str, int],
    ) -> None:
        self.received = 0.0
        """When what has no clock of its own came [s from 1970]; 0 for unknown."""
        self.buffer = buffer
        self._base = base
        self._categories = categories
        self._skips = skips
        self._counts = counts
        self.readers: dict[int, list[Reader]] = {}
        self.n_octets = 0
        self._starts = list[int]()
        self._clocks = list[float]()

    def skip(self, place: int, what: str) -> None:
        """Enter what cannot be decoded, by where it begins in the buffer."""
        self._skips.add(self._base + place, what)

    def count(self, what: str, number: int = 1) -> None:
        """Count what is left out."""
        if number:
            self._counts[what] = self._counts.get(what, 0) + number

    def records(self, number: int) -> list[Records]:
        """Return the records of a category, of each of its kinds."""
        return [reader.records(self.buffer) for reader in self.readers.get(number, [])]

    def clock_of(self, begin: NDArray[np.int64]) -> NDArray[np.float64]:
        """Return the capture's clock [s] for records by where they begin, 0 for none."""
        block = np.searchsorted(self._starts, begin, side="right") - 1
        clock = np.array(self._clocks)[block]
        return np.where(clock == 0.0, self.received, clock)

    def block(self, start: int, stop: int, clock: float = 0.0) -> int:
        """Gather a data block's records; return how far that went."""
        number = self.buffer[start]
        category = self._categories.get(number)
        if category is None:
            self.count(f"data blocks of category {number:03d}, which is not read")
            return stop
        readers = self.readers.get(number)
        if readers is None:
            readers = self.readers[number] = [Reader(layout) for layout in category.layouts]
        self._starts.append(start)
        self._clocks.append(clock)
        block, place = self.buffer[start:stop], _HEADER
        choose = category.choose
        try:
            while place < len(block):
                reader = readers[choose(block, place) if choose else 0]
                place = reader.take(block, place, start)
        except (UndecodableError, IndexError) as err:
            why = str(err) if isinstance(err, UndecodableError) else "a record that is cut off"
            self.skip(start + place, f"category {number:03d}: {why}{_HINTS.get(number, '')}")
        self.n_octets += place
        return start + place

    def decodes(self, start: int, stop: int) -> bool | None:
        """Return whether a data block is one from beginning to end, None where it may become."""
        category = self._categories.get(self.buffer[start])
        if category is None:
            return False
        block, place = self.buffer[start:stop], _HEADER
        try:
            while place < len(block):
                kind = category.choose(block, place) if category.choose else 0
                place = category.layouts[kind].measure(block, place)
        except UndecodableError:
            return False
        except IndexError:
            place = 0
        if place == stop - start:
            return True
        return None if stop > len(self.buffer) else False

    def payload(self, start: int, stop: int, clock: float = 0.0) -> None:
        """Gather the data blocks that a datagram is made of."""
        place, before = start, self._envelope(start, stop)
        while place < stop:
            size = self._block_size(place + before, stop)
            if size == 0:
                break
            self.block(place + before, place + before + size, clock)
            place += before + size
        if place == stop:
            return
        if place == start and self.buffer[start] not in KNOWN_CATEGORIES:
            self.count("datagrams that are no ASTERIX")
        else:
            self.skip(place, "no data block where one should be in a datagram")

    def _envelope(self, start: int, stop: int) -> int:
        """Return how many octets come before each data block of a datagram."""
        if self._block_size(start, stop) or stop - start <= _ENVELOPE:
            return 0
        size = self._block_size(start + _ENVELOPE, stop)
        said = int.from_bytes(self.buffer[start : start + 2], "big")
        return _ENVELOPE if size and said == size + _ENVELOPE else 0

    def _block_size(self, start: int, stop: int) -> int:
        """Return the length of the data block that begins at a place, 0 where none does."""
        if stop - start <= _HEADER:
            return 0
        size = self.buffer[start + 1] << 8 | self.buffer[start + 2]
        return size if _HEADER < size <= stop - start else 0
