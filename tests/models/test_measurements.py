"""Where reports put their objects, against many reports drawn at random."""

import numpy as np
import pytest

from oracles import sensing
from trackweave.domain.measurements import MeasurementKind as Kind
from trackweave.models.measurements import to_position

PLATFORM = np.array([300.0, -200.0, 50.0, 0.0, 0.0, 0.0])
SIGMAS = {2: [20.0, 0.03], 3: [20.0, 0.03, 0.02]}
KINDS = {2: Kind.RANGE_AZIMUTH, 3: Kind.RANGE_AZIMUTH_ELEVATION}


def drawn(dim, true, count=200_000):
    """Return reports of one object, as many as asked for."""
    state = np.concatenate([true, np.zeros(dim)])
    exact = sensing.expected(KINDS[dim], state, PLATFORM, dim)
    rng = np.random.default_rng(1)
    return exact + rng.normal(0.0, SIGMAS[dim], (count, len(exact)))


def placed(kind, measurement, sigma, dim):
    many = np.broadcast_to(sigma, measurement.shape)
    return to_position(kind, measurement, many, np.tile(PLATFORM, (len(measurement), 1)), dim)


@pytest.mark.parametrize(
    "true", [(5000.0, 4000.0), (-3000.0, 100.0), (900.0, -4000.0, 3000.0), (-50.0, 700.0, 2500.0)]
)
def test_places_are_without_bias_and_as_uncertain_as_they_say(true):
    dim = len(true)
    reports = drawn(dim, np.array(true))
    position, covariance = placed(KINDS[dim], reports, SIGMAS[dim], dim)
    off = position - true
    root = np.linalg.cholesky(covariance.mean(axis=0))
    # In units of the spread, the mean of so many is off by 0.002; the bending, by up to 0.06.
    np.testing.assert_allclose(np.linalg.solve(root, off.mean(axis=0)), 0.0, atol=0.012)
    shares = np.linalg.solve(root, np.linalg.solve(root, np.cov(off.T)).T)
    np.testing.assert_allclose(shares, np.eye(dim), atol=0.06)


def test_height_is_not_lengthened_by_what_the_azimuth_is_uncertain():
    report = np.array([[1000.0, 0.3, 1.2]])
    position, _ = placed(KINDS[3], report, [1.0, 0.5, 1e-9], 3)
    assert position[0, 2] == pytest.approx(50.0 + 1000.0 * np.sin(1.2))
    assert np.hypot(*(position[0, :2] - PLATFORM[:2])) == pytest.approx(
        1000.0 * np.cos(1.2) * np.exp(0.125)
    )


@pytest.mark.parametrize("dim", [2, 3])
def test_a_rate_says_nothing_of_the_place(dim):
    reports = drawn(dim, np.full(dim, 3000.0), 5)
    plain = placed(KINDS[dim], reports, SIGMAS[dim], dim)
    rated = placed(
        Kind(KINDS[dim] + 1),
        np.column_stack([reports, np.full(5, 30.0)]),
        [*SIGMAS[dim], 2.0],
        dim,
    )
    for mine, theirs in zip(plain, rated, strict=True):
        np.testing.assert_array_equal(mine, theirs)


@pytest.mark.parametrize("dim", [2, 3])
def test_a_position_is_its_own_place(dim):
    place = np.arange(2.0 * dim).reshape(2, dim)
    sigma = np.arange(1.0, dim + 1)
    position, covariance = placed(Kind.POSITION, place, sigma, dim)
    np.testing.assert_array_equal(position, place)
    np.testing.assert_allclose(covariance, [np.diag(sigma**2)] * 2)
    position[0] = -1.0
    assert place[0, 0] == 0.0


@pytest.mark.parametrize(("kind", "dim"), [(Kind.BEARING, 2), (Kind.RANGE_AZIMUTH, 3)])
def test_some_reports_do_not_tell_a_place(kind, dim):
    width = kind.n_components(dim)
    position, covariance = placed(kind, np.ones((3, width)), np.ones(width), dim)
    assert position.shape == (3, dim)
    assert covariance.shape == (3, dim, dim)
    assert np.isnan(position).all()
    assert np.isnan(covariance).all()
