"""Figures with their 95 % intervals, and verdicts that respect them."""

from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from trackweave.arrays import FloatArray
from trackweave.plotting.panels_of_curves import SpreadCurve
from trackweave.studies.writing import Table, numbers

__all__ = [
    "Interval",
    "Verdict",
    "at_least",
    "at_most",
    "mean_curve",
    "mean_of",
    "share_of",
    "share_where",
    "verdict_of",
]

CONFIDENCE = 0.95


class Verdict(StrEnum):
    """What a measured figure says of a claim."""

    HOLDS = "holds"
    HOLDS_WITHIN = "holds within the tolerance"
    DOES_NOT_HOLD = "does not hold"
    CANNOT_BE_TOLD = "cannot be told"


@dataclass(frozen=True, slots=True)
class Interval:
    """A figure with its 95 % interval, and of how many draws; NaN where nothing was measured.

    Its ends are infinite where one draw tells nothing of the others.
    """

    value: float
    low: float
    high: float
    count: int
    unit: str = ""

    def __str__(self) -> str:
        """Return the figure as a report has it."""
        unit = f" {self.unit}" if self.unit else ""
        if self.count == 0 or np.isnan(self.value):
            return "not measured"
        ends = f"{self.low:.4g} to {self.high:.4g}" if np.isfinite(self.low) else "interval open"
        return f"{self.value:.4g}{unit} ({ends}, n = {self.count})"


def mean_of(values: FloatArray, unit: str = "") -> Interval:
    """Return a mean of independent draws, NaN for none, with its interval by Student's t."""
    # Open where fewer than two draws tell of it, or costs are all alike.
    from scipy.special import stdtrit

    known = values[np.isfinite(values)]
    if known.size == 0:
        return Interval(np.nan, -np.inf, np.inf, 0, unit)
    mean = float(known.mean())
    if known.size == 1:
        return Interval(mean, -np.inf, np.inf, 1, unit)
    if unit == "nats" and np.ptp(known) == 0.0:
        # Draws that are all alike tell of no spread, and a cost has no bound of its own.
        return Interval(mean, -np.inf, np.inf, int(known.size), unit)
    half = float(stdtrit(known.size - 1, 0.5 + CONFIDENCE / 2) * known.std(ddof=1))
    half /= float(np.sqrt(known.size))
    low, high = mean - half, mean + half
    if unit == "%" and known.min() >= 0.0 and known.max() <= 100.0:
        # No mean of shares lies beyond what a share can be.
        low, high = max(low, 0.0), min(high, 100.0)
    return Interval(mean, low, high, int(known.size), unit)


def mean_curve(table: Table, by: str, y: str, x: str | None = None) -> SpreadCurve:
    """Return means with their intervals, a point for each value of a column, or its mean x."""
    points = []
    for (value,), own in table.sort(by, maintain_order=True).group_by(by, maintain_order=True):
        found = mean_of(numbers(own, y))
        spread = found.high - found.value if np.isfinite(found.high) else 0.0
        points.append((value if x is None else numbers(own, x).mean(), found.value, spread))
    return SpreadCurve(*np.array(points, dtype=float).T)


def share_of(hits: int, count: int) -> Interval:
    """Return a share of draws [%] with Clopper and Pearson's interval (1934), never too narrow."""
    from scipy.special import betaincinv

    if count == 0:
        return Interval(np.nan, 0.0, 100.0, 0, "%")
    tail = (1.0 - CONFIDENCE) / 2
    low = 0.0 if hits == 0 else float(betaincinv(hits, count - hits + 1, tail))
    high = 1.0 if hits == count else float(betaincinv(hits + 1, count - hits, 1.0 - tail))
    return Interval(100.0 * hits / count, 100.0 * low, 100.0 * high, count, "%")


def share_where(holds: NDArray[np.bool_]) -> Interval:
    """Return the share of draws [%] of which something holds."""
    return share_of(int(np.count_nonzero(holds)), holds.size)


def at_least(found: Interval, threshold: float, tolerance: float = 0.0) -> Verdict:
    """Tell whether a figure is at least a threshold, perhaps within a tolerance."""
    # It holds where the whole interval reaches the threshold, within the tolerance where it
    # reaches that; it does not hold where none of it does; else it cannot be told.
    if found.low >= threshold:
        return Verdict.HOLDS
    if tolerance > 0.0 and found.low >= threshold - tolerance:
        return Verdict.HOLDS_WITHIN
    if found.high < threshold - tolerance:
        return Verdict.DOES_NOT_HOLD
    return Verdict.CANNOT_BE_TOLD


def at_most(found: Interval, threshold: float, tolerance: float = 0.0) -> Verdict:
    """Tell whether a figure is at most a threshold, as ``at_least`` does of the other side."""
    mirrored = Interval(-found.value, -found.high, -found.low, found.count, found.unit)
    return at_least(mirrored, -threshold, tolerance)


def verdict_of(holds: bool) -> Verdict:
    """Return the verdict of what is certain: counted or proven, not estimated from draws."""
    return Verdict.HOLDS if holds else Verdict.DOES_NOT_HOLD
