"""The simplex search ends where SciPy's ends."""

import math

import numpy as np
import pytest
from numpy.testing import assert_array_equal
from scipy.optimize import minimize

from trackweave.arrays import FloatArray
from trackweave.estimation.simplex import least_by_simplex


@pytest.mark.parametrize("dim", [1, 2, 3])
@pytest.mark.parametrize("rounds", [2, 30, 200])
def test_a_search_ends_in_the_very_corner_of_scipys(dim: int, rounds: int) -> None:
    rng = np.random.default_rng(dim)
    for _ in range(20):
        middle = rng.normal(0.0, 3.0, dim)

        def wavy(place: FloatArray, middle: FloatArray = middle) -> float:
            if np.abs(place).max() > 20.0:
                return math.inf
            return float(np.sum(10.0 * (place - middle) ** 2 + 8.0 * np.sin(3.0 * place)))

        start = np.append(rng.normal(0.0, 2.0, dim - 1), 0.0)
        options = {"maxiter": rounds, "fatol": 1e-3}
        expected = minimize(wavy, start, method="Nelder-Mead", options=options).x
        assert_array_equal(least_by_simplex(wavy, start, rounds=rounds, within=1e-3), expected)
