"""Estimates of one object become one: by hand, against twins, and consistent."""

import numpy as np
import pytest
from scipy.optimize import minimize
from scipy.stats import chi2

from trackweave.errors import InvalidInputError, NumericalError
from trackweave.filters.kalman import predicted, updated
from trackweave.fusion.combine import COMBINATIONS, Combination, SharedPrior, combine

INTERSECTIONS = ("covariance-intersection", "fast-covariance-intersection")
TWO = np.stack([np.diag([1.0, 4.0]), np.diag([4.0, 1.0])])


def matrices(rng: np.random.Generator, count: int, n: int = 4) -> np.ndarray:
    root = rng.normal(size=(count, n, n + 2)) * np.exp(rng.normal(size=(count, 1, 1)))
    return np.asarray(root @ root.swapaxes(1, 2))


def determinant(weight: np.ndarray, information: np.ndarray) -> float:
    return -float(np.linalg.slogdet(np.einsum("s,sij->ij", weight, information))[1])


def trace(weight: np.ndarray, information: np.ndarray) -> float:
    return float(np.log(np.trace(np.linalg.inv(np.einsum("s,sij->ij", weight, information)))))


def test_convex_combination_adds_information() -> None:
    mean, covariance = combine([[0.0, 0.0], [5.0, 5.0]], TWO)
    # Information 1 + 1/4 along the first axis: 5/4 / (5/4) = 1.
    assert mean == pytest.approx([1.0, 4.0])
    assert covariance == pytest.approx(np.diag([0.8, 0.8]))


@pytest.mark.slow
def test_intersection_of_mirrored_covariances_weighs_them_alike() -> None:
    for method in INTERSECTIONS:
        mean, covariance = combine([[0.0, 0.0], [5.0, 5.0]], TWO, method)
        assert mean == pytest.approx([1.0, 4.0])
        assert covariance == pytest.approx(np.diag([1.6, 1.6]))


def test_intersection_takes_the_better_estimate_alone_where_the_other_adds_nothing() -> None:
    mean, covariance = combine(
        [[0.0, 0.0], [5.0, 5.0]], [np.eye(2), 9 * np.eye(2)], INTERSECTIONS[0]
    )
    assert mean == pytest.approx([0.0, 0.0])
    assert covariance == pytest.approx(np.eye(2))


@pytest.mark.parametrize("criterion", ["determinant", "trace"])
@pytest.mark.parametrize("sensors", [2, 3, 6])
def test_weights_are_those_of_a_general_optimiser(criterion: str, sensors: int) -> None:
    rng = np.random.default_rng(sensors)
    value = determinant if criterion == "determinant" else trace
    for _ in range(5):
        information = np.linalg.inv(matrices(rng, sensors))
        weight = Combination(INTERSECTIONS[0], criterion).weights(
            information, np.array([0, sensors])
        )
        twin = minimize(
            value, np.full(sensors, 1 / sensors), args=(information,), method="SLSQP",
            bounds=[(0, 1)] * sensors, options={"ftol": 1e-12},
            constraints={"type": "eq", "fun": lambda weight: weight.sum() - 1},
        )  # fmt: skip
        assert weight.sum() == pytest.approx(1.0)
        assert weight.min() >= 0.0
        assert value(weight, information) <= twin.fun + 1e-6


def test_fast_weights_are_the_closed_form() -> None:
    information = np.linalg.inv(matrices(np.random.default_rng(3), 3))
    weight = Combination(INTERSECTIONS[1]).weights(information, np.array([0, 3]))
    every = information.sum(axis=0)
    det = np.linalg.det
    part = np.array([det(every) - det(every - one) + det(one) for one in information])
    below = 3 * det(every) + sum(det(one) - det(every - one) for one in information)
    assert weight == pytest.approx(part / below)


@pytest.mark.parametrize("method", COMBINATIONS)
def test_many_objects_at_once_are_each_as_alone(method: str) -> None:
    rng = np.random.default_rng(5)
    start = np.array([0, 1, 3, 7])
    covariance, mean = matrices(rng, 7), rng.normal(size=(7, 4))
    prior = alone = None
    if method == "information-matrix":
        spread = 1e4 * np.eye(4)
        prior = SharedPrior(
            np.zeros((3, 4)),
            np.tile(spread, (3, 1, 1)),
            np.zeros((7, 4)),
            np.tile(spread, (7, 1, 1)),
        )
    together = Combination(method)(mean, covariance, start, prior)
    for place in range(3):
        rows = slice(start[place], start[place + 1])
        if prior is not None:
            alone = SharedPrior.common(np.zeros(4), 1e4 * np.eye(4), len(mean[rows]))
        fused = combine(mean[rows], covariance[rows], method, prior=alone)
        assert together[0][place] == pytest.approx(fused[0])
        assert together[1][place] == pytest.approx(fused[1])


@pytest.mark.parametrize("method", COMBINATIONS[:3])
def test_one_estimate_remains_what_it_is(method: str) -> None:
    covariance = matrices(np.random.default_rng(6), 1)
    mean, spread = combine([[1.0, 2.0, 3.0, 4.0]], covariance, method)
    assert mean == pytest.approx([1.0, 2.0, 3.0, 4.0])
    assert spread == pytest.approx(covariance[0])


def test_units_worlds_apart_do_no_harm() -> None:
    covariance = np.stack([np.diag([1e8, 1e-6]), np.diag([4e8, 1e-6])])
    for method in COMBINATIONS[:3]:
        assert np.all(np.linalg.eigvalsh(combine(np.zeros((2, 2)), covariance, method)[1]) > 0)


def test_information_matrix_is_one_filter_with_all_reports() -> None:
    rng = np.random.default_rng(7)
    now = (np.zeros((1, 4)), 100.0 * np.eye(4)[None])
    fused, local = now, [now, now]
    sigma = np.full((1, 2), 3.0)
    for _ in range(5):
        central = predicted(*fused, np.ones(1), 0.5)
        before = [predicted(*estimate, np.ones(1), 0.5) for estimate in local]
        reports = rng.normal(size=(2, 1, 2))
        local = [
            updated(*estimate, report, sigma)
            for estimate, report in zip(before, reports, strict=True)
        ]
        whole = updated(*updated(*central, reports[0], sigma), reports[1], sigma)
        prior = SharedPrior(
            *central, *(np.concatenate([one[part] for one in before]) for part in (0, 1))
        )
        mean, covariance = (np.concatenate([one[part] for one in local]) for part in (0, 1))
        fused = Combination("information-matrix")(mean, covariance, [0, 2], prior)
        assert fused[0] == pytest.approx(whole[0])
        assert fused[1] == pytest.approx(whole[1])


def test_convex_combination_is_consistent_for_independent_errors() -> None:
    rng = np.random.default_rng(8)
    n_objects = 1000
    covariance = matrices(rng, 3 * n_objects)
    error = np.einsum("rij,rj->ri", np.linalg.cholesky(covariance), rng.normal(size=(3000, 4)))
    mean, spread = Combination()(error, covariance, np.arange(0, 3001, 3))
    squared = np.einsum("ri,ri->", mean, np.linalg.solve(spread, mean[..., None])[..., 0])
    low, high = chi2.ppf([0.001, 0.999], 4 * n_objects)
    assert low < squared < high


@pytest.mark.parametrize("method", INTERSECTIONS)
@pytest.mark.parametrize("correlation", [0.0, 0.5, 0.9])
def test_intersection_is_never_over_confident(method: str, correlation: float) -> None:
    rng = np.random.default_rng(9)
    for _ in range(20):
        covariance = matrices(rng, 3)
        root = np.linalg.cholesky(covariance)
        spread = combine(np.zeros((3, 4)), covariance, method)[1]
        information = np.linalg.inv(covariance)
        weight = Combination(method).weights(information, np.array([0, 3]))
        gain = spread @ (weight[:, None, None] * information) @ root
        shared = correlation * np.ones((3, 3)) + (1 - correlation) * np.eye(3)
        true = np.einsum("st,sij,tkj->ik", shared, gain, gain)
        # The true covariance exceeds the reported one in no direction.
        assert np.linalg.eigvalsh(spread - true)[0] > -1e-9 * np.trace(spread)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"method": "average"}, "method: 'average'; expected one of convex, covariance-inter"),
        ({"criterion": "norm"}, "criterion: 'norm'; expected one of determinant, trace"),
    ],
)
def test_refuses_unknown_names(arguments: dict[str, str], message: str) -> None:
    with pytest.raises(InvalidInputError, match=message):
        Combination(**arguments)


@pytest.mark.parametrize(
    ("covariance", "message"),
    [
        (np.stack([np.eye(2), -np.eye(2)]), "estimate 1, covariance: not positive definite"),
        (np.stack([np.eye(2), np.ones((2, 2))]), "estimate 1, covariance: not positive definite"),
        (np.stack([np.tri(2), np.eye(2)]), "estimate 0, covariance: not symmetric"),
        (np.full((2, 2, 2), np.nan), "expected a finite number"),
        (np.eye(2), "estimate, covariance: an array of shape"),
    ],
)
def test_refuses_what_is_no_covariance(covariance: np.ndarray, message: str) -> None:
    with pytest.raises(InvalidInputError, match=message):
        combine(np.zeros((2, 2)), covariance)


@pytest.mark.parametrize("start", [[0, 1], [0, 0, 2], [1, 2], [2]])
def test_refuses_segments_that_do_not_cover_the_rows(start: list[int]) -> None:
    with pytest.raises(InvalidInputError, match=r"start: .*expected rising numbers from 0"):
        Combination()(np.zeros((2, 2)), TWO, start)


def test_refuses_a_prior_that_is_missing_or_not_wanted_or_of_others() -> None:
    prior = SharedPrior.common(np.zeros(2), np.eye(2), 3)
    with pytest.raises(InvalidInputError, match="prior: none; expected a SharedPrior"):
        combine(np.zeros((2, 2)), TWO, "information-matrix")
    with pytest.raises(InvalidInputError, match="prior: given to convex; expected none"):
        combine(np.zeros((2, 2)), TWO, prior=prior)
    with pytest.raises(InvalidInputError, match="prior: 1 objects and 3 local"):
        combine(np.zeros((2, 2)), TWO, "information-matrix", prior=prior)


def test_says_that_a_prior_knows_too_much() -> None:
    prior = SharedPrior.common(np.zeros(2), 0.1 * np.eye(2), 2)
    with pytest.raises(NumericalError, match="prior: it leaves no information"):
        combine(np.zeros((2, 2)), TWO, "information-matrix", prior=prior)
