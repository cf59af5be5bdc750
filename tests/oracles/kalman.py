"""The Kalman filter as textbooks write it: matrices, ``@`` and a general inverse."""

import numpy as np


def matrices(interval, process_noise, dim):
    """Return the transition matrix and the process noise of the constant-velocity model."""
    one = np.eye(dim)
    moving = np.block([[one, interval * one], [np.zeros((dim, dim)), one]])
    noise = process_noise * np.block(
        [
            [interval**3 / 3 * one, interval**2 / 2 * one],
            [interval**2 / 2 * one, interval * one],
        ]
    )
    return moving, noise


def predict(mean, covariance, interval, process_noise):
    """Return the state after an interval."""
    moving, noise = matrices(interval, process_noise, mean.shape[0] // 2)
    return moving @ mean, moving @ covariance @ moving.T + noise


def innovation(mean, covariance, sigma):
    """Return the predicted report and its covariance S."""
    dim = mean.shape[0] // 2
    return mean[:dim], covariance[:dim, :dim] + np.diag(np.asarray(sigma) ** 2)


def squared_distance(mean, covariance, position, sigma):
    """Return the squared Mahalanobis distance of a report."""
    expected, spread = innovation(mean, covariance, sigma)
    return (position - expected) @ np.linalg.inv(spread) @ (position - expected)


def log_likelihood(mean, covariance, position, sigma):
    """Return the log density of a report at its place."""
    _, spread = innovation(mean, covariance, sigma)
    distance = squared_distance(mean, covariance, position, sigma)
    return -0.5 * (distance + np.linalg.slogdet(2 * np.pi * spread)[1])


def update(mean, covariance, position, sigma):
    """Return the state after a report, in Joseph's form."""
    size = mean.shape[0]
    observe = np.eye(size)[: size // 2]
    expected, spread = innovation(mean, covariance, sigma)
    gain = covariance @ observe.T @ np.linalg.inv(spread)
    rest = np.eye(size) - gain @ observe
    noise = np.diag(np.asarray(sigma) ** 2)
    return mean + gain @ (position - expected), rest @ covariance @ rest.T + gain @ noise @ gain.T
