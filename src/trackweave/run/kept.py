"""What attempts of one run need not find out twice."""

from typing import Any

import numpy as np

__all__ = ["Kept"]


# A run asks for two things, with its reports, without those heard twice, and again in its next
# attempt.
MOST = 8


class Kept:
    """What reports and stretches of them told in the last attempts, and what it depended on.

    First estimates need reports and their noise only. Noise of ranges and azimuths that is told
    counts only afterwards, and what is told of motion only where no noise is: where that alone is
    on trial, nothing has to be followed again.
    """

    def __init__(self) -> None:
        self._entries: list[tuple[tuple[Any, ...], tuple[np.ndarray, ...], Any]] = []

    def known(self, asked: tuple[Any, ...], arrays: tuple[np.ndarray, ...]) -> Any:
        """Return what is known, None where something is asked otherwise than then."""
        for before, values, told in self._entries:
            if before == asked and all(map(np.array_equal, values, arrays)):
                return told
        return None

    def keep(self, asked: tuple[Any, ...], arrays: tuple[np.ndarray, ...], told: Any) -> None:
        """Keep what is known now, beside some of what was before."""
        self._entries = [*self._entries[1 - MOST :], (asked, arrays, told)]
