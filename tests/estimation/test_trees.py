"""Few points and SciPy's trees tell the same of who is near whom."""

import numpy as np
import pytest
from numpy.testing import assert_array_equal
from scipy.spatial import cKDTree

from trackweave.estimation.trees import (
    FEW,
    FewPoints,
    all_within,
    n_within,
    pairs_within,
    tree_of,
)


@pytest.mark.parametrize("dim", [1, 2, 3])
@pytest.mark.parametrize("k", [1, 2, 9])
@pytest.mark.parametrize("bound", [np.inf, 0.3])
def test_few_points_find_the_nearest_that_a_tree_finds(dim: int, k: int, bound: float) -> None:
    rng = np.random.default_rng(dim)
    for size in (1, 5, 60):
        points, asked = rng.normal(size=(size, dim)), rng.normal(size=(20, dim))
        distance, index = FewPoints(points).query(asked, k=k, distance_upper_bound=bound)
        expected = cKDTree(points).query(asked, k=k, distance_upper_bound=bound)
        assert_array_equal(distance, expected[0])
        assert_array_equal(index, expected[1])


def test_few_points_count_the_pairs_that_a_tree_counts() -> None:
    rng = np.random.default_rng(0)
    some, others, radii = rng.normal(size=(50, 2)), rng.normal(size=(9, 2)), np.arange(0.0, 4, 0.1)
    expected = cKDTree(some).count_neighbors(cKDTree(others), radii)
    assert_array_equal(pairs_within(FewPoints(some), FewPoints(others), radii), expected)


def test_of_points_at_the_same_distance_the_first_comes_first() -> None:
    points = np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]])
    index = FewPoints(points).query(np.zeros((1, 2)), k=4)[1]
    assert_array_equal(index, [[0, 1, 2, 3]])


@pytest.mark.parametrize("k", [1, 2])
def test_among_no_points_nothing_is_near(k: int) -> None:
    distance, index = FewPoints(np.empty((0, 2))).query(np.zeros((3, 2)), k=k)
    assert np.all(np.isinf(distance))
    assert np.all(index == 0)
    assert distance.shape == index.shape == ((3,) if k == 1 else (3, k))


def test_many_points_and_few_are_counted_together() -> None:
    rng = np.random.default_rng(1)
    many, few = tree_of(rng.normal(size=(FEW + 1, 2))), tree_of(rng.normal(size=(3, 2)))
    assert not isinstance(many, FewPoints)
    assert isinstance(few, FewPoints)
    radii = np.array([0.5, 1.0])
    expected = cKDTree(many.data).count_neighbors(cKDTree(few.data), radii)
    assert_array_equal(pairs_within(many, few, radii), expected)
    assert_array_equal(pairs_within(few, many, radii), expected)


def test_few_points_answer_many_questions_like_few() -> None:
    rng = np.random.default_rng(2)
    points, asked = FewPoints(rng.normal(size=(9, 2))), rng.normal(size=(FEW + 1, 2))
    distance, index = points.query(asked)
    assert_array_equal(distance[:FEW], points.query(asked[:FEW])[0])
    assert_array_equal(index[:FEW], points.query(asked[:FEW])[1])


@pytest.mark.parametrize("n_asked", [20, FEW + 1])
def test_few_points_are_within_a_radius_as_a_tree_says(n_asked: int) -> None:
    rng = np.random.default_rng(3)
    points, asked = rng.normal(size=(60, 2)), rng.normal(size=(n_asked, 2))
    expected = cKDTree(points).query_ball_point(asked, 0.7, return_sorted=True)
    found = all_within(FewPoints(points), asked, 0.7)
    assert [sorted(each.tolist()) for each in found] == expected.tolist()
    assert_array_equal(n_within(FewPoints(points), asked, 0.7), [len(each) for each in expected])
