"""Of explanations that fit alike the one is believed that takes the fewest sensors to be wrong."""

import numpy as np
import pytest

from trackweave.estimation.bias_choice import chosen, conditional
from trackweave.estimation.sightings import AZIMUTH, CLOCK, N_BIASES, RANGE

PRIOR = (200.0, 2e-3, 0.01, 1e3, 1e3, 1.0)
SIGMA = (3.0, 1e-4, 1e-4, 10.0, 10.0, 0.02)


def equations(true, seed=0):
    """Normal equations that tell all but what all clocks have in common."""
    rng = np.random.default_rng(seed)
    n_sensors = len(true)
    size = np.tile(SIGMA, n_sensors)
    rows = np.eye(n_sensors * N_BIASES) / size
    clocks = np.arange(n_sensors) * N_BIASES + CLOCK
    rows[clocks] = 0.0
    pairs = [(i, j) for i in range(n_sensors) for j in range(i)]
    between = np.zeros((len(pairs), rows.shape[1]))
    for row, (i, j) in enumerate(pairs):
        between[row, clocks[i]], between[row, clocks[j]] = 1 / SIGMA[CLOCK], -1 / SIGMA[CLOCK]
    rows = np.concatenate([rows, between])
    seen = rows @ np.ravel(true) + rng.normal(size=len(rows))
    return rows.T @ rows, rows.T @ seen


def explained(true, seed=0, may=None):
    matrix, vector = equations(true, seed)
    prior = np.tile(PRIOR, len(true))
    may = np.ones(prior.size, dtype=bool) if may is None else may
    is_free = chosen(matrix, vector, prior, may).is_free
    mean = conditional(matrix, vector, prior, is_free)[0]
    return is_free.reshape(-1, N_BIASES), mean.reshape(-1, N_BIASES)


@pytest.mark.parametrize("seed", range(8))
def test_without_biases_hardly_anything_is_believed(seed):
    assert explained(np.zeros((4, N_BIASES)), seed)[0].sum() <= 1


def test_a_clock_is_wrong_rather_where_more_is_wrong():
    true = np.zeros((4, N_BIASES))
    true[:2, [RANGE, AZIMUTH, CLOCK]] = 100.0, 0.005, 0.5
    is_free, mean = explained(true)
    assert is_free[:2, [RANGE, AZIMUTH, CLOCK]].all()
    assert not is_free[2:].any()
    np.testing.assert_allclose(mean[:2, CLOCK], 0.5, atol=0.1)


def test_a_clock_that_is_off_by_far_is_no_reason_to_doubt_the_others():
    # Shared among all, 10 s would cost less beside a usual second.
    true = np.zeros((3, N_BIASES))
    true[1, CLOCK] = 10.0
    is_free, mean = explained(true)
    assert is_free[:, CLOCK].tolist() == [False, True, False]
    assert mean[1, CLOCK] == pytest.approx(10.0, abs=0.2)


def test_of_two_clocks_that_differ_the_first_is_believed():
    true = np.zeros((2, N_BIASES))
    true[0, CLOCK] = 0.5
    is_free, mean = explained(true)
    assert is_free[:, CLOCK].tolist() == [False, True]
    assert mean[1, CLOCK] == pytest.approx(-0.5, abs=0.1)


def test_of_many_sensors_the_few_that_are_off_are_found():
    true = np.zeros((9, N_BIASES))
    true[[3, 7], AZIMUTH] = 0.005
    true[3, CLOCK] = -0.4
    is_free, mean = explained(true)
    assert is_free[[3, 7], AZIMUTH].all()
    assert is_free.sum() <= 4
    assert mean[3, CLOCK] == pytest.approx(-0.4, abs=0.1)


def test_what_may_not_be_is_not_believed():
    true = np.zeros((3, N_BIASES))
    true[1, RANGE] = 100.0
    may = np.ones(3 * N_BIASES, dtype=bool)
    may[N_BIASES + RANGE] = False
    assert not explained(true, may=may)[0][1, RANGE]
