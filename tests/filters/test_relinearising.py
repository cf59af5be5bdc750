"""A far report corrects a state to where the two together are likeliest, not along a tangent."""

import math

import numpy as np
import pytest
from scipy.optimize import least_squares

from trackweave.domain.measurements import MeasurementKind as Kind
from trackweave.filters import _measuring as measuring
from trackweave.filters._kernels import correct
from trackweave.filters._relinearising import relinearise

PLATFORM = np.array([200.0, -300.0, 40.0, 12.0, -7.0, 1.0])
RANGING = [(kind, dim) for kind in (Kind.RANGE_AZIMUTH, Kind.RANGE_AZIMUTH_RATE) for dim in (2,)]
RANGING += [(Kind.RANGE_AZIMUTH_ELEVATION, 3), (Kind.RANGE_AZIMUTH_ELEVATION_RATE, 3)]
SIGMA = {0: 10.0, 1: 1e-3, 2: 1e-3, 3: 1e-3}


def before(dim, interval=90.0, process_noise=30.0):
    """Return an object known well once, and unseen for an interval [s]."""
    place, speed = process_noise * interval**3 / 3.0, process_noise * interval
    both = process_noise * interval**2 / 2.0
    covariance = np.kron(np.array([[place, both], [both, speed]]), np.eye(dim))
    return np.r_[8000.0, 7000.0, 3000.0][:dim].tolist() + [150.0, 130.0, 2.0][:dim], covariance


def measured(kind, dim, state):
    """Return what a sensor without noise measures."""
    width, size = kind.n_components(dim), state.size
    out = np.empty(width), np.empty((width, width)), np.empty((size, width))
    measuring.measure(int(kind), state, np.eye(size) * 1e-12, PLATFORM, dim, False, *out)
    return out[0]


def noise_of(kind, dim):
    width = kind.n_components(dim)
    sigma = [SIGMA[column] for column in range(width)]
    if kind.has_rate:
        sigma[-1] = 1.0
    return np.diag(np.square(sigma))


def corrected(kind, dim, mean, covariance, report, noise):
    """Return the state after a plain correction, and after this one of it."""
    width, size = report.size, mean.size
    foreseen, spread, cross = np.empty(width), np.empty((width, width)), np.empty((size, width))
    measuring.measure(int(kind), mean, covariance, PLATFORM, dim, False, foreseen, spread, cross)
    off, plain = np.empty(width), (np.empty(size), np.empty((size, size)))
    measuring.innovation(int(kind), report, foreseen, off)
    correct(mean, covariance, off, spread + noise, cross, *plain)
    again = plain[0].copy(), plain[1].copy()
    relinearise(int(kind), report, noise, PLATFORM, dim, mean, covariance, *again)
    return plain, again


@pytest.mark.parametrize("degrees", [-35.0, 20.0, 30.0])
@pytest.mark.parametrize(("kind", "dim"), RANGING)
def test_a_far_report_leads_to_where_both_together_are_likeliest(kind, dim, degrees):
    mean, covariance = before(dim)
    mean, noise = np.array(mean), noise_of(kind, dim)
    turned, true = np.radians(degrees), mean.copy()
    rotation = np.array(
        [[math.cos(turned), math.sin(turned)], [-math.sin(turned), math.cos(turned)]]
    )
    true[:2] = PLATFORM[:2] + rotation @ (mean[:2] - PLATFORM[:2])
    report = measured(kind, dim, true)
    (first, _), (found, known) = corrected(kind, dim, mean, covariance, report, noise)
    root, sigma = np.linalg.cholesky(covariance), np.sqrt(np.diag(noise))

    def residuals(state):
        off = np.empty(report.size)
        measuring.innovation(int(kind), report, measured(kind, dim, state), off)
        return np.r_[np.linalg.solve(root, state - mean), off / sigma]

    exact = least_squares(residuals, true, x_scale=np.sqrt(np.diag(covariance)), xtol=1e-14)
    certain = np.linalg.inv(exact.jac.T @ exact.jac)
    assert np.abs(found - exact.x)[:dim].max() < 0.5 * SIGMA[0]
    np.testing.assert_allclose(np.sqrt(np.diag(known)), np.sqrt(np.diag(certain)), rtol=0.05)
    # What the plain correction makes of it is tens of its own standard deviations off.
    assert np.abs(first - exact.x)[:dim].max() > 20.0 * SIGMA[0]


@pytest.mark.parametrize(("kind", "dim"), RANGING)
def test_a_short_correction_stays_to_the_last_bit(kind, dim):
    mean, covariance = before(dim, interval=2.0)
    mean, noise = np.array(mean), noise_of(kind, dim)
    report = measured(kind, dim, mean + np.r_[5.0, -5.0, np.zeros(mean.size - 2)])
    plain, again = corrected(kind, dim, mean, covariance, report, noise)
    np.testing.assert_array_equal(again[0], plain[0])
    np.testing.assert_array_equal(again[1], plain[1])


@pytest.mark.parametrize("kind", [Kind.POSITION, Kind.BEARING, Kind.RANGE_RATE])
def test_without_a_range_nothing_changes(kind):
    mean, covariance = before(2)
    mean, width = np.array(mean), kind.n_components(2)
    again, narrowed = mean + 3000.0, covariance * 0.1
    wanted = again.copy(), narrowed.copy()
    relinearise(
        int(kind), measured(kind, 2, mean), np.eye(width) * 1e-6, PLATFORM, 2, mean, covariance,
        again, narrowed,
    )  # fmt: skip
    np.testing.assert_array_equal(again, wanted[0])
    np.testing.assert_array_equal(narrowed, wanted[1])


@pytest.mark.parametrize(("kind", "dim"), RANGING)
def test_a_correction_past_the_sensor_stays_to_the_last_bit(kind, dim):
    mean, covariance = before(dim)
    mean, noise, near = np.array(mean), noise_of(kind, dim), np.array(mean)
    near[:2] = PLATFORM[:2] + np.r_[-600.0, 300.0]
    near[2:dim] = PLATFORM[2:dim] + 20.0
    plain, again = corrected(kind, dim, mean, covariance, measured(kind, dim, near), noise)
    np.testing.assert_array_equal(again[0], plain[0])
    np.testing.assert_array_equal(again[1], plain[1])
