"""Tests of OSPA."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from oracles import metrics as oracle
from trackweave.errors import InvalidInputError
from trackweave.metrics.gospa import ospa

COORDINATES = st.floats(-100, 100).map(lambda value: round(value, 3))
SETS = st.lists(st.tuples(COORDINATES, COORDINATES), max_size=4)
ORDERS = st.sampled_from([1.0, 2.0, 3.5])


@given(SETS, SETS, st.floats(1, 150), ORDERS)
def test_agrees_with_all_permutations(
    truth: list, tracks: list, cutoff: float, order: float
) -> None:
    expected = oracle.ospa(truth, tracks, cutoff, order)
    assert ospa(truth, tracks, cutoff, order) == pytest.approx(expected, abs=1e-9)


@given(SETS, SETS, SETS, ORDERS)
def test_is_symmetric_bounded_and_keeps_the_triangle_inequality(
    first: list, second: list, third: list, order: float
) -> None:
    direct = ospa(first, third, 30.0, order)
    assert 0 <= direct <= 30.0 + 1e-9
    assert direct == pytest.approx(ospa(third, first, 30.0, order))
    assert direct <= ospa(first, second, 30.0, order) + ospa(second, third, 30.0, order) + 1e-9


def test_an_object_too_many_costs_the_cutoff_shared_by_all() -> None:
    assert ospa([[0, 0]], [[0, 0], [9, 9]], cutoff=10, order=1) == pytest.approx(5.0)
    assert ospa([], [[0, 0]], cutoff=10) == pytest.approx(10.0)
    assert ospa([], [], cutoff=10) == 0.0


def test_refuses_different_dimensions() -> None:
    with pytest.raises(InvalidInputError, match="expected 2"):
        ospa([[0, 0]], [[0, 0, 0]])
