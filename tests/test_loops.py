"""The loops of kernels against NumPy."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from trackweave._loops import (
    ascending,
    kth_least,
    largest,
    overwrite,
    overwrite_rows,
    total_of,
    with_label,
)

# Few values, so that many are equal.
VALUES = st.lists(st.sampled_from([-np.inf, -2.5, 0.0, 1.0, 7.0, np.inf]), max_size=100)


@given(VALUES)
def test_ascending_is_the_stable_order(values: list[float]) -> None:
    row = np.array(values, dtype=float)
    assert ascending(row).tolist() == np.argsort(row, kind="stable").tolist()


@pytest.mark.parametrize("size", [0, 1, 16, 17, 32, 33, 1000])
def test_ascending_of_whole_numbers_at_the_borders_of_blocks(size: int) -> None:
    row = np.random.default_rng(size).integers(0, 5, size)
    assert ascending(row).tolist() == np.argsort(row, kind="stable").tolist()


@given(VALUES.filter(len), st.data())
def test_the_kth_least_is_where_sorting_puts_it(values: list[float], data: st.DataObject) -> None:
    k = data.draw(st.integers(0, len(values) - 1))
    assert kth_least(np.array(values), k) == sorted(values)[k]


def test_the_kth_least_of_rows_in_order() -> None:
    row = np.arange(10_000.0)
    assert kth_least(row.copy(), 9_000) == kth_least(row[::-1].copy(), 9_000) == 9_000.0


def test_overwriting_copies_values_into_what_is_there() -> None:
    row, matrix = np.zeros(3), np.zeros((2, 3))
    overwrite(row, np.array([1.0, 2.0, 3.0]))
    overwrite_rows(matrix, np.arange(6.0).reshape(2, 3))
    assert row.tolist() == [1.0, 2.0, 3.0]
    assert matrix.tolist() == [[0.0, 1.0, 2.0], [3.0, 4.0, 5.0]]


def test_a_sum_of_nothing_is_nothing() -> None:
    assert total_of(np.empty(0)) == 0.0
    assert total_of(np.array([0.5, 0.25, 4.0])) == 4.75


@given(VALUES.filter(len))
def test_the_largest_is_the_first_of_equals(values: list[float]) -> None:
    assert largest(np.array(values)) == np.argmax(values)


@given(st.lists(st.integers(-1, 3), max_size=20))
def test_with_label_lists_indices_in_order(labels: list[int]) -> None:
    row = np.array(labels, dtype=np.int64)
    assert with_label(row, 1).tolist() == np.flatnonzero(row == 1).tolist()
