"""Decoders of formats whose records are lines, and of those read as one document."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping

import numpy as np
import polars as pl

from trackweave.arrays import IntArray
from trackweave.domain.facts import Facts, Skips
from trackweave.errors import DataFormatError
from trackweave.formats.format import HEAD_BYTES

__all__ = ["LONGEST_LINE", "Cells", "Document", "Lines", "most_lines", "rate_of", "table_of"]

LONGEST_LINE = 65_536
"""What is longer is no record [bytes]."""
TOO_LONG = f"a line of more than {LONGEST_LINE:,} bytes"
LARGEST_DOCUMENT = 1 << 30
"""A document is held as a whole [bytes]."""


class Lines(ABC):
    """Cuts bytes that come in any pieces into lines; the last need not end."""

    def __init__(self) -> None:
        self.skips, self.facts = Skips(), Facts()
        self._rest = b""
        self._offset = 0
        self._is_too_long = False

    def feed(self, data: bytes) -> pl.DataFrame | None:
        """Return the reports that further bytes complete, None where there are none."""
        whole, end, rest = data.rpartition(b"\n")
        if not end:
            self._keep(self._rest + rest)
            return None
        block, begin = self._rest + whole + end, self._offset
        self._offset += len(block)
        if self._is_too_long:
            cut = block.index(b"\n") + 1
            block, begin, self._is_too_long = block[cut:], begin + cut, False
        self._rest = b""
        self._keep(rest)
        frames = [self._decoded(*part) for part in self._parts(block, begin)]
        found = [frame for frame in frames if frame is not None]
        return pl.concat(found, how="diagonal_relaxed") if found else None

    def finish(self) -> pl.DataFrame | None:
        """Return what the last line holds, whether or not it ends."""
        return self.cut()

    def cut(self) -> pl.DataFrame | None:
        """Return what a datagram's last line holds: the next datagram begins a line."""
        return self.feed(b"\n") if self._rest or self._is_too_long else None

    def _parts(self, block: bytes, begin: int) -> Iterator[tuple[bytes, int]]:
        """Yield whole lines and where they begin, without those that are too long."""
        if len(block) > LONGEST_LINE:
            ends = np.flatnonzero(np.frombuffer(block, np.uint8) == ord("\n")) + 1
            starts = np.r_[0, ends[:-1]]
            for number in np.flatnonzero(ends - starts > LONGEST_LINE + 1):
                start, end = int(starts[number]), int(ends[number])
                self.skips.add(begin + start, TOO_LONG)
                if start:
                    yield block[:start], begin
                block, begin, starts, ends = block[end:], begin + end, starts - end, ends - end
        if block:
            yield block, begin

    def _keep(self, rest: bytes) -> None:
        """Keep the beginning of a line, unless it is longer than any line can be."""
        if self._is_too_long or len(rest) > LONGEST_LINE:
            if not self._is_too_long:
                self.skips.add(self._offset, TOO_LONG)
            self._offset, self._is_too_long, rest = self._offset + len(rest), True, b""
        self._rest = rest

    @abstractmethod
    def _decoded(self, block: bytes, offset: int) -> pl.DataFrame | None:
        """Return the reports in whole lines, which begin at an offset of the stream."""


class Document(ABC):
    """Keeps all bytes until the end, for what can only be read as a whole."""

    def __init__(self) -> None:
        self.skips, self.facts = Skips(), Facts()
        self._parts: list[bytes] = []
        self._size = 0

    def feed(self, data: bytes) -> pl.DataFrame | None:
        """Keep further bytes."""
        self._size += len(data)
        if self._size > LARGEST_DOCUMENT:
            raise DataFormatError(f"a document of more than {LARGEST_DOCUMENT:,} bytes")
        self._parts.append(bytes(data))
        return None

    def finish(self) -> pl.DataFrame | None:
        """Return the reports in the document."""
        return self._decoded(b"".join(self._parts))

    @abstractmethod
    def _decoded(self, document: bytes) -> pl.DataFrame | None:
        """Return the reports in the whole document."""


class Cells:
    """The cells of lines, and where each line begins.

    Parameters
    ----------
    block
        Whole lines.
    offset
        Where the first begins in the stream [bytes].
    separator
        What stands between cells.
    """

    def __init__(self, block: bytes, offset: int, separator: str) -> None:
        lines = block.split(b"\n")
        lengths = np.fromiter(map(len, lines), np.int64, len(lines)) + 1
        texts = pl.Series(block.decode("utf-8", "replace").split("\n")).str.strip_chars()
        filled = (texts != "").to_numpy()
        self.offsets: IntArray = (offset + np.cumsum(lengths) - lengths)[filled]
        self._cells = texts.filter(filled).str.split(separator)
        self.count: IntArray = self._cells.list.len().to_numpy().astype(np.int64)

    def __len__(self) -> int:
        return len(self.offsets)

    def text(self, place: int) -> pl.Series:
        """Return the cells of a column as text, empty where a line is too short."""
        return self._cells.list.get(place, null_on_oob=True).str.strip_chars().fill_null("")

    def number(self, place: int, within: str = "") -> pl.Series:
        """Return the cells of a column as numbers, null where there is no finite one."""
        # ``within`` are marks that may stand about them.
        text = self.text(place)
        text = text.str.strip_chars(within) if within else text
        numbers = text.cast(pl.Float64, strict=False)
        return numbers.set(~numbers.is_finite(), None)


def table_of(columns: Mapping[str, pl.Series]) -> pl.DataFrame:
    """Return columns as a table."""
    return pl.DataFrame([column.rename(name) for name, column in columns.items()])


def most_lines(head: bytes, is_ours: Callable[[bytes], bool]) -> bool:
    """Tell whether more than half of a file's first lines are what is looked for."""
    pieces = head.split(b"\n")
    whole = pieces[:-1] if len(head) >= HEAD_BYTES else pieces
    lines = [line.strip() for line in whole[:40] if line.strip()][:20]
    return 2 * sum(map(is_ours, lines)) > len(lines)


def rate_of(name: str, told: float | None, usual: float, things: str) -> tuple[float, str]:
    """Return how many frames a second there are, and the beginning of a note on the format."""
    if told is not None:
        return told, f"{name}:"
    otherwise = f"(--from {name}?frame_rate=… tells otherwise)"
    return usual, f"{name}: {usual:g} {things} a second {otherwise};"
