"""What a worker keeps of the values that tasks have in common, known on both sides."""

from collections.abc import Sequence
from typing import Any

__all__ = ["Entry", "Place", "Shelf"]

KEPT = 32
"""So many values at most, those that were asked for last."""

Entry = tuple[int, bool, Any]
"""A value's number, whether it is new to the worker, and if so itself."""


class Place(int):
    """Stands among arguments for one of the values sent beside them."""

    __slots__ = ()


class Shelf:
    """Values by numbers: what the caller's holds is what the worker's holds."""

    def __init__(self) -> None:
        self._held: dict[int, Any] = {}
        self._next = 0

    def sent(self, values: Sequence[Any]) -> list[Entry]:
        """Return the entries that tell the worker these values, and note that it has them."""
        entries = []
        for value in values:
            found = [number for number, held in self._held.items() if held is value]
            number = found[0] if found else self._next
            self._next += not found
            self._put(number, value)
            entries.append((number, not found, None if found else value))
        return entries

    def received(self, entries: Sequence[Entry]) -> list[Any]:
        """Return the values that entries tell of."""
        for number, is_new, value in entries:
            self._put(number, value if is_new else self._held[number])
        return [self._held[number] for number, _, _ in entries]

    def _put(self, number: int, value: Any) -> None:
        self._held.pop(number, None)
        self._held[number] = value
        while len(self._held) > KEPT:
            del self._held[next(iter(self._held))]
