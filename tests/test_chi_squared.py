"""Sums of squares are distributed as SciPy says, and in a plane without asking it."""

import pytest
from scipy.special import gammainc
from scipy.stats import chi2

from trackweave.chi_squared import poisson_reaches, quantile_of, share_within


@pytest.mark.parametrize("size", [1, 2, 3, 6])
@pytest.mark.parametrize("share", [1e-6, 0.5, 0.9997])
def test_quantiles_are_those_of_chi_squared(size: int, share: float) -> None:
    assert quantile_of(size, share) == pytest.approx(chi2.ppf(share, size), rel=1e-12)


@pytest.mark.parametrize("size", [1, 2, 3, 6])
@pytest.mark.parametrize("square", [0.0, 1e-6, 9.0, 60.0])
def test_shares_are_those_of_chi_squared(size: int, square: float) -> None:
    assert share_within(size, square) == pytest.approx(chi2.cdf(square, size), rel=1e-12)


@pytest.mark.parametrize("number", [1, 2, 40])
def test_a_poisson_number_reaches_another_as_seldom_as_it_should(number: int) -> None:
    assert poisson_reaches(number, 3.5) == pytest.approx(gammainc(number, 3.5), rel=1e-12)
