"""Cells become numbers and text."""

import numpy as np
import polars as pl
import pytest

from trackweave.io.columns import cell_text, empty_cells, read_numbers, read_text, text_array


def test_reads_numbers_from_text_with_blanks_around():
    numbers = read_numbers(pl.Series(["1", " 2.5 ", "-1e3", "+4", "\t.5"]))
    assert numbers.values.tolist() == [1.0, 2.5, -1000.0, 4.0, 0.5]
    assert not numbers.unreadable.any()


@pytest.mark.parametrize("cell", ["1_0", "0x1", "1,5", "one", "--1", "1 2", "True"])
def test_does_not_guess_numbers(cell):
    numbers = read_numbers(pl.Series(["1", cell]))
    assert numbers.unreadable.tolist() == [False, True]
    assert np.isnan(numbers.values[1])


def test_tells_empty_cells_from_unreadable_ones():
    numbers = read_numbers(pl.Series(["x", None, " ", "1"]))
    assert numbers.missing.tolist() == [False, True, True, False]
    assert numbers.unreadable.tolist() == [True, False, False, False]


@pytest.mark.parametrize("dtype", [pl.Int8, pl.UInt64, pl.Float32, pl.Decimal(10, 2)])
def test_reads_numbers_of_every_type(dtype):
    numbers = read_numbers(pl.Series([1, None, 3]).cast(dtype))
    assert numbers.values[[0, 2]].tolist() == [1.0, 3.0]
    assert numbers.missing.tolist() == [False, True, False]


@pytest.mark.parametrize("values", [[True, None], [[1], None], [{"a": 1}, None], [b"1", None]])
def test_finds_no_numbers_in_other_types(values):
    numbers = read_numbers(pl.Series(values))
    assert numbers.unreadable.tolist() == [True, False]


def test_whole_numbers_lose_their_point_as_text():
    assert read_text(pl.Series([3.0, None, float("nan")])).to_list() == ["3", None, None]
    assert read_text(pl.Series([3.0, 2.5])).to_list() == ["3.0", "2.5"]


@pytest.mark.parametrize(
    ("column", "texts"),
    [
        (pl.Series([" a ", "", "  ", None]), ["a", None, None, None]),
        (pl.Series([1, 22]), ["1", "22"]),
        (pl.Series(["u", "v"], dtype=pl.Categorical), ["u", "v"]),
        (pl.Series([[1, 2], None]), ["[1, 2]", None]),
        (pl.Series([None, None]), [None, None]),
    ],
)
def test_reads_text_from_every_type(column, texts):
    assert read_text(column).to_list() == texts


def test_text_as_an_array_is_empty_where_null():
    assert text_array(pl.Series(["a", None])).tolist() == ["a", ""]


def test_finds_empty_cells():
    assert empty_cells(pl.Series([" ", "a", None])).tolist() == [True, False, True]
    assert empty_cells(pl.Series([1, None])).tolist() == [False, True]


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (None, "(empty)"),
        ("", "(empty)"),
        (" ", "(blank)"),
        ("-3.0", "-3.0"),
        ("a\nb", "'a\\nb'"),
        ("x" * 100, "x" * 59 + "…"),
    ],
)
def test_shows_a_cell_in_one_short_line(value, text):
    assert cell_text(pl.Series([value], dtype=pl.String), 0) == text
