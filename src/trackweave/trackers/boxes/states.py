"""Tracks as columns: where each is by a Kalman filter, and how probably it is there and seen."""

from dataclasses import dataclass, fields
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from trackweave.arrays import FloatArray, IntArray
from trackweave.trackers.boxes.shapes import turned

__all__ = [
    "MOVED",
    "Tracks",
    "born",
    "columns",
    "likelihoods",
    "mean_extents",
    "predict",
    "surprises",
    "update",
]

# Standard deviations for centre, logarithms of extents and yaw; lengths in mean extents of the
# object. They are where learning starts: variances are scaled by what boxes turn out to do.
ERROR = (0.05, 0.08, 0.1)
CHANGE = (1.0, 0.1, 0.5)  # of rates, within a second
RATE = (2.0, 0.3, 0.5)  # of rates at first [1/s]
STEADY = 2.0  # seconds for which a rate is remembered
ODD = 0.05  # share of boxes that are cut, halved or of two objects at once
ODD_ERROR = 3.0  # their further error, in usual ones

MOVED = ("mean", "rate", "variance", "mixed", "rate_variance")
"""What is predicted of a track, and updated."""


@dataclass
class Tracks:
    """Tracks, an entry of each array a track; parts as in ``shapes``.

    ``visible`` and ``hidden`` are the probabilities to be there and to be where the detector sees
    it or does not; what they lack to 1 is the probability to be gone. ``row`` is the last frame's
    box, -1 where it had none; ``score_sum`` and ``evidence`` are sums over ``hits`` boxes;
    ``ratio`` is the last surprise squared over its variance where the link was sure, else NaN.
    """

    mean: FloatArray
    rate: FloatArray
    variance: FloatArray
    mixed: FloatArray
    rate_variance: FloatArray
    visible: FloatArray
    hidden: FloatArray
    kind: IntArray
    name: IntArray
    hits: FloatArray
    evidence: FloatArray
    score_sum: FloatArray
    last_seen: FloatArray
    row: IntArray
    ratio: FloatArray
    score: FloatArray
    data: NDArray[Any]

    def __len__(self) -> int:
        return len(self.visible)

    def of(self, rows: IntArray) -> Self:
        """Return some of the tracks."""
        return type(self)(*(getattr(self, field.name)[rows] for field in fields(self)))

    def and_also(self, others: Self) -> Self:
        """Return these tracks and others after them."""
        pairs = ((getattr(self, f.name), getattr(others, f.name)) for f in fields(self))
        return type(self)(*map(np.concatenate, pairs))

    def put(self, rows: IntArray, others: Self, names: tuple[str, ...]) -> None:
        """Take over columns of others into some rows, in place."""
        for name in names:
            getattr(self, name)[rows] = getattr(others, name)

    @property
    def present(self) -> FloatArray:
        """The probability to be there, seen or not."""
        return self.visible + self.hidden


def columns(values: tuple[float, float, float], parts: FloatArray) -> FloatArray:
    """Return standard deviations of each part of each row in its units."""
    dim = parts.shape[1] // 2
    place, size, yaw = values
    row = np.array([place] * dim + [size] * dim + [yaw] * (parts.shape[1] - 2 * dim))
    scale = np.ones_like(parts)
    scale[:, :dim] = mean_extents(parts)[:, None]
    return row * scale


def mean_extents(parts: FloatArray) -> FloatArray:
    """Return the geometric mean of each box's extents."""
    dim = parts.shape[1] // 2
    return np.asarray(np.exp(parts[:, dim : 2 * dim].mean(axis=1)))


def born(parts: FloatArray, factor: FloatArray, others: dict[str, NDArray[Any]]) -> Tracks:
    """Return tracks that begin with boxes; ``factor`` scales the variances of boxes."""
    return Tracks(
        mean=parts.copy(),
        rate=np.zeros_like(parts),
        variance=columns(ERROR, parts) ** 2 * factor,
        ratio=np.full_like(parts, np.nan),
        mixed=np.zeros_like(parts),
        rate_variance=columns(RATE, parts) ** 2,
        **others,
    )


def predict(tracks: Tracks, factor: FloatArray, wait: float) -> None:
    """Take tracks to a later time [s] at slowly forgotten rates, in place."""
    density = columns(CHANGE, tracks.mean) ** 2 * factor
    tracks.mean = tracks.mean + wait * tracks.rate
    tracks.variance = (
        tracks.variance + 2 * wait * tracks.mixed + wait**2 * tracks.rate_variance
        + density * wait**3 / 3
    )  # fmt: skip
    tracks.mixed = tracks.mixed + wait * tracks.rate_variance + density * wait**2 / 2
    tracks.rate_variance = tracks.rate_variance + density * wait
    tracks.rate = tracks.rate * np.exp(-wait / STEADY)


def surprises(mean: FloatArray, parts: FloatArray) -> FloatArray:
    """Return how boxes differ from tracks, whose shapes fit; yaw but for half turns."""
    difference = parts - mean
    if parts.shape[-1] % 2:
        difference[..., -1] = turned(difference[..., -1], np.pi)
    return difference


def likelihoods(tracks: Tracks, surprise: FloatArray, error: FloatArray) -> FloatArray:
    """Return the logarithms of densities of usual and of odd boxes, (2, tracks, boxes)."""
    both, square = [], surprise**2
    for share, wider in ((1.0 - ODD, 0.0), (ODD, ODD_ERROR**2)):
        total = tracks.variance + (1.0 + wider) * error
        peak = np.log(share) - 0.5 * np.log(2 * np.pi * total).sum(axis=1)
        far = (square @ (1.0 / total)[:, :, None])[:, :, 0]
        both.append(peak[:, None] - 0.5 * far)
    return np.array(both)


def update(tracks: Tracks, surprise: FloatArray, error: FloatArray) -> None:
    """Take in a box for each track, in place; what looks odd counts less."""
    usual, odd = likelihoods(tracks, surprise[:, None], error)[..., 0]
    share = 1.0 / (1.0 + np.exp(np.clip(usual - odd, -50.0, 50.0)))
    total = tracks.variance + error * (1.0 + ODD_ERROR**2 * share)[:, None]
    gain, rate_gain = tracks.variance / total, tracks.mixed / total
    tracks.mean = tracks.mean + gain * surprise
    tracks.rate = tracks.rate + rate_gain * surprise
    tracks.rate_variance = tracks.rate_variance - rate_gain * tracks.mixed
    tracks.variance = tracks.variance - gain * tracks.variance
    tracks.mixed = tracks.mixed - gain * tracks.mixed
