"""Tests of GOSPA."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from oracles import metrics as oracle
from trackweave.errors import InvalidInputError
from trackweave.metrics.gospa import gospa

COORDINATES = st.floats(-100, 100).map(lambda value: round(value, 3))
SETS = st.lists(st.tuples(COORDINATES, COORDINATES), max_size=4)
ORDERS = st.sampled_from([1.0, 2.0, 3.5])


@given(SETS, SETS, st.floats(1, 150), ORDERS)
def test_agrees_with_all_partial_assignments(
    truth: list, tracks: list, cutoff: float, order: float
) -> None:
    expected = oracle.gospa(truth, tracks, cutoff, order)
    assert gospa(truth, tracks, cutoff, order).total == pytest.approx(expected, abs=1e-9)


@given(SETS, SETS, SETS, ORDERS)
def test_is_symmetric_and_keeps_the_triangle_inequality(
    first: list, second: list, third: list, order: float
) -> None:
    direct = gospa(first, third, 30.0, order).total
    assert direct == pytest.approx(gospa(third, first, 30.0, order).total)
    round_about = gospa(first, second, 30.0, order).total + gospa(second, third, 30.0, order).total
    assert direct <= round_about + 1e-9


@given(SETS, SETS, ORDERS)
def test_parts_add_up_in_the_power_of_the_order(truth: list, tracks: list, order: float) -> None:
    found = gospa(truth, tracks, 40.0, order)
    parts = found.localisation**order + found.missed**order + found.false**order
    assert found.total**order == pytest.approx(parts, abs=1e-6)
    assert found.missed**order == pytest.approx(40.0**order / 2 * found.n_missed, abs=1e-6)
    assert found.false**order == pytest.approx(40.0**order / 2 * found.n_false, abs=1e-6)


@given(SETS)
def test_is_zero_for_equal_sets_in_any_order(places: list) -> None:
    assert gospa(places, places[::-1], 40.0, 2.0).total == 0.0


def test_values_computed_by_hand() -> None:
    found = gospa([[0, 0], [100, 0]], [[3, 4]], cutoff=50, order=2)
    assert found.total == pytest.approx(np.sqrt(25 + 1250))
    assert found.localisation == pytest.approx(5.0)
    assert (found.n_missed, found.n_false, found.false) == (1, 0, 0.0)


def test_a_pair_at_the_cutoff_is_a_miss_and_a_false_track() -> None:
    found = gospa([[0.0, 0.0]], [[50.0, 0.0]], cutoff=50, order=2)
    assert (found.n_missed, found.n_false, found.localisation) == (1, 1, 0.0)
    assert found.total == pytest.approx(50.0)


def test_works_in_three_dimensions_and_with_high_orders() -> None:
    assert gospa([[0, 0, 0]], [[2, 3, 6]], order=2).total == pytest.approx(7.0)
    assert gospa([[0, 0, 0]], [[2, 3, 6]], order=300).total == pytest.approx(7.0)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (([[0, 0]], [[0, 0]], 0.0), "cutoff: 0.0"),
        (([[0, 0]], [[0, 0]], np.nan), "cutoff"),
        (([[0, 0]], [[0, 0]], 10.0, 0.5), "order: 0.5"),
        (([[0, np.nan]], [[0, 0]]), "truth"),
        (([[0, 0]], [[0, 0, 0]]), "tracks: 3 dimensions"),
        (([0, 0], [[0, 0]]), "truth"),
    ],
)
def test_refuses_what_is_no_metric(arguments: tuple, words: str) -> None:
    with pytest.raises(InvalidInputError, match=words):
        gospa(*arguments)
