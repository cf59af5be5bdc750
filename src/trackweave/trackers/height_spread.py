"""Over how much the heights that reports tell are spread."""

import math
from dataclasses import dataclass
from typing import Self

import numpy as np

from trackweave.arrays import FloatArray

__all__ = ["HeightSpread"]

FEWEST, LEAST = 50, 150.0
"""Fewer heights tell not how they are spread; what is spread by less [m] tells nobody apart."""
WIDTH = math.sqrt(2.0 * math.pi * math.e)
"""As wide as so many standard deviations is what is as uncertain and even."""


@dataclass(frozen=True, slots=True)
class HeightSpread:
    """How many heights were told, their mean [m], and the sum of squares about it [m²]."""

    count: int = 0
    mean: float = 0.0
    squares: float = 0.0

    def after(self, height: FloatArray) -> Self:
        """Return the same with further heights [m], NaN for none."""
        told = height[np.isfinite(height)]
        if not told.size:
            return self
        count, mean = self.count + told.size, float(np.mean(told))
        off, share = mean - self.mean, told.size / count
        squares = float(np.sum((told - mean) ** 2)) + off**2 * self.count * share
        return type(self)(count, self.mean + share * off, self.squares + squares)

    def width(self) -> float:
        """Return over how much they are spread [m], 0 where that tells nobody apart."""
        if self.count < FEWEST:
            return 0.0
        deviation = math.sqrt(self.squares / self.count)
        return WIDTH * deviation if deviation >= LEAST else 0.0
