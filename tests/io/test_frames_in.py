"""Tables of pandas, polars and Arrow."""

from datetime import UTC, datetime
from decimal import Decimal

import numpy as np
import pandas as pd
import polars as pl
import pyarrow as pa
import pytest

from trackweave.errors import DataFormatError, InvalidInputError
from trackweave.io.frames_in import from_native

DATA = {"time": [0.0, 1.0], "sensor": ["a", "b"], "n": [1, 2]}


@pytest.mark.parametrize(
    ("table", "kind"),
    [(pl.DataFrame(DATA), "polars"), (pd.DataFrame(DATA), "pandas"), (pa.table(DATA), "pyarrow")],
)
def test_takes_the_tables_of_three_libraries_and_remembers_which(table, kind):
    raw = from_native(table)
    assert raw.kind == kind
    assert raw.columns.to_dict(as_series=False) == DATA
    assert raw.row.tolist() == [1, 2]


def test_missing_values_of_pandas_become_null():
    table = pd.DataFrame(
        {
            "a": [1.5, np.nan],
            "b": ["x", None],
            "c": pd.array([1, None], dtype="Int64"),
            "d": pd.Categorical(["u", None]),
            "e": pd.Series(["x", np.nan], dtype=object),
        }
    )
    assert from_native(table).columns.rows()[1] == (None,) * 5


def test_values_of_several_types_in_one_pandas_column_become_text():
    table = pd.DataFrame({"a": pd.Series([1, "x", Decimal("2.5"), None], dtype=object)})
    assert from_native(table).columns["a"].to_list() == ["1", "x", "2.5", None]


def test_dates_of_pandas_keep_their_moment():
    moment = pd.Timestamp("2024-05-01T14:00:00", tz="Europe/Berlin")
    column = from_native(pd.DataFrame({"a": [moment, pd.NaT]})).columns["a"]
    assert column.to_list() == [datetime(2024, 5, 1, 12, tzinfo=UTC), None]


def test_numbers_rows_from_one_whatever_the_index():
    assert from_native(pd.DataFrame(DATA, index=[7, 5])).row.tolist() == [1, 2]


def test_leaves_the_table_as_it_was():
    table = pd.DataFrame(DATA)
    from_native(table)
    pd.testing.assert_frame_equal(table, pd.DataFrame(DATA))


def test_refuses_a_name_that_appears_twice():
    twice = pd.DataFrame([[1, 2]], columns=["x", "x"])
    with pytest.raises(DataFormatError, match="x"):
        from_native(twice)
    with pytest.raises(DataFormatError, match="x"):
        from_native(pa.table([[1], [2]], names=["x", "x"]))


def test_refuses_a_lazy_table():
    with pytest.raises(InvalidInputError, match="lazy table"):
        from_native(pl.DataFrame(DATA).lazy())


@pytest.mark.parametrize("thing", [3, None, np.zeros((2, 2)), object(), {"x": [1]}])
def test_refuses_what_is_no_table(thing):
    with pytest.raises(InvalidInputError, match="not a table"):
        from_native(thing)
