"""The report numbers that a tracker has seen."""

from bisect import bisect_right
from typing import Any

import numpy as np

from trackweave.arrays import IntArray

__all__ = ["UsedNumbers"]

MOST_RUNS = 100_000
"""So many runs of numbers are remembered, the greatest: numbers that count up make one run."""


class UsedNumbers:
    """Every number of a tracker's life, as runs without a gap.

    Numbers that count up, whoever counts, are one run however many they are. Where a caller's
    numbers leave gaps, the lowest runs are forgotten beyond so many.
    """

    def __init__(self) -> None:
        self._first: list[int] = []
        self._last: list[int] = []

    def __getstate__(self) -> dict[str, Any]:
        return {"_first": self._first.copy(), "_last": self._last.copy()}

    @property
    def following(self) -> int:
        """One more than the greatest number."""
        return self._last[-1] + 1 if self._last else 0

    def add(self, numbers: IntArray) -> bool:
        """Enter numbers; or enter none and return False if one comes twice or was used."""
        if not numbers.size:
            return True
        ordered = np.sort(numbers)
        steps = np.diff(ordered)
        if steps.min(initial=1) < 1:
            return False
        ends = np.flatnonzero(steps > 1)
        runs = list(
            zip(
                ordered[[0, *(ends + 1)]].tolist(),
                ordered[[*ends, -1]].tolist(),
                strict=True,
            )
        )
        if any(self._meets(first, last) for first, last in runs):
            return False
        for first, last in runs:
            self._enter(first, last)
        return True

    def count_on(self, count: int) -> IntArray:
        """Return so many numbers above all others, and enter them."""
        first = self.following
        if count:
            self._enter(first, first + count - 1)
        return np.arange(first, first + count)

    def _enter(self, first: int, last: int) -> None:
        place = bisect_right(self._first, first)
        if place and self._last[place - 1] == first - 1:
            place -= 1
            self._last[place] = last
        else:
            self._first.insert(place, first)
            self._last.insert(place, last)
        if place + 1 < len(self._first) and self._first[place + 1] == last + 1:
            del self._first[place + 1], self._last[place]
        n_forgotten = len(self._first) - MOST_RUNS
        if n_forgotten > 0:
            del self._first[:n_forgotten], self._last[:n_forgotten]

    def _meets(self, first: int, last: int) -> bool:
        place = bisect_right(self._first, last)
        return place > 0 and self._last[place - 1] >= first
