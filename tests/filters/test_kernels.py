"""Every kernel of the Kalman filter against its slow, obvious twin."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from oracles import kalman
from trackweave.filters import _kernels as kernels
from trackweave.filters.kalman import predicted, transition

CASES = given(
    dim=st.sampled_from([2, 3]),
    seed=st.integers(0, 10_000),
    interval=st.sampled_from([0.0, 1e-3, 1.0, 12.5, 3600.0]),
    process_noise=st.sampled_from([0.0, 0.05, 30.0]),
)


def random_state(dim, rng):
    """Return a state whose covariance is full: every pair of components is correlated."""
    scale = np.repeat([30.0, 4.0], dim)
    root = rng.normal(size=(2 * dim, 2 * dim + 2)) * scale[:, None]
    return rng.normal(size=2 * dim) * 100.0, root @ root.T


def predict(mean, covariance, interval, process_noise):
    """Return what the kernel writes."""
    mean_out, covariance_out = np.empty_like(mean), np.empty_like(covariance)
    kernels.predict(mean, covariance, interval, process_noise, mean_out, covariance_out)
    return mean_out, covariance_out


def update(mean, covariance, position, sigma):
    """Return what the kernels write, and ln det S."""
    inverse = np.empty((sigma.shape[0], sigma.shape[0]))
    log_determinant = kernels.invert_innovation(covariance, sigma, inverse)
    mean_out, covariance_out = np.empty_like(mean), np.empty_like(covariance)
    noise = np.diag(sigma**2)
    kernels.update(mean, covariance, position, noise, mean_out, covariance_out)
    return mean_out, covariance_out, inverse, log_determinant


@CASES
def test_predicts_as_the_matrices_do(dim, seed, interval, process_noise):
    mean, covariance = random_state(dim, np.random.default_rng(seed))
    expected = kalman.predict(mean, covariance, interval, process_noise)
    for came, wanted in zip(
        predict(mean, covariance, interval, process_noise), expected, strict=True
    ):
        np.testing.assert_allclose(came, wanted, rtol=3e-12, atol=1e-9)


@CASES
def test_predicts_many_rows_as_it_predicts_one(dim, seed, interval, process_noise):
    rng = np.random.default_rng(seed)
    states = [random_state(dim, rng) for _ in range(3)]
    intervals = np.array([0.0, interval, 2 * interval])
    means, covariances = (np.array(column) for column in zip(*states, strict=True))
    ahead, spread = predicted(means, covariances, intervals, process_noise)
    for row in range(3):
        mean, covariance = kalman.predict(*states[row], intervals[row], process_noise)
        np.testing.assert_allclose(ahead[row], mean, rtol=1e-12, atol=1e-9)
        np.testing.assert_allclose(spread[row], covariance, rtol=3e-12, atol=1e-9)
        moving, noise = transition(intervals, process_noise, dim)
        wanted = kalman.matrices(intervals[row], process_noise, dim)
        np.testing.assert_allclose(moving[row], wanted[0])
        np.testing.assert_allclose(noise[row], wanted[1])


@CASES
def test_inverts_measures_and_updates_as_the_matrices_do(dim, seed, interval, process_noise):
    rng = np.random.default_rng(seed)
    mean, covariance = kalman.predict(*random_state(dim, rng), interval, process_noise)
    sigma = rng.uniform(0.5, 60.0, size=dim)
    position = mean[:dim] + rng.normal(size=dim) * 50.0
    mean_out, covariance_out, inverse, log_determinant = update(mean, covariance, position, sigma)
    _, spread = kalman.innovation(mean, covariance, sigma)
    # What is lost in the inverse grows with the condition of S.
    loose = 1e-13 * np.linalg.cond(spread) + 1e-12
    np.testing.assert_allclose(inverse @ spread, np.eye(dim), atol=loose * 10)
    assert log_determinant == pytest.approx(np.linalg.slogdet(spread)[1], abs=loose * 10)
    distance = kernels.squared_distance(position, mean, inverse)
    assert distance == pytest.approx(
        kalman.squared_distance(mean, covariance, position, sigma), rel=loose * 100
    )
    wanted_mean, wanted_covariance = kalman.update(mean, covariance, position, sigma)
    size = np.abs(mean).max() + 1.0
    np.testing.assert_allclose(mean_out, wanted_mean, atol=size * loose * 100)
    np.testing.assert_allclose(
        covariance_out, wanted_covariance, atol=np.abs(covariance).max() * loose * 100
    )


@pytest.mark.parametrize("dim", [2, 3])
def test_an_interval_of_zero_changes_nothing(dim):
    mean, covariance = random_state(dim, np.random.default_rng(1))
    came = predict(mean, covariance, 0.0, 5.0)
    np.testing.assert_array_equal(came[0], mean)
    np.testing.assert_array_equal(came[1], covariance)


@pytest.mark.parametrize("dim", [2, 3])
def test_the_covariance_after_an_update_is_symmetric_to_the_last_bit(dim):
    rng = np.random.default_rng(2)
    mean, covariance = random_state(dim, rng)
    _, after, _, _ = update(mean, covariance, rng.normal(size=dim), np.full(dim, 3.0))
    np.testing.assert_array_equal(after, after.T)


@pytest.mark.parametrize("dim", [2, 3])
def test_stays_positive_definite_over_thousands_of_precise_reports(dim):
    rng = np.random.default_rng(3)
    mean, covariance = np.zeros(2 * dim), np.diag(np.repeat([1e4, 400.0], dim))
    sigma = np.full(dim, 0.01)
    for _ in range(2000):
        mean, covariance = predict(mean, covariance, 1.0, 1e-4)
        mean, covariance, _, _ = update(mean, covariance, rng.normal(size=dim) * 0.01, sigma)
    assert np.linalg.eigvalsh(covariance).min() > 0.0


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("broken", ["negative", "nan", "singular"])
def test_no_report_fits_a_covariance_that_is_none(dim, broken):
    covariance = np.eye(2 * dim)
    if broken == "negative":
        covariance[0, 0] = -5.0
    elif broken == "nan":
        covariance[0, 1] = covariance[1, 0] = np.nan
    else:
        covariance[0, 1] = covariance[1, 0] = 2.0
    inverse = np.full((dim, dim), np.nan)
    assert kernels.invert_innovation(covariance, np.full(dim, 0.1), inverse) == np.inf
