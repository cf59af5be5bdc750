"""The statistic of tuples of tracks, its thresholds, and how often they are exceeded."""

from itertools import combinations, pairwise

import numpy as np
import pytest
from scipy.stats import chi2

from oracles.quadratic_forms import weighted_threshold
from oracles.track_scenes import contrasts
from trackweave.errors import InvalidInputError
from trackweave.fusion.statistic import Statistic, quantiles, tuple_values

N = 4


def estimates(
    rng: np.random.Generator, n_tuples: int, n_times: int, n_members: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return estimates of one object each, far from the origin, with covariances that turn."""
    root = rng.normal(size=(n_members, N, N)) + 2.0 * np.eye(N)
    error = rng.normal(size=(n_tuples, n_times, n_members, N))
    mean = 1e4 + np.einsum("sij,ktsj->ktsi", root, error)
    covariance = root @ root.swapaxes(1, 2)
    return mean, np.broadcast_to(covariance, (*mean.shape, N))


def apart(mean: np.ndarray, covariance: np.ndarray, a: int, b: int) -> float:
    """Return tᵀ C⁻¹ t of two members."""
    t = mean[a] - mean[b]
    return float(t @ np.linalg.inv(covariance[a] + covariance[b]) @ t)


@pytest.mark.parametrize("kind", ["fused-mean", "chain", "all-pairs"])
def test_the_statistic_is_the_closed_sum_over_times(kind: str) -> None:
    rng = np.random.default_rng(1)
    mean, covariance = estimates(rng, 3, 4, 5)
    expected = np.zeros(3)
    for row in range(3):
        for time in range(4):
            m, p = mean[row, time], covariance[row, time]
            if kind == "fused-mean":
                expected[row] += contrasts(m, p)
            else:
                pairs = pairwise(range(5)) if kind == "chain" else combinations(range(5), 2)
                expected[row] += sum(apart(m, p, a, b) for a, b in pairs)
    found = tuple_values(mean, covariance, Statistic(kind, "full"))
    assert found.value == pytest.approx(expected, rel=1e-6)


def test_one_more_time_adds_its_own_distance() -> None:
    # Eq. (6): λ(k) = λ(k − 1) + tᵀ C⁻¹ t.
    rng = np.random.default_rng(2)
    mean, covariance = estimates(rng, 1, 6, 2)
    document = Statistic("chain", "full")
    sums = [tuple_values(mean[:, :k], covariance[:, :k], document).value[0] for k in range(1, 7)]
    steps = [apart(mean[0, k], covariance[0, k], 0, 1) for k in range(6)]
    assert np.diff(sums) == pytest.approx(steps[1:])
    assert sums[0] == pytest.approx(steps[0])


def test_a_sliding_memory_forgets_and_a_fading_one_fades() -> None:
    rng = np.random.default_rng(3)
    mean, covariance = estimates(rng, 1, 6, 3)
    steps = np.array([contrasts(mean[0, k], covariance[0, k]) for k in range(6)])
    sliding = tuple_values(mean, covariance, Statistic(memory="sliding", length=2))
    assert sliding.value[0] == pytest.approx(steps[-2:].sum(), rel=1e-6)
    fading = tuple_values(mean, covariance, Statistic(memory="fading", factor=0.5))
    assert fading.value[0] == pytest.approx((steps * 0.5 ** np.arange(5, -1, -1)).sum(), rel=1e-6)


def test_inflation_divides_the_statistic_and_leaves_the_threshold() -> None:
    rng = np.random.default_rng(4)
    mean, covariance = estimates(rng, 2, 2, 3)
    plain = tuple_values(mean, covariance, Statistic())
    wide = tuple_values(mean, covariance, Statistic(correlation="inflated", inflation=2.0))
    assert wide.value == pytest.approx(plain.value / 2.0)
    assert wide.threshold == pytest.approx(plain.threshold)


@pytest.mark.parametrize(("n_members", "n_times"), [(2, 1), (3, 2), (8, 5)])
def test_the_threshold_of_the_fused_mean_is_that_of_chi_squared(
    n_members: int, n_times: int
) -> None:
    rng = np.random.default_rng(5)
    found = tuple_values(*estimates(rng, 1, n_times, n_members), Statistic(length=9))
    expected = chi2.isf(0.01, N * n_times * (n_members - 1))
    assert found.threshold[0] == pytest.approx(expected, rel=1e-5)


@pytest.mark.slow
@pytest.mark.parametrize("memory", ["full", "fading"])
@pytest.mark.parametrize("kind", ["fused-mean", "chain", "all-pairs"])
@pytest.mark.parametrize("n_members", [2, 3, 6])
def test_rejects_as_often_as_asked_for(kind: str, memory: str, n_members: int) -> None:
    rng = np.random.default_rng(6)
    mean, covariance = estimates(rng, 20_000, 3, n_members)
    found = tuple_values(mean, covariance, Statistic(kind, memory, false_rejection=0.05))
    assert np.mean(found.value > found.threshold) == pytest.approx(0.05, rel=0.2)


def test_the_chain_against_plain_chi_squared_rejects_too_often() -> None:
    rng = np.random.default_rng(7)
    n_members = 8
    mean = rng.normal(size=(30_000, 1, n_members, N))
    covariance = np.broadcast_to(np.eye(N), (*mean.shape, N))
    found = tuple_values(mean, covariance, Statistic("chain", "full", false_rejection=0.05))
    plain = chi2.isf(0.05, N * (n_members - 1))
    assert np.mean(found.value > plain) > 0.07
    # Equal covariances: the eigenvalues are 1 − cos(π j / M).
    weights = np.repeat(1.0 - np.cos(np.pi * np.arange(1, n_members) / n_members), N)
    exact = weighted_threshold(weights, 0.05)
    assert found.threshold[0] == pytest.approx(exact, rel=2e-3)
    assert np.mean(found.value > exact) == pytest.approx(0.05, rel=0.1)


def test_inverting_the_characteristic_function_gives_known_quantiles() -> None:
    assert weighted_threshold(np.ones(7), 0.01) == pytest.approx(chi2.isf(0.01, 7))
    assert weighted_threshold(np.full(3, 2.5), 0.05) == pytest.approx(2.5 * chi2.isf(0.05, 3))
    # Two weights 2 and 1 twice each: the tail is 2 exp(−x / 4) − exp(−x / 2).
    x = weighted_threshold(np.array([2.0, 2.0, 1.0, 1.0]), 0.02)
    assert 2.0 * np.exp(-x / 4.0) - np.exp(-x / 2.0) == pytest.approx(0.02, rel=1e-6)
    x = weighted_threshold(np.array([3.0, 1.0]), 0.1)
    draws = np.random.default_rng(8).chisquare(1.0, (400_000, 2)) @ [3.0, 1.0]
    assert np.mean(draws > x) == pytest.approx(0.1, rel=0.02)


def test_the_table_of_quantiles_is_of_quarters_of_degrees_of_freedom() -> None:
    table = quantiles(0.01, 8)
    assert table.shape == (33,)
    assert table[17] == pytest.approx(chi2.isf(0.01, 4.25))


def test_a_fading_memory_ends_where_weights_are_nothing() -> None:
    assert Statistic(memory="fading", factor=0.5).n_slots == 10
    assert Statistic(memory="full").n_slots is None
    assert Statistic(memory="sliding", length=3).n_slots == 3


@pytest.mark.parametrize(
    ("parts", "message"),
    [
        ({"kind": "median"}, "kind: 'median'; expected one of"),
        ({"memory": "long"}, "memory: 'long'; expected one of"),
        ({"correlation": "some"}, "correlation: 'some'; expected one of"),
        ({"length": 0}, "length: 0; expected a whole number from 1 to 1000"),
        ({"factor": 1.0}, "factor: 1.0; expected a number between 0 and 1"),
        ({"false_rejection": 0.0}, "false_rejection: 0.0; expected a number between"),
        ({"inflation": 0.0}, "inflation: 0.0; expected a number > 0"),
    ],
)
def test_refuses_what_is_no_statistic(parts: dict[str, object], message: str) -> None:
    with pytest.raises(InvalidInputError, match=message):
        Statistic(**parts)  # type: ignore[arg-type]


def test_refuses_to_reckon_correlation_without_process_noise() -> None:
    mean, covariance = estimates(np.random.default_rng(9), 1, 1, 2)
    with pytest.raises(InvalidInputError, match="correlation: 'both'; expected 'none' or"):
        tuple_values(mean, covariance, Statistic(correlation="both"))
