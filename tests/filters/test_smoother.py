import numpy as np
import pytest

from trackweave.filters.smoother import smooth


def batch_least_squares(time, position, sigma, start, q):
    """Return mean and covariance of all states at once, from the joint Gaussian."""
    mean0, cov0 = start
    dim = position.shape[1]
    size, length = 2 * dim, time.shape[0]
    information = np.zeros((length * size, length * size))
    vector = np.zeros(length * size)
    information[:size, :size] += np.linalg.inv(cov0)
    vector[:size] += np.linalg.inv(cov0) @ mean0
    for k in range(length):
        block = slice(k * size, (k + 1) * size)
        if np.isfinite(position[k, 0]):
            pick = np.eye(dim, size)
            weight = np.diag(sigma[k] ** -2)
            information[block, block] += pick.T @ weight @ pick
            vector[block] += pick.T @ weight @ position[k]
        if k + 1 < length:
            dt = time[k + 1] - time[k]
            step = np.kron(np.array([[1.0, dt], [0.0, 1.0]]), np.eye(dim))
            noise = q * np.kron(np.array([[dt**3 / 3, dt**2 / 2], [dt**2 / 2, dt]]), np.eye(dim))
            weight = np.linalg.inv(noise)
            after = slice((k + 1) * size, (k + 2) * size)
            information[block, block] += step.T @ weight @ step
            information[after, after] += weight
            information[block, after] -= step.T @ weight
            information[after, block] -= weight @ step
    joint = np.linalg.inv(information)
    means = (joint @ vector).reshape(length, size)
    return means, [
        joint[k * size : (k + 1) * size, k * size : (k + 1) * size] for k in range(length)
    ]


@pytest.mark.parametrize("dim", [2, 3])
def test_equals_least_squares_over_all_states(dim):
    rng = np.random.default_rng(dim)
    n_tracks, length = 3, 7
    time = np.cumsum(rng.uniform(0.5, 2.0, (n_tracks, length)), axis=1)
    position = rng.normal(0, 20, (n_tracks, length, dim))
    position[0, 2] = position[1, 0] = position[2, -1] = np.nan
    sigma = rng.uniform(2, 6, position.shape)
    mean0 = rng.normal(0, 5, (n_tracks, 2 * dim))
    cov0 = np.stack([np.diag(rng.uniform(5, 50, 2 * dim)) for _ in range(n_tracks)])
    mean, covariance = smooth(time, position, sigma, (mean0, cov0), 0.3)
    for track in range(n_tracks):
        wanted, spreads = batch_least_squares(
            time[track], position[track], sigma[track], (mean0[track], cov0[track]), 0.3
        )
        np.testing.assert_allclose(mean[track], wanted, rtol=1e-6, atol=1e-6)
        np.testing.assert_allclose(covariance[track], spreads, rtol=1e-6, atol=1e-6)


def test_leaves_its_input_alone():
    start = np.zeros((1, 4)), np.eye(4)[None]
    position = np.ones((1, 3, 2))
    smooth(np.arange(3.0)[None], position, np.ones_like(position), start, 1.0)
    assert np.all(start[0] == 0)
    assert np.all(start[1] == np.eye(4))
    assert np.all(position == 1)
