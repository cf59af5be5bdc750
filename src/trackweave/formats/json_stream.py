"""JSON values one after the other, in pieces split anywhere."""

import json
import math
import re
from collections.abc import Iterator
from typing import Any

from trackweave.domain.facts import Facts, Skips

__all__ = ["JsonStream", "finite", "text_of"]

LARGEST_VALUE = 1 << 26
"""What is longer is no value [bytes]: a snapshot of all aircraft of the world has 10 MB."""
# A raw line feed ends a text, which cannot hold one: of a text without its end no more is lost.
_BETWEEN = re.compile(rb'(?:[^"{}\[\]]++|"(?:[^"\\\n]++|\\[^\n])*+")*+')
_LINE = re.compile(rb"[^\n]*\n|[^\n]+")
_START = re.compile(rb"[{\[]")
_BLANK = b" \t\r\n"
_OF = {ord("}"): ord("{"), ord("]"): ord("[")}
_BEFORE = {ord("{"): b":", ord("["): b",["}
"""What stands before a bracket that opens inside of an object, or of a list."""


class JsonStream:
    """Cuts bytes into the outermost objects and lists of JSON; what stands between is skipped.

    A value in which brackets or texts are not as they can be has lost something: it is given up
    at the next line that has a bracket, which then begins another.
    """

    by_line = False
    """Whether values are lines: what opens at a line's very beginning is another value, and each
    line of what is given up counts."""

    def __init__(self) -> None:
        self.skips, self.facts = Skips(), Facts()
        self._kept = bytearray()
        self._begin = 0  # where what is kept begins in the stream
        self._seen = 0  # how much of what is kept was looked at
        self._open = bytearray()  # the brackets that are
        self._is_wrong = False  # that what is kept is no value
        self._is_over = False  # and that its line has ended
        self._junk: int | None = None  # where on its line what is no value begins
        self._is_told = False  # that what goes before on its line is none either

    def values(self, data: bytes) -> Iterator[tuple[int, Any]]:
        """Yield the values that further bytes complete, and where each begins."""
        self._kept += data
        while self._to_start() and (end := self._end_of_value()) is not None:
            begin = self._begin
            value = self._value(end)
            self._drop(end)
            if value is not None:
                yield begin, value
        if len(self._kept) > LARGEST_VALUE:
            self._skip(len(self._kept), f"a value of more than {LARGEST_VALUE:,} bytes")

    def cut(self) -> None:
        """Let the next bytes begin a value, as those of a datagram do."""
        self.rest()

    def rest(self) -> None:
        """Note what is left at the end: a value that does not end."""
        if self._kept:
            self._skip(len(self._kept), "JSON that ends too early")
        self._end_of_line()

    def _value(self, end: int) -> Any:
        """Return the value that ends there, None where it is none."""
        try:
            value = json.loads(bytes(self._kept[:end]))
        except (ValueError, RecursionError):
            self._note(end, "no JSON")
            return None
        self._is_told = False
        return value

    def _to_start(self) -> bool:
        """Drop what stands before the first value; tell whether there is one."""
        if self._open:
            return True
        found = _START.search(self._kept)
        end = len(self._kept) if found is None else found.start()
        for line in _LINE.findall(bytes(self._kept[:end])):
            said = line.lstrip(b" \t\r\n,\x1e\x00")
            if said and self._junk is None:
                self._junk = self._begin + len(line) - len(said)
            self._drop(len(line))
            if line.endswith(b"\n"):
                self._end_of_line()
        if found is not None and self._junk is not None:
            self._end_of_line()
            self._is_told = True
        return found is not None

    def _end_of_line(self) -> None:
        """Note what stood on a line and was no value, once."""
        if self._junk is not None and not self._is_told:
            self.skips.add(self._junk, "no JSON")
        self._junk, self._is_told = None, False

    def _end_of_value(self) -> int | None:
        """Return where the next value that is whole ends, None where more bytes are needed."""
        while self._to_start():
            found = _BETWEEN.match(self._kept, self._seen)
            assert found is not None
            self._look(found.start(), found.end())
            self._seen = seen = found.end()
            if seen == len(self._kept):
                return None
            if self._kept[seen] == ord('"'):  # of a text that has not ended yet, or cannot
                feed = self._kept.find(b"\n", seen)
                if feed < 0:
                    return None
                self._seen, self._is_wrong = feed, True
            elif self._is_another(seen):
                self._skip(self._kept.rfind(b"\n", 0, seen) + 1, "no JSON")
            elif self._takes(seen):
                return self._seen
        return None

    def _look(self, start: int, place: int) -> None:
        """Look at what stands before a bracket: whether that may be, and whether lines end."""
        if place and not self._is_wrong and self._kept.startswith((b"{", b"["), place):
            start = place - 1
            while self._kept[start] in _BLANK:
                start -= 1
            self._is_wrong = self._kept[start] not in _BEFORE[self._open[-1]]
        self._is_over |= self._is_wrong and self._kept.find(b"\n", start, place) >= 0

    def _is_another(self, place: int) -> bool:
        """Tell whether a bracket on a later line begins another value."""
        is_first = self.by_line and place > 0 and self._kept[place - 1] == ord("\n")
        return self._is_over or (is_first and self._kept[place] not in _OF)

    def _takes(self, place: int) -> bool:
        """Take a bracket into the value; tell whether it is its last."""
        mark = self._kept[place]
        self._seen = place + 1
        if mark not in _OF:
            self._open.append(mark)
            return False
        self._is_wrong |= self._open.pop() != _OF[mark]
        return not self._open

    def _skip(self, count: int, what: str) -> None:
        """Give up so much of what is kept."""
        self._note(count, what)
        self._drop(count)

    def _note(self, count: int, what: str) -> None:
        """Tell of what is kept up to there, a line each where values are lines."""
        lost, offset = bytes(self._kept[:count]), self._begin
        for line in _LINE.findall(lost) if self.by_line else [lost]:
            if line.strip():
                self.skips.add(offset, what)
            offset += len(line)
        self._is_told = not lost.endswith(b"\n")

    def _drop(self, count: int) -> None:
        """Forget what is done with; what follows is outside of any value."""
        del self._kept[:count]
        self._begin += count
        self._seen, self._is_wrong, self._is_over = 0, False, False
        self._open.clear()


def finite(value: Any, low: float = -1e300, high: float = 1e300) -> float | None:
    """Return a value as a number within limits, None where it is none."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return None
    return float(value) if low <= value <= high and math.isfinite(value) else None


def text_of(value: Any, longest: int = 64) -> str | None:
    """Return a value as short text that can be encoded, None where it is none or empty."""
    if not isinstance(value, str):
        return None
    return value.strip()[:longest].encode("utf-8", "replace").decode("utf-8") or None
