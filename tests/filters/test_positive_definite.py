"""Covariances stay positive definite, however far apart noise, speeds and intervals are."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from trackweave.domain.measurements import MeasurementKind as Kind
from trackweave.filters.kalman import predicted, updated
from trackweave.filters.smoother import Readings, filtered, merged, smoothed
from trackweave.models.measurements import to_position
from trackweave.models.motion import (
    ConstantAcceleration,
    ConstantVelocity,
    CoordinatedTurn,
    Imm,
    RandomWalk,
)

NOISE = {
    Kind.POSITION: (1.0, 1.0),
    Kind.RANGE_AZIMUTH: (1.0, 1e-3),
    Kind.RANGE_AZIMUTH_RATE: (1.0, 1e-3, 0.1),
    Kind.BEARING: (1e-3,),
}


def power(least, most):
    """Return powers of ten between two exponents."""
    return st.floats(least, most).map(lambda exponent: 10.0**exponent)


def motions(noise, speed):
    """Return every way to move, of some process noise and greatest speed."""
    turn = CoordinatedTurn(noise, 1e-3, speed, 0.3)
    straight = ConstantVelocity(noise, speed)
    return {
        "cv": straight,
        "ca": ConstantAcceleration(noise, speed, speed / 10.0),
        "ct": turn,
        "wild": CoordinatedTurn(noise, 1e4, speed, 1e3),
        "rw": RandomWalk(noise, speed),
        "imm": Imm((straight, turn), (60.0, 15.0)),
    }


def smallest(covariance):
    """Return the smallest eigenvalue of the correlations; not above 0 where there are none."""
    variance = np.diagonal(covariance, axis1=-2, axis2=-1)
    if not (np.isfinite(covariance).all() and (variance > 0.0).all()):
        return -np.inf
    scale = 1.0 / np.sqrt(variance)
    return np.linalg.eigvalsh(covariance * scale[..., None] * scale[..., None, :]).min()


@pytest.mark.parametrize("name", ["cv", "ca", "ct", "wild", "rw", "imm"])
@given(
    kind=st.sampled_from(list(NOISE)),
    noise=power(-9, 6),
    speed=power(-3, 6),
    sharp=power(-4, 4),
    gaps=st.lists(st.one_of(power(-9, 4), st.just(0.0)), min_size=3, max_size=8),
    unscented=st.booleans(),
)
def test_all_states_of_an_object_are_proper(name, kind, noise, speed, sharp, gaps, unscented):
    rule = motions(noise, speed)[name].rule(2, unscented=unscented)
    length, sigma = len(gaps), sharp * np.array(NOISE[kind])
    if kind is not Kind.POSITION:
        sigma = np.minimum(sigma, 1.0)
    rng = np.random.default_rng(length)
    seen = np.array([2e3, 1.0, 3.0]) if kind.has_range else np.array([1.0, 2e3])
    measurement = seen[: sigma.size] + sigma * rng.normal(size=(length, sigma.size))
    readings = Readings(
        time=np.cumsum(gaps),
        kind=np.full(length, int(kind)),
        width=np.full(length, sigma.size),
        measurement=measurement,
        sigma=np.tile(sigma, (length, 1)),
        platform=np.zeros((length, 6)),
        tail=np.tile([0.1 * (length % 2), 7.0, 0.5], (length, 1)),
    )
    variances = rule.prior.copy()
    variances[:2] = (0.3 * 2e3) ** 2
    start = np.array([1.7e3, 1.1e3, *np.zeros(rule.prior.size - 2)]), np.diag(variances)
    for course in (filtered(readings, start, rule), smoothed(readings, start, rule)):
        assert smallest(course.covariance) > 0.0
        assert smallest(merged(course)[1]) > 0.0


@given(noise=power(-12, 9), speed=power(-3, 8), sigma=power(-6, 6), interval=power(-9, 6))
def test_many_states_at_once_are_proper(noise, speed, sigma, interval):
    covariance = np.diag([sigma**2, sigma**2, speed**2, speed**2])[None]
    mean, report = np.zeros((1, 4)), np.zeros((1, 2))
    for _ in range(6):
        mean, covariance = predicted(mean, covariance, np.array([interval]), noise)
        assert smallest(covariance) > 0.0
        mean, covariance = updated(mean, covariance, report, np.full((1, 2), sigma))


@pytest.mark.parametrize("dim", [2, 3])
@given(distance=power(-3, 9), sigma=power(-9, 6), angle=power(-6, 0), turn=st.floats(0, 6.2))
def test_a_place_by_range_and_angles_is_proper(dim, distance, sigma, angle, turn):
    kind = Kind.RANGE_AZIMUTH if dim == 2 else Kind.RANGE_AZIMUTH_ELEVATION
    measurement = np.array([[distance, turn, 0.4]])[:, :dim]
    noise = np.array([[sigma, angle, angle]])[:, :dim]
    _, covariance = to_position(kind, measurement, noise, np.zeros((1, 6)), dim)
    assert smallest(covariance) > 0.0
