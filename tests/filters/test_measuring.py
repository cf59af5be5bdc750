"""What a state makes of a sensor and a report of a state, against derivatives and samples."""

import numpy as np
import pytest

from oracles import sensing
from trackweave.domain.measurements import MeasurementKind as Kind
from trackweave.filters import _measuring as measuring
from trackweave.filters._kernels import correct

PLATFORM = np.array([200.0, -300.0, 40.0, 12.0, -7.0, 1.0])
FLAT = [Kind.RANGE_AZIMUTH, Kind.RANGE_AZIMUTH_RATE, Kind.BEARING, Kind.RANGE_RATE, Kind.POSITION]
ALL = [(kind, 2) for kind in FLAT] + [(kind, 3) for kind in Kind]


def random_state(dim, rng, size=None):
    """Return a state some kilometres from the sensor, all components correlated."""
    size = 3 * dim + 1 if size is None else size
    scale = np.r_[np.full(dim, 60.0), np.full(size - dim, 8.0)]
    root = rng.normal(size=(size, size + 2)) * scale[:, None]
    mean = rng.normal(size=size) * 15.0
    mean[:dim] += rng.choice([-1.0, 1.0], dim) * rng.uniform(2000.0, 6000.0, dim)
    return mean, root @ root.T


def measure(kind, mean, covariance, dim, unscented, platform=PLATFORM):
    """Return what the kernel writes."""
    width = kind.n_components(dim)
    out = np.full(width, np.nan), np.full((width, width), np.nan)
    cross = np.full((mean.size, width), np.nan)
    measuring.measure(int(kind), mean, covariance, platform, dim, unscented, *out, cross)
    return *out, cross


def assert_scaled(came, wanted, one, other, tolerance):
    """Compare each entry on the scale of its row and its column."""
    assert np.max(np.abs(came - wanted) / np.outer(one, other)) < tolerance


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize(("kind", "dim"), ALL)
def test_the_extended_filter_foresees_by_the_derivatives(kind, dim, seed):
    mean, covariance = random_state(dim, np.random.default_rng(seed))
    came = measure(kind, mean, covariance, dim, False)
    wanted = sensing.by_slopes(kind, mean, covariance, PLATFORM, dim)
    np.testing.assert_allclose(came[0], wanted[0], rtol=1e-12, atol=1e-9)
    own, size = np.sqrt(np.diag(wanted[1])), np.sqrt(np.diag(covariance))
    assert_scaled(came[1], wanted[1], own, own, 1e-5)
    assert_scaled(came[2], wanted[2], size, own, 1e-5)
    np.testing.assert_array_equal(came[1], came[1].T)


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize(("kind", "dim"), [case for case in ALL if case[0] != Kind.POSITION])
def test_the_unscented_filter_foresees_over_sigma_points(kind, dim, seed):
    mean, covariance = random_state(dim, np.random.default_rng(seed))
    came = measure(kind, mean, covariance, dim, True)
    wanted = sensing.by_points(kind, mean, covariance, PLATFORM, dim)
    own, size = np.sqrt(np.diag(wanted[1])), np.sqrt(np.diag(covariance))
    apart = sensing.difference(kind, came[0], wanted[0])
    assert np.max(np.abs(apart) / own) < 1e-9
    assert_scaled(came[1], wanted[1], own, own, 1e-9)
    assert_scaled(came[2], wanted[2], size, own, 1e-9)


@pytest.mark.parametrize("unscented", [False, True])
@pytest.mark.parametrize(("kind", "dim"), ALL)
def test_both_filters_agree_with_many_samples_of_a_distant_object(kind, dim, unscented):
    rng = np.random.default_rng(9)
    mean, covariance = random_state(dim, rng)
    samples = rng.multivariate_normal(mean, covariance, size=4000)
    centre = sensing.expected(kind, mean, PLATFORM, dim)
    seen = np.array(
        [
            sensing.difference(kind, sensing.expected(kind, sample, PLATFORM, dim), centre)
            for sample in samples
        ]
    )
    came = measure(kind, mean, covariance, dim, unscented)
    deviation = seen.std(axis=0)
    wide = np.outer(deviation, deviation)
    np.testing.assert_allclose(came[1] / wide, np.atleast_2d(np.cov(seen.T)) / wide, atol=0.15)


@pytest.mark.parametrize("unscented", [False, True])
@pytest.mark.parametrize(("kind", "dim"), ALL)
@pytest.mark.parametrize("place", ["on", "above", "beside"])
def test_stays_finite_on_top_of_the_sensor(kind, dim, unscented, place):
    mean, covariance = random_state(dim, np.random.default_rng(2))
    mean[:dim] = PLATFORM[:dim]
    if place == "above":
        mean[dim - 1] += 100.0
    elif place == "beside":
        mean[0] += 1e-9
    for spread in (covariance, np.zeros_like(covariance), covariance * 1e-20):
        for part in measure(kind, mean, spread, dim, unscented):
            assert np.all(np.isfinite(part))


@pytest.mark.parametrize("offset", [0.0, 1e-9, 1e-3, 1.0])
@pytest.mark.parametrize("unscented", [False, True])
def test_an_angle_tells_next_to_nothing_from_within_the_uncertainty(offset, unscented):
    covariance = np.diag([100.0, 100.0, 1.0, 1.0])
    mean = np.r_[PLATFORM[:2] + offset, 0.0, 0.0]
    _, spread, cross = measure(Kind.BEARING, mean, covariance, 2, unscented)
    assert spread[0, 0] > 1.0
    # A report from behind moves the object by less than twice its standard deviation.
    assert np.max(np.abs(cross[:2, 0])) / spread[0, 0] * np.pi < 20.0


@pytest.mark.parametrize("unscented", [False, True])
def test_north_is_no_seam(unscented):
    covariance = np.diag([900.0, 900.0, 1.0, 1.0])
    west = np.r_[PLATFORM[:2], 0.0, 0.0] + np.array([-1e-6, 1000.0, 0.0, 0.0])
    east = np.r_[PLATFORM[:2], 0.0, 0.0] + np.array([1e-6, 1000.0, 0.0, 0.0])
    one, other = (measure(Kind.BEARING, m, covariance, 2, unscented) for m in (west, east))
    apart = sensing.difference(Kind.BEARING, one[0], other[0])
    assert abs(apart[0]) < 1e-8
    np.testing.assert_allclose(one[1], other[1], rtol=1e-6)
    np.testing.assert_allclose(one[2], other[2], rtol=1e-6, atol=1e-8)


@pytest.mark.parametrize("dim", [2, 3])
def test_a_position_of_fewer_numbers_takes_the_first_coordinates(dim):
    mean, covariance = random_state(dim, np.random.default_rng(3))
    out = np.empty(2), np.empty((2, 2)), np.empty((mean.size, 2))
    measuring.measure(int(Kind.POSITION), mean, covariance, PLATFORM, dim, False, *out)
    np.testing.assert_array_equal(out[0], mean[:2])
    np.testing.assert_array_equal(out[1], covariance[:2, :2])
    np.testing.assert_array_equal(out[2], covariance[:, :2])


def test_a_flat_world_ignores_the_height_of_the_sensor():
    mean, covariance = random_state(2, np.random.default_rng(4))
    aloft = PLATFORM + np.array([0, 0, 5000.0, 0, 0, 30.0])
    one = measure(Kind.RANGE_AZIMUTH_RATE, mean, covariance, 2, False)
    other = measure(Kind.RANGE_AZIMUTH_RATE, mean, covariance, 2, False, aloft)
    for a, b in zip(one, other, strict=True):
        np.testing.assert_array_equal(a, b)


def test_sigma_points_bear_components_without_variance():
    mean, covariance = random_state(2, np.random.default_rng(5))
    covariance[1, :] = covariance[:, 1] = 0.0
    for part in measure(Kind.RANGE_AZIMUTH_RATE, mean, covariance, 2, True):
        assert np.all(np.isfinite(part))


@pytest.mark.parametrize(
    ("kind", "column"), [(Kind.BEARING, 0), (Kind.RANGE_AZIMUTH, 1), (Kind.RANGE_AZIMUTH_RATE, 1)]
)
@pytest.mark.parametrize(
    ("measured", "foreseen", "apart"),
    [(0.1, 6.2, 0.1 - 6.2 + 2 * np.pi), (6.2, 0.1, 6.1 - 2 * np.pi), (np.pi, 0.0, np.pi),
     (0.0, np.pi, np.pi), (1.0, 1.0, 0.0), (9.0, 1.0, 8.0 - 2 * np.pi)],
)  # fmt: skip
def test_angles_differ_the_short_way_round(kind, column, measured, foreseen, apart):
    width = kind.n_components(2)
    one, other, out = np.full(width, 7.0), np.full(width, -4.0), np.empty(width)
    one[column], other[column] = measured, foreseen
    measuring.innovation(int(kind), one, other, out)
    assert out[column] == pytest.approx(apart)
    assert np.all(np.delete(out, column) == 11.0)


@pytest.mark.parametrize("kind", [Kind.POSITION, Kind.RANGE_RATE])
def test_what_is_no_angle_is_not_wrapped(kind):
    width = kind.n_components(2)
    out = np.empty(width)
    measuring.innovation(int(kind), np.full(width, 50.0), np.zeros(width), out)
    np.testing.assert_array_equal(out, 50.0)


@pytest.mark.parametrize("width", [1, 2, 3, 4])
def test_inverts_as_linear_algebra_does(width):
    rng = np.random.default_rng(width)
    for _ in range(20):
        scale = 10.0 ** rng.uniform(-3, 3, width)
        root = rng.normal(size=(width, width + 2)) * scale[:, None]
        matrix = root @ root.T
        inverse = np.full_like(matrix, np.nan)
        log_determinant = measuring.invert(matrix, inverse)
        unit = scale[:, None] * inverse * scale
        wanted = np.linalg.inv(matrix / np.outer(scale, scale))
        np.testing.assert_allclose(unit, wanted, rtol=1e-7, atol=1e-7 * np.abs(wanted).max())
        assert log_determinant == pytest.approx(np.linalg.slogdet(matrix)[1], abs=1e-7)


@pytest.mark.parametrize("width", [1, 2, 3, 4])
@pytest.mark.parametrize("broken", ["negative", "nan", "zero"])
def test_nothing_fits_a_covariance_that_is_none(width, broken):
    matrix = np.eye(width)
    matrix[-1, -1] = {"negative": -1.0, "nan": np.nan, "zero": 0.0}[broken]
    assert measuring.invert(matrix, np.empty_like(matrix)) == np.inf


@pytest.mark.parametrize(("kind", "dim"), ALL)
def test_corrects_as_the_matrices_do(kind, dim):
    rng = np.random.default_rng(7)
    mean, covariance = random_state(dim, rng)
    width = kind.n_components(dim)
    _, spread, cross = measure(kind, mean, covariance, dim, False)
    spread = spread + np.diag(np.diag(spread) * rng.uniform(0.1, 2.0, width))
    apart = rng.normal(size=width) * np.sqrt(np.diag(spread))
    inverse = np.linalg.inv(spread)
    after, narrow = np.empty_like(mean), np.empty_like(covariance)
    correct(mean, covariance, apart, spread, cross, after, narrow)
    size = np.sqrt(np.diag(covariance))
    wanted = mean + cross @ inverse @ apart
    np.testing.assert_allclose(after / size, wanted / size, rtol=1e-9)
    wanted = covariance - cross @ inverse @ cross.T
    assert_scaled(narrow, wanted, size, size, 1e-9)
    np.testing.assert_array_equal(narrow, narrow.T)


def test_corrects_in_place_as_it_corrects_elsewhere():
    mean, covariance = random_state(3, np.random.default_rng(8))
    _, spread, cross = measure(Kind.RANGE_AZIMUTH_ELEVATION, mean, covariance, 3, True)
    arguments = np.ones(3), spread * 1.5, cross
    elsewhere = np.empty_like(mean), np.empty_like(covariance)
    correct(mean, covariance, *arguments, *elsewhere)
    correct(mean, covariance, *arguments, mean, covariance)
    np.testing.assert_array_equal(mean, elsewhere[0])
    np.testing.assert_array_equal(covariance, elsewhere[1])
