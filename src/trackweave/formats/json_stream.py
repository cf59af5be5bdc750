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
_BETWEEN = re.compile(rb'(?:[^"{}\[\]]++|"(?:[^"\\]++|\\.)*+")*+', re.DOTALL)
_START = re.compile(rb"[{\[]")


class JsonStream:
    """Cuts bytes into the outermost objects and lists of JSON; what stands between is skipped."""

    def __init__(self) -> None:
        self.skips, self.facts = Skips(), Facts()
        self._kept = bytearray()
        self._begin = 0  # where what is kept begins in the stream
        self._seen = 0  # how much of what is kept was looked at
        self._depth = 0
        self._junk: int | None = None

    def values(self, data: bytes) -> Iterator[tuple[int, Any]]:
        """Yield the values that further bytes complete, and where each begins."""
        self._kept += data
        while self._to_start() and (end := self._end_of_value()) is not None:
            begin = self._begin
            try:
                yield begin, json.loads(bytes(self._kept[:end]))
            except (ValueError, RecursionError):
                self.skips.add(begin, "no JSON")
            self._drop(end)
        if len(self._kept) > LARGEST_VALUE:
            self.skips.add(self._begin, f"a value of more than {LARGEST_VALUE:,} bytes")
            self._drop(len(self._kept))

    def cut(self) -> None:
        """Let the next bytes begin a value, as those of a datagram do."""
        self.rest()

    def rest(self) -> None:
        """Note what is left at the end: a value that does not end."""
        if self._kept:
            self.skips.add(self._begin, "JSON that ends too early")
        elif self._junk is not None:
            self.skips.add(self._junk, "no JSON")
        self._junk = None
        self._drop(len(self._kept))

    def _to_start(self) -> bool:
        """Drop what stands before the first value; tell whether there is one."""
        if self._depth:
            return True
        found = _START.search(self._kept)
        between = bytes(self._kept if found is None else self._kept[: found.start()])
        said = between.lstrip(b" \t\r\n,\x1e\x00")
        if said and self._junk is None:
            self._junk = self._begin + len(between) - len(said)
        self._drop(len(between))
        if found is not None and self._junk is not None:
            self.skips.add(self._junk, "no JSON")
            self._junk = None
        return found is not None

    def _end_of_value(self) -> int | None:
        """Return where the value that is kept ends, None where more bytes are needed."""
        while True:
            found = _BETWEEN.match(self._kept, self._seen)
            assert found is not None
            self._seen = found.end()
            mark = bytes(self._kept[self._seen : self._seen + 1])
            if mark in (b"", b'"'):  # of a text that has not ended yet
                return None
            self._seen += 1
            self._depth += 1 if mark in b"{[" else -1
            if self._depth == 0:
                return self._seen

    def _drop(self, count: int) -> None:
        """Forget what is done with; what follows is outside of any value."""
        del self._kept[:count]
        self._begin += count
        self._seen = self._depth = 0


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
