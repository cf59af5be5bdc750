"""How surprising chains of reports are to a Kalman filter. Nothing here checks or raises."""

import math

import numpy as np
from numpy.typing import NDArray

from trackweave.arrays import FloatArray
from trackweave.jit import jit

WRONG = 0.05
"""Share of a chain's reports that may come from elsewhere."""


@jit
def follow_chains(
    step: FloatArray,
    places: FloatArray,
    scale: FloatArray,
    variance: float,
    process: float,
    elsewhere: float,
    limit: float,
    counted: NDArray[np.bool_],
) -> tuple[float, float, float]:
    """Run a filter of nearly constant velocity along each chain.

    A report came from its object or, as likely as ``elsewhere`` says (a share times a density),
    from somewhere else; then it must not pull the filter along. A chain ends at the first step
    that is NaN. Noise has the ``variance`` times the square of each report's ``scale``. Returns
    minus the log-likelihood of all chains, by how much those of the ``counted`` reports that are
    beyond a squared distance of ``limit`` are trusted, and by how much all reports are.
    """
    dim = places.shape[2]
    position, velocity = np.empty(dim), np.empty(dim)
    surprise, far, trusted = 0.0, 0.0, 0.0
    log_elsewhere = math.log(elsewhere)
    log_own = math.log1p(-WRONG)
    for chain in range(places.shape[0]):
        interval = step[chain, 0]
        for axis in range(dim):
            position[axis] = places[chain, 1, axis]
            velocity[axis] = (places[chain, 1, axis] - places[chain, 0, axis]) / interval
        # Two reports determine position and velocity exactly, with this covariance.
        before, now = scale[chain, 0] ** 2 * variance, scale[chain, 1] ** 2 * variance
        pp, pv = now, now / interval
        vv = (before + now) / interval**2 + process * interval / 3.0
        for scan in range(2, places.shape[1]):
            interval = step[chain, scan - 1]
            if not math.isfinite(interval):
                break
            pp += 2.0 * interval * pv + interval**2 * vv + process * interval**3 / 3.0
            pv += interval * vv + process * interval**2 / 2.0
            vv += process * interval
            spread, square = pp + scale[chain, scan] ** 2 * variance, 0.0
            for axis in range(dim):
                position[axis] += velocity[axis] * interval
                square += (places[chain, scan, axis] - position[axis]) ** 2 / spread
            own = log_own - 0.5 * square - 0.5 * dim * math.log(2.0 * math.pi * spread)
            most, least = max(own, log_elsewhere), min(own, log_elsewhere)
            either = most + math.log1p(math.exp(least - most))
            trust = math.exp(own - either)
            surprise -= either
            trusted += trust
            far += trust if square > limit and counted[chain, scan] else 0.0
            gain_p, gain_v = trust * pp / spread, trust * pv / spread
            for axis in range(dim):
                off = places[chain, scan, axis] - position[axis]
                position[axis] += gain_p * off
                velocity[axis] += gain_v * off
            vv -= gain_v * pv
            pp *= 1.0 - gain_p
            pv *= 1.0 - gain_p
    return surprise, far, trusted
