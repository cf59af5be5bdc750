"""Lists and ranges of values."""

from itertools import product
from typing import Any

import pytest

from trackweave.errors import InvalidInputError
from trackweave.experiments.sweeps import merged, nested, sweeps_of


@pytest.mark.parametrize(
    ("given", "wanted"),
    [
        ([3, "x", [1.0, 2.0]], (3, "x", [1.0, 2.0])),
        ({"from": 1, "to": 7, "step": 2}, (1, 3, 5, 7)),
        ({"from": 1, "to": 6, "step": 2}, (1, 3, 5)),
        ({"from": 0.1, "to": 0.3, "step": 0.1}, (0.1, 0.2, 0.3)),
        ({"from": 0, "to": 1, "count": 3}, (0.0, 0.5, 1.0)),
        ({"from": 1e-6, "to": 1e-3, "count": 4, "scale": "logarithmic"}, (1e-6, 1e-5, 1e-4, 1e-3)),
    ],
)
def test_values_of_a_list_or_a_range(given: Any, wanted: tuple[Any, ...]) -> None:
    sweep = sweeps_of({"a": {"b": given}}, {}, "sweep")
    (values,) = sweep.keys.values()
    assert list(sweep.keys) == [("a", "b")]
    assert values == wanted or values == pytest.approx(wanted)


def test_a_range_of_whole_numbers_is_of_whole_numbers() -> None:
    (values,) = sweeps_of({"depth": {"from": 2, "to": 4, "count": 3}}, {}, "sweep").keys.values()
    assert values == (2, 3, 4)
    assert [type(value) for value in values] == [int] * 3


def test_points_are_the_product_with_the_last_key_the_fastest() -> None:
    sweep = sweeps_of({"a": [1, 2], "b": {"c": [3, 4, 5]}}, {}, "sweep")
    found = [nested(point) for point in sweep.points()]
    assert found == [{"a": a, "b": {"c": c}} for a, c in product([1, 2], [3, 4, 5])]
    assert len(sweep) == 6


def test_nothing_swept_is_one_point() -> None:
    sweep = sweeps_of({}, {}, "sweep")
    assert len(sweep) == 1
    assert list(sweep.points()) == [{}]


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (3, "sweep.a: 3; expected a list of values, or a range such as"),
        ("text", "expected a list of values"),
        ([], r"sweep.a: \[\]; expected a list of values"),
        ([1, 2, 1], "sweep.a: 1 comes twice; expected each value once"),
        ([[1, 2], [1, 2]], r"\[1, 2\] comes twice"),
        ({"from": 1}, "expected a list of values, or a range"),
        ({"from": 1, "to": 2}, "expected a list of values, or a range"),
        ({"from": 1, "to": 2, "step": 1, "count": 3}, "expected a list of values, or a range"),
        ({"from": 1, "to": "2", "count": 3}, "expected a list of values, or a range"),
        ({"from": 1, "to": 2, "count": 1}, "expected a list of values, or a range"),
        ({"from": 1, "to": 2, "count": 3, "scale": "cubic"}, "expected a list of values"),
        ({"from": 2, "to": 1, "step": 1}, "expected from below to"),
        ({"from": 1, "to": float("inf"), "count": 2}, "expected from below to"),
        ({"from": 0, "to": 1, "count": 3, "scale": "logarithmic"}, "expected from above 0"),
        ({"from": 0, "to": 1, "step": 0}, "expected a step above 0"),
        ({"from": 0, "to": 1, "step": 2}, "expected a step above 0"),
        ({"from": 0, "to": 1, "step": 1e-9}, "from one to 100,000 times"),
    ],
)
def test_what_is_no_sweep_is_refused_by_name(given: Any, message: str) -> None:
    with pytest.raises(InvalidInputError, match=message):
        sweeps_of({"a": given}, {}, "sweep")


def test_a_key_that_is_swept_and_set_is_a_contradiction() -> None:
    with pytest.raises(InvalidInputError, match=r"s.window.depth: swept and also set to 4; exp"):
        sweeps_of({"window": {"depth": [3, 4]}}, {"window": {"depth": 4}}, "s")
    sweeps_of({"window": {"depth": [3, 4]}}, {"window": {"max_scans": 4}}, "s")


def test_tables_are_laid_over_tables_key_by_key() -> None:
    below = {"a": {"b": 1, "c": 2}, "d": 3}
    assert merged(below, {"a": {"c": 4, "e": 5}, "d": {"f": 6}}) == {
        "a": {"b": 1, "c": 4, "e": 5}, "d": {"f": 6},
    }  # fmt: skip
    assert below == {"a": {"b": 1, "c": 2}, "d": 3}
