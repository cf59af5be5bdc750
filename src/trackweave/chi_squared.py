"""Sums of squares of normal numbers, without waiting for SciPy where a formula says it.

Of two numbers, the usual case in a plane, half the sum has an exponential distribution.
"""

import math

__all__ = ["poisson_reaches", "quantile_of", "share_within"]


def quantile_of(size: int, share: float) -> float:
    """Return the sum of squares that a share of all such sums does not exceed.

    Parameters
    ----------
    size
        How many numbers, at least 1.
    share
        Above 0 and below 1.

    Returns
    -------
    The quantile of χ², in the numbers' own variance.
    """
    if size == 2:
        return -2.0 * math.log1p(-share)
    # SciPy takes longer to import than a short run takes; scipy.stats longer than all the rest.
    from scipy.special import gammaincinv

    return 2.0 * float(gammaincinv(size / 2.0, share))


def share_within(size: int, square: float) -> float:
    """Return how large a share of all such sums of squares stays below one.

    Parameters
    ----------
    size
        How many numbers, at least 1.
    square
        The sum of squares, in the numbers' own variance, at least 0.

    Returns
    -------
    The distribution function of χ².
    """
    if size == 2:
        return -math.expm1(-square / 2.0)
    from scipy.special import chdtr

    return float(chdtr(size, square))


def poisson_reaches(number: int, mean: float) -> float:
    """Return the probability that a Poisson number is as great as one, or greater.

    Parameters
    ----------
    number
        At least 1.
    mean
        The Poisson number's mean, above 0.

    Returns
    -------
    The probability.
    """
    return share_within(2 * number, 2.0 * mean)
