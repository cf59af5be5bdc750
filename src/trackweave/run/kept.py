"""What attempts of one run need not find out twice."""

from typing import Any

import numpy as np

__all__ = ["Kept"]


class Kept:
    """What the last attempt's stretch told, and what it depended on.

    Noise of ranges and azimuths that is told counts only afterwards: where that alone is on trial,
    nothing has to be followed again.
    """

    def __init__(self) -> None:
        self._asked: tuple[Any, ...] = ()
        self._arrays: tuple[np.ndarray, ...] = ()
        self._told: tuple[Any, Any, Any] | None = None

    def known(
        self, asked: tuple[Any, ...], arrays: tuple[np.ndarray, ...]
    ) -> tuple[Any, Any, Any] | None:
        """Return what is known, None where something is asked otherwise than then."""
        if self._asked != asked or not all(map(np.array_equal, self._arrays, arrays)):
            return None
        return self._told

    def keep(
        self, asked: tuple[Any, ...], arrays: tuple[np.ndarray, ...], told: tuple[Any, Any, Any]
    ) -> None:
        """Keep what is known now in the place of what was."""
        self._asked, self._arrays, self._told = asked, arrays, told
