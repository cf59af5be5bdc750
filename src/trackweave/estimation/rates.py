"""Noise of range rates, and whether they are how fast ranges change."""

from dataclasses import dataclass

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from trackweave.arrays import FloatArray
from trackweave.chi_squared import quantile_of
from trackweave.estimation.estimates import bounded
from trackweave.estimation.neighbours import beside_neighbours

__all__ = ["RateNoise", "rate_noise"]

# Over so many reports in turn an object's range changes by what their rates say on average.
SPAN = 7
FEWEST = 30
# Rates are doubted that lie so many times farther off than both noises together explain.
DOUBTED = 2.5
# Ranges tell by how much they change where that is so many times its noise.
CLEAR = 3.0
LEAST = 1e-3
# Rates fold where so many are off by multiples of what they all fill, but for noise and for this
# share of it, and so many by one at least.
MOST, FOLDED, NEAR_FOLD = 0.8, 0.1, 0.05
# What the factor means between rates and the change of ranges, within this share of it.
NEAR = 0.1
MEANT = {
    -1.0: "they count what comes nearer as positive",
    3.6: "they look like km/h",
    1.944: "they look like knots",
    2.237: "they look like miles per hour",
    3.281: "they look like feet per second",
}


@dataclass(frozen=True, slots=True)
class RateNoise:
    """What the reports of sure tracks tell of a sensor's range rates."""

    sigma: float  # Standard deviation [m/s]
    doubt: str = ""  # In what they contradict ranges, a clause; empty where they do not


def rate_noise(
    tracks: list[tuple[FloatArray, FloatArray, FloatArray]], sigma_range: float
) -> RateNoise | None:
    """Return the noise of range rates along tracks, None where these are too few."""
    # Of each track times, ranges and rates, by ascending time; ``sigma_range`` is the noise of
    # the ranges [m]. An object's rate changes little from report to report whatever the ranges
    # are, so that rates beside the curve through their neighbours tell their noise alone.
    tracks = [track for track in tracks if track[0].size >= SPAN]
    if sum(time.size for time, _, _ in tracks) < FEWEST:
        return None
    rates = np.concatenate([rate for _, _, rate in tracks])
    off = np.concatenate([beside_neighbours(time, rate[:, None])[1] for time, _, rate in tracks])
    if off.size == 0:
        return None
    sigma = max(_spread(off), LEAST)
    change, mean, spread, single = (
        np.concatenate(parts) for parts in zip(*map(_compared, tracks), strict=True)
    )
    noise = np.hypot(sigma_range * spread, sigma / np.sqrt(SPAN))
    beside = single - change
    doubt = _folded(beside, np.hypot(sigma_range * spread, sigma), rates)
    if not doubt and _spread((mean - change) / noise) <= DOUBTED:
        return RateNoise(bounded(sigma, LEAST))
    is_clear = np.abs(change) > CLEAR * noise
    # The usual one says nothing where a half are right and the others far off.
    wide = max(float(np.sqrt(np.mean(beside**2))), sigma)
    return RateNoise(bounded(wide, LEAST), doubt or _doubt(change[is_clear], mean[is_clear]))


def _folded(beside: FloatArray, noise: FloatArray, rates: FloatArray) -> str:
    """Return that rates lie off how ranges change by what they all fill, empty if they do not."""
    width = float(np.ptp(rates))
    turns = np.round(beside / max(width, LEAST))
    near = np.abs(beside - turns * width) < CLEAR * noise + NEAR_FOLD * width
    if np.mean(near) < MOST or np.mean(near & (turns != 0)) < FOLDED:
        return ""
    return (
        f"fold: they lie off how its ranges change by multiples of {width:.3g} m/s, which is what "
        f"all of them fill, from {rates.min():.3g} to {rates.max():.3g}"
    )


def _spread(off: FloatArray) -> float:
    """Return a standard deviation that wild values hardly move."""
    return float(np.median(np.abs(off)) / np.sqrt(quantile_of(1, 0.5)))


def _compared(
    track: tuple[FloatArray, FloatArray, FloatArray],
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return by how much ranges change, by how much rates say so, and how noise counts."""
    # For so many reports in turn: the slope of ranges, the mean of rates, the noise of the slope
    # as a share of that of one range, and the rate in the middle.
    time, distance, rate = (sliding_window_view(each, SPAN) for each in track)
    centred = time - time.mean(axis=1, keepdims=True)
    total = np.sum(centred**2, axis=1)
    slope = np.sum(centred * distance, axis=1) / total
    return slope, rate.mean(axis=1), 1.0 / np.sqrt(total), rate[:, SPAN // 2]


def _doubt(change: FloatArray, mean: FloatArray) -> str:
    """Return in what rates contradict ranges."""
    if change.size < FEWEST:
        return "do not go with how its ranges change"
    factor = float(np.median(mean / change))
    if abs(factor - 1.0) < NEAR:
        return "scatter far more about how its ranges change than beside one another"
    off, value = min((abs(factor / value - 1.0), value) for value in MEANT)
    meant = f" ({MEANT[value]})" if off < NEAR else ""
    return f"are {factor:.2g} times what its ranges change in a second{meant}"
