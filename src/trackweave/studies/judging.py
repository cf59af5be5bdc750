"""Figures with their 95 % intervals, and verdicts that respect them."""

from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from trackweave.arrays import FloatArray

__all__ = ["Interval", "Verdict", "at_least", "at_most", "mean_of", "share_of", "verdict_of"]

CONFIDENCE = 0.95


class Verdict(StrEnum):
    """What a measured figure says of a claim."""

    HOLDS = "holds"
    HOLDS_WITHIN = "holds within the tolerance"
    DOES_NOT_HOLD = "does not hold"
    CANNOT_BE_TOLD = "cannot be told"


@dataclass(frozen=True, slots=True)
class Interval:
    """A figure with its 95 % interval.

    Parameters
    ----------
    value
        The figure; NaN where nothing was measured.
    low, high
        The interval's ends; infinite where one draw tells nothing of the others.
    count
        Number of draws that it rests on.
    unit
        What it is measured in, such as "%".
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
    """Return a mean with its interval by Student's t.

    Parameters
    ----------
    values
        One figure of each independent draw, shape (draws,); NaN where there is none.
    unit
        What they are measured in.

    Returns
    -------
    The mean; its interval is open where fewer than two draws tell of it, or costs are all alike.
    """
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


def share_of(hits: int, count: int) -> Interval:
    """Return a share in per cent with its exact binomial interval.

    Parameters
    ----------
    hits
        In how many draws it was so.
    count
        Of how many independent draws.

    Returns
    -------
    The share [%] with Clopper and Pearson's interval [1]_, which is never too narrow.

    References
    ----------
    .. [1] C. Clopper, E. Pearson, *The use of confidence or fiducial limits*, Biometrika 1934.
    """
    from scipy.special import betaincinv

    if count == 0:
        return Interval(np.nan, 0.0, 100.0, 0, "%")
    tail = (1.0 - CONFIDENCE) / 2
    low = 0.0 if hits == 0 else float(betaincinv(hits, count - hits + 1, tail))
    high = 1.0 if hits == count else float(betaincinv(hits + 1, count - hits, 1.0 - tail))
    return Interval(100.0 * hits / count, 100.0 * low, 100.0 * high, count, "%")


def at_least(found: Interval, threshold: float, tolerance: float = 0.0) -> Verdict:
    """Tell whether a figure is at least a threshold.

    Parameters
    ----------
    found
        The figure.
    threshold
        What it has to reach.
    tolerance
        By how much it may fall short and still hold *within the tolerance*.

    Returns
    -------
    Holds where the whole interval reaches the threshold; within the tolerance where it reaches
    that; does not hold where none of it does; else it cannot be told.
    """
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
