"""Quadratic forms in normal errors, by inverting the characteristic function."""

import math

import numpy as np
from scipy.optimize import brentq
from scipy.special import chdtri


def weighted_threshold(weight: np.ndarray, false_rejection: float) -> float:
    """Return what Σ wᵢ χ²₁, all wᵢ > 0, exceeds with a probability (Imhof 1961, eq. 3.2)."""
    scale = float(weight.max())
    share = weight / scale
    if np.all(share == 1.0):
        return scale * float(chdtri(weight.size, false_rejection))

    def excess(x: float) -> float:
        return _tail(share, x) - false_rejection

    high = float(share.sum() + 1.0)
    while excess(high) > 0.0:
        high *= 2.0
    return scale * float(brentq(excess, 1e-9, high, xtol=1e-9))


def _tail(weight: np.ndarray, x: float) -> float:
    """Return P{Σ wᵢ χ²₁ > x} from Imhof's integral."""
    if weight.size == 2:
        # Imhof's integrand falls off too slowly; around the circle of directions it is smooth.
        turn = np.linspace(0.0, np.pi, 4096, endpoint=False)
        across = weight[0] * np.cos(turn) ** 2 + weight[1] * np.sin(turn) ** 2
        return float(np.exp(-x / (2.0 * across)).mean())
    # Beyond this the integrand is below 1e-9 of its size; fine steps follow its turns.
    last = 1.0
    while np.log1p(weight**2 * last**2).sum() / 4.0 + math.log(last) < 21.0:
        last *= 1.5
    steps = 1 << 15
    # Squares of even steps: dense near zero, where the integrand is large.
    t = np.linspace(0.0, 1.0, steps + 1)[1:]
    u = last * t**3
    angle = 0.5 * np.arctan(weight[:, None] * u).sum(axis=0) - 0.5 * x * u
    size = np.exp(0.25 * np.log1p((weight[:, None] * u) ** 2).sum(axis=0))
    integrand = np.sin(angle) / (u * size) * 3.0 * last * t**2
    return float(0.5 + (integrand.sum() - integrand[-1] / 2.0) / steps / math.pi)
